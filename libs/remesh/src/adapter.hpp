// SPDX-License-Identifier: MIT
#pragma once

#include <algorithm>
#include <array>
#include <optional>
#include <span>
#include <vector>

#include "candidates.hpp"
#include "editor.hpp"
#include "guard.hpp"
#include "metric.hpp"

namespace crease {

/// Of a vertex in a chain: towards a neighbour there, by a share of the edge between them.
struct ChainSlide {
  int vertex, towards;
  double share;
};
/// Which vertex of a chain is to go, into one of its neighbours, after others have slid to where that leaves even
/// edges.
struct ChainPlan {
  int vertex;
  std::array<int, 2> into;
  std::vector<ChainSlide> slides;
};

/// What was there before a slide along a chain.
struct SlidAlong {
  Surrounds surrounds;
  Tensor size;
  std::vector<int> faces;
  std::vector<double> moved;  // by what the pass had moved the surface in the faces
  std::size_t touched;        // how many vertices had been
};

/// One pass of adapt(). Splits, flips and collapses are in adapt.cpp, what slides in adapt_slides.cpp, chains in
/// thin_chains.cpp.
class Adapter {
 public:
  Adapter(const Cloth& cloth, const AdaptOptions& options, std::span<const PosedObstacle> obstacles);

  RemeshResult run() &&;

 private:
  const Cloth& cloth() const { return editor_.cloth(); }
  const Mesh& mesh() const { return editor_.mesh(); }

  int operations();
  int operations_allowed() const;
  bool may_go_on(int vertex);
  double squared_length(int a, int b) const {
    return squared_metric_length(mesh().X[b] - mesh().X[a], sizes_[a], sizes_[b]);
  }
  double squared_length(int h) const { return squared_length(mesh().from(h), mesh().to(h)); }

  void flip_around(std::vector<int> stack);
  // The corners of h's face: where h begins, where it ends, and the one opposite.
  std::array<int, 3> corners_from(int h) const {
    const int f = h / 3, k = h - 3 * f;
    const std::array<int, 3>& corners = mesh().face(f);
    return {corners[k], corners[k == 2 ? 0 : k + 1], corners[k == 0 ? 2 : k - 1]};
  }
  bool is_worse_diagonal(int h, const std::array<int, 3>& corners) const;
  std::optional<double> should_flip(int h);
  void split_long_edges();
  Tensor mean_size(int h) const;
  void split(int h, CandidateQueue& queue);
  void collapse_short_edges();
  // Whether nothing asks for short edges at a vertex: its size is the coarsest one, to the last bit.
  bool is_idle(int v) const {
    return sizes_[v].radius == coarsest_ && sizes_[v].centre.isZero(0) && !cloth().is_eol(v);
  }
  bool leaves_short_edges(int p, int q, double longest) const;
  double longest_left(int p, int q) const {
    return cloth().is_eol(p) && cloth().is_eol(q) ? chain_collapse_below : collapse_below;
  }
  std::optional<double> should_collapse(int p, int q, double longest);
  void collapse(int p, int q, double moved, CandidateQueue& queue);

  void thin_chains();
  bool thin(std::vector<int>& run, std::vector<int>& refused);
  bool carry_out(const ChainPlan& plan);
  bool leaves_fitting_edges(const ChainPlan& plan) const;
  Verdict judge_slide_along(const ChainSlide& s, const GuardLimits& limits) const;
  SlidAlong slide_along(const ChainSlide& s, double moved);
  void take_back(const SlidAlong& before);

  void make_room_for_chains();
  void even_out_short_edges();
  bool take_out(int vertex);
  bool may_slide(int vertex) const;
  bool even_out(int vertex, double enough);
  void make_room_around(std::vector<int> vertices);
  void slide(int vertex, const Vec2& X);

  void touch(const std::vector<int>& faces);
  bool look_again();
  void look_at_edges();
  void look_at(int h, const std::array<int, 3>& corners);
  Candidate candidate(const std::array<int, 3>& corners) const {
    const auto& [a, b, c] = corners;
    return {squared_length(a, b), std::min(a, b), std::max(a, b)};
  }
  void push_splits(CandidateQueue& queue, const std::vector<int>& halfedges) const;
  void push_collapse(CandidateQueue& queue, const Candidate& edge) const;
  GuardLimits limits(double moved) const;
  std::optional<double> allowed(const Verdict& verdict, double moved);
  double moved_around(int vertex) const;
  void set_moved(std::span<const int> faces, double moved);

  Editor editor_;
  Surroundings surroundings_;
  double shift_allowed_;
  std::vector<double> moved_;  // by face: what this pass has moved the surface there at most [m]
  std::vector<Tensor> sizes_;
  double coarsest_;  // eigenvalues of the longest edge
  int budget_ = 0;   // made when it is first needed
  bool has_chains_;
  bool spent_ = false, everywhere_ = true;
  std::vector<int> edges_;    // what this round looks at, if not everywhere
  std::vector<int> touched_;  // corners of the faces that it changed
  int n_seen_ = 0;            // operations when edges_ was made
  int slides_ = 0;            // but for those that make room
  // What looking at edges_ found: what to flip, split, try to collapse, and even out: too short where nothing
  // asks for it.
  std::vector<int> worse_;
  std::vector<Candidate> long_, collapsible_, short_;
};

}  // namespace crease
