// SPDX-License-Identifier: MIT
// Five defects known from an implementation of the method; each test says what went wrong there and why.
#include <gtest/gtest.h>

#include "constraints/eol_sheet.hpp"
#include "crease/geometry/triangle.hpp"

namespace crease {
namespace {

using namespace crease::testing;

// The vector orthogonal to the border was built by adding a component that had to be subtracted: right for borders
// y = const and for x = 0 alone. With the edge along x, EOL vertices left the sheet within a second.
TEST(KnownDefect, BorderRuleHoldsOnBordersOfBothAxes) {
  for (const double turn : {0.0, std::acos(0.0), -std::acos(0.0), 2 * std::acos(0.0)}) {
    EolSheet sheet = make_eol_sheet(0.4);
    place_material(sheet, turn, Vec2(0.3, 0.9));
    const ConstraintRows rows = sheet.rows();
    const DofMap dofs = make_dof_map(sheet.cloth);
    const Vec2 border = Eigen::Rotation2Dd(turn) * Vec2(1, 0);  // the chain's ends stand on v = const
    for (const int v : {sheet.chain.front(), sheet.chain.back()}) {
      const Vec2 row = material_part(rows.A_eq, rows_of(rows.eq, RowKind::EolBorder, v)[0], dofs, v);
      EXPECT_NEAR(row.dot(border), 0, 1e-12);
      EXPECT_NEAR(row.norm(), 1, 1e-12);
    }
  }
}

// The two halves of the chain were ordered by their distance to the material origin; where the chain passes nearest to
// it the halves cancelled, and the row vanished or locked the sliding direction.
TEST(KnownDefect, ChainThroughTheMaterialOriginKeepsItsTangent) {
  for (const double turn : {0.0, 0.5, 1.1}) {
    EolSheet sheet = make_eol_sheet(0.4);
    place_material(sheet, 0, Vec2(-0.5 * sheet_length, -0.5 * sheet_width));
    place_material(sheet, turn, Vec2::Zero());
    const int v = sheet.chain[2];
    ASSERT_LT(sheet.cloth.mesh.X[v].norm(), 1e-12);
    const ConstraintRows rows = sheet.rows();
    const Vec2 row =
        material_part(rows.A_eq, rows_of(rows.eq, RowKind::EolTangent, v)[0], make_dof_map(sheet.cloth), v);
    EXPECT_NEAR(std::abs(row.dot(Eigen::Rotation2Dd(turn) * Vec2(0, 1))), 1, 1e-12);
  }
}

// Contacts of Lagrangian vertices asked for n . xdot >= 0 whatever the obstacle did: a plate that rose at 0.5 m/s went
// through the sheet. Every kind of row must carry the obstacle's velocity at its point.
TEST(KnownDefect, EveryRowMovesWithItsObstacle) {
  EolSheet sheet = make_eol_sheet(0.4);
  sheet.pose.velocity = {0, 0, 0.5};
  sheet.pose.spin = cross_matrix({0.3, -0.2, 0.1});
  Contact contact;
  contact.obstacle = 0;
  contact.n_vertices = 1;
  contact.vertices = {0, -1, -1};
  contact.weights = {1, 0, 0};
  contact.normal = sheet.up;
  contact.point = sheet.cloth.mesh.x[0];
  contact.velocity = sheet.pose.velocity_at(contact.point);
  const ConstraintRows rows = sheet.rows({contact});
  for (std::size_t r = 0; r < rows.in.size(); ++r) {
    const Vec3 velocity = sheet.pose.velocity_at(sheet.cloth.mesh.x[rows.in[r].vertex]);
    EXPECT_NEAR(rows.b_in[static_cast<int>(r)], rows.in[r].normal.dot(velocity), 1e-12);
  }
  ASSERT_EQ(rows_of(rows.in, RowKind::Contact).size(), 1u);
}

// A box corner was bounded by its mean normal and two arbitrary tangents, the first of them (0, -n_z, n_y), which is
// zero for a normal along x. The cone is that of the faces: it admits exactly what leaves all three.
TEST(KnownDefect, FramesExistForEveryNormal) {
  for (int axis = 0; axis < 3; ++axis) {
    for (const double sign : {1.0, -1.0}) {
      EolSheet sheet = make_eol_sheet(0.4);
      const int v = sheet.chain[2];
      for (const int i : sheet.chain) sheet.cloth.feature[i] = {};
      for (const int edge : sheet.cloth.mesh.edges()) sheet.cloth.mesh.set_tag(edge, 0);
      sheet.shape = {};
      sheet.shape.kind = ObstacleShape::Kind::Point;
      sheet.shape.corners = {{Vec3::Zero(), {sign * Vec3::Unit(axis)}}};
      sheet.pose.position = sheet.cloth.mesh.x[v];
      sheet.cloth.feature[v] = {0, FeatureKind::Corner, 0};
      const ConstraintRows rows = sheet.rows();
      ASSERT_EQ(rows.eq.size(), 2u);
      for (const RowInfo& row : rows.eq) {
        EXPECT_NEAR(row.normal.norm(), 1, 1e-15);
        EXPECT_NEAR(row.normal[axis], 0, 1e-15);
      }
    }
  }
}

// The flat case took its normal from the cloth; a sheet turned over was pulled into the box.
TEST(KnownDefect, SheetTurnedOverHasTheSameRows) {
  for (const double bend : {0.0, 0.4}) {
    const EolSheet sheet = make_eol_sheet(bend);
    EolSheet turned = make_eol_sheet(bend);
    for (Vec3& x : turned.cloth.mesh.x) x.y() = sheet_width - x.y();
    ASSERT_LT(face_normal(sheet.cloth.mesh, 0).dot(face_normal(turned.cloth.mesh, 0)), 0);
    const ConstraintRows rows = sheet.rows(), turned_rows = turned.rows();
    EXPECT_TRUE(MatX(rows.A_in).isApprox(MatX(turned_rows.A_in), 1e-15));
    EXPECT_TRUE((rows.b_in - turned_rows.b_in).isZero(1e-12));
    for (std::size_t r = 0; r < rows.in.size(); ++r)
      EXPECT_LT((rows.in[r].normal - turned_rows.in[r].normal).norm(), 1e-15) << "the sums run another way round";
  }
}

}  // namespace
}  // namespace crease
