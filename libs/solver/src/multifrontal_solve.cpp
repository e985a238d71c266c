// SPDX-License-Identifier: MIT
#include <algorithm>

#include "crease/base/require.hpp"
#include "multifrontal.hpp"

namespace crease {
namespace {

/// Right-hand sides from which on a panel of eight, some of them empty, takes less time than one after the other.
constexpr int least_batch = 3;
constexpr int batch = HalfSolves::batch;
using PanelRow = Eigen::Map<Eigen::Array<double, FrontShape::panel, 1>>;

}  // namespace

MatX Multifrontal::forward(const MatX& B) const {
  CREASE_ASSERT(factorized_ && B.rows() == graph_.n_unknowns());
  MatX Y(B.rows(), B.cols());
  for (int first = 0; first < B.cols(); first += batch) {
    const int n = std::min(batch, static_cast<int>(B.cols()) - first);
    if (n >= least_batch) {
      forward_panels(B.middleCols(first, n), Y.middleCols(first, n));
      continue;
    }
    for (int j = first; j < first + n; ++j) {
      for (Eigen::Index i = 0; i < B.rows(); ++i) Y(i, j) = B(unknown_[i], j);
      forward_one(Y.col(j).data());
    }
  }
  return Y;
}

MatX Multifrontal::backward(const MatX& Y) const {
  CREASE_ASSERT(factorized_ && Y.rows() == graph_.n_unknowns());
  MatX X(Y.rows(), Y.cols());
  VecX x;
  for (Eigen::Index j = 0; j < Y.cols(); ++j) {
    x = Y.col(j);
    backward_one(x.data());
    for (Eigen::Index i = 0; i < Y.rows(); ++i) X(unknown_[i], j) = x[i];
  }
  return X;
}

void Multifrontal::forward_one(double* y) const {
  std::vector<double> product(static_cast<std::size_t>(8 * most_border_panels_));
  for (const Front& front : fronts_) {
    kernels_.forward(front.shape, factor_.data() + front.factor_at, y + front.first, product.data());
    const int* border = border_.data() + front.rows_at;
    for (int i = 0; i < front.shape.border; ++i) y[border[i]] -= product[i];
  }
}

void Multifrontal::backward_one(double* y) const {
  std::vector<double> below(static_cast<std::size_t>(8 * most_border_panels_));
  for (auto front = fronts_.rbegin(); front != fronts_.rend(); ++front) {
    const int* border = border_.data() + front->rows_at;
    const int n = front->shape.border;
    for (int i = 0; i < n; ++i) below[i] = y[border[i]];
    std::fill(below.begin() + n, below.begin() + 8 * front->shape.border_panels(), 0.0);
    kernels_.backward(front->shape, factor_.data() + front->factor_at, below.data(), y + front->first);
  }
}

void Multifrontal::forward(const SparseMatrix& C, HalfSolves& Y) const {
  CREASE_ASSERT(factorized_ && C.rows() == graph_.n_unknowns());
  std::vector<char> met(static_cast<std::size_t>(n_free()));
  for (int first = 0; first < C.cols(); first += batch) {
    const int n = std::min(batch, static_cast<int>(C.cols()) - first);
    double* rows[max_rhs_panels];
    rows[0] = Y.add_batch(n);
    for (int p = 1; p < FrontShape::panels(n); ++p) rows[p] = rows[p - 1] + 8 * static_cast<std::ptrdiff_t>(n_free());
    std::fill(met.begin(), met.end(), 0);
    for (int j = 0; j < n; ++j)
      for (SparseMatrix::InnerIterator entry(C, first + j); entry; ++entry) {
        const int place = place_[entry.row()];
        CREASE_ASSERT(place < n_free());
        rows[j / 8][8 * static_cast<std::ptrdiff_t>(place) + j % 8] = entry.value();
        met[place] = 1;
      }
    forward_fronts(FrontShape::panels(n), rows, met);
    Y.set_rows(met);
  }
}

/// At most `batch` columns at once.
void Multifrontal::forward_panels(const Eigen::Ref<const MatX>& B, Eigen::Ref<MatX> Y) const {
  const int n_panels = FrontShape::panels(static_cast<int>(B.cols()));
  const auto panel_size = 8 * static_cast<std::size_t>(n_free());
  AlignedBuffer work;
  work.reserve(static_cast<std::size_t>(n_panels) * panel_size);
  double* rows[max_rhs_panels];
  for (int p = 0; p < n_panels; ++p) rows[p] = work.data() + static_cast<std::size_t>(p) * panel_size;
  std::vector<char> met = fill_panels(B, rows, Y);
  forward_fronts(n_panels, rows, met);
  for (int p = 0; p < n_panels; ++p) {
    const Eigen::Index first = FrontShape::panel * p,
                       width = std::min<Eigen::Index>(FrontShape::panel, Y.cols() - first);
    for (int i = 0; i < n_free(); ++i)
      if (met[i])
        for (Eigen::Index k = 0; k < width; ++k) Y(i, first + k) = rows[p][8 * static_cast<std::ptrdiff_t>(i) + k];
  }
}

/// A supernode none of whose descendants, nor itself, meets an entry is passed over.
/// @param met  the rows that have entries; those that get some are added
void Multifrontal::forward_fronts(int n_panels, double* const* rows, std::vector<char>& met) const {
  const auto product_size = 64 * static_cast<std::size_t>(most_border_panels_);
  AlignedBuffer work;
  work.reserve(static_cast<std::size_t>(n_panels) * product_size);
  double* product[max_rhs_panels];
  for (int p = 0; p < n_panels; ++p) product[p] = work.data() + static_cast<std::size_t>(p) * product_size;
  double* own[max_rhs_panels];
  for (const Front& front : fronts_) {
    const auto begin = met.begin() + front.first, end = begin + front.shape.pivots;
    if (std::find(begin, end, 1) == end) continue;
    std::fill(begin, end, 1);
    for (int p = 0; p < n_panels; ++p) own[p] = rows[p] + 8 * static_cast<std::ptrdiff_t>(front.first);
    kernels_.forward_batch(front.shape, factor_.data() + front.factor_at, n_panels, own, product);
    const int* border = border_.data() + front.rows_at;
    for (int i = 0; i < front.shape.border; ++i) met[border[i]] = 1;
    for (int p = 0; p < n_panels; ++p)
      for (int i = 0; i < front.shape.border; ++i)
        PanelRow(rows[p] + 8 * static_cast<std::ptrdiff_t>(border[i])) += PanelRow(product[p] + 8 * i);
  }
}

/// Spreads the entries of B over panels, and those of held unknowns over Y. @return which free unknowns have any
std::vector<char> Multifrontal::fill_panels(const Eigen::Ref<const MatX>& B, double* const* rows,
                                            Eigen::Ref<MatX> Y) const {
  const auto panel_size = 8 * static_cast<std::size_t>(n_free());
  for (int p = 0; p < FrontShape::panels(static_cast<int>(B.cols())); ++p)
    std::fill(rows[p], rows[p] + panel_size, 0.0);
  Y.setZero();
  std::vector<char> met(static_cast<std::size_t>(n_free()), 0);
  for (Eigen::Index j = 0; j < B.cols(); ++j)
    for (Eigen::Index i = 0; i < B.rows(); ++i) {
      if (B(i, j) == 0) continue;
      const int place = place_[i];
      if (place >= n_free()) {
        Y(place, j) = B(i, j);
      } else {
        rows[j / 8][8 * static_cast<std::ptrdiff_t>(place) + j % 8] = B(i, j);
        met[place] = 1;
      }
    }
  return met;
}

}  // namespace crease
