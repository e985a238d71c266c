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
#include "obj_text.hpp"

namespace crease {
namespace {

// A triangle whose area is below this share of its longest edge squared is a line, whatever sign rounding gave it:
// three coordinates of size 1 that lie on a line yield an area of about 1e-16.
constexpr double zero_area = 1e-12;

// One material position a vertex; a seam would need two.
std::vector<Vec2> material_positions(const ObjText& text) {
  std::vector<int> texcoord(text.positions.size(), -1);
  for (const ObjFace& face : text.faces)
    for (int k = 0; k < 3; ++k) {
      int& known = texcoord[face.v[k]];
      if (known >= 0 && text.texcoords[known] != text.texcoords[face.vt[k]])
        text.fail(face.line, "vertex " + std::to_string(face.v[k] + 1) + " has two texture coordinates, " +
                                 std::to_string(known + 1) + " and " + std::to_string(face.vt[k] + 1) +
                                 ": seams are not available yet, so give each vertex one");
      known = face.vt[k];
    }
  std::vector<Vec2> X(text.positions.size());
  for (size_t i = 0; i < X.size(); ++i) {
    if (texcoord[i] < 0)
      text.fail(text.position_lines[i], "vertex " + std::to_string(i + 1) + " is in no triangle: remove it");
    X[i] = text.texcoords[texcoord[i]];
  }
  return X;
}

void check_areas(const ObjText& text, const std::vector<Vec2>& X) {
  for (const ObjFace& face : text.faces) {
    const Vec2 a = X[face.v[1]] - X[face.v[0]], b = X[face.v[2]] - X[face.v[0]];
    const double twice_area = a.x() * b.y() - a.y() * b.x();
    const double longest = std::max({a.squaredNorm(), b.squaredNorm(), (a - b).squaredNorm()});
    if (!(std::abs(twice_area) > 2 * zero_area * longest))
      text.fail(face.line, "triangle of zero area in material space (vt): remove it or move its corners apart");
    if (twice_area < 0)
      text.fail(face.line, "triangle is inverted in material space (vt): its corners must run counter-clockwise there");
  }
}

// With consistent orientation a directed edge belongs to one face at most; a third face at an edge repeats a direction.
void check_manifold(const ObjText& text) {
  std::vector<std::pair<std::array<int, 2>, int>> directed;  // edge, line
  for (const ObjFace& face : text.faces)
    for (int k = 0; k < 3; ++k) directed.push_back({{face.v[k], face.v[(k + 1) % 3]}, face.line});
  std::sort(directed.begin(), directed.end());
  for (size_t i = 1; i < directed.size(); ++i)
    if (directed[i].first == directed[i - 1].first) {
      const auto& [edge, line] = directed[i];
      text.fail(line, "edge " + std::to_string(edge[0] + 1) + "-" + std::to_string(edge[1] + 1) +
                          " runs the same way in two triangles (the other on line " +
                          std::to_string(directed[i - 1].second) + "): the mesh is not manifold there");
    }
  std::vector<char> fans(text.positions.size(), 0);
  for (const auto& [edge, line] : directed) {
    const std::array<int, 2> back{edge[1], edge[0]};
    const auto it = std::lower_bound(directed.begin(), directed.end(), std::pair(back, 0));
    if (it != directed.end() && it->first == back) continue;
    if (fans[edge[0]]++ > 0)
      text.fail(line, "vertex " + std::to_string(edge[0] + 1) +
                          " joins two pieces that share nothing else: the mesh is not manifold there; duplicate it");
  }
}

// Shortest decimal that reads back as the same double.
void append(std::string& out, double value) {
  std::array<char, 32> digits;
  const auto end = std::to_chars(digits.data(), digits.data() + digits.size(), value).ptr;
  out.append(digits.data(), end);
}

void append_faces(std::string& out, const Mesh& mesh, int offset) {
  for (int f = 0; f < mesh.n_faces(); ++f) {
    out += 'f';
    for (const int v : mesh.face(f)) {
      const std::string index = std::to_string(offset + v + 1);
      out.append(" ").append(index).append("/").append(index);
    }
    out += '\n';
  }
}

}  // namespace

Mesh read_obj(const std::filesystem::path& file) {
  ObjText text = read_obj_text(file, ObjUse::Cloth);
  std::vector<Vec2> X = material_positions(text);
  check_areas(text, X);
  check_manifold(text);
  std::vector<std::array<int, 3>> faces;
  for (const ObjFace& face : text.faces) faces.push_back(face.v);
  try {
    return Mesh(std::move(X), std::move(text.positions), faces);
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
  int offset = 0;
  for (const NamedCloth& named : cloths) {
    for (int i = 0; i < named.cloth->mesh.n_vertices(); ++i)
      if (named.cloth->is_eol(i)) text.append(" ").append(std::to_string(offset + i + 1));
    offset += named.cloth->mesh.n_vertices();
  }
  text += '\n';
  offset = 0;
  for (const NamedCloth& named : cloths) {
    const Mesh& mesh = named.cloth->mesh;
    if (cloths.size() > 1) text.append("o ").append(named.name).append("\n");
    for (const Vec3& x : mesh.x) {
      text += 'v';
      for (const double coordinate : x) append(text += ' ', coordinate);
      text += '\n';
    }
    for (const Vec2& X : mesh.X) {
      append(text += "vt ", X.x());
      append(text += ' ', X.y());
      text += '\n';
    }
    append_faces(text, mesh, offset);
    offset += mesh.n_vertices();
  }
  out.write(text.data(), static_cast<std::streamsize>(text.size()));
}

}  // namespace crease
