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
    if (!spread(tensors[from], tensors[to], mesh.X[to] - mesh.X[from]) || waits[to]) return;
    waits[to] = 1;
    queue.push_back(to);
  };
  for (int f = 0; f < mesh.face_slots(); ++f) {
    if (!mesh.face_live(f)) continue;
    const std::array<int, 3>& corners = mesh.face(f);
    for (int k = 0; k < 3; ++k) {
      if (mesh.twin(3 * f + k) > 3 * f + k) continue;
      const int a = corners[k], b = corners[k == 2 ? 0 : k + 1];
      pass_on(a, b);
      pass_on(b, a);
    }
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
