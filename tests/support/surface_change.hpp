// SPDX-License-Identifier: MIT
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

#include "crease/geometry/mesh.hpp"
#include "crease/geometry/triangle.hpp"

namespace crease::testing {

/// World positions of material points of a mesh, found through a grid of cells in material space.
class Surface {
 public:
  explicit Surface(const Mesh& mesh) : mesh_(mesh) {
    Vec2 high = mesh.X.front();
    low_ = high;
    for (const Vec2& X : mesh.X) low_ = low_.cwiseMin(X), high = high.cwiseMax(X);
    n_ = std::max(1, static_cast<int>(std::sqrt(mesh.n_faces())));
    cell_ = (high - low_) / n_;
    faces_.resize(static_cast<std::size_t>(n_ * n_));
    for (int f = 0; f < mesh.face_slots(); ++f) {
      if (!mesh.face_live(f)) continue;
      const auto X = material_corners(mesh, f);
      const auto from = cell_of(X[0].cwiseMin(X[1]).cwiseMin(X[2])), to = cell_of(X[0].cwiseMax(X[1]).cwiseMax(X[2]));
      for (int j = from[1]; j <= to[1]; ++j)
        for (int i = from[0]; i <= to[0]; ++i) faces_[static_cast<std::size_t>(j * n_ + i)].push_back(f);
    }
  }

  /// The face that holds X best: with round-off a point of the border lies in none.
  Vec3 at(const Vec2& X) const {
    const auto cell = cell_of(X);
    double inside = -1e300;
    Vec3 x = Vec3::Zero();
    for (const int f : faces_[static_cast<std::size_t>(cell[1] * n_ + cell[0])]) {
      const Vec3 b = barycentric(material_corners(mesh_, f), X);
      if (!(b.minCoeff() > inside)) continue;
      inside = b.minCoeff();
      const auto corners = world_corners(mesh_, f);
      x = b[0] * corners[0] + b[1] * corners[1] + b[2] * corners[2];
    }
    return x;
  }

 private:
  std::array<int, 2> cell_of(const Vec2& X) const {
    const auto index = [&](int k) { return std::clamp(static_cast<int>((X[k] - low_[k]) / cell_[k]), 0, n_ - 1); };
    return {index(0), index(1)};
  }

  const Mesh& mesh_;
  Vec2 low_, cell_;
  int n_;
  std::vector<std::vector<int>> faces_;
};

struct SurfaceChange {
  double distance = 0;    ///< [m]
  Vec2 X = Vec2::Zero();  ///< where
};

/// How far a remeshing pass moved the surface in the world: the largest distance between the two positions of one
/// material point, over the vertices of both meshes and the middles of their edges.
inline SurfaceChange surface_change(const Mesh& before, const Mesh& after) {
  SurfaceChange largest;
  const auto compare = [&](const Mesh& mesh, const Surface& other) {
    const auto offer = [&](const Vec2& X, const Vec3& x) {
      const double distance = (other.at(X) - x).norm();
      if (distance > largest.distance) largest = {distance, X};
    };
    for (int v = 0; v < mesh.vertex_slots(); ++v)
      if (mesh.vertex_live(v)) offer(mesh.X[v], mesh.x[v]);
    for (const int h : mesh.edges())
      offer(0.5 * (mesh.X[mesh.from(h)] + mesh.X[mesh.to(h)]), 0.5 * (mesh.x[mesh.from(h)] + mesh.x[mesh.to(h)]));
  };
  compare(before, Surface(after));
  compare(after, Surface(before));
  return largest;
}

}  // namespace crease::testing
