// SPDX-License-Identifier: MIT
// The only file that calls CHOLMOD.
#include "sparse_cholesky.hpp"

#include <limits>

#include "one_thread.hpp"

namespace crease {
namespace {

/// Views Eigen's arrays; CHOLMOD does not write to its inputs, though its types say nothing of it.
cholmod_sparse view(int n, const int* outer, const int* inner, const double* values) {
  cholmod_sparse A{};
  A.nrow = A.ncol = static_cast<size_t>(n);
  A.nzmax = static_cast<size_t>(outer[n]);
  A.p = const_cast<int*>(outer);
  A.i = const_cast<int*>(inner);
  A.x = const_cast<double*>(values);
  A.stype = -1;  // symmetric, upper triangle ignored
  A.itype = CHOLMOD_INT;
  A.xtype = values ? CHOLMOD_REAL : CHOLMOD_PATTERN;
  A.dtype = CHOLMOD_DOUBLE;
  A.sorted = A.packed = 1;
  return A;
}

cholmod_sparse view(const SparseMatrix& A) {
  return view(static_cast<int>(A.rows()), A.outerIndexPtr(), A.innerIndexPtr(), A.valuePtr());
}

cholmod_dense view(const MatX& B) {
  cholmod_dense D{};
  D.nrow = D.d = static_cast<size_t>(B.rows());
  D.ncol = static_cast<size_t>(B.cols());
  D.nzmax = D.nrow * D.ncol;
  D.x = const_cast<double*>(B.data());
  D.xtype = CHOLMOD_REAL;
  D.dtype = CHOLMOD_DOUBLE;
  return D;
}

}  // namespace

SparseCholesky::SparseCholesky() : symbolic_(nullptr, {&common_}), numeric_(nullptr, {&common_}) {
  cholmod_start(&common_);
  common_.print = 0;
  common_.supernodal = CHOLMOD_SUPERNODAL;
  common_.quick_return_if_not_posdef = 1;
  common_.nmethods = 1;
  common_.method[0].ordering = CHOLMOD_GIVEN;
  common_.postorder = 1;
}

SparseCholesky::~SparseCholesky() {
  numeric_.reset();
  symbolic_.reset();
  for (cholmod_dense** dense : {&work_.X1, &work_.X2, &work_.Y, &work_.E}) cholmod_free_dense(dense, &common_);
  cholmod_finish(&common_);
}

bool SparseCholesky::analyze(const SparseMatrix& A, const std::vector<int>& blocks, std::vector<int>& block_outer,
                             std::vector<int>& block_inner) {
  const OneThread guard;
  numeric_.reset();
  symbolic_.reset();
  const int n_blocks = static_cast<int>(blocks.size()) - 1;
  cholmod_sparse graph = view(n_blocks, block_outer.data(), block_inner.data(), nullptr);
  std::vector<int> block_order(static_cast<size_t>(n_blocks));
  if (!cholmod_amd(&graph, nullptr, 0, block_order.data(), &common_)) return false;
  std::vector<int> order;
  order.reserve(static_cast<size_t>(A.rows()));
  for (const int block : block_order)
    for (int i = blocks[block]; i < blocks[block + 1]; ++i) order.push_back(i);
  cholmod_sparse matrix = view(A);
  symbolic_.reset(cholmod_analyze_p(&matrix, order.data(), nullptr, 0, &common_));
  return symbolic_ != nullptr;
}

bool SparseCholesky::factorize(const SparseMatrix& A) {
  const OneThread guard;
  if (!symbolic_) return false;
  // A factor that met a bad pivot is not fit for another try, so the analysis is copied afresh after a failure.
  if (!numeric_) numeric_.reset(cholmod_copy_factor(symbolic_.get(), &common_));
  if (!numeric_) return false;
  cholmod_sparse matrix = view(A);
  const bool done = cholmod_factorize(&matrix, numeric_.get(), &common_) && common_.status == CHOLMOD_OK &&
                    numeric_->minor == numeric_->n;
  if (!done) numeric_.reset();
  return done;
}

double SparseCholesky::rcond() {
  return numeric_ ? cholmod_rcond(numeric_.get(), &common_) : 0.0;
}

MatX SparseCholesky::half_solve(const MatX& B, int first, int second) {
  const OneThread guard;
  if (B.size() == 0) return B;
  cholmod_dense rhs = view(B);
  const bool done =
      cholmod_solve2(first, numeric_.get(), &rhs, nullptr, &work_.X1, nullptr, &work_.Y, &work_.E, &common_) &&
      cholmod_solve2(second, numeric_.get(), work_.X1, nullptr, &work_.X2, nullptr, &work_.Y, &work_.E, &common_);
  if (!done) return MatX::Constant(B.rows(), B.cols(), std::numeric_limits<double>::quiet_NaN());
  return Eigen::Map<const MatX>(static_cast<const double*>(work_.X2->x), B.rows(), B.cols());
}

}  // namespace crease
