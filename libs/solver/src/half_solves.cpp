// SPDX-License-Identifier: MIT
#include "half_solves.hpp"

#include <algorithm>

namespace crease {

void HalfSolves::clear(int n_rows) {
  n_rows_ = n_rows;
  first_column_.assign(1, 0);
}

double* HalfSolves::add_batch(int n_columns) {
  const int b = n_batches(), panels = FrontShape::panels(n_columns);
  first_column_.push_back(first_column_.back() + width * panels);
  if (b == static_cast<int>(batches_.size())) batches_.emplace_back();
  const std::size_t size = static_cast<std::size_t>(width * panels) * static_cast<std::size_t>(n_rows_);
  batches_[b].values.reserve(size);
  std::fill(batches_[b].values.data(), batches_[b].values.data() + size, 0.0);
  return batches_[b].values.data();
}

void HalfSolves::set_rows(const std::vector<char>& met) {
  std::vector<char>& has = batches_[n_batches() - 1].has;
  has.assign(static_cast<std::size_t>(n_strips()), 0);
  for (int s = 0; s < n_strips(); ++s) {
    const auto begin = met.begin() + s * strip, end = begin + rows_of(s);
    has[s] = std::find(begin, end, 1) != end;
  }
}

void HalfSolves::fill_gram(int first, MatX& gram) const {
  const int n = n_columns();
  gram.middleCols(first, n - first).topRows(n).setZero();
  for (int s = 0; s < n_strips(); ++s)
    for (int b = 0; b < n_batches(); ++b) {
      if (first_column_[b] < first || !batches_[b].has[s]) continue;
      for (int c = 0; c <= b; ++c) {
        if (!batches_[c].has[s]) continue;
        for (int j = 0; j < n_panels(b); ++j)
          for (int i = 0; i < (c == b ? j + 1 : n_panels(c)); ++i) {
            alignas(64) double product[width * width];
            kernels_->product(rows_of(s), at(c, i, s), at(b, j, s), product);
            gram.block<width, width>(first_column_[c] + width * i, first_column_[b] + width * j) -=
                Eigen::Map<const Eigen::Matrix<double, width, width>>(product);
          }
      }
    }
  for (int j = first; j < n; ++j)
    for (int i = 0; i < j; ++i) gram(j, i) = gram(i, j);
}

void HalfSolves::subtract_product(const VecX& z, VecX& x) const {
  std::vector<const double*> panels, factors;
  for (int s = 0; s < n_strips(); ++s) {
    panels.clear();
    factors.clear();
    for (int b = 0; b < n_batches(); ++b)
      for (int i = 0; batches_[b].has[s] && i < n_panels(b); ++i) {
        panels.push_back(at(b, i, s));
        factors.push_back(z.data() + first_column_[b] + width * i);
      }
    kernels_->subtract_rows(static_cast<int>(panels.size()), panels.data(), factors.data(), rows_of(s),
                            x.data() + s * strip);
  }
}

VecX HalfSolves::transposed_product(const VecX& y) const {
  VecX result = VecX::Zero(n_columns());
  Eigen::Matrix<double, width, 1> part;
  for (int b = 0; b < n_batches(); ++b)
    for (int s = 0; s < n_strips(); ++s)
      for (int i = 0; batches_[b].has[s] && i < n_panels(b); ++i) {
        kernels_->times(at(b, i, s), rows_of(s), y.data() + s * strip, part.data());
        result.segment<width>(first_column_[b] + width * i) += part;
      }
  return result;
}

}  // namespace crease
