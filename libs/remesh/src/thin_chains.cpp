// SPDX-License-Identifier: MIT
#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <span>
#include <utility>
#include <vector>

#include "adapter.hpp"
#include "neighbourhood.hpp"

// A chain's vertices come where mesh edges crossed the feature. Of k of its edges in a row that k - 1 could stand for
// one vertex goes, and the others slide along the chain until what is left is even.
//
// Every plan that is carried out removes a vertex, and one that is refused leaves nothing behind: so it ends. What it
// leaves in place of k edges are edges of up to .92, which are not split.
namespace crease {

namespace {

// Edges in a row that are looked at together: of 8 in a row 7 can be made if they are .8 long in the mean.
constexpr std::size_t longest_window = 8;
// Metric lengths that differ by less are equal.
constexpr double same = 1e-6;
// Altitude of faces beside a vertex that slides, in shortest edges wanted: those between it and the one that goes are
// thin for a moment.
constexpr double least_altitude = 0.1;

// The chain's neighbours of a vertex that may slide along it or go: one that rides in the midst of a straight stretch,
// away from border, seams and pins.
std::optional<std::array<int, 2>> neighbours_in_chain(const Cloth& cloth, int vertex) {
  const Mesh& mesh = cloth.mesh;
  const FeatureId& feature = cloth.feature[vertex];
  if (feature.kind != FeatureKind::Edge || feature.away > 0 || cloth.pins[vertex] != 0) return std::nullopt;
  if (mesh.is_border_vertex(vertex) || mesh.on_seam(vertex)) return std::nullopt;
  std::array<int, 2> ends{Mesh::none, Mesh::none};
  std::size_t n = 0;
  const bool is_plain = mesh.all_outgoing(vertex, [&](int h) {
    if (mesh.tag(h) == 0) return true;
    const FeatureId& there = cloth.feature[mesh.to(h)];
    if (n == 2 || mesh.tag(h) != edge_tag(feature.obstacle, feature.index)) return false;
    if (there.lifted != feature.lifted || there.away > 0) return false;
    ends[n++] = mesh.to(h);
    return true;
  });
  if (!is_plain || n != 2) return std::nullopt;
  return ends;
}

// From one vertex that stays to the next, if `vertex` comes after the first; empty if not.
std::vector<int> run_from(const Cloth& cloth, int vertex, std::vector<char>& seen) {
  std::vector<int> run;
  auto ends = neighbours_in_chain(cloth, vertex);
  if (!ends) return run;
  if (neighbours_in_chain(cloth, (*ends)[0])) std::swap((*ends)[0], (*ends)[1]);
  if (neighbours_in_chain(cloth, (*ends)[0])) return run;
  run = {(*ends)[0]};
  for (; ends; ends = neighbours_in_chain(cloth, vertex)) {
    seen[vertex] = 1;
    run.push_back(vertex);
    vertex = (*ends)[0] == run[run.size() - 2] ? (*ends)[1] : (*ends)[0];
  }
  run.push_back(vertex);
  return run;
}

// Those to the left of the one that goes are due at d, 2 d, ..., and that one is between its neighbours' new places.
// Who goes on slides before who is behind: so none meets another.
ChainPlan plan_thinning(std::span<const int> chain, std::span<const double> at) {
  const std::size_t k = chain.size() - 1;
  const double d = (at[k] - at[0]) / static_cast<double>(k - 1);
  const auto due = [&](std::size_t i, std::size_t goes) {
    return at[0] + d * static_cast<double>(i < goes ? i : i - 1);
  };
  std::size_t goes = 0;
  double least = HUGE_VAL;
  for (std::size_t j = 1; j < k; ++j) {
    const double s = at[j] - at[0];
    if (!(s > d * static_cast<double>(j - 1) && s < d * static_cast<double>(j))) continue;
    double way = 0;
    for (std::size_t i = 1; i < k; ++i)
      if (i != j) way = std::max(way, std::abs(due(i, j) - at[i]));
    if (way < least) least = way, goes = j;
  }
  if (goes == 0) return {Mesh::none, {}, {}};  // an edge that is lost in rounding
  ChainPlan plan{chain[goes], {chain[goes - 1], chain[goes + 1]}, {}};
  std::vector<double> now(at.begin(), at.end());
  const auto slide = [&](std::size_t i, std::size_t towards) {
    plan.slides.push_back({chain[i], chain[towards], (due(i, goes) - now[i]) / (now[towards] - now[i])});
    now[i] = due(i, goes);
  };
  for (std::size_t i = k - 1; i > 0; --i)
    if (i != goes && due(i, goes) > at[i] + same) slide(i, i + 1);
  for (std::size_t i = 1; i < k; ++i)
    if (i != goes && due(i, goes) < at[i] - same) slide(i, i - 1);
  return plan;
}

}  // namespace

// First of all in a pass, for what the surface may be moved by goes to what costs most; and after every round.
void Adapter::thin_chains() {
  if (!has_chains_) return;
  std::vector<char> seen(static_cast<std::size_t>(mesh().vertex_slots()), 0);
  for (int v = 0; v < mesh().vertex_slots(); ++v) {
    if (!cloth().is_eol(v) || !mesh().vertex_live(v) || seen[v]) continue;
    std::vector<int> run = run_from(cloth(), v, seen), refused;
    while (thin(run, refused)) continue;
  }
}

// Fewest edges first.
bool Adapter::thin(std::vector<int>& run, std::vector<int>& refused) {
  std::vector<double> at{0};
  for (std::size_t i = 1; i < run.size(); ++i) at.push_back(at.back() + std::sqrt(squared_length(run[i - 1], run[i])));
  for (std::size_t k = 2; k <= longest_window; ++k) {
    for (std::size_t i = 0; i + k < run.size(); ++i) {
      if (at[i + k] - at[i] > chain_collapse_below * static_cast<double>(k - 1)) continue;
      const ChainPlan plan = plan_thinning(std::span(run).subspan(i, k + 1), std::span(at).subspan(i, k + 1));
      const int goes = plan.vertex;
      if (goes == Mesh::none || std::find(refused.begin(), refused.end(), goes) != refused.end()) continue;
      if (!may_go_on(goes)) return false;
      if (carry_out(plan)) {
        run.erase(std::find(run.begin(), run.end(), goes));
        return true;
      }
      refused.push_back(goes);
    }
  }
  return false;
}

// All of it or nothing.
bool Adapter::carry_out(const ChainPlan& plan) {
  if (!leaves_fitting_edges(plan)) return false;
  std::vector<SlidAlong> slid;
  std::optional<RefusalReason> trouble;
  const auto slides = [&](const ChainSlide& s) {
    const double moved = moved_around(s.vertex);
    const Verdict verdict = judge_slide_along(s, limits(moved));
    trouble = verdict.trouble;
    if (!trouble) slid.push_back(slide_along(s, moved + verdict.shift));
    return !trouble;
  };
  const auto goes_into = [&](int into) {
    if (!leaves_short_edges(plan.vertex, into, chain_collapse_below)) return false;
    const double moved = moved_around(plan.vertex);
    const Verdict verdict = judge_collapse(cloth(), plan.vertex, into, limits(moved));
    trouble = verdict.trouble;
    if (trouble) return false;
    CandidateQueue queue(later_collapse);  // the rounds'
    collapse(plan.vertex, into, moved + verdict.shift, queue);
    return true;
  };
  if (std::all_of(plan.slides.begin(), plan.slides.end(), slides) &&
      std::any_of(plan.into.begin(), plan.into.end(), goes_into)) {
    for (const ChainSlide& s : plan.slides) flip_around(halfedges_around(mesh(), s.vertex));
    return true;
  }
  for (; !slid.empty(); slid.pop_back()) take_back(slid.back());
  if (trouble) ++editor_.report().kept_back[static_cast<std::size_t>(*trouble)];
  return false;
}

// Looked at before anything moves. A slide may not stretch other edges beyond 1: such an edge would be split, by a
// vertex in the way of the chain. And one of the collapses must leave short edges.
bool Adapter::leaves_fitting_edges(const ChainPlan& plan) const {
  struct Place {
    int vertex;
    Vec2 X;
    Tensor size;
  };
  std::vector<Place> slid;
  const auto place = [&](int v) {
    const auto it = std::find_if(slid.rbegin(), slid.rend(), [&](const Place& p) { return p.vertex == v; });
    return it != slid.rend() ? *it : Place{v, mesh().X[v], sizes_[v]};
  };
  const auto squared_distance = [](const Place& a, const Place& b) {
    return squared_metric_length(b.X - a.X, a.size, b.size);
  };
  for (const auto& [vertex, towards, t] : plan.slides) {
    const Place a = place(vertex), b = place(towards);
    slid.push_back({vertex, (1 - t) * a.X + t * b.X, (1 - t) * a.size + t * b.size});
  }
  const auto keeps_others = [&](const ChainSlide& s) {
    const Place now = place(s.vertex);
    return mesh().all_outgoing(s.vertex, [&](int h) {
      return mesh().tag(h) != 0 ||
             squared_distance(now, place(mesh().to(h))) <= std::max(split_above * split_above, squared_length(h));
    });
  };
  const auto fits = [&](int into) {
    const Place end = place(into);
    return mesh().all_outgoing(plan.vertex, [&](int h) {
      return squared_distance(end, place(mesh().to(h))) <= chain_collapse_below * chain_collapse_below;
    });
  };
  return std::all_of(plan.slides.begin(), plan.slides.end(), keeps_others) &&
         std::any_of(plan.into.begin(), plan.into.end(), fits);
}

Verdict Adapter::judge_slide_along(const ChainSlide& s, const GuardLimits& limits) const {
  const Target place = on_edge(mesh(), s.vertex, s.towards, s.share);
  const double altitude = least_altitude / std::sqrt(sizes_[s.vertex].large());
  return judge_slide(cloth(), s.vertex, {place.X, place.x}, altitude, limits);
}

SlidAlong Adapter::slide_along(const ChainSlide& s, double moved) {
  SlidAlong before{editor_.surrounds(s.vertex), sizes_[s.vertex], faces_around(mesh(), s.vertex), {}, touched_.size()};
  for (const int f : before.faces) before.moved.push_back(moved_[f]);
  editor_.slide_along(s.vertex, s.towards, s.share);
  ++slides_;
  sizes_[s.vertex] = (1 - s.share) * sizes_[s.vertex] + s.share * sizes_[s.towards];
  set_moved(before.faces, moved);
  touch(before.faces);
  return before;
}

void Adapter::take_back(const SlidAlong& before) {
  editor_.take_back(before.surrounds);
  --slides_;
  sizes_[before.surrounds.vertex] = before.size;
  for (std::size_t i = 0; i < before.faces.size(); ++i) moved_[before.faces[i]] = before.moved[i];
  touched_.resize(before.touched);
}

}  // namespace crease
