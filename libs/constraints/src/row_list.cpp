// SPDX-License-Identifier: MIT
#include "row_list.hpp"

#include <algorithm>
#include <cmath>
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

void FreeDirections::fix_axis(int vertex, int axis) {
  free_[vertex](axis, axis) = 0;
}

void FreeDirections::fix_all_but(int vertex, const Vec3& direction) {
  free_[vertex] = direction * direction.transpose();
}

bool FreeDirections::leaves_free(const Vec3& direction, std::span<const Term> terms) const {
  double whole = 0, rest = 0;
  for (const Term& term : terms) {
    whole += term.weight * term.weight * direction.squaredNorm();
    rest += term.weight * term.weight * (free_[term.vertex] * direction).squaredNorm();
  }
  return rest > smallest_free_share * smallest_free_share * whole;
}

double gap_velocity(double gap, const ConstraintOptions& options) {
  return gap >= 0 ? -gap / options.h : std::min(-gap, 0.5 * options.threshold) / options.h;
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
  std::vector<Eigen::Triplet<double, int>> entries;
  entries.reserve(9 * rows.size());
  for (int r = 0; r < static_cast<int>(rows.size()); ++r) {
    for (int i = 0; i < rows[r].n; ++i) entries.emplace_back(r, rows[r].columns[i], rows[r].values[i]);
  }
  SparseRows A(static_cast<int>(rows.size()), n_columns);
  A.setFromTriplets(entries.begin(), entries.end());
  return A;
}

VecX make_bounds(const std::vector<Row>& rows) {
  VecX b(static_cast<int>(rows.size()));
  for (int r = 0; r < b.size(); ++r) b[r] = rows[r].bound;
  return b;
}

}  // namespace crease
