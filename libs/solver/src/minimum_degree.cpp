// SPDX-License-Identifier: MIT
#include <algorithm>
#include <cmath>
#include <numeric>
#include <utility>
#include <vector>

#include "ordering.hpp"

namespace crease {
namespace {

/// Approximate minimum degree [AMESTOY96] with the same rules and ties as AMD. A block that has been eliminated is a
/// pivot: it stands for the clique of the blocks in its list. The list of one that is left begins with the pivots it
/// touches, and what it touches otherwise follows. Blocks that have become indistinguishable go on as one, which weighs
/// as many as they are.
///
/// Which entries of a list are still alive looks random, so no branch is taken on that: there AMD spends its time.
class MinimumDegree {
 public:
  explicit MinimumDegree(const BlockGraph& graph)
      : n_(graph.n_blocks()),
        weight_(size(n_), 1),
        degree_(size(n_)),
        at_(size(n_)),
        length_(size(n_)),
        n_pivots_(size(n_), 0),
        into_(size(n_), -1),
        outside_(size(n_)),
        seen_by_(size(n_), -1),
        next_(size(2 * n_)),
        former_(size(2 * n_)),
        key_(size(n_)) {
    entries_.resize(2 * graph.inner.size());
    std::iota(next_.begin(), next_.end(), 0);
    former_ = next_;
    std::size_t n_buckets = 1;
    while (n_buckets < size(n_)) n_buckets *= 2;
    bucket_.assign(n_buckets, -1);
    const int dense = std::max(16, static_cast<int>(10 * std::sqrt(n_)));
    for (int i = 0; i < n_; ++i) {
      at_[i] = end_;
      for (int at = graph.outer[i]; at < graph.outer[i + 1]; ++at) {
        entries_[end_] = graph.inner[at];
        end_ += graph.inner[at] != i;
      }
      degree_[i] = length_[i] = end_ - at_[i];
      if (degree_[i] > dense)
        weight_[i] = 0, dense_.push_back(i);
      else
        enlist(i);
    }
    n_left_ = n_ - static_cast<int>(dense_.size());
  }

  std::vector<int> run() {
    for (int least = 0; n_left_ > 0;) {
      while (next_[n_ + least] == n_ + least) ++least;
      const int k = next_[n_ + least];
      eliminate(k);
      for (int p = at_[k]; p < at_[k] + length_[k]; ++p) find_outside(entries_[p], k);
      for (int p = at_[k]; p < at_[k] + length_[k]; ++p) update(entries_[p], k);
      for (int p = at_[k] + length_[k] - 1; p >= at_[k]; --p) join_equal(entries_[p]);
      least = std::min(least, finish(k));
    }
    return postorder();
  }

 private:
  static std::size_t size(int n) { return static_cast<std::size_t>(n); }

  /// Lists of the blocks of each degree d are rings that are entered at n + d.
  void enlist(int i) {
    const int entrance = n_ + degree_[i];
    next_[i] = next_[entrance];
    former_[i] = entrance;
    former_[next_[i]] = next_[entrance] = i;
  }

  /// Makes k the clique of all that it touches, whose weights are negative from then on.
  void eliminate(int k) {
    pivots_.push_back(k);
    n_left_ -= weight_[k];
    weight_[k] = 0;
    delist(k);
    int most = length_[k];
    for (int p = at_[k]; p < at_[k] + n_pivots_[k]; ++p) most += length_[entries_[p]];
    if (entries_.size() < size(end_ + most + 1)) entries_.resize(2 * size(end_ + most + 1));
    const bool in_place = n_pivots_[k] == 0;
    int* const begin = entries_.data() + (in_place ? at_[k] : end_);
    int* end = begin;
    clique_weight_ = 0;
    for (int p = at_[k]; p < at_[k] + n_pivots_[k]; ++p) {
      const int e = entries_[p];
      end = add_to_clique(at_[e], length_[e], end);
      into_[e] = k;
      degree_[e] = 0;  // nothing of it is outside
    }
    end = add_to_clique(at_[k] + n_pivots_[k], length_[k] - n_pivots_[k], end);
    at_[k] = static_cast<int>(begin - entries_.data());
    length_[k] = static_cast<int>(end - begin);
    if (!in_place) end_ = at_[k] + length_[k];
    for (const int* i = begin; i < end; ++i) delist(*i);
  }

  int* add_to_clique(int from, int length, int* end) {
    int* const weight = weight_.data();
    int sum = 0;
    for (const int *i = entries_.data() + from, *last = i + length; i < last; ++i) {
      const int w = weight[*i];
      *end = *i;
      end += w > 0;
      sum += std::max(w, 0);
      weight[*i] = std::min(w, -w);
    }
    clique_weight_ += sum;
    return end;
  }

  void delist(int i) {
    next_[former_[i]] = next_[i];
    former_[next_[i]] = former_[i];
  }

  /// What other cliques have outside that of k, of which i is.
  void find_outside(int i, int k) {
    for (int p = at_[i]; p < at_[i] + n_pivots_[i]; ++p) {
      const int e = entries_[p];
      outside_[e] = (seen_by_[e] == k ? outside_[e] : degree_[e]) + weight_[i];
      seen_by_[e] = k;
    }
  }

