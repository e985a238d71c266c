// SPDX-License-Identifier: MIT
#include "active_rows.hpp"

#include <utility>

#include "crease/geometry/mesh.hpp"

namespace crease {

ActiveRows::Key ActiveRows::key_of(const RowInfo& row) {
  return {row.vertex,           static_cast<int>(row.kind),         row.slot,
          row.feature.obstacle, static_cast<int>(row.feature.kind), row.feature.index};
}

void ActiveRows::remember(const ConstraintRows& rows, const QpResult& solution) {
  active_.clear();
  for (std::size_t r = 0; r < rows.in.size(); ++r)
    if (solution.active[r]) active_.insert(key_of(rows.in[r]));
}

void ActiveRows::renumber(const std::vector<int>& vertex_map) {
  std::set<Key> moved;
  for (const Key& key : active_) {
    const int old = std::get<0>(key);
    if (old < 0 || old >= static_cast<int>(vertex_map.size()) || vertex_map[old] == Mesh::none) continue;
    Key renamed = key;
    std::get<0>(renamed) = vertex_map[old];
    moved.insert(renamed);
  }
  active_ = std::move(moved);
}

std::vector<char> ActiveRows::guess(const ConstraintRows& rows, const VecX& motion) const {
  if (rows.in.empty()) return {};
  const VecX slack = rows.A_in * motion - rows.b_in;
  std::vector<char> start(rows.in.size());
  for (std::size_t r = 0; r < rows.in.size(); ++r)
    start[r] = slack[static_cast<int>(r)] <= 0 || active_.contains(key_of(rows.in[r]));
  return start;
}

}  // namespace crease
