// SPDX-License-Identifier: MIT
#pragma once

#include <array>
#include <span>
#include <vector>

#include "crease/constraints/rows.hpp"

namespace crease {

/// One row before it stands in a matrix: sum values[i] qdot[columns[i]] (= or >=) bound; columns ascend.
struct Row {
  RowInfo info;
  int n = 0;
  std::array<int, 9> columns{};
  std::array<double, 9> values{};
  double bound = 0;
};

/// A vertex and its share in a point of the cloth.
struct Term {
  int vertex = -1;
  double weight = 0;
};

/// direction . sum w_i xdot_i; `info.normal` is the direction.  @pre terms ascend by vertex
Row world_row(const RowInfo& info, std::span<const Term> terms, double bound, const DofMap& dofs);

/// direction . Xdot_vertex = 0.  @pre info.vertex is EOL
Row material_row(const RowInfo& info, const Vec2& direction, const DofMap& dofs);

/// Which directions of xdot no equality row has fixed yet: one orthogonal projector a vertex, kept for those vertices
/// alone that have an equality.
class FreeDirections {
 public:
  explicit FreeDirections(int n_vertices) : place_(n_vertices, -1) {}
  /// @pre only axes are fixed at `vertex` so far
  void fix_axis(int vertex, int axis);
  /// @pre unit directions, orthogonal to each other and to what is fixed so far
  void fix(int vertex, std::span<const Vec3> directions);
  bool untouched(int vertex) const { return place_[vertex] < 0; }
  /// False if the equalities alone decide direction . sum w_i xdot_i, up to a small rest.
  bool leaves_free(const Vec3& direction, std::span<const Term> terms) const;

 private:
  Mat3& projector(int vertex);

  std::vector<int> place_;  // in projectors_, -1 = all free
  std::vector<Mat3> projectors_;
};

/// Velocity towards the cloth's side, relative to the obstacle, that a gap asks for at least [m/s]: a positive gap may
/// close within the step; a penetration is pushed out, no faster than `push_out_speed`, so that a deep one (a bad
/// start, an obstacle that jumps) is not turned into kinetic energy at once.
double gap_velocity(double gap, const ConstraintOptions& options);

/// Sorts by vertex, kind, feature, slot, and numbers contacts that agree in all of these by their order of arrival.
void sort_rows(std::vector<Row>& rows);

/// The matrix of sorted rows, right shape also when there are none.
SparseRows make_matrix(const std::vector<Row>& rows, int n_columns);
VecX make_bounds(const std::vector<Row>& rows);

}  // namespace crease
