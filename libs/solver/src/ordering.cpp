// SPDX-License-Identifier: MIT
// The only file that calls AMD.
#include "ordering.hpp"

#include <amd.h>

namespace crease {

std::optional<std::vector<int>> choose_order(const BlockGraph& graph, std::span<const int> given) {
  if (!given.empty()) return std::vector<int>(given.begin(), given.end());
  std::vector<int> order(static_cast<std::size_t>(graph.n_blocks()));
  if (order.empty()) return order;  // for which AMD would want an array all the same
  const int status =
      amd_order(graph.n_blocks(), graph.outer.data(), graph.inner.data(), order.data(), nullptr, nullptr);
  if (status != AMD_OK && status != AMD_OK_BUT_JUMBLED) return std::nullopt;
  return order;
}

}  // namespace crease
