// SPDX-License-Identifier: MIT
#include "row_list.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <tuple>

#include "crease/base/require.hpp"

namespace crease {
namespace {

// Share of a row's direction that equalities must leave free for the row to stay. With less, the row could only be met
// by moving the cloth sideways a hundred times faster than the obstacle comes: that is a contradiction, not a contact.
constexpr double smallest_free_share = 1e-2;

auto sort_key(const RowInfo& info) {
  return std::tuple(info.vertex, info.kind, info.feature.obstacle, info.feature.kind, info.feature.index, info.slot);
}

}  // namespace

Row world_row(const RowInfo& info, std::span<const Term> terms, double bound, const DofMap& dofs) {
  CREASE_ASSERT(!terms.empty() && terms.size() <= 3);
  CREASE_ASSERT(std::is_sorted(terms.begin(), terms.end(), [](auto& a, auto& b) { return a.vertex < b.vertex; }));
  Row row{.info = info, .bound = bound};
  for (const Term& term : terms) {
    for (int axis = 0; axis < 3; ++axis) {
      row.columns[row.n] = dofs.x(term.vertex) + axis;
      row.values[row.n] = term.weight * info.normal[axis];
      ++row.n;
    }
  }
  return row;
}

Row material_row(const RowInfo& info, const Vec2& direction, const DofMap& dofs) {
  CREASE_ASSERT(dofs.is_eol(info.vertex));
  Row row{.info = info, .n = 2};
  for (int axis = 0; axis < 2; ++axis) {
    row.columns[axis] = dofs.X(info.vertex) + axis;
    row.values[axis] = direction[axis];
  }
  return row;
}

Mat3& FreeDirections::projector(int vertex) {
  if (place_[vertex] < 0) {
    place_[vertex] = static_cast<int>(projectors_.size());
    projectors_.push_back(Mat3::Identity());
  }
  return projectors_[place_[vertex]];
}

void FreeDirections::fix_axis(int vertex, int axis) {
  projector(vertex)(axis, axis) = 0;
}

void FreeDirections::fix(int vertex, std::span<const Vec3> directions) {
  Mat3& free = projector(vertex);
  for (const Vec3& direction : directions) free -= direction * direction.transpose();
}

bool FreeDirections::leaves_free(const Vec3& direction, std::span<const Term> terms) const {
  double whole = 0, rest = 0;
  for (const Term& term : terms) {
    const Vec3 part = term.weight * direction;
    whole += part.squaredNorm();
    rest += untouched(term.vertex) ? part.squaredNorm() : (projectors_[place_[term.vertex]] * part).squaredNorm();
  }
  const bool decided = rest <= smallest_free_share * smallest_free_share * whole;
  return !decided;  // NaN is not decided: the row stays and is found out
}

double gap_velocity(double gap, const ConstraintOptions& options) {
  return gap >= 0 ? -gap / options.h : std::min(-gap / options.h, options.push_out_speed);
}

void sort_rows(std::vector<Row>& rows) {
  std::stable_sort(rows.begin(), rows.end(),
                   [](const Row& a, const Row& b) { return sort_key(a.info) < sort_key(b.info); });
  for (std::size_t i = 1; i < rows.size(); ++i) {
    RowInfo probe = rows[i - 1].info;
    probe.slot = rows[i].info.slot;
    if (rows[i].info.kind == RowKind::Contact && sort_key(probe) == sort_key(rows[i].info)) {
      rows[i].info.slot = rows[i - 1].info.slot + 1;
    }
  }
}

SparseRows make_matrix(const std::vector<Row>& rows, int n_columns) {
  SparseRows A(static_cast<int>(rows.size()), n_columns);
  A.reserve(std::accumulate(rows.begin(), rows.end(), 0, [](int n, const Row& row) { return n + row.n; }));
  for (int r = 0; r < A.rows(); ++r) {
    A.startVec(r);
    for (int i = 0; i < rows[r].n; ++i) A.insertBack(r, rows[r].columns[i]) = rows[r].values[i];
  }
  A.finalize();
  return A;
}

VecX make_bounds(const std::vector<Row>& rows) {
  VecX b(static_cast<int>(rows.size()));
  for (int r = 0; r < b.size(); ++r) b[r] = rows[r].bound;
  return b;
}

}  // namespace crease
