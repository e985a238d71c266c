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
// test is that for no growth at all, and nearly always enough in one direction.
bool spread(const Tensor& from, Tensor& to, const Vec2& e) {
  if (encloses(to, from)) return false;
  const double growth = 1 + std::sqrt(std::max(0.0, from.along(e))) * log_gradation;
  const Tensor wanted = 1 / (growth * growth) * from;
  if (encloses(to, wanted)) return false;
  const Tensor raised = tensor_max(std::array{wanted, to});
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
  for (int h = 0; h < 3 * mesh.face_slots(); ++h) {
    if (mesh.twin(h) > h || !mesh.face_live(Mesh::face_of(h))) continue;
    pass_on(mesh.from(h), mesh.to(h));
    pass_on(mesh.to(h), mesh.from(h));
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
