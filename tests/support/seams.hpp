// SPDX-License-Identifier: MIT
#pragma once

#include <array>
#include <cmath>
#include <functional>
#include <map>
#include <numbers>
#include <vector>

#include <Eigen/Geometry>

#include "crease/geometry/mesh.hpp"
#include "support/meshes.hpp"

/// Meshes of panels that are sewn together.
namespace crease::support {

/// Ties all border vertices that stand at one place.
inline void sew(Mesh& mesh) {
  for (int a = 0; a < mesh.n_vertices(); ++a)
    for (int b = a + 1; b < mesh.n_vertices(); ++b)
      if (mesh.is_border_vertex(a) && mesh.is_border_vertex(b) && mesh.x[a] == mesh.x[b]) mesh.tie(a, b);
}

/// A sheet cut into panels, each laid elsewhere in material space, turned, and sewn together again.
struct CutSheet {
  Mesh mesh;
  std::vector<int> whole;  ///< vertex of the sheet that was cut, for each vertex
};
/// @param panel  by the centroid of a face
inline CutSheet cut_and_sew(const Mesh& sheet, const std::function<int(const Vec2&)>& panel) {
  std::map<std::array<int, 2>, int> ids;
  CutSheet cut;
  std::vector<Vec2> X;
  std::vector<Vec3> x;
  std::vector<std::array<int, 3>> faces;
  for (int f = 0; f < sheet.n_faces(); ++f) {
    const auto P = material_corners(sheet, f);
    const int p = panel((P[0] + P[1] + P[2]) / 3);
    faces.push_back(sheet.face(f));
    for (int& v : faces.back()) {
      const auto [found, is_new] = ids.try_emplace({p, v}, static_cast<int>(X.size()));
      if (is_new) {
        const Eigen::Rotation2Dd turn(p * std::numbers::pi / 3);
        X.push_back(turn * sheet.X[v] + Vec2(5 * p, 0));
        x.push_back(sheet.x[v]);
        cut.whole.push_back(v);
      }
      v = found->second;
    }
  }
  cut.mesh = Mesh(X, x, faces);
  sew(cut.mesh);
  return cut;
}

inline CutSheet halves(GridPattern pattern = GridPattern::Alternating) {
  return cut_and_sew(grid(pattern, 6, 5), [](const Vec2& c) { return c.x() < 0.6 ? 0 : 1; });
}

/// Four panels that meet in the middle.
inline CutSheet patchwork() {
  return cut_and_sew(grid(GridPattern::Cross, 4, 4),
                     [](const Vec2& c) { return (c.x() < 0.4 ? 0 : 1) + (c.y() < 0.4 ? 0 : 2); });
}

/// One panel whose left and right borders are sewn together.
inline Mesh tube(int n = 8) {
  Mesh mesh = grid(GridPattern::Alternating, n, 4);
  for (int v = 0; v < mesh.n_vertices(); ++v) {
    const double turn = mesh.X[v].x() / (0.2 * n), angle = turn > 1 - 1e-9 ? 0 : 2 * std::numbers::pi * turn;
    mesh.x[v] = Vec3(0.3 * std::cos(angle), mesh.X[v].y(), 0.3 * std::sin(angle));
  }
  sew(mesh);
  return mesh;
}

/// Two equal panels, the second turned over, sewn together all around: the corners' triangles have their long sides in
/// common as well, which are no seam.
inline Mesh pillow(int n = 4) {
  const Mesh front = grid(GridPattern::Alternating, n, n);
  std::vector<Vec2> X = front.X;
  std::vector<Vec3> x = front.x;
  std::vector<std::array<int, 3>> faces;
  for (int f = 0; f < front.n_faces(); ++f) faces.push_back(front.face(f));
  for (const Vec2& P : front.X) X.emplace_back(3 - P.x(), P.y());
  x.insert(x.end(), front.x.begin(), front.x.end());
  for (int f = 0; f < front.n_faces(); ++f) {
    const auto& [a, b, c] = front.face(f);
    faces.push_back({front.n_vertices() + a, front.n_vertices() + c, front.n_vertices() + b});
  }
  for (int v = 0; v < front.n_vertices(); ++v) {
    const Vec2& P = front.X[v];
    const double side = 0.2 * n, rise = front.is_border_vertex(v) ? 0 : P.x() * (side - P.x()) * P.y() * (side - P.y());
    x[v].z() = rise;
    x[v + front.n_vertices()].z() = -rise;
  }
  Mesh mesh(X, x, faces);
  sew(mesh);
  return mesh;
}

/// A grid whose edges along one line are cut open from the lower border to the middle: two borders that stand at one
/// place in the world, and in material space a wedge apart.
/// @param slope  how much each side of the wedge recedes over its length
inline Mesh slit(GridPattern pattern = GridPattern::Alternating, double slope = 0) {
  const Mesh whole = grid(pattern, 6, 6);
  std::vector<Vec2> X = whole.X;
  std::vector<Vec3> x = whole.x;
  std::vector<int> twin(X.size(), Mesh::none);
  for (int v = 0; v < whole.n_vertices(); ++v) {
    if (std::abs(whole.X[v].x() - 0.6) > 1e-9 || whole.X[v].y() > 0.5) continue;
    twin[v] = static_cast<int>(X.size());
    const Vec2 aside(slope * (0.6 - whole.X[v].y()), 0);
    X.push_back(whole.X[v] + aside);
    X[v] -= aside;
    x.push_back(whole.x[v]);
  }
  std::vector<std::array<int, 3>> faces;
  for (int f = 0; f < whole.n_faces(); ++f) {
    faces.push_back(whole.face(f));
    const auto P = material_corners(whole, f);
    if ((P[0] + P[1] + P[2]).x() / 3 < 0.6) continue;
    for (int& v : faces.back())
      if (twin[v] != Mesh::none) v = twin[v];
  }
  return Mesh(X, x, faces);
}

/// A sheet with a wedge cut out, from the lower border to the middle, that is sewn up: the seam ends inside the sheet.
inline Mesh dart() {
  Mesh mesh = slit(GridPattern::Alternating, 0.05);
  sew(mesh);
  return mesh;
}

inline std::vector<NamedMesh> sewn_meshes() {
  return {{"halves", halves().mesh},
          {"irregular halves", halves(GridPattern::Cross).mesh},
          {"patchwork", patchwork().mesh},
          {"tube", tube()},
          {"pillow", pillow()},
          {"dart", dart()}};
}

/// Material length of all border edges that are, or are not, sides of a seam [m].
inline double border_length(const Mesh& mesh, bool sewn) {
  double sum = 0;
  for (int h = 0; h < 3 * mesh.face_slots(); ++h)
    if (mesh.face_live(Mesh::face_of(h)) && mesh.is_border(h) && (mesh.seam_twin(h) != Mesh::none) == sewn)
      sum += mesh.material_length(h);
  return sum;
}

}  // namespace crease::support
