// SPDX-License-Identifier: MIT
#include "block_basis.hpp"

#include <Eigen/Cholesky>
#include <Eigen/Geometry>

#include <algorithm>
#include <cmath>

namespace crease {
namespace {

/// |part of a unit normal outside the span of the equalities|, below which the equalities decide the row. The row then
/// holds to this share of |q|, well inside any tolerance asked for.
constexpr double dependent_share = 1e-10;
/// Mismatch of constants that counts as rounding, relative to the size of the unknowns.
constexpr double mismatch_tolerance = 1e-9;
/// Distance of two unit normals that are one and the same.
constexpr double same_normal = 1e-12;
/// Sine of the least angle [rad] between an inequality normal and those already coordinates: the condition number of
/// the basis is about its reciprocal, so smaller angles go to the general rows instead.
constexpr double least_angle = 1e-2;

/// Removes from `a` its part in the columns of the orthonormal `Q`; twice, because once leaves rounding of |a|.
SmallVector project_off(const SmallMatrix& Q, SmallVector a) {
  for (int pass = 0; pass < 2; ++pass)
    for (int k = 0; k < Q.cols(); ++k) a -= Q.col(k).dot(a) * Q.col(k);
  return a;
}

void append_column(SmallMatrix& A, const SmallVector& column) {
  A.conservativeResize(Eigen::NoChange, A.cols() + 1);
  A.rightCols<1>() = column;
}

void append(SmallVector& v, double value) {
  v.conservativeResize(v.size() + 1);
  v[v.size() - 1] = value;
}

struct EqualityPart {
  SmallMatrix Q;  ///< its columns span the equalities' normals
  SmallVector q;  ///< the point of the span that meets them
};

/// Picks the row farthest from those picked, until none is left that is independent; the rest has to agree.
EqualityPart add_equalities(BlockBasis& basis, int size, const std::vector<LocalRow>& rows, double q_scale) {
  EqualityPart part{SmallMatrix(size, 0), SmallVector::Zero(size)};
  std::vector<SmallVector> rest;  // of each row outside the span of those picked
  for (const LocalRow& row : rows) rest.push_back(row.a);
  while (part.Q.cols() < size) {
    int best = -1;
    double best_length = dependent_share;
    for (size_t i = 0; i < rows.size(); ++i)
      if (const double length = rest[i].norm(); length > best_length) best = static_cast<int>(i), best_length = length;
    if (best < 0) break;
    basis.eq.push_back(rows[best]);
    const SmallVector direction = project_off(part.Q, rows[best].a).normalized();
    append_column(part.Q, direction);
    rest[best].setZero();
    for (SmallVector& a : rest) a -= direction.dot(a) * direction;
  }
  const auto n_eq = part.Q.cols();
  basis.L = SmallMatrix::Zero(n_eq, n_eq);
  basis.fixed = SmallVector::Zero(n_eq);
  for (int i = 0; i < n_eq; ++i) {
    basis.L.row(i) = basis.eq[i].a.transpose().lazyProduct(part.Q);
    const double known = basis.L.row(i).head(i) * basis.fixed.head(i);
    basis.fixed[i] = (basis.eq[i].b - known) / basis.L(i, i);
  }
  part.q = part.Q.lazyProduct(basis.fixed);
  for (const LocalRow& row : rows) {
    const double scale = std::max({std::abs(row.b), part.q.norm(), q_scale});
    if (std::abs(row.a.dot(part.q) - row.b) > mismatch_tolerance * scale) basis.conflict = true;
  }
  return part;
}

/// An inequality after the equalities are met: normal . q >= lower over what is left of the block.
struct Reduced {
  SmallVector normal;
  double lower, length;
  int same_as;  ///< first inequality with this normal (itself if none)
};

std::vector<Reduced> reduce(BlockBasis& basis, const EqualityPart& eq, const std::vector<LocalRow>& rows,
                            double q_scale) {
  std::vector<Reduced> reduced;
  for (size_t i = 0; i < rows.size(); ++i) {
    const SmallVector rest = project_off(eq.Q, rows[i].a);
    Reduced r{rest, rows[i].b - rows[i].a.dot(eq.q), rest.norm(), static_cast<int>(i)};
    if (r.length <= dependent_share) {
      basis.owner[i] = BlockBasis::redundant;
      const double scale = std::max({std::abs(rows[i].b), eq.q.norm(), q_scale});
      if (r.lower > mismatch_tolerance * scale) basis.conflict = true;
    } else {
      r.normal /= r.length;
      r.lower /= r.length;
      for (size_t j = 0; j < i; ++j)
        if (reduced[j].length > dependent_share && (reduced[j].normal - r.normal).norm() < same_normal) {
          r.same_as = reduced[j].same_as;
          break;
        }
    }
    reduced.push_back(r);
  }
  return reduced;
}

/// The inequalities become coordinates in the order given as long as they are independent enough; of equal normals the
/// tightest one does.
SmallMatrix add_inequalities(BlockBasis& basis, const EqualityPart& eq, const std::vector<LocalRow>& rows,
                             double q_scale) {
  const int size = static_cast<int>(eq.Q.rows());
  basis.owner.assign(rows.size(), BlockBasis::surplus);
  const std::vector<Reduced> reduced = reduce(basis, eq, rows, q_scale);
  SmallMatrix N(size, 0), span = eq.Q;
  basis.coupling.resize(0, eq.Q.cols());
  basis.length.resize(0);
  basis.lower.resize(0);
  for (size_t i = 0; i < rows.size(); ++i) {
    if (basis.owner[i] != BlockBasis::surplus || reduced[i].same_as != static_cast<int>(i)) continue;
    if (span.cols() == size) break;
    const SmallVector outside = project_off(span, reduced[i].normal);
    if (outside.norm() < least_angle) continue;
    size_t tightest = i;
    for (size_t j = i; j < rows.size(); ++j) {
      if (reduced[j].same_as != static_cast<int>(i) || basis.owner[j] == BlockBasis::redundant) continue;
      basis.owner[j] = static_cast<int>(basis.in.size());
      if (reduced[j].lower > reduced[tightest].lower) tightest = j;
    }
    basis.in.push_back(rows[tightest]);
    append_column(N, reduced[tightest].normal);
    basis.coupling.conservativeResize(N.cols(), Eigen::NoChange);
    basis.coupling.bottomRows<1>() = rows[tightest].a.transpose().lazyProduct(eq.Q);
    append(basis.length, reduced[tightest].length);
    append(basis.lower, reduced[tightest].lower);
    append_column(span, outside.normalized());
  }
  return N;
}

/// Appends orthonormal columns until there is a basis, grown from the unit vectors farthest from those before.
void complete(SmallMatrix& span) {
  const auto size = span.rows();
  while (span.cols() < size) {
    const SmallVector left = SmallVector::Ones(size) - span.rowwise().squaredNorm();  // |unit vector outside|^2
    int farthest = 0;
    for (int k = 1; k < size; ++k)  // a clear win only, so that rounding does not decide between equals
      if (left[k] > left[farthest] * (1 + 1e-6)) farthest = k;
    append_column(span, project_off(span, SmallVector::Unit(size, farthest)).normalized());
  }
}

/// The commonest case by far: a vertex of three unknowns on one face.
BlockBasis on_one_face(const LocalRow& row) {
  const double length = row.a.norm();
  const Vec3 normal = row.a.head<3>() / length;
  int farthest = 0;
  normal.cwiseAbs().minCoeff(&farthest);
  const Vec3 first = (Vec3::Unit(farthest) - normal[farthest] * normal).normalized();
  BlockBasis basis;
  basis.T.resize(3, 3);
  basis.T << normal, first, normal.cross(first);
  basis.in = {row};
  basis.owner = {0};
  basis.L.resize(0, 0);
  basis.coupling.resize(1, 0);
  basis.length = SmallVector::Constant(1, length);
  basis.lower = SmallVector::Constant(1, row.b / length);
  return basis;
}

}  // namespace

BlockBasis make_block_basis(int size, const std::vector<LocalRow>& equalities,
                            const std::vector<LocalRow>& inequalities, double q_scale) {
  if (size == 3 && equalities.empty() && inequalities.size() == 1) return on_one_face(inequalities.front());
  BlockBasis basis;
  const EqualityPart eq = add_equalities(basis, size, equalities, q_scale);
  const SmallMatrix N = add_inequalities(basis, eq, inequalities, q_scale);
  const auto n_eq = eq.Q.cols(), n_in = N.cols();
  SmallMatrix span = eq.Q;
  for (int i = 0; i < n_in; ++i) append_column(span, project_off(span, N.col(i)).normalized());
  complete(span);
  basis.T = span;
  if (n_in == 1) basis.T.col(n_eq) = N;
  if (n_in > 1) {
    const SmallMatrix gram = N.transpose().lazyProduct(N);
    basis.T.middleCols(n_eq, n_in) = gram.llt().solve(SmallMatrix(N.transpose())).transpose();
  }
  return basis;
}

}  // namespace crease
