// SPDX-License-Identifier: MIT
#include "guard.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include <Eigen/Geometry>

#include "crease/geometry/triangle.hpp"
#include "shift.hpp"
#include "strain.hpp"

namespace crease {

namespace {

// A border that bends by more [rad] is a shape of its own: without the vertex there the cloth would lose area. Splits
// leave bends of rounding.
constexpr double straight = 1e-9;

constexpr double infinity = std::numeric_limits<double>::infinity();

double angle_between(const Vec3& m, const Vec3& n) {
  if (m.isZero(0)) return 0;  // no direction to lose
  if (n.isZero(0)) return std::numbers::pi;
  return std::atan2(m.cross(n).norm(), m.dot(n));
}

Vec3 normal_of(const std::array<Vec3, 3>& x) {
  const Vec3 n = (x[1] - x[0]).cross(x[2] - x[0]);
  const double length = n.norm();
  return length > 0 ? Vec3(n / length) : Vec3::Zero();
}

// The obstacle edge whose chain a vertex is in, as a tag; 0 for corners and Lagrangian vertices.
int line_of(const Cloth& cloth, int vertex) {
  const FeatureId& f = cloth.feature[vertex];
  return f.kind == FeatureKind::Edge ? edge_tag(f.obstacle, f.index) : 0;
}

// A fold that has lifted off an edge, and the chain found again on that edge behind it, are not one line: between them
// there is cloth. But a fold may also have lifted off in part.
bool in_two_chains(const Cloth& cloth, int a, int b) {
  if (cloth.feature[a].lifted == cloth.feature[b].lifted) return false;
  const Mesh& mesh = cloth.mesh;
  const auto are_linked = [&](int u, int v) {
    const int h = mesh.find_edge(u, v);
    return h != Mesh::none && mesh.tag(h) != 0;
  };
  const std::vector<int> around = mesh.neighbours(a);
  return !are_linked(a, b) &&
         std::none_of(around.begin(), around.end(), [&](int u) { return are_linked(a, u) && are_linked(u, b); });
}

// Whether one obstacle edge holds all three corners of a face with one corner at a target.
bool in_one_line(const Cloth& cloth, const Target& target, int s, int t) {
  const int line = std::max(line_of(cloth, s), line_of(cloth, t));
  if (line == 0 || target.a == Mesh::none || !on_line(cloth, s, line) || !on_line(cloth, t, line)) return false;
  if (in_two_chains(cloth, s, t) || in_two_chains(cloth, target.a, s) || in_two_chains(cloth, target.a, t))
    return false;
  return on_line(cloth, target.a, line) && (target.b == Mesh::none || on_line(cloth, target.b, line));
}

struct NearestFace {
  double inside = -infinity;  // smallest barycentric coordinate
  double shift = 0;
};

void offer(NearestFace& nearest, const std::array<Vec2, 3>& X, const std::array<Vec3, 3>& x, const Vec2& P,
           const Vec3& p) {
  Vec3 b = barycentric(X, P);
  if (!(b.minCoeff() > nearest.inside)) return;
  nearest.inside = b.minCoeff();
  b = b.cwiseMax(0.0);
  b /= b.sum();
  nearest.shift = (b[0] * x[0] + b[1] * x[1] + b[2] * x[2] - p).norm();
}

// Whether there is no feature between a vertex's faces and those that are left when it has gone to its target.
bool leaves_features(const Cloth& cloth, int vertex, const Target& target, double shift,
                     const Surroundings& surroundings) {
  if (surroundings.empty()) return true;
  const Mesh& mesh = cloth.mesh;
  std::vector<Swept> swept;
  std::vector<FeatureId> held{cloth.feature[vertex]};
  for (const int h : mesh.outgoing(vertex)) {
    const int s = mesh.to(h), t = mesh.opposite(h);
    held.insert(held.end(), {cloth.feature[s], cloth.feature[t]});
    if (s != target.a && t != target.a)
      swept.push_back({{mesh.x[vertex], target.x, mesh.x[s], mesh.x[t]}, {true, false, false, false}});
  }
  return surroundings.allow(swept, shift, held);
}

// Which side of a line something is on: 1, -1, or 0 where rounding may decide.
int certain_side(double left, double right) {
  constexpr double rounding = 1e-14;  // a few units of the products that it is the difference of
  const double difference = left - right, bound = rounding * (std::abs(left) + std::abs(right));
  return difference > bound ? 1 : difference < -bound ? -1 : 0;
}

// What becomes of the vertex's own panel.
Verdict judge_removal(const Cloth& cloth, int vertex, int into, const GuardLimits& limits) {
  const Mesh& mesh = cloth.mesh;
  const Target target = at_vertex(mesh, into);
  if (left_behind(mesh, vertex, target) > limits.shift) return {RefusalReason::WouldMoveSurface};
  if (!mesh.can_collapse_vertex(vertex, into)) return {RefusalReason::NotManifold};
  const Ring ring = ring_after(cloth, vertex, target);
  if (!ring.sound) return {RefusalReason::WouldInvert};
  if (ring.angle < std::min(least_angle, ring.angle_before)) return {RefusalReason::TooThin};
  if (ring.turn > limits.turn) return {RefusalReason::WouldMoveSurface};
  const double shift = shift_after(cloth, vertex, target, ring);
  if (shift > limits.shift) return {RefusalReason::WouldMoveSurface};
  if (!leaves_features(cloth, vertex, target, shift, limits.surroundings)) return {RefusalReason::NearObstacle};
  if (strain_gained(cloth.mesh, vertex, target) > unfelt_strain) return {RefusalReason::WouldMoveSurface};
  return {std::nullopt, shift};
}

}  // namespace

// The face that holds the vertex lies, seen from the target, to both sides of it; where none surely does, all are
// asked.
double left_behind(const Mesh& mesh, int vertex, const Target& target) {
  const Vec2 P = mesh.X[vertex] - target.X;
  NearestFace nearest;
  const auto is_left = [&](int h) { return mesh.to(h) != target.a && mesh.opposite(h) != target.a; };
  const auto ask = [&](int h) {
    const int s = mesh.to(h), t = mesh.opposite(h);
    offer(nearest, {target.X, mesh.X[s], mesh.X[t]}, {target.x, mesh.x[s], mesh.x[t]}, mesh.X[vertex], mesh.x[vertex]);
  };
  int holder = Mesh::none;
  const bool is_certain = mesh.all_outgoing(vertex, [&](int h) {
    if (!is_left(h)) return true;
    const Vec2 S = mesh.X[mesh.to(h)] - target.X, T = mesh.X[mesh.opposite(h)] - target.X;
    const int after = certain_side(S.x() * P.y(), S.y() * P.x()), before = certain_side(P.x() * T.y(), P.y() * T.x());
    if (after > 0 && before > 0) holder = h;
    return after != 0 && before != 0;
  });
  if (is_certain && holder != Mesh::none) {
    ask(holder);
    return nearest.shift;
  }
  mesh.all_outgoing(vertex, [&](int h) {
    if (is_left(h)) ask(h);
    return true;
  });
  return nearest.shift;
}

Target at_vertex(const Mesh& mesh, int vertex) {
  return {mesh.X[vertex], mesh.x[vertex], vertex};
}

Target on_edge(const Mesh& mesh, int a, int b, double t) {
  return {(1 - t) * mesh.X[a] + t * mesh.X[b], (1 - t) * mesh.x[a] + t * mesh.x[b], a, b};
}

bool on_line(const Cloth& cloth, int vertex, int tag) {
  const FeatureId& f = cloth.feature[vertex];
  if (f.kind == FeatureKind::Edge) return edge_tag(f.obstacle, f.index) == tag;
  if (f.kind == FeatureKind::None) return false;
  for (const int h : cloth.mesh.outgoing(vertex))
    if (cloth.mesh.tag(h) == tag || cloth.mesh.tag(Mesh::prev(h)) == tag) return true;
  return false;
}

bool in_one_line(const Cloth& cloth, int a, int b, int c) {
  const int line = std::max({line_of(cloth, a), line_of(cloth, b), line_of(cloth, c)});
  return line != 0 && on_line(cloth, a, line) && on_line(cloth, b, line) && on_line(cloth, c, line) &&
         !in_two_chains(cloth, a, b) && !in_two_chains(cloth, b, c) && !in_two_chains(cloth, c, a);
}

Ring ring_after(const Cloth& cloth, int vertex, const Target& target) {
  const Mesh& mesh = cloth.mesh;
  Ring ring{.altitude = infinity, .altitude_before = infinity, .angle = infinity, .angle_before = infinity};
  NearestFace nearest;
  for (const int h : mesh.outgoing(vertex)) {
    const int f = Mesh::face_of(h), s = mesh.to(h), t = mesh.opposite(h);
    const auto X_old = material_corners(mesh, f);
    ring.altitude_before = std::min(ring.altitude_before, smallest_altitude(X_old));
    ring.angle_before = std::min(ring.angle_before, smallest_angle(X_old));
    const bool has_a = s == target.a || t == target.a;
    const bool has_b = target.b == Mesh::none || s == target.b || t == target.b;
    if (has_a && has_b) continue;  // vanishes
    const std::array<Vec2, 3> X{target.X, mesh.X[s], mesh.X[t]};
    const std::array<Vec3, 3> x{target.x, mesh.x[s], mesh.x[t]};
    if (!(orient2d(X[0], X[1], X[2]) > 0) || in_one_line(cloth, target, s, t)) return {.sound = false};
    ring.altitude = std::min(ring.altitude, smallest_altitude(X));
    ring.angle = std::min(ring.angle, smallest_angle(X));
    ring.turn = std::max(ring.turn, angle_between(face_normal(mesh, f), normal_of(x)));
    offer(nearest, X, x, mesh.X[vertex], mesh.x[vertex]);
  }
  ring.shift = nearest.shift;
  return ring;
}

FlipCheck flip_check(const Cloth& cloth, int h) {
  const Mesh& mesh = cloth.mesh;
  if (!mesh.can_flip(h)) return {};
  const int g = mesh.twin(h);
  const int a = mesh.from(h), b = mesh.opposite(h), c = mesh.to(h), d = mesh.opposite(g);
  if (in_one_line(cloth, d, b, a) || in_one_line(cloth, b, d, c)) return {};
  const auto& X = mesh.X;
  const std::array<Vec2, 3> abc_1{X[d], X[b], X[a]}, abc_2{X[b], X[d], X[c]};
  const auto old_1 = material_corners(mesh, Mesh::face_of(h)), old_2 = material_corners(mesh, Mesh::face_of(g));
  FlipCheck check{.sound = true};
  check.altitude = std::min(smallest_altitude(abc_1), smallest_altitude(abc_2));
  check.altitude_before = std::min(smallest_altitude(old_1), smallest_altitude(old_2));
  check.angle = std::min(smallest_angle(abc_1), smallest_angle(abc_2));
  check.angle_before = std::min(smallest_angle(old_1), smallest_angle(old_2));
  check.dihedral = angle_between(face_normal(mesh, Mesh::face_of(h)), face_normal(mesh, Mesh::face_of(g)));
  return check;
}

Verdict judge_flip(const Cloth& cloth, int h, const GuardLimits& limits) {
  const Mesh& mesh = cloth.mesh;
  const double shift = flip_shift(mesh, h);
  if (shift > limits.shift) return {RefusalReason::WouldMoveSurface};
  const FlipCheck check = flip_check(cloth, h);
  if (!check.sound) return {RefusalReason::WouldInvert};
  if (check.angle < std::min(least_angle, check.angle_before)) return {RefusalReason::TooThin};
  if (check.dihedral > flip_dihedral) return {RefusalReason::WouldMoveSurface};
  if (!limits.surroundings.empty()) {
    const int a = mesh.from(h), b = mesh.opposite(h), c = mesh.to(h), d = mesh.opposite(mesh.twin(h));
    const std::array swept{Swept{{mesh.x[a], mesh.x[b], mesh.x[c], mesh.x[d]}, {true, false, true, false}}};
    const std::array held{cloth.feature[a], cloth.feature[b], cloth.feature[c], cloth.feature[d]};
    if (!limits.surroundings.allow(swept, shift, held)) return {RefusalReason::NearObstacle};
  }
  if (strain_gained_by_flip(mesh, h) > unfelt_strain) return {RefusalReason::WouldMoveSurface};
  return {std::nullopt, shift};
}

// A chain is thinned along itself only: its ends, its corners and its course stay. A seam is thinned on both sides.
Verdict judge_collapse(const Cloth& cloth, int vertex, int into, const GuardLimits& limits) {
  const Mesh& mesh = cloth.mesh;
  if (cloth.pins[vertex] != 0) return {RefusalReason::Pinned};
  const bool along_chain = mesh.tag(mesh.find_edge(vertex, into)) != 0;
  if (cloth.is_eol(vertex) &&
      (!along_chain || cloth.feature[vertex].kind != FeatureKind::Edge || mesh.is_border_vertex(vertex)))
    return {RefusalReason::WouldLoseChain};
  if (mesh.on_seam(vertex) && !mesh.can_collapse_vertex(vertex, into)) return {RefusalReason::OnSeam};
  if (mesh.is_material_corner(vertex, straight)) return {RefusalReason::AtCorner};
  const Verdict here = judge_removal(cloth, vertex, into, limits);
  const Mesh::Ends tied = mesh.across_seam(vertex, into);
  if (here.trouble || tied.vertex == Mesh::none) return here;
  const Verdict there = judge_removal(cloth, tied.vertex, tied.into, limits);
  return there.trouble ? there : Verdict{std::nullopt, std::max(here.shift, there.shift)};
}

Verdict judge_slide(const Cloth& cloth, int vertex, const Target& target, double least_altitude,
                    const GuardLimits& limits) {
  const Ring ring = ring_after(cloth, vertex, target);
  if (!ring.sound) return {RefusalReason::WouldInvert};
  if (ring.altitude < std::min(least_altitude, ring.altitude_before)) return {RefusalReason::TooThin};
  const double shift = shift_after(cloth, vertex, target, ring);
  if (ring.turn > limits.turn || shift > limits.shift) return {RefusalReason::WouldMoveSurface, shift};
  if (!leaves_features(cloth, vertex, target, shift, limits.surroundings)) return {RefusalReason::NearObstacle};
  if (strain_gained(cloth.mesh, vertex, target) > unfelt_strain) return {RefusalReason::WouldMoveSurface};
  return {std::nullopt, shift};
}

}  // namespace crease
