// SPDX-License-Identifier: MIT
#include "reduction.hpp"
#include "max_abs.hpp"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>

namespace crease {
namespace {

using DenseMap = Eigen::Map<const MatX>;

/// A diagonal entry of H this small beside the others of its block is rounding of zero; scaling by it would blow the
/// rounding up to a stiffness. Scaled by the block instead it stays what it is: singular, and seen as such.
constexpr double no_diagonal = 1e-13;
/// |part of a general row outside the fixed coordinates| / |row| below which the fixed coordinates decide the row.
constexpr double decided_row = 1e-10;
/// Mismatch of constants that counts as rounding.
constexpr double mismatch_tolerance = 1e-9;

/// One block of H, `rows` x `columns` in a column of blocks `height` high, into the coordinates of its vertices: by a
/// basis, or where there is none by a diagonal. N = 3 is the size of nearly all of them.
template <int N>
void change_basis(const double* from, double* to, int height, int rows, int columns, const SmallMatrix* left,
                  const double* left_diagonal, const SmallMatrix* right, const double* right_diagonal) {
  constexpr int most = N == Eigen::Dynamic ? max_block : N;
  using Block = Eigen::Matrix<double, N, N, 0, most, most>;
  using Diagonal = Eigen::Map<const Eigen::Matrix<double, N, 1, 0, most, 1>>;
  const Eigen::Map<const Block, 0, Eigen::OuterStride<>> given(from, rows, columns, Eigen::OuterStride<>(height));
  Eigen::Map<Block, 0, Eigen::OuterStride<>> result(to, rows, columns, Eigen::OuterStride<>(height));
  Block half(rows, columns);
  if (left != nullptr)
    half = Eigen::Map<const Block>(left->data(), rows, rows).transpose().lazyProduct(given);
  else
    half = Diagonal(left_diagonal, rows).asDiagonal() * given;
  if (right != nullptr)
    result = half.lazyProduct(Eigen::Map<const Block>(right->data(), columns, columns));
  else
    result = half * Diagonal(right_diagonal, columns).asDiagonal();
}

}  // namespace

bool Reduction::build(const QpProblem& problem, const Checked& checked) {
  qp_.graph = &pattern_.graph();
  if (!checked.same_pattern && pattern_.update(problem)) make_block_matrix(pattern_.graph()).swap(qp_.H);
  n_eq_ = static_cast<int>(problem.b_eq.size());
  n_in_ = static_cast<int>(problem.b_in.size());
  largest_ = checked.largest;
  q_scale_ = std::max(max_abs(problem.b_eq), max_abs(problem.b_in));
  if (largest_ > 0) q_scale_ = std::max(q_scale_, max_abs(problem.f) / largest_);
  const auto n_blocks = static_cast<size_t>(pattern_.n_blocks());
  local_eq_.resize(n_blocks);
  local_in_.resize(n_blocks);
  for (auto* local : {&local_eq_, &local_in_})
    for (auto& rows : *local) rows.clear();
  general_.clear();
  coordinate_of_.assign(static_cast<size_t>(n_in_), -1);
  row_of_.assign(static_cast<size_t>(n_in_), -1);
  sort_rows(problem.A_eq, problem.b_eq, true);
  sort_rows(problem.A_in, problem.b_in, false);
  if (!make_bases()) return false;
  transform_H(problem.H);
  qp_.f = problem.f.cwiseQuotient(scale_);
  for (size_t k = 0; k < bases_.size(); ++k) {
    const int start = pattern_.start(basis_block_[k]), size = pattern_.size(basis_block_[k]);
    qp_.f.segment(start, size) = bases_[k].T.transpose() * problem.f.segment(start, size);
  }
  for (int i = 0; i < qp_.size(); ++i)
    if (qp_.kind[i] != Coordinate::Free) qp_.bound[i] *= scale_[i];
  return add_general_rows(problem);
}

/// Rows inside one block wait there for its basis; the others are general. A row of zeros is general too.
void Reduction::sort_rows(const SparseRows& A, const VecX& b, bool equality) {
  for (int i = 0; i < A.rows(); ++i) {
    int block = -1;
    bool local = true;
    double squared = 0;
    for (SparseRows::InnerIterator entry(A, i); entry; ++entry) {
      if (entry.value() == 0) continue;
      const int touched = pattern_.block_of(static_cast<int>(entry.col()));
      local = local && (block < 0 || block == touched);
      block = touched;
      squared += entry.value() * entry.value();
    }
    if (!local || block < 0) {
      general_.push_back({i, equality, 0, std::sqrt(squared)});
      continue;
    }
    LocalRow row{i, std::sqrt(squared), SmallVector::Zero(pattern_.size(block)), 0};
    for (SparseRows::InnerIterator entry(A, i); entry; ++entry)
      if (entry.value() != 0) row.a[entry.col() - pattern_.start(block)] = entry.value() / row.norm;
    row.b = b[i] / row.norm;
    (equality ? local_eq_ : local_in_)[block].push_back(std::move(row));
  }
}

bool Reduction::make_bases() {
  const int n = pattern_.start(pattern_.n_blocks());
  qp_.kind.assign(static_cast<size_t>(n), Coordinate::Free);
  qp_.bound = VecX::Zero(n);
  basis_of_.assign(static_cast<size_t>(pattern_.n_blocks()), -1);
  bases_.clear();
  basis_block_.clear();
  for (int block = 0; block < pattern_.n_blocks(); ++block) {
    const std::vector<LocalRow>&eq = local_eq_[block], &in = local_in_[block];
    if (eq.empty() && in.empty()) continue;
    BlockBasis basis = make_block_basis(pattern_.size(block), eq, in, q_scale_);
    if (basis.conflict) return false;
    int at = pattern_.start(block);
    for (const double value : basis.fixed) qp_.kind[at] = Coordinate::Fixed, qp_.bound[at++] = value;
    for (size_t i = 0; i < in.size(); ++i) {
      if (basis.owner[i] >= 0) coordinate_of_[in[i].row] = at + basis.owner[i];
      if (basis.owner[i] == BlockBasis::surplus) general_.push_back({in[i].row, false, 0, in[i].norm});
    }
    for (const double value : basis.lower) qp_.kind[at] = Coordinate::Bounded, qp_.bound[at++] = value;
    basis_of_[block] = static_cast<int>(bases_.size());
    basis_block_.push_back(block);
    bases_.push_back(std::move(basis));
  }
  // Equalities first, then as in the problem.
  std::sort(general_.begin(), general_.end(), [](const GeneralRow& a, const GeneralRow& b) {
    return a.equality != b.equality ? a.equality : a.row < b.row;
  });
  return true;
}

/// S^-1 T^T H T S^-1, block by block; S is left in scale_, T S^-1 in bases_.
void Reduction::transform_H(const SparseMatrix& H) {
  double* values = qp_.H.valuePtr();
  const int* outer = qp_.H.outerIndexPtr();
  if (!pattern_.is_full()) pattern_.gather(H, values);
  const double* given = pattern_.is_full() ? H.valuePtr() : values;
  scale_.resize(qp_.H.rows());
  const BlockGraph& graph = pattern_.graph();
  for (int k = 0; k < pattern_.n_blocks(); ++k) {
    int row = 0;
    for (int at = graph.outer[k]; graph.inner[at] != k; ++at) row += pattern_.size(graph.inner[at]);
    const int size = pattern_.size(k), start = pattern_.start(k);
    set_scale(k, DenseMap(given + outer[start], pattern_.height(k), size).middleRows(row, size));
  }
  const VecX inverse = scale_.cwiseInverse();
  for (size_t k = 0; k < bases_.size(); ++k) {
    const int block = basis_block_[k];
    bases_[k].T *= inverse.segment(pattern_.start(block), pattern_.size(block)).asDiagonal();
  }
  const auto basis = [&](int block) { return basis_of_[block] < 0 ? nullptr : &bases_[basis_of_[block]].T; };
  for (int k = 0; k < pattern_.n_blocks(); ++k) {
    const int size = pattern_.size(k), start = pattern_.start(k), height = pattern_.height(k);
    const double* from = given + outer[start];
    double* to = values + outer[start];
    for (int at = graph.outer[k]; at < graph.outer[k + 1]; ++at) {
      const int other = graph.inner[at], rows = pattern_.size(other);
      if (rows == 3 && size == 3)
        change_basis<3>(from, to, height, 3, 3, basis(other), inverse.data() + pattern_.start(other), basis(k),
                        inverse.data() + start);
      else
        change_basis<Eigen::Dynamic>(from, to, height, rows, size, basis(other), inverse.data() + pattern_.start(other),
                                     basis(k), inverse.data() + start);
      from += rows, to += rows;
    }
  }
}

/// Square roots of the diagonal of one block in its new coordinates.
void Reduction::set_scale(int block, const SmallMatrix& diagonal_block) {
  auto scale = scale_.segment(pattern_.start(block), pattern_.size(block));
  if (basis_of_[block] >= 0) {
    const SmallMatrix& T = bases_[basis_of_[block]].T;
    scale = T.cwiseProduct(diagonal_block.lazyProduct(T)).colwise().sum().transpose();
  } else {
    scale = diagonal_block.diagonal();
  }
  const double fallback = largest_ > 0 ? largest_ : 1.0;
  const double block_scale = scale.maxCoeff() > no_diagonal * largest_ ? scale.maxCoeff() : fallback;
  for (double& s : scale) s = std::sqrt(s > no_diagonal * block_scale ? s : block_scale);
}

/// One general row in the new coordinates.
Reduction::TransformedRow Reduction::transform_row(const SparseRows& A, int row) const {
  TransformedRow result;
  SparseRows::InnerIterator entry(A, row);
  while (entry) {
    const int block = pattern_.block_of(static_cast<int>(entry.col()));
    const int start = pattern_.start(block), size = pattern_.size(block);
    SmallVector part = SmallVector::Zero(size);
    for (; entry && entry.col() < start + size; ++entry) part[entry.col() - start] = entry.value();
    if (basis_of_[block] >= 0)
      part = (bases_[basis_of_[block]].T.transpose() * part).eval();
    else
      part = part.cwiseQuotient(scale_.segment(start, size)).eval();
    for (int i = 0; i < size; ++i) {
      if (part[i] == 0) continue;
      result.entries.emplace_back(start + i, part[i]);
      result.all += part[i] * part[i];
      if (qp_.kind[start + i] == Coordinate::Fixed) {
        result.fixed_value += part[i] * qp_.bound[start + i];
        result.fixed_size += std::abs(part[i] * qp_.bound[start + i]);
      } else {
        result.open += part[i] * part[i];
      }
    }
  }
  return result;
}

/// @return false if a row that the fixed coordinates decide does not hold
bool Reduction::add_general_rows(const QpProblem& problem) {
  std::vector<Eigen::Triplet<double>> entries;
  std::vector<double> rhs;
  std::vector<GeneralRow> kept;
  qp_.n_equalities = 0;
  for (GeneralRow general : general_) {
    const TransformedRow row = transform_row(general.equality ? problem.A_eq : problem.A_in, general.row);
    const double b = (general.equality ? problem.b_eq : problem.b_in)[general.row];
    if (row.open <= decided_row * decided_row * row.all) {
      const double slack = row.fixed_value - b;
      const double tolerance = mismatch_tolerance * std::max({std::abs(b), row.fixed_size, general.size * q_scale_});
      if (slack < -tolerance || (general.equality && slack > tolerance)) return false;
      continue;
    }
    const int at = static_cast<int>(kept.size());
    general.norm = std::sqrt(row.open);
    for (const auto& [column, value] : row.entries) entries.emplace_back(at, column, value / general.norm);
    rhs.push_back(b / general.norm);
    if (general.equality) ++qp_.n_equalities;
    if (!general.equality) row_of_[general.row] = at;
    kept.push_back(general);
  }
  general_ = std::move(kept);
  const int n = qp_.size();
  qp_.rows.resize(static_cast<int>(general_.size()), n);
  qp_.rows.setFromTriplets(entries.begin(), entries.end());
  qp_.rhs = Eigen::Map<const VecX>(rhs.data(), static_cast<Eigen::Index>(rhs.size()));
  qp_.unit.resize(n + qp_.n_rows());
  qp_.unit.head(n) = scale_;
  for (int k = 0; k < qp_.n_rows(); ++k) qp_.unit[n + k] = general_[k].size / general_[k].norm;
  return true;
}

WorkingSet Reduction::start(std::span<const char> guess) const {
  WorkingSet set;
  set.held.assign(qp_.kind.size(), 0);
  set.on.assign(static_cast<size_t>(qp_.n_rows()), 0);
  std::fill(set.on.begin(), set.on.begin() + qp_.n_equalities, 1);
  for (size_t i = 0; i < qp_.kind.size(); ++i)
    set.held[i] = qp_.kind[i] == Coordinate::Fixed || (qp_.kind[i] == Coordinate::Bounded && guess.empty());
  for (size_t i = 0; i < guess.size(); ++i) {
    if (!guess[i]) continue;
    if (coordinate_of_[i] >= 0) set.held[coordinate_of_[i]] = 1;
    if (row_of_[i] >= 0) set.on[row_of_[i]] = 1;
  }
  return set;
}

std::vector<char> Reduction::active(const WorkingSet& set) const {
  std::vector<char> active(static_cast<size_t>(n_in_), 0);
  for (const BlockBasis& basis : bases_)
    for (const LocalRow& row : basis.in) active[row.row] = set.held[coordinate_of_[row.row]];
  for (int i = 0; i < n_in_; ++i)
    if (row_of_[i] >= 0) active[i] = set.on[row_of_[i]];
  return active;
}

VecX Reduction::to_q(const VecX& u) const {
  VecX q = u.cwiseQuotient(scale_);
  for (size_t k = 0; k < bases_.size(); ++k) {
    const int start = pattern_.start(basis_block_[k]), size = pattern_.size(basis_block_[k]);
    q.segment(start, size) = bases_[k].T * u.segment(start, size);
  }
  return q;
}

Multipliers Reduction::to_multipliers(const VecX& gradient, const VecX& row_lambda, const WorkingSet& set) const {
  Multipliers lambda{VecX::Zero(n_eq_), VecX::Zero(n_in_)};
  for (size_t k = 0; k < general_.size(); ++k) {
    const double value = row_lambda[static_cast<int>(k)] / general_[k].norm;
    (general_[k].equality ? lambda.eq : lambda.in)[general_[k].row] = value;
  }
  for (size_t k = 0; k < bases_.size(); ++k) {
    const BlockBasis& basis = bases_[k];
    const int start = pattern_.start(basis_block_[k]);
    const auto n_eq = basis.fixed.size(), n_in = basis.lower.size();
    // gradient in q = Q^T y + N^T g, and N.row(i) = (a_i - coupling.row(i) Q) / length_i.
    SmallVector y = gradient.segment(start, n_eq).cwiseProduct(scale_.segment(start, n_eq));
    for (int i = 0; i < n_in; ++i) {
      const auto at = start + n_eq + i;
      if (!set.held[at]) continue;
      const double value = gradient[at] * scale_[at] / basis.length[i];
      y -= basis.coupling.row(i).transpose() * value;
      lambda.in[basis.in[i].row] = value / basis.in[i].norm;
    }
    basis.L.transpose().triangularView<Eigen::Upper>().solveInPlace(y);
    for (int i = 0; i < n_eq; ++i) lambda.eq[basis.eq[i].row] = y[i] / basis.eq[i].norm;
  }
  return lambda;
}

}  // namespace crease
