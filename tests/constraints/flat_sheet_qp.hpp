// SPDX-License-Identifier: MIT
#pragma once

#include <Eigen/Cholesky>
#include <Eigen/QR>

#include "constraints/eol_sheet.hpp"
#include "crease/geometry/triangle.hpp"

namespace crease::testing {

inline constexpr double sheet_density = 0.05;

/// Inertia of the whole sheet by Eq. 8, element by element, dense.
inline MatX make_inertia(const Cloth& cloth, const DofMap& dofs) {
  MatX M = MatX::Zero(dofs.size(), dofs.size());
  const Mesh& mesh = cloth.mesh;
  for (int f = 0; f < mesh.n_faces(); ++f) {
    const Mat32 F = deformation_gradient(mesh, f);
    const double m = sheet_density * mesh.material_area(f) / 12;
    const auto block = [&](int v) {
      MatX B = MatX::Zero(3, dofs.is_eol(v) ? 5 : 3);
      B.leftCols(3).setIdentity();
      if (dofs.is_eol(v)) B.rightCols(2) = -F;
      return B;
    };
    for (const int i : mesh.face(f)) {
      for (const int j : mesh.face(f)) {
        const MatX Bi = block(i), Bj = block(j);
        M.block(dofs.start[i], dofs.start[j], Bi.cols(), Bj.cols()) += (i == j ? 2 : 1) * m * Bi.transpose() * Bj;
      }
    }
  }
  return M;
}

inline double lumped_mass(const Mesh& mesh, int vertex) {
  double area = 0;
  for (const int h : mesh.outgoing(vertex)) area += mesh.material_area(Mesh::face_of(h));
  return sheet_density * area / 3;
}

/// Range and null space of rows A that do not depend on each other: A^T = Q (R; 0).
struct RowSpaces {
  MatX range, null, R;  ///< orthonormal columns; R upper triangular
};
inline RowSpaces split_spaces(const MatX& A) {
  const Eigen::HouseholderQR<MatX> qr(A.transpose());
  const MatX Q = qr.householderQ();
  return {Q.leftCols(A.rows()), Q.rightCols(A.cols() - A.rows()), qr.matrixQR().topRows(A.rows())};
}

/// minimise 1/2 q^T H q - f^T q  s.t.  all equalities, and the inequalities for which `active` holds as equalities.
template <class Active>
VecX minimise(const ConstraintRows& rows, const MatX& H, const VecX& f, Active active) {
  std::vector<int> held;
  for (std::size_t r = 0; r < rows.in.size(); ++r) {
    if (active(rows.in[r])) held.push_back(static_cast<int>(r));
  }
  const int n = static_cast<int>(H.rows()), m_eq = static_cast<int>(rows.eq.size());
  const int m = m_eq + static_cast<int>(held.size());
  MatX A(m, n);
  VecX b(m);
  A.topRows(m_eq) = MatX(rows.A_eq);
  b.head(m_eq) = rows.b_eq;
  for (int r = m_eq; r < m; ++r) {
    A.row(r) = MatX(rows.A_in.row(held[r - m_eq]));
    b[r] = rows.b_in[held[r - m_eq]];
  }
  const RowSpaces spaces = split_spaces(A);
  const MatX& Z = spaces.null;
  const VecX particular = spaces.range * spaces.R.triangularView<Eigen::Upper>().transpose().solve(b);
  const MatX reduced = Z.transpose() * H * Z;
  return particular + Z * reduced.ldlt().solve(Z.transpose() * (f - H * particular));
}

}  // namespace crease::testing
