// SPDX-License-Identifier: MIT
#pragma once

#include <set>
#include <tuple>
#include <vector>

#include "crease/constraints/rows.hpp"
#include "crease/solver/qp.hpp"

namespace crease {

/// Which inequalities were active in the last solution, by names that outlive the step and its mesh: what the next
/// solution starts from.
class ActiveRows {
 public:
  void remember(const ConstraintRows& rows, const QpResult& solution);
  void forget() { active_.clear(); }
  /// After a remeshing; what was at vertices that are gone is forgotten.
  /// @param vertex_map  of each vertex before: its number now, or Mesh::none
  void renumber(const std::vector<int>& vertex_map);

  /// One entry an inequality: rows that were active stay so at first; others become it where they are broken by the
  /// motion as it is, which is that of the last solution in this step, or that of the sheet. So a front that comes
  /// closer is met on time.
  std::vector<char> guess(const ConstraintRows& rows, const VecX& motion) const;

 private:
  using Key = std::tuple<int, int, int, int, int, int>;
  static Key key_of(const RowInfo& row);

  std::set<Key> active_;
};

}  // namespace crease
