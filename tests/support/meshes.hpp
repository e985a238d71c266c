// SPDX-License-Identifier: MIT
#pragma once

#include <array>
#include <cmath>
#include <cstdint>
#include <functional>
#include <random>
#include <string>
#include <vector>

#include "crease/geometry/grid.hpp"
#include "crease/geometry/mesh.hpp"
#include "crease/geometry/triangle.hpp"

/// Meshes that tests run over: every border shape a cloth may have, and world shapes that are bent, stretched and
/// noisy.
namespace crease::support {

using Rng = std::mt19937_64;

/// In [lo, hi), from the generator's bits alone, so the same numbers on every machine.
inline double uniform(Rng& rng, double lo, double hi) {
  return lo + (hi - lo) * (static_cast<double>(rng() >> 11) * 0x1p-53);
}
inline int pick(Rng& rng, int n) {
  return static_cast<int>(rng() % static_cast<std::uint64_t>(n));
}

inline Mesh grid(GridPattern pattern, int nx = 6, int ny = 5, std::uint64_t seed = 1) {
  GridOptions options;
  options.size = Vec2(0.2 * nx, 0.2 * ny);
  options.cells = {nx, ny};
  options.pattern = pattern;
  options.seed = seed;
  return make_grid(options);
}

/// The faces of `mesh` whose centroid `keep` accepts, as a mesh of its own.
inline Mesh cut(const Mesh& mesh, const std::function<bool(const Vec2&)>& keep) {
  std::vector<int> id(mesh.X.size(), Mesh::none);
  std::vector<Vec2> X;
  std::vector<Vec3> x;
  std::vector<std::array<int, 3>> faces;
  for (int f = 0; f < mesh.face_slots(); ++f) {
    const auto P = material_corners(mesh, f);
    if (!keep((P[0] + P[1] + P[2]) / 3)) continue;
    std::array<int, 3> face{};
    for (int k = 0; k < 3; ++k) {
      const int v = mesh.face(f)[k];
      if (id[v] == Mesh::none) {
        id[v] = static_cast<int>(X.size());
        X.push_back(mesh.X[v]);
        x.push_back(mesh.x[v]);
      }
      face[k] = id[v];
    }
    faces.push_back(face);
  }
  return Mesh(X, x, faces);
}

/// L shape: a grid without its upper right quarter (one re-entrant corner).
inline Mesh l_shape(GridPattern pattern = GridPattern::Alternating, int n = 8) {
  const double half = 0.1 * n;
  return cut(grid(pattern, n, n), [=](const Vec2& c) { return c.x() < half || c.y() < half; });
}

/// A square with a square hole in the middle (Euler characteristic 0). @pre n divisible by 4
inline Mesh holed(GridPattern pattern = GridPattern::Right, int n = 8) {
  const double a = 0.05 * n, b = 0.15 * n;
  return cut(grid(pattern, n, n), [=](const Vec2& c) { return c.x() < a || c.x() > b || c.y() < a || c.y() > b; });
}

/// Two strips that touch nowhere (Euler characteristic 2).
inline Mesh two_components(GridPattern pattern = GridPattern::Cross) {
  return cut(grid(pattern, 9, 4), [](const Vec2& c) { return c.x() < 0.8 || c.x() > 1.0; });
}

struct NamedMesh {
  std::string name;
  Mesh mesh;
};

/// One of every kind.
inline std::vector<NamedMesh> all_meshes() {
  return {{"cross", grid(GridPattern::Cross)},
          {"alternating", grid(GridPattern::Alternating)},
          {"right", grid(GridPattern::Right)},
          {"irregular", grid(GridPattern::Irregular, 8, 7, 5)},
          {"l_shape", l_shape()},
          {"holed", holed()},
          {"two_components", two_components()},
          {"single_cell", grid(GridPattern::Right, 1, 1)}};
}

/// World positions of a smooth, bent and stretched sheet plus noise of the given size [m].
inline void crumple(Mesh& mesh, Rng& rng, double noise = 0.01) {
  for (std::size_t i = 0; i < mesh.X.size(); ++i) {
    const Vec2& P = mesh.X[i];
    mesh.x[i] = Vec3(1.1 * P.x() + 0.1 * P.y(), 0.9 * P.y(), 0.3 * std::sin(3 * P.x()) * std::cos(2 * P.y()));
    for (int k = 0; k < 3; ++k) mesh.x[i][k] += uniform(rng, -noise, noise);
  }
}

inline double total_area(const Mesh& mesh) {
  double sum = 0;
  for (int f = 0; f < mesh.face_slots(); ++f) sum += mesh.face_live(f) ? mesh.material_area(f) : 0.0;
  return sum;
}

inline int euler_characteristic(const Mesh& mesh) {
  return mesh.n_vertices() - static_cast<int>(mesh.edges().size()) + mesh.n_faces();
}

}  // namespace crease::support
