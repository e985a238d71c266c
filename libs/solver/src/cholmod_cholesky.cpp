// SPDX-License-Identifier: MIT
// The only file that calls CHOLMOD.
#include "cholmod_cholesky.hpp"

#include <limits>
#include <new>

#include "block_graph.hpp"
#include "crease/base/require.hpp"
#include "one_thread.hpp"
#include "ordering.hpp"

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

CholmodCholesky::CholmodCholesky() : symbolic_(nullptr, {&common_}), numeric_(nullptr, {&common_}) {
  cholmod_start(&common_);
  common_.print = 0;
  common_.supernodal = CHOLMOD_SUPERNODAL;
  common_.quick_return_if_not_posdef = 1;
  common_.nmethods = 1;
  common_.method[0].ordering = CHOLMOD_GIVEN;
  common_.postorder = 1;
}

CholmodCholesky::~CholmodCholesky() {
  numeric_.reset();
  symbolic_.reset();
  for (cholmod_dense** dense : {&work_.X1, &work_.X2, &work_.Y, &work_.E}) cholmod_free_dense(dense, &common_);
  cholmod_finish(&common_);
}

bool CholmodCholesky::analyze(const BlockGraph& graph, std::span<const int> order) try {
  require_valid(graph, order);
  const OneThread guard;
  numeric_.reset();
  symbolic_.reset();
  rcond_ = 0;
  order_ = choose_order(graph, order);
  masked_ = make_block_matrix(graph);
  std::vector<int> unknowns;
  unknowns.reserve(static_cast<size_t>(graph.n_unknowns()));
  for (const int block : order_)
    for (int i = graph.starts[block]; i < graph.starts[block + 1]; ++i) unknowns.push_back(i);
  if (unknowns.empty()) return true;  // which CHOLMOD takes for an error
  cholmod_sparse matrix = view(masked_);
  symbolic_.reset(cholmod_analyze_p(&matrix, unknowns.data(), nullptr, 0, &common_));
  return symbolic_ != nullptr;
} catch (const std::bad_alloc&) {
  return false;
}

bool CholmodCholesky::factorize(const SparseMatrix& A, std::span<const char> held, double lift) {
  CREASE_ASSERT(A.nonZeros() == masked_.nonZeros());
  const OneThread guard;
  rcond_ = 0;
  if (A.rows() == 0) return (rcond_ = 1) > 0;
  if (!symbolic_) return false;
  mask(A, held, lift);
  // A factor that met a bad pivot is not fit for another try, so the analysis is copied afresh after a failure.
  if (!numeric_) numeric_.reset(cholmod_copy_factor(symbolic_.get(), &common_));
  if (!numeric_) return false;
  cholmod_sparse matrix = view(masked_);
  bool done = cholmod_factorize(&matrix, numeric_.get(), &common_) && common_.status == CHOLMOD_OK &&
              numeric_->minor == numeric_->n;
  rcond_ = done ? cholmod_rcond(numeric_.get(), &common_) : 0;
  if (!(rcond_ > 0)) numeric_.reset(), done = false;  // pivots that are no numbers pass CHOLMOD
  return done;
}

void CholmodCholesky::mask(const SparseMatrix& A, std::span<const char> held, double lift) {
  const int* outer = A.outerIndexPtr();
  const int* inner = A.innerIndexPtr();
  for (int c = 0; c < A.cols(); ++c)
    for (int at = outer[c]; at < outer[c + 1]; ++at) {
      const bool masked = !held.empty() && (held[c] || held[inner[at]]);
      const double diagonal = inner[at] == c ? (masked ? 1.0 : lift) : 0.0;
      masked_.valuePtr()[at] = (masked ? 0.0 : A.valuePtr()[at]) + diagonal;
    }
}

MatX CholmodCholesky::half_solve(const MatX& B, int first, int second) const {
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
