// SPDX-License-Identifier: MIT
// On flat cloth x and X of an EOL vertex slide against each other across its edge without inertia: it is held there.
#include <gtest/gtest.h>

#include <Eigen/Eigenvalues>

#include "constraints/flat_sheet_qp.hpp"

namespace crease {
namespace {

using namespace crease::testing;

const double degree = std::acos(-1.0) / 180;

/// Smallest eigenvalue of the inertia on the motions that the equalities allow, relative to the largest.
double smallest_eigenvalue(const EolSheet& sheet, bool with_holds) {
  const DofMap dofs = make_dof_map(sheet.cloth);
  const ConstraintRows rows = sheet.rows();
  const MatX H = make_inertia(sheet.cloth, dofs), all = MatX(rows.A_eq);
  MatX A(0, all.cols());
  for (int r = 0; r < all.rows(); ++r) {
    if (!with_holds && rows.eq[r].kind == RowKind::EolHold) continue;
    A.conservativeResize(A.rows() + 1, Eigen::NoChange);
    A.bottomRows<1>() = all.row(r);
  }
  const MatX Z = split_spaces(A).null;
  const VecX values = Eigen::SelfAdjointEigenSolver<MatX>(Z.transpose() * H * Z, Eigen::EigenvaluesOnly).eigenvalues();
  return values[0] / values[values.size() - 1];
}

// With the tangent rule alone the smallest eigenvalue is 0 when flat and grows with the square of the bend. Held across
// the cloth's normal the vertex has no motion without inertia at any bend, and the eigenvalue is that of the mesh.
TEST(FlatCloth, EveryMotionHasInertiaAtEveryBend) {
  for (const GridPattern pattern : {GridPattern::Right, GridPattern::Cross}) {
    const double bent = smallest_eigenvalue(make_eol_sheet(90 * degree, pattern), true);
    EXPECT_GT(bent, 1e-3);
    for (const double bend : {0.0, 0.1 * degree, 5 * degree, 45 * degree, 135 * degree, 179 * degree}) {
      EXPECT_GT(smallest_eigenvalue(make_eol_sheet(bend, pattern), true), 0.2 * bent) << "bend " << bend;
    }
  }
  EXPECT_LT(smallest_eigenvalue(make_eol_sheet(0), false), 1e-14) << "else there is nothing to hold";
  EXPECT_LT(smallest_eigenvalue(make_eol_sheet(0.1 * degree), false), 1e-5);
}

/// A sheet that moves at `velocity` throughout, as world velocity of Lagrangian and EOL vertices alike.
VecX uniform_motion(const EolSheet& sheet, const DofMap& dofs, const Vec3& velocity) {
  VecX q = VecX::Zero(dofs.size());
  for (int v = 0; v < sheet.cloth.mesh.vertex_slots(); ++v) q.segment<3>(dofs.x(v)) = velocity;
  return q;
}

const auto table_holds = [](const EolSheet& sheet) {
  return [up = sheet.up](const RowInfo& row) { return row.normal.dot(up) > 0.9; };
};

// The sheet slides at `speed` over the edge of a box that itself moves: the vertex rides with the edge and the material
// flows through it. Errors: solving with a condition of 1e6 or so leaves 1e-16 * 1e6 of the speed, times some.
TEST(FlatCloth, VertexStaysOnTheEdgeWhileTheMaterialSlides) {
  constexpr double speed = 0.7, carried = 0.2;
  std::mt19937_64 rng(19);
  SCOPED_TRACE("seed 19");
  for (int trial = 0; trial < 4; ++trial) {
    EolSheet sheet = make_eol_sheet(0, trial % 2 ? GridPattern::Cross : GridPattern::Right);
    sheet.pose.velocity = carried * sheet.side;
    if (trial > 1) {
      place(sheet, random_rotation(rng), Vec3(1, 0, 0));
      place_material(sheet, 0.7, Vec2(0.1, 0.2));
    }
    const DofMap dofs = make_dof_map(sheet.cloth);
    const ConstraintRows rows = sheet.rows();
    const MatX M = make_inertia(sheet.cloth, dofs);
    const VecX f = M * uniform_motion(sheet, dofs, speed * sheet.side);
    const VecX q = minimise(rows, M, f, table_holds(sheet));
    for (const int v : sheet.chain) {
      const Vec3 x = q.segment<3>(dofs.x(v));
      EXPECT_NEAR(x.dot(sheet.side), carried, 1e-8) << "rides with the edge";
      const Mat32 F = vertex_deformation_gradient(sheet.cloth.mesh, v);
      const Vec3 world = x - F * q.segment<2>(dofs.X(v));
      EXPECT_LT((world - speed * sheet.side).norm(), 1e-8) << "and the material goes on as before";
    }
  }
}

// Held at its far end, the sheet lies still under gravity: nothing may creep, in world or in material.
TEST(FlatCloth, RestStaysAtRest) {
  EolSheet sheet = make_eol_sheet(0, GridPattern::Cross);
  Mesh& mesh = sheet.cloth.mesh;
  std::vector<Contact> contacts;
  for (int v = 0; v < mesh.vertex_slots(); ++v) {
    if (mesh.x[v].x() > 0.5 * sheet_length + 1e-9) {
      sheet.cloth.pins[v] = 1;
    } else if (!sheet.cloth.is_eol(v)) {
      Contact contact;
      contact.obstacle = 0;
      contact.n_vertices = 1;
      contact.vertices = {v, -1, -1};
      contact.weights = {1, 0, 0};
      contact.normal = sheet.up;
      contacts.push_back(contact);
    }
  }
  const DofMap dofs = make_dof_map(sheet.cloth);
  const ConstraintRows rows = sheet.rows(contacts, {PinState{}});
  const MatX M = make_inertia(sheet.cloth, dofs);
  const VecX f = M * (1e-2 * uniform_motion(sheet, dofs, Vec3(0, 0, -9.81)));
  const VecX q = minimise(rows, M, f, table_holds(sheet));
  for (const int v : sheet.chain) EXPECT_LE(q.segment<2>(dofs.X(v)).norm(), 1e-8);
  EXPECT_LE(q.cwiseAbs().maxCoeff(), 1e-8);
}

// A force of the cloth's own weight pushes the vertices across the edge, at bends through zero: none leaves it, and the
// material's motion is bounded by what the force does to a free vertex.
TEST(FlatCloth, ForceAcrossTheEdgeMovesNoVertexOffIt) {
  constexpr double g = 9.8;
  for (const double h : {1e-2, 1e-4}) {
    for (const double bend : {0.0, 1e-3 * degree, 0.1 * degree, 1 * degree, 10 * degree}) {
      const EolSheet sheet = make_eol_sheet(bend);
      const DofMap dofs = make_dof_map(sheet.cloth);
      const ConstraintRows rows = sheet.rows({}, {}, h);
      const MatX H = make_inertia(sheet.cloth, dofs);
      VecX f = VecX::Zero(dofs.size());
      for (const int v : sheet.chain) f.segment<3>(dofs.x(v)) = h * lumped_mass(sheet.cloth.mesh, v) * g * sheet.side;
      const VecX q = minimise(rows, H, f, [](const RowInfo&) { return true; });
      for (const int v : sheet.chain) {
        EXPECT_LE(q.segment<3>(dofs.x(v)).norm(), 1e-12) << "h " << h << ", bend " << bend;
        EXPECT_LE(q.segment<2>(dofs.X(v)).norm(), h * g) << "h " << h << ", bend " << bend;
      }
    }
  }
}

// The contact opens along the cloth's normal, and nothing holds the sheet back that way: a uniform motion stays one.
TEST(FlatCloth, LiftOffIsFree) {
  for (const double bend : {0.0, 5 * degree, 90 * degree}) {
    const EolSheet sheet = make_eol_sheet(bend);
    const DofMap dofs = make_dof_map(sheet.cloth);
    const ConstraintRows rows = sheet.rows();
    const MatX M = make_inertia(sheet.cloth, dofs);
    const Vec3 away = 0.7 * (std::cos(bend / 2) * sheet.up + std::sin(bend / 2) * sheet.side);
    const VecX motion = uniform_motion(sheet, dofs, away);
    const VecX q = minimise(rows, M, M * motion, [](const RowInfo&) { return false; });
    EXPECT_LT((q - motion).norm(), 1e-10 * motion.norm()) << "bend " << bend;
  }
}

}  // namespace
}  // namespace crease
