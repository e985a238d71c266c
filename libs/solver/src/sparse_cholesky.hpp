// SPDX-License-Identifier: MIT
#pragma once

#include <cholmod.h>

#include <memory>
#include <vector>

#include "crease/base/types.hpp"

namespace crease {

/// P A P^T = L L^T of a sparse symmetric positive definite matrix by CHOLMOD's supernodal factorisation [CHEN08], on
/// one thread. The analysis is kept until the next analyze(); factorize() may be called with new values any number of
/// times.
class SparseCholesky {
 public:
  SparseCholesky();
  ~SparseCholesky();
  SparseCholesky(const SparseCholesky&) = delete;
  SparseCholesky& operator=(const SparseCholesky&) = delete;

  /// Orders the graph of blocks by minimum degree, then analyses `A` in that order. Only the lower triangle is read.
  /// @param blocks        ascending starts of the blocks, last entry A.rows()
  /// @param block_outer, block_inner  which blocks touch which, compressed columns with both triangles
  /// @return              false if CHOLMOD failed (out of memory)
  bool analyze(const SparseMatrix& A, const std::vector<int>& blocks, std::vector<int>& block_outer,
               std::vector<int>& block_inner);
  /// @return false if `A` is not positive definite to working precision
  bool factorize(const SparseMatrix& A);
  /// Rough reciprocal condition number: squared ratio of the smallest to the largest diagonal entry of L.
  double rcond();

  /// Flops of a factorisation over those of half a solve with one right-hand side.
  double cost_ratio() const { return common_.lnz > 0 ? common_.fl / (2 * common_.lnz) : 0; }

  /// L^-1 P B and P^T L^-T B, both halves of a solve.
  MatX forward(const MatX& B) { return half_solve(B, CHOLMOD_P, CHOLMOD_L); }
  MatX backward(const MatX& B) { return half_solve(B, CHOLMOD_Lt, CHOLMOD_Pt); }

 private:
  MatX half_solve(const MatX& B, int first, int second);

  struct FactorDeleter {
    cholmod_common* common;
    void operator()(cholmod_factor* factor) const { cholmod_free_factor(&factor, common); }
  };
  using Factor = std::unique_ptr<cholmod_factor, FactorDeleter>;
  struct Workspace {
    cholmod_dense *X1 = nullptr, *X2 = nullptr, *Y = nullptr, *E = nullptr;
  };

  cholmod_common common_;
  Factor symbolic_, numeric_;
  Workspace work_;
};

}  // namespace crease
