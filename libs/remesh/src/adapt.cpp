// SPDX-License-Identifier: MIT
#include <algorithm>
#include <cmath>
#include <queue>
#include <tuple>
#include <vector>

#include <Eigen/LU>

#include "crease/base/require.hpp"
#include "crease/geometry/triangle.hpp"
#include "crease/remesh/remesh.hpp"
#include "editor.hpp"
#include "guard.hpp"
#include "metric.hpp"
#include "options.hpp"

// L is the metric length of an edge: 1 is as long as it may be. Queues hold vertex pairs, not edges: vertices keep
// their ids and do not move during a pass, so an entry is up to date exactly when the mesh still has the edge. All
// loops share one budget of operations.
namespace crease {

namespace {

constexpr double split_above = 1.0;
// A collapse may not make an edge longer than this: its distance to split_above is the hysteresis.
constexpr double collapse_below = 0.85;
// Edges longer than this are not tried: removing one of their ends leaves edges longer than collapse_below.
constexpr double collapse_candidate = 0.6;
// A flip needs the opposite angles to exceed 180 degrees by this (as a sine), so that four points on a circle rest.
constexpr double flip_margin = 0.1;
// A collapse may move the surface by this share of the shortest edge, and turn a normal by this [rad].
constexpr double shift_share = 0.02;
constexpr double normal_turn = 0.35;
// Rounds of flips, splits and collapses; each after the first only if the one before did something. The sizes are those
// at the start: new vertices lie on the old facets, so curvature measured again at once would refine every facet's rim.
constexpr int max_rounds = 4;
// Operations per face wanted.
constexpr double budget_share = 20;

struct Candidate {
  double length;
  int a, b;
};
// Ties fall to the lower vertex ids, so the order never depends on how the queue is built.
bool later_split(const Candidate& p, const Candidate& q) {
  return std::tie(p.length, q.a, q.b) < std::tie(q.length, p.a, p.b);
}
bool later_collapse(const Candidate& p, const Candidate& q) {
  return std::tie(p.length, p.a, p.b) > std::tie(q.length, q.a, q.b);
}
using Queue = std::priority_queue<Candidate, std::vector<Candidate>, bool (*)(const Candidate&, const Candidate&)>;

class Adapter {
 public:
  Adapter(const Cloth& cloth, const AdaptOptions& options) : editor_(cloth), options_(options) {}

  RemeshResult run() && {
    sizes_ = sizing_field(editor_.cloth(), options_);
    budget_ = operations_allowed();
    for (int round = 0; round < max_rounds && !spent_; ++round) {
      const int before = operations();
      flip_around(mesh().edges());
      split_long_edges();
      collapse_short_edges();
      if (operations() == before) break;
    }
    return std::move(editor_).finish();
  }

 private:
  const Cloth& cloth() const { return editor_.cloth(); }
  const Mesh& mesh() const { return editor_.mesh(); }

  int operations() {
    const RemeshReport& r = editor_.report();
    return r.splits + r.flips + r.collapses;
  }
  int operations_allowed() const;
  bool may_go_on(int vertex);
  double length(int a, int b) const { return metric_length(mesh().X[b] - mesh().X[a], sizes_[a], sizes_[b]); }
  double length(int h) const { return length(mesh().from(h), mesh().to(h)); }

  void flip_around(const std::vector<int>& halfedges);
  bool should_flip(int h) const;
  void split_long_edges();
  void split(int h, Queue& queue);
  void collapse_short_edges();
  bool may_go(int p, int q) const;
  bool leaves_short_edges(int p, int q) const;
  bool should_collapse(int p, int q) const;
  void collapse(int p, int q, Queue& queue);
  std::vector<int> halfedges_of(const std::vector<int>& faces) const;
  Candidate candidate(int h, double L) const {
    return {L, std::min(mesh().from(h), mesh().to(h)), std::max(mesh().from(h), mesh().to(h))};
  }
  void push_splits(Queue& queue, const std::vector<int>& halfedges) const;
  void push_collapses(Queue& queue, const std::vector<int>& halfedges) const;

