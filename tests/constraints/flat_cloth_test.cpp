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
  add_regularisation(rows, sheet.cloth, dofs, H, f);
  return {plain, smallest(Z.transpose() * H * Z)};
}

// Without the term the smallest eigenvalue is 0 when flat and grows with the square of the bend; with it, it is of the
// term's own size (the mass of a vertex, as h = t_r here; the flat mode has half of its length in xdot, and meshes cost
// a factor) at least.
TEST(FlatCloth, MinimiserIsUniqueAtEveryBend) {
  for (const double bend : {0.0, 0.1 * degree, 5 * degree, 90 * degree, 179 * degree}) {
    for (const GridPattern pattern : {GridPattern::Right, GridPattern::Cross}) {
      EXPECT_GT(smallest_eigenvalues(make_eol_sheet(bend, pattern)).regularised, 1e-3) << "bend " << bend;
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
    add_regularisation(rows, sheet.cloth, dofs, H, f);
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
  add_regularisation(rows, sheet.cloth, dofs, H, f);
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
    add_regularisation(rows, sheet.cloth, dofs, H, g);
    const auto all = [](const RowInfo&) { return true; };
    const VecX with = minimise(rows, H, g, all), without = minimise(rows, M, f, all);
    EXPECT_LT((with - without).norm(), 1e-11 * without.norm());
  }
}

// A force of the cloth's own weight pushes the vertices off the edge. What has no inertia of its own gets a drag of
// rate 1/t_r: the vertex goes no faster than g t_r at any bend and any step, and its speed changes by little where the
// bend passes through zero.
TEST(FlatCloth, ForceAcrossTheEdgeMovesTheVertexByABoundedSpeed) {
  constexpr double g = 9.8, return_time = 0.01;
  for (const double h : {1e-2, 1e-3, 1e-4}) {
    double last = -1;
    for (const double bend : {0.0, 1e-3 * degree, 0.1 * degree, 1 * degree}) {
      const EolSheet sheet = make_eol_sheet(bend);
      const DofMap dofs = make_dof_map(sheet.cloth);
      const ConstraintRows rows = sheet.rows({}, {}, h);
      MatX H = make_inertia(sheet.cloth, dofs);
      VecX f = VecX::Zero(dofs.size());
      for (const int v : sheet.chain) f.segment<3>(dofs.x(v)) = h * lumped_mass(sheet.cloth.mesh, v) * g * sheet.side;
      add_regularisation(rows, sheet.cloth, dofs, H, f);
      const VecX q = minimise(rows, H, f, table_holds(sheet));
      double fastest = 0;
      for (const int v : sheet.chain) fastest = std::max(fastest, q.segment<5>(dofs.start[v]).cwiseAbs().maxCoeff());
      EXPECT_LE(fastest, 1.01 * g * return_time) << "h " << h << ", bend " << bend;
      EXPECT_GE(fastest, 0.5 * g * return_time) << "else nothing was free to move";
      // One degree adds sin^2(1 deg) = 3e-4 of the inertia, times t_r/h = 100 at most against the term's.
      if (last >= 0) {
        EXPECT_NEAR(fastest, last, 0.1 * last) << "h " << h << ", bend " << bend;
      }
      last = fastest;
    }
  }
}

// Bent cloth with the contact open at both normals: the term takes the share h/t_r of the momentum of the vertices on
// the edge, which the rest of the sheet makes up for in part.
TEST(FlatCloth, LiftOffFeelsTheTermByItsShareOfTheStep) {
  const EolSheet sheet = make_eol_sheet(90 * degree);
  const DofMap dofs = make_dof_map(sheet.cloth);
  const MatX M = make_inertia(sheet.cloth, dofs);
  const VecX f = M * uniform_motion(sheet, dofs, Vec3(1, 0, 1));
  const auto none = [](const RowInfo&) { return false; };
  double last = 0;
  for (const double h : {1e-4, 1e-5}) {
    const ConstraintRows rows = sheet.rows({}, {}, h);
    MatX H = M;
    VecX g = f;
    add_regularisation(rows, sheet.cloth, dofs, H, g);
    const VecX with = minimise(rows, H, g, none), without = minimise(rows, M, f, none);
    const double change = (with - without).norm() / without.norm();
    EXPECT_LT(change, 2 * h / 0.01);
    if (last > 0) {
      EXPECT_NEAR(last / change, 10, 0.5);
    }
    last = change;
  }
}

}  // namespace
}  // namespace crease
