// SPDX-License-Identifier: MIT
// Rows on Xdot: border rule and tangent rule, wherever the sheet lies in material space.
#include <gtest/gtest.h>

#include "constraints/eol_sheet.hpp"

namespace crease {
namespace {

using namespace crease::testing;

constexpr double pi = 3.14159265358979323846;
constexpr double round_off = 1e-12;  // material coordinates of size 1 m over edges of 0.1 m

/// Direction in which a row on Xdot lets the material move.
Vec2 allowed(const ConstraintRows& rows, int r, const DofMap& dofs, int vertex) {
  const Vec2 row = material_part(rows.A_eq, r, dofs, vertex);
  EXPECT_NEAR(row.norm(), 1, round_off);
  EXPECT_EQ(rows.b_eq[r], 0);
  EXPECT_EQ(rows.A_eq.row(r).nonZeros(), 2);
  return {-row.y(), row.x()};
}

// The material position, moved as the row allows, stays on the border's line: axis-aligned, oblique, anywhere.
TEST(EulerianRows, BorderVertexStaysOnItsBorderForEveryDirection) {
  for (int step = 0; step < 24; ++step) {
    EolSheet sheet = make_eol_sheet(0.3);
    place_material(sheet, step * pi / 12 + (step % 2 ? 0.123 : 0.0), Vec2(0.4, -0.7));
    const ConstraintRows rows = sheet.rows();
    const DofMap dofs = make_dof_map(sheet.cloth);
    const Mesh& mesh = sheet.cloth.mesh;
    for (const int v : {sheet.chain.front(), sheet.chain.back()}) {
      const std::vector<int> found = rows_of(rows.eq, RowKind::EolBorder, v);
      ASSERT_EQ(found.size(), 1u);
      EXPECT_TRUE(rows_of(rows.eq, RowKind::EolTangent, v).empty());
      const Vec2 along = allowed(rows, found[0], dofs, v);
      for (const int i : mesh.neighbours(v)) {
        if (!mesh.is_border(mesh.find_edge(v, i)) || !mesh.is_border_vertex(i)) continue;
        const Vec2 border = (mesh.X[i] - mesh.X[v]).normalized();
        EXPECT_NEAR(std::abs(border.dot(along)), 1, round_off) << "step " << step;
      }
    }
  }
}

// The tangent row forbids flow along the chain and leaves flow across it.
TEST(EulerianRows, InteriorVertexMayMoveAcrossItsChainOnly) {
  for (int step = 0; step < 24; ++step) {
    for (const GridPattern pattern : {GridPattern::Right, GridPattern::Cross}) {
      EolSheet sheet = make_eol_sheet(0.3, pattern);
      place_material(sheet, step * pi / 12, Vec2(-0.3, 0.8));
      const ConstraintRows rows = sheet.rows();
      const DofMap dofs = make_dof_map(sheet.cloth);
      const Mesh& mesh = sheet.cloth.mesh;
      const Vec2 chain = (mesh.X[sheet.chain.back()] - mesh.X[sheet.chain.front()]).normalized();
      for (std::size_t i = 1; i + 1 < sheet.chain.size(); ++i) {
        const std::vector<int> found = rows_of(rows.eq, RowKind::EolTangent, sheet.chain[i]);
        ASSERT_EQ(found.size(), 1u);
        EXPECT_NEAR(allowed(rows, found[0], dofs, sheet.chain[i]).dot(chain), 0, round_off);
      }
    }
  }
}

// The halves of a kinked chain add up: the row is along their bisector, not across it.
TEST(EulerianRows, TangentOfAKinkedChainIsItsBisector) {
  EolSheet sheet = make_eol_sheet(0.3);
  Mesh& mesh = sheet.cloth.mesh;
  const int v = sheet.chain[2];
  mesh.X[v].x() += 0.03;
  const Vec2 bisector =
      ((mesh.X[v] - mesh.X[sheet.chain[1]]).normalized() + (mesh.X[sheet.chain[3]] - mesh.X[v]).normalized())
          .normalized();
  const ConstraintRows rows = sheet.rows();
  const Vec2 row = material_part(rows.A_eq, rows_of(rows.eq, RowKind::EolTangent, v)[0], make_dof_map(sheet.cloth), v);
  EXPECT_NEAR(std::abs(row.dot(bisector)), 1, round_off);
}

}  // namespace
}  // namespace crease
