// SPDX-License-Identifier: MIT
#include <algorithm>
#include <cmath>
#include <vector>

#include "adapter.hpp"
#include "crease/base/require.hpp"
#include "crease/remesh/remesh.hpp"
#include "neighbourhood.hpp"
#include "options.hpp"
#include "sizing.hpp"

// Queues hold vertex pairs, not edges: vertices keep their ids and do not move while a queue is worked off, so an entry
// is up to date exactly when the mesh still has the edge. All loops share one budget of operations.
namespace crease {

namespace {

// A flip needs the opposite angles to exceed 180 degrees by this (as a sine), so that four points on a circle rest.
constexpr double flip_margin = 0.1;
// All flips and collapses of a pass together may move the surface by this share of the contact threshold, and of the
// shortest edge: what lies there unseen would pop in a picture and drum in the contact. A collapse may turn a normal by
// this [rad].
constexpr double threshold_share = 0.15;
constexpr double shift_share = 0.02;
constexpr double normal_turn = 0.35;
// Rounds of flips, splits, collapses and slides; each after the first looks only where the one before did something.
// The sizes are those at the start: new vertices lie on the old facets, so curvature measured again at once would
// refine every facet's rim.
constexpr int max_rounds = 8;
// Operations per face wanted.
constexpr double budget_share = 20;

}  // namespace

Adapter::Adapter(const Cloth& cloth, const AdaptOptions& options, std::span<const PosedObstacle> obstacles)
    : editor_(cloth, options.conserve),
      surroundings_(obstacles, options.threshold),
      shift_allowed_(std::min(threshold_share * options.threshold, shift_share * options.size[0])),
      moved_(static_cast<std::size_t>(cloth.mesh.face_slots()), 0.0),
      sizes_(vertex_sizes(cloth, options)),
      coarsest_(1 / (options.size[1] * options.size[1])),
      has_chains_(cloth.n_eol() > 0) {}

RemeshResult Adapter::run() && {
  thin_chains();
  make_room_for_chains();
  for (int round = 0; round < max_rounds && !spent_; ++round) {
    touched_.clear();
    look_at_edges();
    flip_around(worse_);
    if (look_again()) look_at_edges();
    split_long_edges();
    if (look_again()) look_at_edges();
    collapse_short_edges();
    if (look_again()) look_at_edges();
    even_out_short_edges();
    if (touched_.empty()) break;
    thin_chains();
    edges_ = edges_at(mesh(), touched_);
    everywhere_ = false;
  }
  return std::move(editor_).finish();
}

GuardLimits Adapter::limits(double moved) const {
  return {shift_allowed_ - moved, normal_turn, surroundings_};
}

int Adapter::operations() {
  const RemeshReport& r = editor_.report();
  return r.splits + r.flips + r.collapses + slides_;
}

// A face of the wanted size has a metric area of about 1/4 (edges of L = 0.75); strips narrower than an edge have no
// area to speak of and are counted by their edges.
int Adapter::operations_allowed() const {
  double wanted = mesh().n_faces();
  for (int f = 0; f < mesh().face_slots(); ++f) {
    if (!mesh().face_live(f)) continue;
    const auto& [a, b, c] = mesh().face(f);
    const Tensor sum = sizes_[a] + sizes_[b] + sizes_[c];
    wanted += 4 * std::sqrt(std::max(0.0, sum.determinant())) / 3 * mesh().material_area(f);
    for (int h = 3 * f; h < 3 * f + 3; ++h) wanted += std::sqrt(squared_length(h));
  }
  return static_cast<int>(std::min(budget_share * wanted, 1e8));
}

bool Adapter::may_go_on(int vertex) {
  if (budget_ == 0) budget_ = operations_allowed();
  if (operations() < budget_) return true;
  if (!spent_) editor_.refuse(RefusalReason::BudgetSpent, vertex, mesh().X[vertex]);
  spent_ = true;
  return false;
}

// What the pass will have moved the surface where the operation is done, if it may be.
std::optional<double> Adapter::allowed(const Verdict& verdict, double moved) {
  if (!verdict.trouble) return moved + verdict.shift;
  ++editor_.report().kept_back[static_cast<std::size_t>(*verdict.trouble)];
  return std::nullopt;
}

double Adapter::moved_around(int vertex) const {
  double moved = 0;
  mesh().all_outgoing(vertex, [&](int h) {
    moved = std::max(moved, moved_[Mesh::face_of(h)]);
    return true;
  });
  return moved;
}

void Adapter::set_moved(std::span<const int> faces, double moved) {
  moved_.resize(static_cast<std::size_t>(mesh().face_slots()), 0.0);
  for (const int f : faces) moved_[f] = moved;
}

void Adapter::touch(const std::vector<int>& faces) {
  for (const int f : faces)
    for (const int v : mesh().face(f)) touched_.push_back(v);
}

// Operations rename edges and make new ones: then the list is made anew, wherever this round looks. Returns whether.
bool Adapter::look_again() {
  if (operations() == n_seen_) return false;
  n_seen_ = operations();
  if (everywhere_) return true;
  for (const int h : edges_)
    if (mesh().face_live(Mesh::face_of(h))) touched_.insert(touched_.end(), {mesh().from(h), mesh().to(h)});
  edges_ = edges_at(mesh(), touched_);
  return true;
}

void Adapter::look_at(int h, const std::array<int, 3>& corners) {
  if (is_worse_diagonal(h, corners)) worse_.push_back(h);
  const Candidate edge = candidate(corners);
  if (is_long(edge)) long_.push_back(edge);
  if (is_collapsible(edge)) collapsible_.push_back(edge);
  if (!has_chains_ && is_short(edge) && is_idle(edge.a) && is_idle(edge.b)) short_.push_back(edge);
}

// Every edge once, by its canonical half-edge, in ascending order.
void Adapter::look_at_edges() {
  worse_.clear(), long_.clear(), collapsible_.clear(), short_.clear();
  for (const int h : edges_) look_at(h, corners_from(h));
  for (int f = 0; everywhere_ && f < mesh().face_slots(); ++f) {
    if (!mesh().face_live(f)) continue;
    const auto [a, b, c] = mesh().face(f);
    if (const int h = 3 * f; mesh().edge_of(h) == h) look_at(h, {a, b, c});
    if (const int h = 3 * f + 1; mesh().edge_of(h) == h) look_at(h, {b, c, a});
    if (const int h = 3 * f + 2; mesh().edge_of(h) == h) look_at(h, {c, a, b});
  }
}

void Adapter::push_splits(CandidateQueue& queue, const std::vector<int>& halfedges) const {
  for (const int h : halfedges)
    if (const Candidate edge = candidate(corners_from(h)); is_long(edge)) queue.push(edge);
}

void Adapter::push_collapse(CandidateQueue& queue, const Candidate& edge) const {
  const double longest = longest_left(edge.a, edge.b);
  if (leaves_short_edges(edge.a, edge.b, longest) || leaves_short_edges(edge.b, edge.a, longest)) queue.push(edge);
}

// Whether the other diagonal of the quadrilateral round edge h would be the better one.
bool Adapter::is_worse_diagonal(int h, const std::array<int, 3>& corners) const {
  const int g = mesh().twin(h);
  if (g == Mesh::none || mesh().tag(h) != 0) return false;
  const auto [a, c, b] = corners;
  const int d = corners_from(g)[2];
  Tensor M = sizes_[a] + sizes_[b] + sizes_[c] + sizes_[d];
  // Next to a chain roundness in material space itself counts: it keeps the chain's way ahead open. But an edge that
  // would only be split again is not made.
  if (has_chains_ && (cloth().is_eol(a) || cloth().is_eol(b) || cloth().is_eol(c) || cloth().is_eol(d))) {
    if (squared_length(b, d) > std::max(split_above * split_above, squared_length(a, c))) return false;
    M = Tensor::isotropic(1);
  }
  const auto& X = mesh().X;
  return opposite_angle_sine(X[a], X[b], X[c], X[d], M) <= -flip_margin;
}

std::optional<double> Adapter::should_flip(int h) {
  if (!is_worse_diagonal(h, corners_from(h))) return std::nullopt;
  const double moved = std::max(moved_[Mesh::face_of(h)], moved_[Mesh::face_of(mesh().twin(h))]);
  return allowed(judge_flip(cloth(), h, limits(moved)), moved);
}

// A half-edge stays the name of some edge whatever is flipped, so the stack needs no upkeep.
void Adapter::flip_around(std::vector<int> stack) {
  std::reverse(stack.begin(), stack.end());
  while (!stack.empty()) {
    const int h = stack.back();
    stack.pop_back();
    if (!mesh().face_live(Mesh::face_of(h))) continue;
    const std::optional<double> moved = should_flip(h);
    if (!moved) continue;
    if (!may_go_on(mesh().from(h))) return;
    const std::array<int, 2> faces = editor_.flip(h);
    set_moved(faces, *moved);
    touch({faces[0], faces[1]});
    for (const int f : faces)
      for (int side = 3 * f; side < 3 * f + 3; ++side) stack.push_back(side);
  }
}

void Adapter::split_long_edges() {
  CandidateQueue queue(later_split, std::move(long_));
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

Tensor Adapter::mean_size(int h) const {
  const Tensor &from = sizes_[mesh().from(h)], &to = sizes_[mesh().to(h)];
  if (from.radius == to.radius && from.centre == to.centre) return from;  // to the last bit
  const auto log = [](double l) { return std::log(l); };
  const auto exp = [](double l) { return std::exp(l); };
  const Tensor logs = map_eigenvalues(from, log) + map_eigenvalues(to, log);
  return map_eigenvalues(0.5 * logs, exp);
}

void Adapter::split(int h, CandidateQueue& queue) {
  const Tensor size = mean_size(h);
  const int sewn = mesh().seam_twin(h);
  const Tensor size_there = sewn == Mesh::none ? Tensor() : mean_size(sewn);
  const int across = sewn == Mesh::none ? mesh().twin(h) : sewn;
  const double moved = std::max(moved_[Mesh::face_of(h)], across == Mesh::none ? 0.0 : moved_[Mesh::face_of(across)]);
  const Mesh::Split done = editor_.split(h, 0.5);
  set_moved(done.faces, moved);
  sizes_.push_back(size);
  if (done.tied != Mesh::none) sizes_.push_back(size_there);
  touch(done.faces);
  std::vector<int> sides;
  for (const int f : done.faces) sides.insert(sides.end(), {3 * f, 3 * f + 1, 3 * f + 2});
  flip_around(std::move(sides));
  // Flips pass on what they touch to each other only, so look again at all that surrounds the new vertex.
  push_splits(queue, halfedges_around(mesh(), done.vertex));
  if (done.tied != Mesh::none) push_splits(queue, halfedges_around(mesh(), done.tied));
}

// Whether p's edges, moved to q, would be short enough. The one test that nearly all candidates fail, so it comes first
// and allocates nothing.
bool Adapter::leaves_short_edges(int p, int q, double longest) const {
  const auto fits = [&](int v) {
    return v == q || (squared_length(v, q) <= longest * longest && (longest < collapse_short_below || is_idle(v)));
  };
  return mesh().all_outgoing(
      p, [&](int h) { return fits(mesh().to(h)) && (!mesh().is_border(Mesh::prev(h)) || fits(mesh().opposite(h))); });
}

std::optional<double> Adapter::should_collapse(int p, int q, double longest) {
  if (!leaves_short_edges(p, q, longest)) return std::nullopt;
  double moved = moved_around(p);
  if (const Mesh::Ends tied = mesh().across_seam(p, q); tied.vertex != Mesh::none) {
    if (!leaves_short_edges(tied.vertex, tied.into, longest)) return std::nullopt;
    moved = std::max(moved, moved_around(tied.vertex));
  }
  return allowed(judge_collapse(cloth(), p, q, limits(moved)), moved);
}

void Adapter::collapse_short_edges() {
  CandidateQueue queue(later_collapse);
  for (const Candidate& edge : collapsible_) push_collapse(queue, edge);
  while (!queue.empty()) {
    const Candidate top = queue.top();
    queue.pop();
    for (const auto& [from, to] : {std::pair{top.a, top.b}, std::pair{top.b, top.a}}) {
      if (operations() != n_seen_ && mesh().find_edge(from, to) == Mesh::none) break;
      const std::optional<double> moved = should_collapse(from, to, longest_left(from, to));
      if (!moved) continue;
      if (!may_go_on(from)) return;
      collapse(from, to, *moved, queue);
      break;
    }
  }
}

void Adapter::collapse(int p, int q, double moved, CandidateQueue& queue) {
  const Mesh::Collapse done = editor_.collapse(p, q);
  set_moved(done.faces, moved);
  touch(done.faces);
  std::vector<int> sides;
  for (const int f : done.faces) sides.insert(sides.end(), {3 * f, 3 * f + 1, 3 * f + 2});
  flip_around(std::move(sides));
  for (const int into : {done.into, done.tied.into}) {
    if (into == Mesh::none) continue;
    for (const int h : halfedges_around(mesh(), into))
      if (const Candidate edge = candidate(corners_from(h)); is_collapsible(edge)) push_collapse(queue, edge);
  }
}

RemeshResult adapt(const Cloth& cloth, const AdaptOptions& options, std::span<const PosedObstacle> obstacles) {
  require_valid(options);
  require(cloth.mesh.is_compact(), "adapt: expected a compact mesh");
  return Adapter(cloth, options, obstacles).run();
}

}  // namespace crease
