// SPDX-License-Identifier: MIT
// The only file that calls AMD.
#include "ordering.hpp"

#include <amd.h>

namespace crease {

std::vector<int> minimum_degree_order(const BlockGraph& graph) {
  std::vector<int> order(static_cast<std::size_t>(graph.n_blocks()));
  const int status =
      amd_order(graph.n_blocks(), graph.outer.data(), graph.inner.data(), order.data(), nullptr, nullptr);
  if (status != AMD_OK && status != AMD_OK_BUT_JUMBLED) order.clear();
  return order;
}

}  // namespace crease
