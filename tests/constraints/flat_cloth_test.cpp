// SPDX-License-Identifier: MIT
// A flat cloth leaves the motion of an EOL vertex across its edge undecided: what the regularisation makes of it.
#include <gtest/gtest.h>

#include <Eigen/Eigenvalues>

#include "constraints/flat_sheet_qp.hpp"

namespace crease {
namespace {

using namespace crease::testing;

const double degree = std::acos(-1.0) / 180;

/// Both smallest eigenvalues of the inertia on the motions that the equalities allow, relative to the largest.
struct Spectrum {
  double plain, regularised;
};
Spectrum smallest_eigenvalues(const EolSheet& sheet) {
  const DofMap dofs = make_dof_map(sheet.cloth);
  const ConstraintRows rows = sheet.rows();
  MatX H = make_inertia(sheet.cloth, dofs);
  VecX f = VecX::Zero(dofs.size());
  const MatX Z = split_spaces(MatX(rows.A_eq)).null;
  const auto smallest = [&](const MatX& S) {
    const VecX values = Eigen::SelfAdjointEigenSolver<MatX>(S, Eigen::EigenvaluesOnly).eigenvalues();
    return values[0] / values[values.size() - 1];
  };
  const double plain = smallest(Z.transpose() * H * Z);
  add_regularisation(rows, dofs, H, f);
  return {plain, smallest(Z.transpose() * H * Z)};
}

// Without the term the smallest eigenvalue is 0 when flat and grows with the square of the bend; with it, it is of the
// term's own size (1e-6 of the diagonal; the flat mode has half of its length in xdot, and meshes cost a factor) at
// least.
TEST(FlatCloth, MinimiserIsUniqueAtEveryBend) {
  for (const double bend : {0.0, 0.1 * degree, 5 * degree, 90 * degree, 179 * degree}) {
    for (const GridPattern pattern : {GridPattern::Right, GridPattern::Cross}) {
      EXPECT_GT(smallest_eigenvalues(make_eol_sheet(bend, pattern)).regularised, 1e-8) << "bend " << bend;
    }
  }
  EXPECT_LT(smallest_eigenvalues(make_eol_sheet(0)).plain, 1e-14) << "else there is nothing to regularise";
  EXPECT_GT(smallest_eigenvalues(make_eol_sheet(90 * degree)).plain, 1e-3);
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
    MatX H = M;
    VecX f = M * uniform_motion(sheet, dofs, speed * sheet.side);
    add_regularisation(rows, dofs, H, f);
    const VecX q = minimise(rows, H, f, table_holds(sheet));
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
  MatX H = M;
  VecX f = M * (1e-2 * uniform_motion(sheet, dofs, Vec3(0, 0, -9.81)));
  add_regularisation(rows, dofs, H, f);
  const VecX q = minimise(rows, H, f, table_holds(sheet));
  for (const int v : sheet.chain) EXPECT_LE(q.segment<2>(dofs.X(v)).norm(), 1e-8);
  EXPECT_LE(q.cwiseAbs().maxCoeff(), 1e-8);
}

// Where both normals hold, xdot is given across the edge and the term must not move anything: not by a bit more than
// the solves themselves do.
TEST(FlatCloth, RegularisationIsSilentWhereTheContactIsActive) {
  for (const double bend : {5 * degree, 90 * degree}) {
    EolSheet sheet = make_eol_sheet(bend);
    sheet.pose.velocity = {0.1, 0.2, 0.3};
    const DofMap dofs = make_dof_map(sheet.cloth);
    const ConstraintRows rows = sheet.rows();
    const MatX M = make_inertia(sheet.cloth, dofs);
    const VecX f = M * VecX::Random(dofs.size());
    MatX H = M;
    VecX g = f;
    add_regularisation(rows, dofs, H, g);
    const auto all = [](const RowInfo&) { return true; };
    const VecX with = minimise(rows, H, g, all), without = minimise(rows, M, f, all);
    EXPECT_LT((with - without).norm(), 1e-11 * without.norm());
  }
}

// Bent cloth with the contact open at both normals: the term changes the free motion by its own size only.
TEST(FlatCloth, RegularisationIsSmallOnBentClothThatLiftsOff) {
  const EolSheet sheet = make_eol_sheet(90 * degree);
  const DofMap dofs = make_dof_map(sheet.cloth);
  const ConstraintRows rows = sheet.rows();
  const MatX M = make_inertia(sheet.cloth, dofs);
  const VecX f = M * uniform_motion(sheet, dofs, Vec3(1, 0, 1));
  MatX H = M;
  VecX g = f;
  add_regularisation(rows, dofs, H, g);
  const auto none = [](const RowInfo&) { return false; };
  const VecX with = minimise(rows, H, g, none), without = minimise(rows, M, f, none);
  EXPECT_LT((with - without).norm(), 1e-4 * without.norm()) << "1e-6 times the condition of the bent system";
}

}  // namespace
}  // namespace crease
