// SPDX-License-Identifier: MIT
#pragma once

#include <array>
#include <span>
#include <vector>

#include "aligned_buffer.hpp"
#include "crease/base/workers.hpp"
#include "crease/solver/block_cholesky.hpp"
#include "front_kernels.hpp"
#include "half_solves.hpp"
#include "supernode_tree.hpp"

namespace crease {

/// Multifrontal Cholesky [DUFF83], [LIU92] on the graph of blocks.
///
/// Children first, every supernode assembles a front: its columns of A, and what the factorised columns of its children
/// subtract from them and from later ones (their updates). It factorises its own columns, which become part of L, and
/// leaves the update of the rest to its parent.
///
/// Held unknowns are left out of the fronts, not multiplied by zero: the tree is one of blocks, and how many unknowns
/// of a block take part is seen anew by every factorisation.
class Multifrontal final : public BlockCholesky {
 public:
  Multifrontal(const FrontKernels& kernels, int n_threads)
      : kernels_(kernels), n_threads_(n_threads), workers_(n_threads) {}

  bool analyze(const BlockGraph& graph, std::span<const int> order) override;
  const std::vector<int>& order() const override { return order_; }
  bool factorize(const SparseMatrix& A, std::span<const char> held, double lift) override;
  double rcond() const override { return rcond_; }
  FactorCost cost() const override { return cost_; }
  MatX forward(const MatX& B) const override;
  MatX backward(const MatX& B) const override;

  /// Unknowns that are not held by the last factorisation: the first rows between the halves of a solve.
  int n_free() const { return free_at_.back(); }
  /// Its row there.
  int place(int unknown) const { return place_[unknown]; }
  /// Adds L^-1 P C to `Y`, which has n_free() rows. Columns of neighbours in a row are the cheaper.
  /// @pre no entry of C stands in the row of a held unknown
  void forward(const SparseMatrix& C, HalfSolves& Y) const;

 private:
  struct Front {
    FrontShape shape;
    int first;              ///< of its pivots, among the unknowns that are not held, in order of elimination
    int rows_at;            ///< in border_
    std::size_t factor_at;  ///< in factor_
    std::size_t update_at;  ///< in its stack of updates
  };
  /// A block of A on or below the diagonal of a block column: whose rows, and where in that column's values.
  struct Entry {
    int position, offset;
  };
  class Assembly;

  void collect_entries();
  void lay_out(std::span<const char> held);
  /// Updates of one worker's supernodes, by the parity of their depth: those of a node's children lie on top of the one
  /// stack while its own is put on the other.
  using Stacks = std::array<AlignedBuffer, 2>;

  /// In memory, and what all fronts of these shapes cost.
  void place_fronts();
  void place_updates();
  void share_out();
  double* update_of(int s) const { return updates_[worker_[s]][depth_[s] % 2].data() + fronts_[s].update_at; }
  bool factorize_fronts(const double* values, double lift);
  void find_rcond();
  void forward_one(double* y) const;
  void backward_one(double* y) const;
  void forward_panels(const Eigen::Ref<const MatX>& B, Eigen::Ref<MatX> Y) const;
  void forward_fronts(int n_panels, double* const* rows, std::vector<char>& met) const;
  std::vector<char> fill_panels(const Eigen::Ref<const MatX>& B, double* const* rows, Eigen::Ref<MatX> Y) const;

  const FrontKernels& kernels_;
  int n_threads_;
  Workers workers_;

  // The analysis.
  BlockGraph graph_;
  std::vector<int> order_;  ///< as given, or of minimum degree; the tree's differs, and would give a third
  SupernodeTree tree_;
  std::vector<int> depth_, first_child_, next_child_;  ///< one a supernode; -1 = none
  std::vector<int> worker_;               ///< one a supernode; the last one begins when the others are done
  std::vector<int> heights_, values_at_;  ///< one a block: rows of its column of A, its first value
  std::vector<int> entries_at_;           ///< one a position
  std::vector<Entry> entries_;

  // One factorisation.
  bool factorized_ = false;
  std::vector<int> free_at_;  ///< one a position: its first unknown among the free ones
  std::vector<int> unknown_;  ///< free unknowns in order of elimination, then the held ones
  std::vector<int> place_;    ///< its inverse
  std::vector<Front> fronts_;
  std::vector<int> border_;  ///< the free unknowns below the columns of each front
  AlignedBuffer factor_;
  std::vector<Stacks> updates_;  ///< one a worker
  int most_border_panels_ = 0;
  double rcond_ = 0;
  FactorCost cost_;
};

}  // namespace crease