  /// Puts k into the list of i in place of what it covers. Cliques within that of k go into it, and i too if it
  /// touches nothing else. Degrees are those outside the clique until finish().
  void update(int i, int k) {
    int* const list = entries_.data() + at_[i];
    int* end = list;
    int degree = 0;
    unsigned key = 0;
    for (const int *e = list, *last = list + n_pivots_[i]; e < last; ++e) {
      const int pivot = *e, outside = outside_[pivot];
      const bool stays = outside > 0;
      into_[pivot] = stays ? into_[pivot] : k;
      *end = pivot;
      end += stays;
      degree += stays ? outside : 0;
      key += stays ? static_cast<unsigned>(pivot) : 0;
    }
    int* const blocks = end;
    for (const int *j = list + n_pivots_[i], *last = list + length_[i]; j < last; ++j) {
      const int block = *j, w = weight_[block];
      const bool stays = w > 0;
      *end = block;
      end += stays;
      degree += stays ? w : 0;
      key += stays ? static_cast<unsigned>(block) : 0;
    }
    if (degree == 0) {
      into_[i] = k;
      n_left_ += weight_[i];
      clique_weight_ += weight_[i];
      weight_[i] = 0;
      return;
    }
    *end++ = *blocks;  // at least one entry has gone
    *blocks = *list;
    *list = k;
    n_pivots_[i] = static_cast<int>(blocks - list) + 1;
    length_[i] = static_cast<int>(end - list);
    degree_[i] = std::min(degree_[i], degree);
    key_[i] = static_cast<int>(key & (bucket_.size() - 1));
  }

  /// Into one that is listed under the same key and has the same entries; if there is none it is listed there itself.
  void join_equal(int i) {
    if (weight_[i] == 0) return;
    int j = bucket_[key_[i]];
    while (j >= 0 && !are_equal(i, j)) j = next_[j];
    if (j < 0) {
      next_[i] = std::exchange(bucket_[key_[i]], i);
    } else {
      weight_[j] += std::exchange(weight_[i], 0);
      into_[i] = j;
    }
  }

  /// First entries apart: in both that is the last pivot.
  bool are_equal(int i, int j) {
    if (length_[i] != length_[j] || n_pivots_[i] != n_pivots_[j]) return false;
    --mark_;
    for (int p = at_[i] + 1; p < at_[i] + length_[i]; ++p) seen_by_[entries_[p]] = mark_;
    int p = at_[j] + 1;
    while (p < at_[j] + length_[j] && seen_by_[entries_[p]] == mark_) ++p;
    return p == at_[j] + length_[j];
  }

  /// Lists what is left of the clique of k by degree. @return the least
  int finish(int k) {
    int* const list = entries_.data() + at_[k];
    int* end = list;
    int least = n_;
    for (const int *at = list, *last = list + length_[k]; at < last; ++at) {
      const int i = *at;
      bucket_[key_[i]] = -1;
      if (weight_[i] == 0) continue;
      weight_[i] = -weight_[i];
      degree_[i] = std::min(degree_[i] + clique_weight_, n_left_) - weight_[i];
      least = std::min(least, degree_[i]);
      enlist(i);
      *end++ = i;
    }
    degree_[k] = clique_weight_;
    if (end_ == at_[k] + length_[k]) end_ = static_cast<int>(end - entries_.data());
    length_[k] = static_cast<int>(end - list);
    return least;
  }

  /// The pivots, each with what has gone into it and right after those whose cliques have; dense blocks last.
  std::vector<int> postorder() {
    pivots_.insert(pivots_.end(), dense_.begin(), dense_.end());
    std::vector<int> pivot_of(size(n_), -1), n_own(size(n_), 0), n_all(size(n_), 0), begin(size(n_)), order(size(n_));
    for (const int k : pivots_) pivot_of[k] = k;
    for (int i = 0; i < n_; ++i) {
      int k = i;
      while (pivot_of[k] < 0) k = into_[k];
      ++n_own[pivot_of[i] = pivot_of[k]];
    }
    for (const int k : pivots_) {
      n_all[k] += n_own[k];
      if (into_[k] >= 0) n_all[into_[k]] += n_all[k];
    }
    int end = n_;
    for (auto k = pivots_.rbegin(); k != pivots_.rend(); ++k) {  // room is taken from the end
      int& rest = into_[*k] < 0 ? end : begin[into_[*k]];
      begin[*k] = rest - n_own[*k];
      rest -= n_all[*k];
    }
    for (const int k : pivots_) begin[k] += n_all[k] - n_own[k];  // past its children
    for (int i = 0; i < n_; ++i) order[begin[pivot_of[i]]++] = i;
    return order;
  }

  int n_;
  // One a block:
  std::vector<int> weight_;                  ///< 0 = a pivot, or gone into another block; < 0 = in the clique at hand
  std::vector<int> degree_;                  ///< bound on the weight of what it touches; of a pivot that of its clique
  std::vector<int> at_, length_, n_pivots_;  ///< its list in entries_, pivots first; of a pivot its clique
  std::vector<int> into_;                    ///< the pivot or block that it has gone into; -1 = none
  std::vector<int> outside_;                 ///< weight of a pivot's clique outside that of pivot seen_by_
  std::vector<int> seen_by_;
  std::vector<int> next_, former_;  ///< in the rings of one degree, entrances after the blocks; or under a key
  std::vector<int> key_;            ///< of its list
  std::vector<int> bucket_;         ///< one a key: the last one listed under it, -1 = none
  std::vector<int> entries_, pivots_, dense_;
  int end_ = 0;  ///< of the lists in entries_
  int n_left_;   ///< weight of the blocks that are neither pivots nor dense
  int clique_weight_ = 0;
  int mark_ = -1;  ///< below all that seen_by_ holds
};

}  // namespace

std::vector<int> minimum_degree_order(const BlockGraph& graph) {
  return MinimumDegree(graph).run();
}

}  // namespace crease
