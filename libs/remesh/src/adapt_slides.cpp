// SPDX-License-Identifier: MIT
#include <algorithm>
#include <cmath>
#include <iterator>
#include <vector>

#include "adapter.hpp"
#include "even.hpp"
#include "neighbourhood.hpp"
#include "relax.hpp"
#include "room.hpp"

namespace crease {

namespace {

// How much of a fit (see even.hpp) is worth a slide of a vertex that is in nobody's way but stands beside one that is.
constexpr double roomy = 1.4;
constexpr std::size_t max_rings = 6;

}  // namespace

// Before the rounds: it changes no edge, and they see what it leaves. What a slide moves fades from its vertex to the
// neighbours, so that those of neighbours do not add up; it does add to what thinned chains have moved.
void Adapter::make_room_for_chains() {
  const std::vector<int> beside = vertices_beside_chains(cloth());
  std::vector<double> before;
  for (const int v : beside) before.push_back(moved_around(v));
  for (std::size_t i = 0; i < beside.size(); ++i) {
    const int v = beside[i];
    const std::optional<Slide> slide = slide_from_chain(cloth(), v, sizes_[v], limits(before[i]));
    if (!slide) continue;
    editor_.slide(v, slide->X, slide->x, slide->v);
    mesh().all_outgoing(v, [&](int h) {
      double& moved = moved_[Mesh::face_of(h)];
      moved = std::max(moved, before[i] + slide->shift);
      return true;
    });
  }
}

// What no collapse could remove, shortest first: one end slides, or, where there is no room, those round it do first.
// Not in a cloth that a chain travels through: what is even now it would only undo.
void Adapter::even_out_short_edges() {
  std::vector<Candidate> left;
  std::copy_if(short_.begin(), short_.end(), std::back_inserter(left),
               [&](const Candidate& edge) { return may_slide(edge.a) || may_slide(edge.b); });
  std::sort(left.begin(), left.end(), [](const Candidate& p, const Candidate& q) { return later_collapse(q, p); });
  const auto is_left = [&](int a, int b) {
    return operations() == n_seen_ || (mesh().find_edge(a, b) != Mesh::none && squared_length(a, b) < squared_short);
  };
  for (const auto& [length, a, b] : left) {
    if (spent_) return;
    if (!is_left(a, b)) continue;
    const bool may_a = may_slide(a), may_b = may_slide(b);
    if ((may_a && even_out(a, 1)) || (may_b && even_out(b, 1)) || !(may_a || may_b)) continue;
    if (take_out(a) || take_out(b)) continue;
    for (const int end : {a, b})
      for (const int u : mesh().neighbours(end))
        if (may_slide(u)) even_out(u, roomy);
    if (is_left(a, b)) make_room_around({a, b});
  }
}

// Into whichever neighbour will have it.
bool Adapter::take_out(int vertex) {
  for (const int into : mesh().neighbours(vertex)) {
    if (!is_idle(into)) continue;
    const std::optional<double> moved = should_collapse(vertex, into, collapse_short_below);
    if (!moved || !may_go_on(vertex)) continue;
    CandidateQueue queue(later_collapse);  // the next round's
    collapse(vertex, into, *moved, queue);
    return true;
  }
  return false;
}

bool Adapter::may_slide(int vertex) const {
  const auto is_idle_edge = [&](int h) { return is_idle(mesh().to(h)) && is_idle(mesh().opposite(h)); };
  return is_idle(vertex) && is_flat(cloth(), vertex, shift_allowed_) && mesh().all_outgoing(vertex, is_idle_edge) &&
         is_free_to_slide(cloth(), vertex);
}

bool Adapter::even_out(int vertex, double enough) {
  const double moved = moved_around(vertex);
  const std::optional<Slide> place = slide_to_even_lengths(cloth(), vertex, sizes_, enough, limits(moved));
  if (!place || !may_go_on(vertex)) return false;
  editor_.slide(vertex, place->X, place->x, place->v);
  ++slides_;
  const std::vector<int> faces = faces_around(mesh(), vertex);
  set_moved(faces, moved + place->shift);
  touch(faces);
  flip_around(halfedges_around(mesh(), vertex));
  return true;
}

// The vertices and those around them, in ever more rings, find their places together.
void Adapter::make_room_around(std::vector<int> vertices) {
  std::erase_if(vertices, [&](int v) { return !may_slide(v); });
  std::vector<Move> moves;
  for (std::size_t ring = 0, inner = 0; ring < max_rings && moves.empty(); ++ring) {
    const std::size_t n = vertices.size();
    for (std::size_t k = inner; k < n; ++k)
      for (const int u : mesh().neighbours(vertices[k]))
        if (std::find(vertices.begin(), vertices.end(), u) == vertices.end() && may_slide(u)) vertices.push_back(u);
    if (vertices.size() == n) return;
    inner = n;
    moves = relax(mesh(), vertices, 1 / std::sqrt(coarsest_));
  }
  for (const auto& [v, X] : moves)
    if (X != mesh().X[v] && may_go_on(v)) slide(v, X);
  for (const auto& [v, X] : moves) flip_around(halfedges_around(mesh(), v));
}

void Adapter::slide(int vertex, const Vec2& X) {
  const double moved = moved_around(vertex);
  const std::optional<Slide> place = place_in_star(cloth(), vertex, X);
  if (!place) return;
  const Verdict verdict = judge_slide(cloth(), vertex, {place->X, place->x}, 0, limits(moved));
  if (verdict.trouble) return;
  editor_.slide(vertex, place->X, place->x, place->v);
  ++slides_;
  const std::vector<int> faces = faces_around(mesh(), vertex);
  set_moved(faces, moved + verdict.shift);
  touch(faces);
}

}  // namespace crease
