// SPDX-License-Identifier: MIT
#include <array>
#include <cmath>

#include "sizing.hpp"

namespace crease {

namespace {

const double log_gradation = std::log(1.4);
constexpr std::size_t max_visits = 24;  // a vertex, on average
// Changes this small decide no edge; they only keep the queue going.
constexpr double least_rise = 1e-6;

// Raises the tensor at `to` to what `from`, an edge e away, allows it to fall to. Returns whether it did. The first
// test is that for no growth at all, and nearly always enough in one direction; the second is that for growth, all
// multiplied by it.
bool spread(const Tensor& from, Tensor& to, const Vec2& e) {
  if (encloses(to, from)) return false;
  const double growth = 1 + std::sqrt(std::max(0.0, from.along(e))) * log_gradation, squared = growth * growth;
  if (encloses(squared * to, from)) return false;
  const Tensor raised = tensor_max(1 / squared * from, to);
  if (raised.radius <= to.radius * (1 + least_rise)) return false;
  to = raised;
  return true;
}

}  // namespace

// A queue of vertices that have something to demand of their neighbours; at first all, seen as edges.
void limit_gradation(const Mesh& mesh, std::vector<Tensor>& tensors) {
  std::vector<int> queue;
  std::vector<char> waits(tensors.size(), 0);
  const auto pass_on = [&](int from, int to) {
    if (!spread(tensors[from], tensors[to], mesh.X[to] - mesh.X[from])) return false;
    if (!waits[to]) queue.push_back(to);
    waits[to] = 1;
    return true;
  };
  // Of two tensors one of which encloses the other, it has nothing to take from that one.
  const auto pass_both_ways = [&](int a, int b) {
    const double slack = tensors[a].radius - tensors[b].radius;
    const bool is_one_in_other = (tensors[a].centre - tensors[b].centre).squaredNorm() <= slack * slack;
    const bool is_raised = (!is_one_in_other || slack > 0) && pass_on(a, b);
    if (!is_one_in_other || slack < 0 || is_raised) pass_on(b, a);
  };
  for (int f = 0; f < mesh.face_slots(); ++f) {
    if (!mesh.face_live(f)) continue;
    const auto [a, b, c] = mesh.face(f);
    if (mesh.twin(3 * f) < 3 * f) pass_both_ways(a, b);
    if (mesh.twin(3 * f + 1) < 3 * f + 1) pass_both_ways(b, c);
    if (mesh.twin(3 * f + 2) < 3 * f + 2) pass_both_ways(c, a);
  }
  const std::size_t budget = max_visits * tensors.size();
  for (std::size_t i = 0; i < queue.size() && i < budget; ++i) {
    const int v = queue[i];
    waits[v] = 0;
    mesh.all_outgoing(v, [&](int h) {
      pass_on(v, mesh.to(h));
      if (mesh.is_border(Mesh::prev(h))) pass_on(v, mesh.opposite(h));
      return true;
    });
  }
}

}  // namespace crease
