// SPDX-License-Identifier: MIT
#include "crease/geometry/grid.hpp"

#include <string>

#include "crease/base/require.hpp"
#include "crease/geometry/triangle.hpp"

namespace crease {
namespace {

/// SplitMix64: integer arithmetic only, so that a seed means the same mesh on every machine.   [STEELE14]
class SplitMix64 {
 public:
  explicit SplitMix64(std::uint64_t seed) : state_(seed) {}
  /// In [-1, 1).
  double symmetric() { return static_cast<double>(next() >> 11) * 0x1p-52 - 1.0; }

 private:
  std::uint64_t next() {
    std::uint64_t z = (state_ += 0x9e3779b97f4a7c15);
    z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9;
    z = (z ^ (z >> 27)) * 0x94d049bb133111eb;
    return z ^ (z >> 31);
  }
  std::uint64_t state_;
};

void check(const GridOptions& o) {
  require(o.size.allFinite() && o.size.minCoeff() > 0, "make_grid: expected a positive size");
  require(o.cells[0] >= 1 && o.cells[1] >= 1, "make_grid: expected at least one cell each way, got " +
                                                  std::to_string(o.cells[0]) + " x " + std::to_string(o.cells[1]));
  constexpr long long max_cells = 50'000'000;
  require(static_cast<long long>(o.cells[0]) * o.cells[1] <= max_cells, "make_grid: too many cells");
}

/// Lattice points row by row; the last row and column stand exactly at the size, whatever the division rounds to.
std::vector<Vec2> lattice(const GridOptions& o) {
  const auto [n, m] = o.cells;
  std::vector<Vec2> X;
  X.reserve((n + 1) * static_cast<std::size_t>(m + 1));
  for (int j = 0; j <= m; ++j) {
    for (int i = 0; i <= n; ++i) {
      X.emplace_back(i == n ? o.size.x() : o.size.x() * i / n, j == m ? o.size.y() : o.size.y() * j / m);
    }
  }
  return X;
}

/// Moves points by up to 0.2 of a cell each way: less than the 0.25 at which a cell's triangles could turn over. Border
/// points move along the border only, corners not at all.
void jitter(const GridOptions& o, std::vector<Vec2>& X) {
  constexpr double amplitude = 0.2;
  const auto [n, m] = o.cells;
  SplitMix64 random(o.seed);
  for (int j = 0; j <= m; ++j) {
    for (int i = 0; i <= n; ++i) {
      const double dx = amplitude * random.symmetric() * o.size.x() / n;
      const double dy = amplitude * random.symmetric() * o.size.y() / m;
      Vec2& P = X[static_cast<std::size_t>(j) * (n + 1) + i];
      if (i > 0 && i < n) P.x() += dx;
      if (j > 0 && j < m) P.y() += dy;
    }
  }
}

std::vector<std::array<int, 3>> triangles(const GridOptions& o, std::vector<Vec2>& X) {
  const auto [n, m] = o.cells;
  std::vector<std::array<int, 3>> faces;
  faces.reserve(4 * static_cast<std::size_t>(n) * m);
  for (int j = 0; j < m; ++j) {
    for (int i = 0; i < n; ++i) {
      const int a = j * (n + 1) + i, b = a + 1, d = a + n + 1, c = d + 1;  // counter-clockwise a b c d
      if (o.pattern == GridPattern::Cross) {
        const int e = static_cast<int>(X.size());
        X.push_back(0.5 * (X[a] + X[c]));
        faces.insert(faces.end(), {{a, b, e}, {b, c, e}, {c, d, e}, {d, a, e}});
      } else if (o.pattern == GridPattern::Alternating && (i + j) % 2 == 1) {
        faces.insert(faces.end(), {{a, b, d}, {b, c, d}});
      } else {
        faces.insert(faces.end(), {{a, b, c}, {a, c, d}});
      }
    }
  }
  return faces;
}

/// True if the two angles opposite to h exceed 180 degrees together by more than rounding: sin(alpha + beta) < -margin.
bool violates_delaunay(const Mesh& mesh, int h) {
  const int g = mesh.twin(h);
  const Vec2 &a = mesh.X[mesh.from(h)], &c = mesh.X[mesh.to(h)];
  const Vec2 &b = mesh.X[mesh.opposite(h)], &d = mesh.X[mesh.opposite(g)];
  const double sin_b = orient2d(a, c, b), cos_b = (a - b).dot(c - b);
  const double sin_d = orient2d(c, a, d), cos_d = (c - d).dot(a - d);
  constexpr double margin = 1e-12;
  const double scale = (a - b).norm() * (c - b).norm() * (c - d).norm() * (a - d).norm();
  return sin_b * cos_d + cos_b * sin_d < -margin * scale;
}

/// Flips to Delaunay. Each flip lowers the lifted surface, so the rounds end; the budget makes it so by construction.
void make_delaunay(Mesh& mesh) {
  constexpr int max_rounds = 100;
  for (int round = 0; round < max_rounds; ++round) {
    int flips = 0;
    for (const int h : mesh.edges()) {
      if (mesh.edge_of(h) != h || mesh.is_border(h) || !violates_delaunay(mesh, h) || !mesh.can_flip(h)) continue;
      mesh.flip(h);
      ++flips;
    }
    if (flips == 0) return;
  }
}

}  // namespace

Mesh make_grid(const GridOptions& options) {
  check(options);
  std::vector<Vec2> X = lattice(options);
  if (options.pattern == GridPattern::Irregular) jitter(options, X);
  const auto faces = triangles(options, X);
  std::vector<Vec3> x;
  x.reserve(X.size());
  for (const Vec2& P : X) x.emplace_back(options.origin + P.x() * options.u + P.y() * options.v);
  Mesh mesh(std::move(X), std::move(x), faces);
  if (options.pattern == GridPattern::Irregular) make_delaunay(mesh);
  return mesh;
}

}  // namespace crease
