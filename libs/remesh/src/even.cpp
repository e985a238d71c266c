// SPDX-License-Identifier: MIT
#include "even.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <vector>

namespace crease {

namespace {

// Steps of the search, in lengths of the shortest edge wanted in any direction: halved while none of the ways leads on.
constexpr double first_step = 0.25, last_step = 0.01;
// A step must gain this share of the fit squared, a slide that leaves an edge too short this share of the fit: so
// neither goes on for ever.
constexpr double step_gain = 1.002, slide_gain = 1.05;
// Altitude of faces, in the same unit: with edges of at least one half, angles of 23 degrees.
constexpr double least_altitude = 0.2;
constexpr double straight = 1e-9;

// A vertex's edges and faces, seen from any place it may take.
struct Star {
  std::vector<Vec2> X;    // of the neighbours
  std::vector<Tensor> M;  // of the edges to them
  bool is_closed;
  double altitude;             // that faces must keep
  double squared_longest = 1;  // that edges may have

  Star(const Mesh& mesh, int vertex, std::span<const Tensor> sizes, double altitude_)
      : is_closed(!mesh.is_border_vertex(vertex)), altitude(altitude_) {
    for (const int u : mesh.neighbours(vertex)) {
      X.push_back(mesh.X[u]);
      M.push_back(0.5 * (sizes[vertex] + sizes[u]));
      squared_longest = std::max(squared_longest, M.back().along(X.back() - mesh.X[vertex]));
    }
  }
  double squared_fit(const Vec2& P) const;
};

// 0 where an edge would be too long, a face too thin or turned over.
double Star::squared_fit(const Vec2& P) const {
  double shortest = std::numeric_limits<double>::infinity(), longest = 0;
  for (std::size_t k = 0; k < X.size(); ++k) {
    const double squared = M[k].along(X[k] - P);
    shortest = std::min(shortest, squared);
    longest = std::max(longest, squared);
    if (k + 1 == X.size() && !is_closed) break;
    const Vec2 &S = X[k], &T = X[k + 1 == X.size() ? 0 : k + 1];
    const double doubled = cross2(S - P, T - P);
    if (!(doubled > 0 && doubled * doubled >= altitude * altitude * (T - S).squaredNorm())) return 0;
  }
  return longest > 0 && longest <= squared_longest ? std::min(shortest / (short_below * short_below), 1 / longest) : 0;
}

}  // namespace

bool is_free_to_slide(const Cloth& cloth, int vertex) {
  const Mesh& mesh = cloth.mesh;
  if (cloth.is_eol(vertex) || cloth.pins[vertex] != 0 || mesh.on_seam(vertex)) return false;
  return !mesh.is_border_vertex(vertex) || mesh.border_turn(vertex) <= straight;
}

bool is_flat(const Cloth& cloth, int vertex, double tolerance) {
  const Mesh& mesh = cloth.mesh;
  const auto& [a, b, c] = mesh.face(Mesh::face_of(mesh.halfedge(vertex)));
  const Vec2 P = mesh.X[a], U = mesh.X[b] - P, W = mesh.X[c] - P;
  const Vec3 p = mesh.x[a], u = mesh.x[b] - p, w = mesh.x[c] - p;
  const double area = cross2(U, W);
  return mesh.all_outgoing(vertex, [&](int h) {
    for (const int v : {mesh.to(h), mesh.opposite(h)}) {
      const Vec2 D = mesh.X[v] - P;
      const Vec3 aside = area * (mesh.x[v] - p) - cross2(D, W) * u - cross2(U, D) * w;
      if (!(aside.squaredNorm() <= area * area * tolerance * tolerance)) return false;
    }
    return true;
  });
}

std::optional<Slide> slide_to_even_lengths(const Cloth& cloth, int vertex, std::span<const Tensor> sizes, double enough,
                                           const GuardLimits& limits) {
  const Mesh& mesh = cloth.mesh;
  const double unit = 1 / std::sqrt(sizes[vertex].large());
  const Star star(mesh, vertex, sizes, least_altitude * unit);
  const double before = Star(mesh, vertex, sizes, 0).squared_fit(mesh.X[vertex]);
  if (before >= enough * enough) return std::nullopt;
  const std::vector<Vec2> directions = ways_to_slide(mesh, vertex);
  Vec2 X = mesh.X[vertex];
  double fit = star.squared_fit(X);
  for (double step = first_step; step > last_step;) {
    Vec2 best = X;
    double best_fit = step_gain * fit;
    for (const Vec2& way : directions) {
      const Vec2 P = X + step * unit * way;
      if (const double there = star.squared_fit(P); there > best_fit) best = P, best_fit = there;
    }
    if (best == X)
      step /= 2;
    else
      X = best, fit = best_fit;
  }
  if (fit < std::min(enough * enough, slide_gain * slide_gain * before)) return std::nullopt;
  std::optional<Slide> slide = place_in_star(cloth, vertex, X);
  if (!slide) return std::nullopt;
  const Verdict verdict = judge_slide(cloth, vertex, {slide->X, slide->x}, least_altitude * unit, limits);
  if (verdict.trouble) return std::nullopt;
  slide->shift = verdict.shift;
  return slide;
}

}  // namespace crease