  Editor editor_;
  const AdaptOptions& options_;
  std::vector<Mat2> sizes_;
  int budget_ = 0;
  bool spent_ = false;
};

// A face of the wanted size has a metric area of about 1/4 (edges of L = 0.75); strips narrower than an edge have no
// area to speak of and are counted by their edges.
int Adapter::operations_allowed() const {
  double wanted = mesh().n_faces();
  for (int f = 0; f < mesh().face_slots(); ++f) {
    double density = 0;
    for (const int v : mesh().face(f)) density += std::sqrt(std::max(0.0, sizes_[v].determinant())) / 3;
    wanted += 4 * density * mesh().material_area(f);
  }
  for (const int h : mesh().edges()) wanted += length(h);
  return static_cast<int>(std::min(budget_share * wanted, 1e8));
}

bool Adapter::may_go_on(int vertex) {
  if (operations() < budget_) return true;
  if (!spent_) editor_.refuse(RefusalReason::BudgetSpent, vertex, mesh().X[vertex]);
  spent_ = true;
  return false;
}

std::vector<int> Adapter::halfedges_of(const std::vector<int>& faces) const {
  std::vector<int> result;
  for (const int f : faces)
    for (int k = 0; k < 3; ++k) result.push_back(3 * f + k);
  return result;
}

void Adapter::push_splits(Queue& queue, const std::vector<int>& halfedges) const {
  for (const int h : halfedges)
    if (const double L = length(h); L > split_above) queue.push(candidate(h, L));
}

void Adapter::push_collapses(Queue& queue, const std::vector<int>& halfedges) const {
  for (const int h : halfedges) {
    const double L = length(h);
    if (L > collapse_candidate) continue;
    if (leaves_short_edges(mesh().from(h), mesh().to(h)) || leaves_short_edges(mesh().to(h), mesh().from(h)))
      queue.push(candidate(h, L));
  }
}

bool Adapter::should_flip(int h) const {
  if (mesh().is_border(h) || mesh().tag(h) != 0) return false;
  const int a = mesh().from(h), b = mesh().opposite(h), c = mesh().to(h), d = mesh().opposite(mesh().twin(h));
  Mat2 M = 0.25 * (sizes_[a] + sizes_[b] + sizes_[c] + sizes_[d]);
  // Next to a chain roundness in material space itself counts: it keeps the chain's way ahead open.
  for (const int v : {a, b, c, d})
    if (cloth().is_eol(v)) M.setIdentity();
  if (opposite_angle_sine(mesh().X[a], mesh().X[b], mesh().X[c], mesh().X[d], M) > -flip_margin) return false;
  const FlipCheck check = flip_check(cloth(), h);
  return check.sound && check.dihedral <= flip_dihedral && check.angle >= std::min(least_angle, check.angle_before);
}

// A half-edge stays the name of some edge whatever is flipped, so the stack needs no upkeep.
void Adapter::flip_around(const std::vector<int>& halfedges) {
  std::vector<int> stack(halfedges.rbegin(), halfedges.rend());
  while (!stack.empty()) {
    const int h = stack.back();
    stack.pop_back();
    if (!mesh().face_live(Mesh::face_of(h)) || !should_flip(h)) continue;
    if (!may_go_on(mesh().from(h))) return;
    const std::array<int, 2> faces = editor_.flip(h);
    for (const int side : halfedges_of({faces[0], faces[1]})) stack.push_back(side);
  }
}

void Adapter::split_long_edges() {
  Queue queue(later_split);
  push_splits(queue, mesh().edges());
  while (!queue.empty()) {
    const Candidate top = queue.top();
    queue.pop();
    const int h = mesh().find_edge(top.a, top.b);
    if (h == Mesh::none) continue;
    if (!may_go_on(top.a)) return;
    if (mesh().can_split(h, 0.5))
      split(h, queue);
    else
      editor_.refuse(RefusalReason::WouldInvert, top.a, 0.5 * (mesh().X[top.a] + mesh().X[top.b]));
  }
}

void Adapter::split(int h, Queue& queue) {
  const auto log = [](double l) { return std::log(l); };
  const auto exp = [](double l) { return std::exp(l); };
  const Mat2 logs = map_eigenvalues(sizes_[mesh().from(h)], log) + map_eigenvalues(sizes_[mesh().to(h)], log);
  const Mesh::Split done = editor_.split(h, 0.5);
  sizes_.push_back(map_eigenvalues(0.5 * logs, exp));
  flip_around(halfedges_of(done.faces));
  // Flips pass on what they touch to each other only, so look again at all that surrounds the new vertex.
  std::vector<int> faces;
  for (const int out : mesh().outgoing(done.vertex)) faces.push_back(Mesh::face_of(out));
  push_splits(queue, halfedges_of(faces));
}

// A chain is thinned along itself only: its ends, its corners and its course stay.
bool Adapter::may_go(int p, int q) const {
  if (cloth().pins[p] != 0) return false;
  if (!cloth().is_eol(p)) return !mesh().is_border_vertex(p) || !mesh().is_material_corner(p);
  return cloth().feature[p].kind == FeatureKind::Edge && !mesh().is_border_vertex(p) &&
         mesh().tag(mesh().find_edge(p, q)) != 0;
}

// Whether p's edges, moved to q, would be short enough. The one test that nearly all candidates fail, so it comes first
// and allocates nothing.
bool Adapter::leaves_short_edges(int p, int q) const {
  const int first = mesh().halfedge(p);
  int h = first;
  do {
    if (mesh().to(h) != q && length(mesh().to(h), q) > collapse_below) return false;
    const int across = mesh().twin(Mesh::prev(h));
    if (across == Mesh::none) return mesh().opposite(h) == q || length(mesh().opposite(h), q) <= collapse_below;
    h = across;
  } while (h != first);
  return true;
}

bool Adapter::should_collapse(int p, int q) const {
  if (!may_go(p, q) || !leaves_short_edges(p, q)) return false;
  if (!mesh().can_collapse_vertex(p, q)) return false;
  const Ring ring = ring_after(cloth(), p, at_vertex(mesh(), q));
  return ring.sound && ring.angle >= std::min(least_angle, ring.angle_before) && ring.turn <= normal_turn &&
         ring.shift <= shift_share * options_.size[0];
}

void Adapter::collapse_short_edges() {
  Queue queue(later_collapse);
  push_collapses(queue, mesh().edges());
  while (!queue.empty()) {
    const Candidate top = queue.top();
    queue.pop();
    for (const auto& [from, to] : {std::pair{top.a, top.b}, std::pair{top.b, top.a}}) {
      if (mesh().find_edge(from, to) == Mesh::none) break;
      if (!should_collapse(from, to)) continue;
      if (!may_go_on(from)) return;
      collapse(from, to, queue);
      break;
    }
  }
}

void Adapter::collapse(int p, int q, Queue& queue) {
  const Mesh::Collapse done = editor_.collapse(p, q);
  flip_around(halfedges_of(done.faces));
  std::vector<int> faces;
  for (const int out : mesh().outgoing(done.into)) faces.push_back(Mesh::face_of(out));
  push_collapses(queue, halfedges_of(faces));
}

}  // namespace

RemeshResult adapt(const Cloth& cloth, const AdaptOptions& options) {
  require_valid(options);
  require(cloth.mesh.is_compact(), "adapt: expected a compact mesh");
  return Adapter(cloth, options).run();
}

}  // namespace crease
