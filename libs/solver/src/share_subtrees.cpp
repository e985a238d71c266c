// SPDX-License-Identifier: MIT
#include <algorithm>
#include <numeric>

#include "supernode_tree.hpp"

namespace crease {
namespace {

/// Subtrees that are opened in search of a better balance, a worker. Later ones are too small to matter.
constexpr int most_opened = 16;

/// Largest first, each to the worker with the least so far. @return what the slowest has
double share_out(const std::vector<int>& subtrees, const std::vector<double>& time, std::vector<int>& worker,
                 int n_parts) {
  std::vector<double> sum(static_cast<std::size_t>(n_parts), 0.0);
  worker.clear();
  for (const int s : subtrees) {
    const auto least = std::min_element(sum.begin(), sum.end());
    *least += time[s];
    worker.push_back(static_cast<int>(least - sum.begin()));
  }
  return *std::max_element(sum.begin(), sum.end());
}

}  // namespace

std::vector<int> share_subtrees(const std::vector<int>& parent, const std::vector<double>& time, int n_parts) {
  const auto n = static_cast<int>(parent.size());
  std::vector<double> whole = time;  // of each subtree
  std::vector<std::vector<int>> children(parent.size() + 1);
  for (int s = 0; s < n; ++s) {
    if (parent[s] >= 0) whole[parent[s]] += whole[s];
    children[parent[s] < 0 ? n : parent[s]].push_back(s);
  }
  const auto longer = [&](int a, int b) { return whole[a] != whole[b] ? whole[a] > whole[b] : a < b; };
  std::vector<int> subtrees = children.back(), worker, best(parent.size(), n_parts);
  double top = 0, least = std::accumulate(time.begin(), time.end(), 0.0);
  for (int opened = 0; !subtrees.empty() && opened <= most_opened * n_parts; ++opened) {
    std::sort(subtrees.begin(), subtrees.end(), longer);
    if (const double slowest = top + share_out(subtrees, whole, worker, n_parts); slowest < least) {
      least = slowest;
      std::fill(best.begin(), best.end(), n_parts);
      for (std::size_t k = 0; k < subtrees.size(); ++k) best[subtrees[k]] = worker[k];
    }
    const int largest = subtrees.front();
    top += time[largest];
    subtrees.erase(subtrees.begin());
    subtrees.insert(subtrees.end(), children[largest].begin(), children[largest].end());
  }
  for (int s = n - 1; s >= 0; --s)
    if (parent[s] >= 0 && best[parent[s]] < n_parts) best[s] = best[parent[s]];
  return best;
}

}  // namespace crease
