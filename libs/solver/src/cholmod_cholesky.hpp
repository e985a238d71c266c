// SPDX-License-Identifier: MIT
#pragma once

#include <cholmod.h>

#include <memory>
#include <vector>

#include "crease/solver/block_cholesky.hpp"

namespace crease {

/// CHOLMOD's supernodal factorisation [CHEN08] on one thread. Held unknowns stay in it as identity rows.
class CholmodCholesky final : public BlockCholesky {
 public:
  CholmodCholesky();
  ~CholmodCholesky() override;
  CholmodCholesky(const CholmodCholesky&) = delete;
  CholmodCholesky& operator=(const CholmodCholesky&) = delete;

  bool analyze(const BlockGraph& graph, std::span<const int> order) override;
  const std::vector<int>& order() const override { return order_; }
  bool factorize(const SparseMatrix& A, std::span<const char> held, double lift) override;
  double rcond() const override { return rcond_; }
  FactorCost cost() const override { return symbolic_ ? FactorCost{common_.lnz, common_.fl} : FactorCost{}; }
  MatX forward(const MatX& B) const override { return half_solve(B, CHOLMOD_P, CHOLMOD_L); }
  MatX backward(const MatX& B) const override { return half_solve(B, CHOLMOD_Lt, CHOLMOD_Pt); }

 private:
  void mask(const SparseMatrix& A, std::span<const char> held, double lift);
  MatX half_solve(const MatX& B, int first, int second) const;

  struct FactorDeleter {
    cholmod_common* common;
    void operator()(cholmod_factor* factor) const { cholmod_free_factor(&factor, common); }
  };
  using Factor = std::unique_ptr<cholmod_factor, FactorDeleter>;
  struct Workspace {
    cholmod_dense *X1 = nullptr, *X2 = nullptr, *Y = nullptr, *E = nullptr;
  };

  // CHOLMOD counts and keeps its workspace here, also in what is a const call to us.
  mutable cholmod_common common_;
  mutable Workspace work_;
  Factor symbolic_, numeric_;
  std::vector<int> order_;  ///< of blocks
  SparseMatrix masked_;
  double rcond_ = 0;
};

}  // namespace crease
