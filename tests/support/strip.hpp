// SPDX-License-Identifier: MIT
#pragma once

// The strip that slides over a table's edge: the one scene of this field with an exact solution.
//
// An inextensible strip of length L lies on a frictionless table with an overhang x0 and is let go. With k^2 = g/L:
//   overhang x = x0 cosh(k t),   tension at the edge T = rho g x (L - x)/L,   edge reaction (T - rho v^2)(1, 1) per
//   width, the fold leaves the edge when T = rho v^2, at x_lift = (L + sqrt(L^2 + 8 x0^2))/4.
// (Newton's law along the path; the reaction is the momentum balance of the fold, through which rho v^2 flows.)

#include <cmath>
#include <numbers>
#include <span>
#include <vector>

#include "crease/geometry/cloth.hpp"
#include "crease/geometry/grid.hpp"
#include "crease/geometry/obstacle.hpp"
#include "crease/stepper/step.hpp"

namespace crease::testing {

struct Strip {
  double L = 1, W = 0.2, x0 = 0.3, rho = 0.1, E = 1e4, g = 9.81;
  double k() const { return std::sqrt(g / L); }
  double overhang(double t) const { return x0 * std::cosh(k() * t); }
  double speed(double t) const { return x0 * k() * std::sinh(k() * t); }
  double tension(double t) const { return rho * g * overhang(t) * (L - overhang(t)) / L; }
  double lift_overhang() const { return (L + std::sqrt(L * L + 8 * x0 * x0)) / 4; }
  double lift_time() const { return std::acosh(lift_overhang() / x0) / k(); }
  Material material() const { return {.density = rho, .youngs = E, .poisson = 0, .bending = 0, .damping = 0}; }
};

/// Box whose top is z = 0 for x < 0 and whose side is x = 0 for z < 0.
inline Obstacle strip_table() {
  Obstacle table;
  table.name = "table";
  table.shape = make_box({4, 4, 4});
  table.start.position = {-2, 0, -2};
  return table;
}

/// The edge of the table that runs along y through the origin.
inline int strip_edge(const Obstacle& table) {
  for (std::size_t e = 0; e < table.shape.edges.size(); ++e) {
    const Vec3 a = table.start.to_world(table.shape.edges[e].a), b = table.start.to_world(table.shape.edges[e].b);
    if (std::abs(a.x()) + std::abs(b.x()) + std::abs(a.z()) + std::abs(b.z()) < 1e-9) return static_cast<int>(e);
  }
  return -1;
}

/// The strip at release, stretched by the tension it will have at once, so that no wave is excited:
/// eps = rho g x0 s/(L E) on the table, rho g (1 - x0/L)(L - s)/E below it, s = material coordinate from the tail.
inline Cloth make_strip(const Strip& strip, std::array<int, 2> cells, GridPattern pattern, bool mark_fold) {
  GridOptions grid;
  grid.size = {strip.L, strip.W};
  grid.cells = cells;
  grid.pattern = pattern;
  Cloth cloth = make_cloth(make_grid(grid));
  const double fold = strip.L - strip.x0, on_table = strip.rho * strip.g * strip.x0 / (strip.L * strip.E);
  const double below = strip.rho * strip.g * (1 - strip.x0 / strip.L) / strip.E;
  for (int i = 0; i < cloth.mesh.n_vertices(); ++i) {
    const double s = cloth.mesh.X[i].x(), y = cloth.mesh.X[i].y() - strip.W / 2;
    if (s <= fold + 1e-12) {
      cloth.mesh.x[i] = {-(fold - s) - on_table * (fold * fold - s * s) / 2, y, 0};
    } else {
      const double l = strip.L - s;
      cloth.mesh.x[i] = {0, y, -(s - fold) - below * (strip.x0 * strip.x0 - l * l) / 2};
    }
  }
  if (!mark_fold) return cloth;
  const int edge = strip_edge(strip_table());
  for (int i = 0; i < cloth.mesh.n_vertices(); ++i)
    if (std::abs(cloth.mesh.X[i].x() - fold) < 1e-9) {
      cloth.mesh.x[i] = {0, cloth.mesh.x[i].y(), 0};
      cloth.feature[i] = {0, FeatureKind::Edge, edge};
    }
  for (const int h : cloth.mesh.edges())
    if (cloth.is_eol(cloth.mesh.from(h)) && cloth.is_eol(cloth.mesh.to(h))) cloth.mesh.set_tag(h, edge_tag(0, edge));
  return cloth;
}

/// Turns a whole scene about the origin.
inline void rotate(Cloth& cloth, Obstacle& obstacle, const Mat3& R) {
  for (auto& x : cloth.mesh.x) x = R * x;
  for (auto& v : cloth.v) v = R * v;
  obstacle.start.position = R * obstacle.start.position;
  obstacle.start.rotation = R * obstacle.start.rotation;
}

/// Mean material overhang behind the fold, and the spread of Xdot along it.
struct Fold {
  double overhang = 0, speed = 0, speed_spread = 0;
  int vertices = 0;
};
inline Fold measure_fold(const Cloth& cloth, double L) {
  Fold fold;
  double low = 1e300, high = -1e300;
  for (int i = 0; i < cloth.mesh.n_vertices(); ++i) {
    if (!cloth.is_eol(i)) continue;
    ++fold.vertices;
    fold.overhang += L - cloth.mesh.X[i].x();
    fold.speed -= cloth.V[i].x();
    low = std::min(low, cloth.V[i].x());
    high = std::max(high, cloth.V[i].x());
  }
  if (fold.vertices > 0) fold.overhang /= fold.vertices, fold.speed /= fold.vertices, fold.speed_spread = high - low;
  return fold;
}

}  // namespace crease::testing
