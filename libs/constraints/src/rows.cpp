// SPDX-License-Identifier: MIT
#include "crease/constraints/rows.hpp"

#include <algorithm>
#include <cmath>

#include "crease/base/require.hpp"
#include "crease/geometry/chain.hpp"
#include "crease/geometry/wire.hpp"
#include "feature_cone.hpp"
#include "row_list.hpp"

namespace crease {
namespace {

// Share below which a vertex takes no part in a contact: the round-off of barycentric coordinates. Leaving it out keeps
// the row local to fewer vertices, which is what a solver is quick with.
constexpr double smallest_weight = 1e-12;

// Collects the rows of one call; members in the order in which they are made.
struct Builder {
  const Cloth& cloth;
  const DofMap& dofs;
  std::span<const PosedObstacle> obstacles;
  const ConstraintOptions& options;

  FreeDirections free{cloth.mesh.vertex_slots()};
  std::vector<Row> eq = {}, in = {};

  void add_pin(int vertex, std::span<const PinState> pins);
  void add_eol_world(int vertex);
  void add_eol_material(int vertex);
  void add_contact(const Contact& contact);
  void add_inequality(const RowInfo& info, std::span<const Term> terms, double bound);
  ConstraintRows finish();
};

void Builder::add_pin(int vertex, std::span<const PinState> pins) {
  const Term term{vertex, 1.0};
  for (int axis = 0; axis < 3; ++axis) {
    const auto holds = [&](const PinState& pin) {
      return !pin.released && pin.axes[axis] && (cloth.pins[vertex] >> pin.index & 1u) != 0;
    };
    const auto pin = std::find_if(pins.begin(), pins.end(), holds);
    if (pin == pins.end()) continue;
    const RowInfo info{.kind = RowKind::Pin, .vertex = vertex, .feature = {}, .slot = axis, .normal = Vec3::Unit(axis)};
    eq.push_back(world_row(info, {&term, 1}, pin->velocity[axis], dofs));
    free.fix_axis(vertex, axis);
  }
}

// Lagrangian part of Algorithm 2, in other coordinates than the paper's. It asks n_k . xdot >= n_k . v_obstacle of
// every face normal. But material slides freely across the feature, so the reaction is along the cloth's own normal N
// there, which lies in the cone: N . xdot >= N . v_obstacle bears it all. Across it no force acts, on flat cloth no
// inertia either, where x and X slide against each other; there the vertex is held, so that it stands on its feature
// until N opens. The gap is round-off while it does; else the rows lead it back.
void Builder::add_eol_world(int vertex) {
  const FeatureId& feature = cloth.feature[vertex];
  FeatureCone cone = feature_cone(feature, obstacles);
  if (cone.normals.empty()) {
    const Vec3 normal = wire_normal(cloth, vertex, cone.tangent);
    if (!normal.isZero()) lie_on(cone, normal);
  } else if (cone.holds.empty()) {
    lie_on(cone, support_normal(cloth, vertex, cone.tangent, cone.normals));
  }
  const Vec3& x = cloth.mesh.x[vertex];
  const Pose& pose = obstacles[feature.obstacle].pose;
  const Vec3 velocity = pose.velocity_at(x);
  const Term term{vertex, 1.0};
  const auto info = [&](RowKind kind, std::size_t slot, const Vec3& direction) {
    return RowInfo{kind, vertex, feature, static_cast<int>(slot), direction};
  };

  if (!cone.holds.empty() && free.untouched(vertex)) {  // a pin wins: with both, the equalities could contradict
    for (std::size_t k = 0; k < cone.holds.size(); ++k) {
      const double offset = cone.holds[k].dot(x - cone.point);
      const double back = std::copysign(gap_velocity(-std::abs(offset), options), -offset);
      cone.holds[k] = pose.turned(cone.holds[k], options.h);
      eq.push_back(
          world_row(info(RowKind::EolHold, k, cone.holds[k]), {&term, 1}, cone.holds[k].dot(velocity) + back, dofs));
    }
    free.fix(vertex, cone.holds);
  }
  for (std::size_t k = 0; k < cone.normals.size(); ++k) {
    const double gap = cone.normals[k].dot(x - cone.point);
    const Vec3 normal = pose.turned(cone.normals[k], options.h);
    add_inequality(info(RowKind::EolNormal, k, normal), {&term, 1}, normal.dot(velocity) + gap_velocity(gap, options));
  }
}

// Eulerian part of Algorithm 2.
void Builder::add_eol_material(int vertex) {
  const RowKind kind = cloth.mesh.is_border_vertex(vertex) ? RowKind::EolBorder : RowKind::EolTangent;
  const bool is_held = cloth.feature[vertex].away > 0 || (!options.held.empty() && options.held[vertex] != 0);
  int slot = 0;
  for (const Vec2& direction :
       is_held ? std::vector<Vec2>{Vec2::UnitX(), Vec2::UnitY()} : eulerian_rows(cloth, vertex, obstacles)) {
    const RowInfo info{.kind = kind, .vertex = vertex, .feature = cloth.feature[vertex], .slot = slot++};
    eq.push_back(material_row(info, direction, dofs));
  }
}

// The terms of a contact, ascending by the vertex that owns the unknowns, without those that take no part.
std::span<const Term> contact_terms(const Contact& contact, const DofMap& dofs, std::array<Term, 3>& terms) {
  std::size_t n = 0;
  for (int i = 0; i < contact.n_vertices; ++i) {
    if (std::abs(contact.weights[i]) <= smallest_weight) continue;
    const int vertex = dofs.owner(contact.vertices[i]);
    std::size_t place = n++;
    for (; place > 0 && terms[place - 1].vertex > vertex; --place) terms[place] = terms[place - 1];
    terms[place] = {vertex, contact.weights[i]};
  }
  return {terms.data(), n};
}

// What touches on a seam is found on both of its sides; the second row would only repeat the first.
bool is_repeated(const Row& row, const std::vector<Row>& rows) {
  constexpr double rounding = 1e-9;  // weights are shares of 1, normals unit vectors
  return std::any_of(rows.begin(), rows.end(), [&](const Row& other) {
    if (other.n != row.n || other.columns != row.columns || other.info.feature != row.info.feature) return false;
    for (int i = 0; i < row.n; ++i)
      if (std::abs(other.values[i] - row.values[i]) > rounding) return false;
    return true;
  });
}

// The point of the cloth that touches now moves with sum w_i xdot_i, also where a vertex is EOL and material flows
// through that point: it is the surface, not the material, that x + h xdot must keep outside.
void Builder::add_contact(const Contact& contact) {
  const auto on_this_cloth = [&](int vertex) { return vertex >= 0 && vertex < cloth.mesh.vertex_slots(); };
  require(contact.n_vertices >= 1 && contact.n_vertices <= 3 &&
              std::all_of(contact.vertices.begin(), contact.vertices.begin() + contact.n_vertices, on_this_cloth),
          "build_constraints: expected contacts of 1 to 3 vertices of this cloth");
  std::array<Term, 3> buffer;
  const std::span<const Term> terms = contact_terms(contact, dofs, buffer);
  require(!terms.empty(), "build_constraints: expected a contact with at least one weight");
  FeatureId feature = contact.feature;
  feature.obstacle = contact.obstacle;  // also for a face, which is no feature
  require(feature.obstacle >= 0 && static_cast<std::size_t>(feature.obstacle) < obstacles.size(),
          "build_constraints: expected contacts with the given obstacles");
  const Vec3 normal = obstacles[feature.obstacle].pose.turned(contact.normal, options.h);
  const RowInfo info{.kind = RowKind::Contact, .vertex = terms[0].vertex, .feature = feature, .normal = normal};
  const bool on_wire = obstacles[feature.obstacle].shape->kind == ObstacleShape::Kind::Wire;
  const double gap = contact.distance - (on_wire ? options.wire_clearance : 0.0);
  add_inequality(info, terms, normal.dot(contact.velocity) + gap_velocity(gap, options));
}

void Builder::add_inequality(const RowInfo& info, std::span<const Term> terms, double bound) {
  if (!free.leaves_free(info.normal, terms)) return;
  const Row row = world_row(info, terms, bound, dofs);
  if (dofs.owners.empty() || !is_repeated(row, in)) in.push_back(row);
}

ConstraintRows Builder::finish() {
  ConstraintRows rows;
  const auto fill = [&](std::vector<Row>& from, SparseRows& A, VecX& b, std::vector<RowInfo>& info) {
    sort_rows(from);
    A = make_matrix(from, dofs.size());
    b = make_bounds(from);
    for (const Row& row : from) info.push_back(row.info);
    require(b.allFinite() && Eigen::Map<const VecX>(A.valuePtr(), A.nonZeros()).allFinite(),
            "build_constraints: expected finite positions, velocities, poses and contacts");
  };
  fill(eq, rows.A_eq, rows.b_eq, rows.eq);
  fill(in, rows.A_in, rows.b_in, rows.in);
  return rows;
}

}  // namespace

ConstraintRows build_constraints(const Cloth& cloth, const DofMap& dofs, std::span<const Contact> contacts,
                                 std::span<const PosedObstacle> obstacles, std::span<const PinState> pins,
                                 const ConstraintOptions& options) {
  const int n = cloth.mesh.vertex_slots();
  require(options.h > 0 && options.push_out_speed >= 0, "build_constraints: expected h > 0 and push_out_speed >= 0");
  require(static_cast<int>(dofs.start.size()) == n + 1, "build_constraints: expected the dof map of this cloth");
  require(options.held.empty() || static_cast<int>(options.held.size()) == n,
          "build_constraints: expected `held` for all vertices or for none");
  for (const PinState& pin : pins) {
    require(pin.index >= 0 && pin.index < 64, "build_constraints: expected pin indices in [0, 64)");
  }

  Builder builder{cloth, dofs, obstacles, options};
  builder.in.reserve(contacts.size() + 2 * static_cast<std::size_t>(cloth.n_eol()));
  for (int vertex = 0; vertex < n; ++vertex) {
    require(dofs.is_eol(vertex) == cloth.is_eol(vertex), "build_constraints: expected the dof map of this cloth");
    if (cloth.pins[vertex] != 0 && dofs.owner(vertex) == vertex) builder.add_pin(vertex, pins);
    if (!cloth.is_eol(vertex)) continue;
    if (cloth.rides(vertex)) builder.add_eol_world(vertex);
    builder.add_eol_material(vertex);
  }
  for (const Contact& contact : contacts) builder.add_contact(contact);
  return builder.finish();
}

}  // namespace crease
