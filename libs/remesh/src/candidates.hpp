// SPDX-License-Identifier: MIT
#pragma once

#include <queue>
#include <tuple>
#include <vector>

#include "even.hpp"

// Edges that are too long or too short, and in which order they are dealt with. L is the metric length of an edge: 1 is
// as long as it may be.
namespace crease {

inline constexpr double split_above = 1.0;
/// A collapse may not make an edge longer than this: its distance to split_above is the hysteresis. One that removes an
/// edge below short_below may, by all but a hundredth: nothing else would bring the lengths to between 1/2 and 1.
inline constexpr double collapse_below = 0.85, collapse_short_below = 1;
/// Along a chain: its vertices come where mesh edges crossed a feature, twice as close as they need be, and cost more.
inline constexpr double chain_collapse_below = 0.92;
/// Edges longer than this are not tried: removing one of their ends leaves edges longer than collapse_below.
inline constexpr double collapse_candidate = 0.6;

struct Candidate {
  double length;  ///< squared
  int a, b;       ///< a < b
};
inline bool is_long(const Candidate& edge) {
  return edge.length > split_above * split_above;
}
inline bool is_collapsible(const Candidate& edge) {
  return edge.length <= collapse_candidate * collapse_candidate;
}
inline bool is_short(const Candidate& edge) {
  return edge.length < squared_short;
}
/// Ties fall to the lower vertex ids, so the order never depends on how the queue is built.
inline bool later_split(const Candidate& p, const Candidate& q) {
  return std::tie(p.length, q.a, q.b) < std::tie(q.length, p.a, p.b);
}
inline bool later_collapse(const Candidate& p, const Candidate& q) {
  return std::tie(p.length, p.a, p.b) > std::tie(q.length, q.a, q.b);
}
using CandidateQueue =
    std::priority_queue<Candidate, std::vector<Candidate>, bool (*)(const Candidate&, const Candidate&)>;

}  // namespace crease
