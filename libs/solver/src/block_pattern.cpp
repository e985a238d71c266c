// SPDX-License-Identifier: MIT
#include "block_pattern.hpp"

#include <algorithm>
#include <cstring>

#include "block_basis.hpp"

namespace crease {
namespace {

bool equal(const std::vector<int>& a, const int* b, size_t count) {
  return a.size() == count && std::equal(a.begin(), a.end(), b);
}

}  // namespace

bool BlockPattern::update(const QpProblem& problem) {
  const SparseMatrix& H = problem.H;
  const size_t n_outer = static_cast<size_t>(H.outerSize()) + 1;
  const size_t n_inner = static_cast<size_t>(H.nonZeros());
  if (!starts_.empty() && given_blocks_ == problem.blocks && equal(given_outer_, H.outerIndexPtr(), n_outer) &&
      equal(given_inner_, H.innerIndexPtr(), n_inner))
    return false;
  given_blocks_ = problem.blocks;
  given_outer_.assign(H.outerIndexPtr(), H.outerIndexPtr() + n_outer);
  given_inner_.assign(H.innerIndexPtr(), H.innerIndexPtr() + n_inner);
  set_blocks(problem);
  build_graph(H);
  ++revision_;
  return true;
}

void BlockPattern::set_blocks(const QpProblem& problem) {
  const int n = static_cast<int>(problem.f.size());
  starts_.assign(1, 0);
  const std::vector<int>& given = problem.blocks;
  for (size_t k = 0; k + 1 < given.size(); ++k) {
    if (given[k + 1] - given[k] > max_block)
      for (int i = given[k] + 1; i < given[k + 1]; ++i) starts_.push_back(i);
    starts_.push_back(given[k + 1]);
  }
  if (given.empty())
    for (int i = 1; i <= n; ++i) starts_.push_back(i);
  block_of_.resize(static_cast<size_t>(n));
  for (int k = 0; k < n_blocks(); ++k) std::fill(&block_of_[start(k)], &block_of_[start(k)] + size(k), k);
}

void BlockPattern::build_graph(const SparseMatrix& H) {
  outer_.assign(1, 0);
  inner_.clear();
  heights_.assign(static_cast<size_t>(n_blocks()), 0);
  std::vector<int> seen_by(static_cast<size_t>(n_blocks()), -1);
  long long n_values = 0;
  for (int k = 0; k < n_blocks(); ++k) {
    const auto first = static_cast<std::ptrdiff_t>(inner_.size());
    inner_.push_back(k);  // the diagonal is needed even where H has none
    seen_by[k] = k;
    for (int c = start(k); c < start(k + 1); ++c)
      for (SparseMatrix::InnerIterator entry(H, c); entry; ++entry) {
        const int other = block_of_[entry.row()];
        if (seen_by[other] == k) continue;
        seen_by[other] = k;
        inner_.push_back(other);
      }
    std::sort(inner_.begin() + first, inner_.end());
    outer_.push_back(static_cast<int>(inner_.size()));
    for (auto other = inner_.begin() + first; other != inner_.end(); ++other) heights_[k] += size(*other);
    n_values += static_cast<long long>(heights_[k]) * size(k);
  }
  is_full_ = n_values == H.nonZeros();
}

SparseMatrix BlockPattern::make_matrix() const {
  const int n = static_cast<int>(block_of_.size());
  SparseMatrix A(n, n);
  int* outer = A.outerIndexPtr();
  outer[0] = 0;
  for (int c = 0; c < n; ++c) outer[c + 1] = outer[c] + heights_[block_of_[c]];
  A.resizeNonZeros(outer[n]);
  for (int c = 0; c < n; ++c) {
    int* row = A.innerIndexPtr() + outer[c];
    const int k = block_of_[c];
    for (int at = outer_[k]; at < outer_[k + 1]; ++at)
      for (int r = start(inner_[at]); r < start(inner_[at] + 1); ++r) *row++ = r;
  }
  std::fill(A.valuePtr(), A.valuePtr() + outer[n], 0.0);
  return A;
}

void BlockPattern::gather(const SparseMatrix& H, double* values) const {
  if (is_full_) {
    std::copy(H.valuePtr(), H.valuePtr() + H.nonZeros(), values);
    return;
  }
  std::vector<int> offset(static_cast<size_t>(n_blocks()));
  double* column = values;
  for (int k = 0; k < n_blocks(); ++k) {
    int height_so_far = 0;
    for (int at = outer_[k]; at < outer_[k + 1]; ++at) {
      offset[inner_[at]] = height_so_far;
      height_so_far += size(inner_[at]);
    }
    for (int c = start(k); c < start(k + 1); ++c, column += heights_[k]) {
      std::fill(column, column + heights_[k], 0.0);
      for (SparseMatrix::InnerIterator entry(H, c); entry; ++entry) {
        const int r = static_cast<int>(entry.row());
        column[offset[block_of_[r]] + r - start(block_of_[r])] = entry.value();
      }
    }
  }
}

}  // namespace crease
