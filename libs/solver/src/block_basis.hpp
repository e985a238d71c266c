// SPDX-License-Identifier: MIT
#pragma once

#include <vector>

#include "crease/base/types.hpp"

namespace crease {

/// Larger blocks are treated as single unknowns: a change of basis fills its block, and no vertex has more than this.
constexpr int max_block = 8;
using SmallMatrix = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, 0, max_block, max_block>;
using SmallVector = Eigen::Matrix<double, Eigen::Dynamic, 1, 0, max_block, 1>;

/// One constraint whose entries all lie in one block: a . q = b or a . q >= b, scaled so that |a| = 1.
struct LocalRow {
  int row;      ///< in A_eq or A_in
  double norm;  ///< |a| before scaling
  SmallVector a;
  double b;
};

/// New coordinates u of one block in which its constraints are bounds: q = T u,  u = [Q; N; Z] q, where
///   Q  orthonormal basis of the equalities' normals:   u = fixed,
///   N  unit inequality normals, projected off Q:       u >= lower,
///   Z  orthonormal completion:                         u free.
struct BlockBasis {
  SmallMatrix T;
  SmallVector fixed, lower;

  // What it takes to go back from the gradient in u to the multipliers of the rows.
  std::vector<LocalRow> eq;  ///< independent ones; eq[i].a = L.row(i) * Q
  SmallMatrix L;             ///< lower triangular
  std::vector<LocalRow> in;  ///< those that became coordinates: in[i].a = coupling.row(i) * Q + length[i] * N.row(i)
  SmallMatrix coupling;
  SmallVector length;

  std::vector<int> owner;  ///< one a given inequality: its coordinate among `lower`, or one of the two below
  bool conflict = false;   ///< the equalities alone have no solution, or forbid an inequality

  static constexpr int redundant = -1;  ///< decided by the equalities
  static constexpr int surplus = -2;    ///< too many or too parallel normals; has to stay a general row
};

/// @param q_scale  typical size of an unknown, against which a mismatch of constants counts as rounding
BlockBasis make_block_basis(int size, const std::vector<LocalRow>& equalities,
                            const std::vector<LocalRow>& inequalities, double q_scale);

}  // namespace crease
