// SPDX-License-Identifier: MIT
#include "frames.hpp"

#include <bit>
#include <charconv>
#include <cstdint>
#include <cstdio>
#include <vector>

namespace crease {
namespace {

static_assert(std::endian::native == std::endian::little, "frames are declared little-endian");

std::string digits(double value) {
  char text[64];
  return {text, std::to_chars(text, text + sizeof text, value).ptr};
}

template <class T>
constexpr const char* vtk_name = nullptr;
template <>
constexpr const char* vtk_name<double> = "Float64";
template <>
constexpr const char* vtk_name<std::int32_t> = "Int32";
template <>
constexpr const char* vtk_name<std::uint8_t> = "UInt8";

/// Collects the raw block and hands out the XML elements that point into it.
class Appended {
 public:
  template <class T>
  std::string add(const char* name, int components, const std::vector<T>& values) {
    const std::uint64_t bytes = values.size() * sizeof(T);
    std::string element = "<DataArray type=\"" + std::string(vtk_name<T>) + "\" Name=\"" + name +
                          "\" NumberOfComponents=\"" + std::to_string(components) + "\" format=\"appended\" offset=\"" +
                          std::to_string(raw_.size()) + "\"/>\n";
    raw_.append(reinterpret_cast<const char*>(&bytes), sizeof bytes);
    if (bytes) raw_.append(reinterpret_cast<const char*>(values.data()), bytes);
    return element;
  }
  const std::string& raw() const { return raw_; }

 private:
  std::string raw_;
};

/// All sheets one behind the other.
struct Arrays {
  std::vector<double> points, uv, velocity, material_velocity;
  std::vector<std::uint8_t> eol;
  std::vector<std::int32_t> point_cloth, face_cloth, connectivity, offsets;
};

void append(std::vector<double>& values, const Vec3& p) {
  values.insert(values.end(), {p.x(), p.y(), p.z()});
}

Arrays gather(std::span<const NamedCloth> cloths) {
  Arrays all;
  for (std::size_t c = 0; c < cloths.size(); ++c) {
    const Cloth& cloth = *cloths[c].cloth;
    const auto first = static_cast<std::int32_t>(all.eol.size());
    for (int i = 0; i < cloth.mesh.n_vertices(); ++i) {
      append(all.points, cloth.mesh.x[i]);
      append(all.velocity, cloth.world_velocity(i));
      append(all.material_velocity, {cloth.V[i].x(), cloth.V[i].y(), 0});
      all.uv.insert(all.uv.end(), {cloth.mesh.X[i].x(), cloth.mesh.X[i].y()});
      all.eol.push_back(cloth.is_eol(i));
      all.point_cloth.push_back(static_cast<std::int32_t>(c));
    }
    for (int f = 0; f < cloth.mesh.n_faces(); ++f) {
      for (const int v : cloth.mesh.face(f)) all.connectivity.push_back(first + v);
      all.offsets.push_back(static_cast<std::int32_t>(all.connectivity.size()));
      all.face_cloth.push_back(static_cast<std::int32_t>(c));
    }
  }
  return all;
}

}  // namespace

std::string vtp_text(std::span<const NamedCloth> cloths, double time) {
  const Arrays all = gather(cloths);
  Appended data;
  std::string text =
      "<?xml version=\"1.0\"?>\n"
      "<VTKFile type=\"PolyData\" version=\"1.0\" byte_order=\"LittleEndian\" header_type=\"UInt64\">\n<PolyData>\n"
      "<FieldData>\n<DataArray type=\"Float64\" Name=\"TimeValue\" NumberOfTuples=\"1\" format=\"ascii\">" +
      digits(time) + "</DataArray>\n</FieldData>\n";
  text += "<Piece NumberOfPoints=\"" + std::to_string(all.eol.size()) + "\" NumberOfVerts=\"0\" NumberOfLines=\"0\"" +
          " NumberOfStrips=\"0\" NumberOfPolys=\"" + std::to_string(all.offsets.size()) + "\">\n";
  text += "<Points>\n" + data.add("Points", 3, all.points) + "</Points>\n";
  text +=
      "<Polys>\n" + data.add("connectivity", 1, all.connectivity) + data.add("offsets", 1, all.offsets) + "</Polys>\n";
  text += "<PointData TCoords=\"uv\" Vectors=\"velocity\">\n" + data.add("uv", 2, all.uv) +
          data.add("velocity", 3, all.velocity) + data.add("material_velocity", 3, all.material_velocity) +
          data.add("eol", 1, all.eol) + data.add("cloth", 1, all.point_cloth) + "</PointData>\n";
  text += "<CellData>\n" + data.add("cloth", 1, all.face_cloth) + "</CellData>\n";
  text += "</Piece>\n</PolyData>\n<AppendedData encoding=\"raw\">\n_" + data.raw() + "\n</AppendedData>\n</VTKFile>\n";
  return text;
}

std::string pvd_text(std::span<const double> frame_times) {
  std::string text =
      "<?xml version=\"1.0\"?>\n<VTKFile type=\"Collection\" version=\"0.1\" "
      "byte_order=\"LittleEndian\">\n<Collection>\n";
  for (std::size_t k = 0; k < frame_times.size(); ++k)
    text += "<DataSet timestep=\"" + digits(frame_times[k]) + "\" part=\"0\" file=\"" +
            frame_path(static_cast<int>(k), "vtp").generic_string() + "\"/>\n";
  return text + "</Collection>\n</VTKFile>\n";
}

std::filesystem::path frame_path(int frame, const char* extension) {
  char name[32];
  std::snprintf(name, sizeof name, "%06d.%s", frame, extension);
  return std::filesystem::path("frames") / name;
}

}  // namespace crease
