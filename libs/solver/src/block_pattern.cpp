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

/// Largest difference between a block, `rows` x `columns`, and the transpose of its image; both stand in columns of
/// the heights given.
template <int N>
double asymmetry_of(const double* block, int height, const double* image, int image_height, int rows, int columns) {
  using View = Eigen::Map<const Eigen::Matrix<double, N, N>, 0, Eigen::OuterStride<>>;
  const View here(block, rows, columns, Eigen::OuterStride<>(height));
  const View there(image, columns, rows, Eigen::OuterStride<>(image_height));
  return (here - there.transpose()).cwiseAbs().maxCoeff();
}

}  // namespace

bool BlockPattern::is_that_of(const QpProblem& problem) const {
  const SparseMatrix& H = problem.H;
  return revision_ > 0 && H.rows() == H.cols() && H.isCompressed() && given_blocks_ == problem.blocks &&
         equal(given_outer_, H.outerIndexPtr(), static_cast<size_t>(H.outerSize()) + 1) &&
         equal(given_inner_, H.innerIndexPtr(), static_cast<size_t>(H.nonZeros()));
}

bool BlockPattern::update(const QpProblem& problem) {
  if (is_that_of(problem)) return false;
  const SparseMatrix& H = problem.H;
  given_blocks_ = problem.blocks;
  given_outer_.assign(H.outerIndexPtr(), H.outerIndexPtr() + H.outerSize() + 1);
  given_inner_.assign(H.innerIndexPtr(), H.innerIndexPtr() + H.nonZeros());
  set_blocks(problem);
  build_graph(H);
  find_mirrors();
  ++revision_;
  return true;
}

void BlockPattern::set_blocks(const QpProblem& problem) {
  const int n = static_cast<int>(problem.f.size());
  graph_.starts.assign(1, 0);
  const std::vector<int>& given = problem.blocks;
  for (size_t k = 0; k + 1 < given.size(); ++k) {
    if (given[k + 1] - given[k] > max_block)
      for (int i = given[k] + 1; i < given[k + 1]; ++i) graph_.starts.push_back(i);
    graph_.starts.push_back(given[k + 1]);
  }
  if (given.empty())
    for (int i = 1; i <= n; ++i) graph_.starts.push_back(i);
  block_of_.resize(static_cast<size_t>(n));
  for (int k = 0; k < n_blocks(); ++k) std::fill(&block_of_[start(k)], &block_of_[start(k)] + size(k), k);
}

void BlockPattern::build_graph(const SparseMatrix& H) {
  graph_.outer.assign(1, 0);
  graph_.inner.clear();
  heights_.assign(static_cast<size_t>(n_blocks()), 0);
  std::vector<int> seen_by(static_cast<size_t>(n_blocks()), -1);
  long long n_values = 0;
  for (int k = 0; k < n_blocks(); ++k) {
    const auto first = static_cast<std::ptrdiff_t>(graph_.inner.size());
    graph_.inner.push_back(k);  // the diagonal is needed even where H has none
    seen_by[k] = k;
    for (int c = start(k); c < start(k + 1); ++c)
      for (SparseMatrix::InnerIterator entry(H, c); entry; ++entry) {
        const int other = block_of_[entry.row()];
        if (seen_by[other] == k) continue;
        seen_by[other] = k;
        graph_.inner.push_back(other);
      }
    std::sort(graph_.inner.begin() + first, graph_.inner.end());
    graph_.outer.push_back(static_cast<int>(graph_.inner.size()));
    for (auto other = graph_.inner.begin() + first; other != graph_.inner.end(); ++other) heights_[k] += size(*other);
    n_values += static_cast<long long>(heights_[k]) * size(k);
  }
  is_full_ = n_values == H.nonZeros();
}

/// Columns in order meet the blocks of a row in order.
void BlockPattern::find_mirrors() {
  mirrors_.clear();
  if (!is_full_) return;
  std::vector<int> next(static_cast<size_t>(n_blocks()));  // first value of the block in each column to be met next
  for (int k = 0; k < n_blocks(); ++k) next[k] = given_outer_[start(k)];
  for (int k = 0; k < n_blocks(); ++k)
    for (int at = graph_.outer[k]; at < graph_.outer[k + 1]; ++at) {
      const int other = graph_.inner[at];
      if (other <= k) continue;
      mirrors_.push_back(next[other]);
      next[other] += size(k);
    }
}

double BlockPattern::asymmetry(const SparseMatrix& H) const {
  const double* values = H.valuePtr();
  double worst = 0;
  auto mirror = mirrors_.begin();
  for (int k = 0; k < n_blocks(); ++k) {
    const double* block = values + H.outerIndexPtr()[start(k)];
    for (int at = graph_.outer[k]; at < graph_.outer[k + 1]; ++at) {
      const int other = graph_.inner[at], rows = size(other);
      if (other >= k) {
        const double* image = other == k ? block : values + *mirror++;
        worst = std::max(worst,
                         rows == 3 && size(k) == 3
                             ? asymmetry_of<3>(block, heights_[k], image, heights_[other], 3, 3)
                             : asymmetry_of<Eigen::Dynamic>(block, heights_[k], image, heights_[other], rows, size(k)));
      }
      block += rows;
    }
  }
  return worst;
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
    for (int at = graph_.outer[k]; at < graph_.outer[k + 1]; ++at) {
      offset[graph_.inner[at]] = height_so_far;
      height_so_far += size(graph_.inner[at]);
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

// Column by column: by symmetry a column's product with x is an entry of the result, and no entry is met twice.
VecX multiply(const BlockGraph& graph, const SparseMatrix& H, const VecX& x) {
  VecX y(x.size());
  const double* values = H.valuePtr();
  for (int k = 0; k < graph.n_blocks(); ++k) {
    const int start = graph.starts[k], size = graph.size(k);
    const int height = H.outerIndexPtr()[start + 1] - H.outerIndexPtr()[start];
    const double* column = values + H.outerIndexPtr()[start];
    if (size == 3) {
      Vec3 sum[3] = {Vec3::Zero(), Vec3::Zero(), Vec3::Zero()};  // additions that need not wait for each other
      for (int at = graph.outer[k]; at < graph.outer[k + 1]; ++at) {
        const int other = graph.starts[graph.inner[at]], rows = graph.size(graph.inner[at]);
        const auto add = [&](Vec3& to, int i) {
          to += x[other + i] * Vec3(column[i], column[height + i], column[2 * height + i]);
        };
        if (rows == 3) {
          add(sum[0], 0), add(sum[1], 1), add(sum[2], 2);
        } else {
          for (int i = 0; i < rows; ++i) add(sum[0], i);
        }
        column += rows;
      }
      y.segment<3>(start) = sum[0] + sum[1] + sum[2];
      continue;
    }
    for (int c = 0; c < size; ++c) {
      double sum = 0;
      const double* entry = column + static_cast<std::ptrdiff_t>(c) * height;
      for (int at = graph.outer[k]; at < graph.outer[k + 1]; ++at)
        for (int i = graph.starts[graph.inner[at]]; i < graph.starts[graph.inner[at] + 1]; ++i) sum += *entry++ * x[i];
      y[start + c] = sum;
    }
  }
  return y;
}

}  // namespace crease
