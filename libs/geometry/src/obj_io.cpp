// SPDX-License-Identifier: MIT
#include "crease/geometry/obj_io.hpp"

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <ostream>
#include <stdexcept>
#include <utility>

#include "crease/base/require.hpp"
#include "obj_panels.hpp"
#include "obj_text.hpp"

namespace crease {
namespace {

// A triangle whose area is below this share of its longest edge squared is a line, whatever sign rounding gave it:
// three coordinates of size 1 that lie on a line yield an area of about 1e-16.
constexpr double zero_area = 1e-12;

void check_areas(const ObjText& text) {
  for (const ObjFace& face : text.faces) {
    const Vec2 &X = text.texcoords[face.vt[0]], a = text.texcoords[face.vt[1]] - X, b = text.texcoords[face.vt[2]] - X;
    const double twice_area = a.x() * b.y() - a.y() * b.x();
    const double longest = std::max({a.squaredNorm(), b.squaredNorm(), (a - b).squaredNorm()});
    if (!(std::abs(twice_area) > 2 * zero_area * longest))
      text.fail(face.line, "triangle of zero area in material space (vt): remove it or move its corners apart");
    if (twice_area < 0)
      text.fail(face.line, "triangle is inverted in material space (vt): its corners must run counter-clockwise there");
  }
}

// Shortest decimal that reads back as the same double.
void append(std::string& out, double value) {
  std::array<char, 32> digits;
  const auto end = std::to_chars(digits.data(), digits.data() + digits.size(), value).ptr;
  out.append(digits.data(), end);
}

// The number of each vertex' position among the `v` of its cloth, from 0: tied vertices share that of the lowest.
std::vector<int> position_numbers(const Mesh& mesh, int& n) {
  std::vector<int> numbers(mesh.X.size(), -1);
  n = 0;
  for (int i = 0; i < mesh.n_vertices(); ++i) {
    if (numbers[i] >= 0) continue;
    for (int v = i; numbers[v] < 0; v = mesh.tied(v)) numbers[v] = n;
    ++n;
  }
  return numbers;
}

void append_cloth(std::string& out, const Mesh& mesh, const std::vector<int>& numbers, int first_v, int first_vt) {
  int next = 0;
  for (int i = 0; i < mesh.n_vertices(); ++i) {
    if (numbers[i] != next) continue;
    ++next;
    out += 'v';
    for (const double coordinate : mesh.x[i]) append(out += ' ', coordinate);
    out += '\n';
  }
  for (const Vec2& X : mesh.X) {
    append(out += "vt ", X.x());
    append(out += ' ', X.y());
    out += '\n';
  }
  for (int f = 0; f < mesh.n_faces(); ++f) {
    out += 'f';
    for (const int v : mesh.face(f)) {
      out.append(" ").append(std::to_string(first_v + numbers[v]));
      out.append("/").append(std::to_string(first_vt + v));
    }
    out += '\n';
  }
}

}  // namespace

Mesh read_obj(const std::filesystem::path& file) {
  const ObjText text = read_obj_text(file, ObjUse::Cloth);
  check_areas(text);
  const ObjPanels panels = sew_panels(text);
  std::vector<Vec2> X;
  std::vector<Vec3> x;
  for (const auto& [v, vt] : panels.vertices) {
    X.push_back(text.texcoords[vt]);
    x.push_back(text.positions[v]);
  }
  try {
    Mesh mesh(std::move(X), std::move(x), panels.faces);
    for (int i = static_cast<int>(text.positions.size()); i < mesh.n_vertices(); ++i) mesh.tie(panels.vertices[i].v, i);
    return mesh;
  } catch (const std::invalid_argument& error) {
    throw std::runtime_error(file.string() + ": " + error.what());
  }
}

TriangleSurface read_surface_obj(const std::filesystem::path& file) {
  ObjText text = read_obj_text(file, ObjUse::Surface);
  TriangleSurface surface{std::move(text.positions), {}};
  for (const ObjFace& face : text.faces) surface.triangles.push_back(face.v);
  return surface;
}

void write_obj(std::ostream& out, std::span<const NamedCloth> cloths, double time) {
  for (const NamedCloth& named : cloths)
    require(named.cloth && named.cloth->mesh.is_compact(), "write_obj: expected compact cloths");
  std::string text = "# time ";
  append(text, time);
  text += "\n# eol";
  std::vector<std::vector<int>> numbers;
  std::vector<int> first_v{1}, first_vt{1};
  for (const NamedCloth& named : cloths) {
    const Mesh& mesh = named.cloth->mesh;
    int n = 0;
    numbers.push_back(position_numbers(mesh, n));
    for (int i = 0; i < mesh.n_vertices(); ++i)
      if (named.cloth->is_eol(i)) text.append(" ").append(std::to_string(first_v.back() + numbers.back()[i]));
    first_v.push_back(first_v.back() + n);
    first_vt.push_back(first_vt.back() + mesh.n_vertices());
  }
  text += '\n';
  for (std::size_t c = 0; c < cloths.size(); ++c) {
    if (cloths.size() > 1) text.append("o ").append(cloths[c].name).append("\n");
    append_cloth(text, cloths[c].cloth->mesh, numbers[c], first_v[c], first_vt[c]);
  }
  out.write(text.data(), static_cast<std::streamsize>(text.size()));
}

}  // namespace crease
