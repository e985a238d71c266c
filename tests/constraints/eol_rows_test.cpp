// SPDX-License-Identifier: MIT
// Lagrangian rows of EOL vertices: Algorithm 2 against hand counts, for edges, corners, points and wires.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "constraints/eol_sheet.hpp"

namespace crease {
namespace {

using namespace crease::testing;

constexpr double h = 1e-2;
constexpr double push_out_speed = 0.1;  // the default of ConstraintOptions
// Unit normals through one rotation, and sums of a handful of terms of size 1: a few ulp.
constexpr double round_off = 1e-13;
// A position of size 1 m is known to 1e-16 m; a gap's share of the bound is that over h = 1e-2 s, a few times.
constexpr double gap_round_off = 1e-12;

/// A sheet with one EOL vertex, on a corner of the obstacle.
EolSheet make_corner_sheet() {
  EolSheet sheet;
  sheet.cloth = make_cloth(make_grid({.size = {0.4, 0.4}, .cells = {2, 2}, .pattern = GridPattern::Right}));
  sheet.shape = make_box({0.5, 0.5, 0.5});
  for (std::size_t c = 0; c < sheet.shape.corners.size(); ++c) {
    if (sheet.shape.corners[c].position.isApprox(Vec3(0.25, 0.25, 0.25))) {
      sheet.feature = {0, FeatureKind::Corner, static_cast<int>(c)};
    }
  }
  sheet.pose.position = Vec3(0.2 - 0.25, 0.2 - 0.25, -0.25);
  for (int v = 0; v < sheet.cloth.mesh.vertex_slots(); ++v) {
    if (!sheet.cloth.mesh.is_border_vertex(v)) sheet.chain = {v};
  }
  sheet.cloth.feature[sheet.chain.front()] = sheet.feature;
  return sheet;
}

EolSheet make_nail_sheet(const Vec3& normal) {
  EolSheet sheet = make_corner_sheet();
  sheet.shape = {};
  sheet.shape.kind = ObstacleShape::Kind::Point;
  sheet.shape.corners = {{Vec3::Zero(), {normal}}};
  sheet.pose.position = {0.2, 0.2, 0};
  sheet.feature = sheet.cloth.feature[sheet.chain.front()] = {0, FeatureKind::Corner, 0};
  return sheet;
}

EolSheet make_wire_sheet() {
  EolSheet sheet = make_eol_sheet();
  sheet.shape = {};
  sheet.shape.kind = ObstacleShape::Kind::Wire;
  SharpEdge segment{};
  segment.a = {0, -1, 0};
  segment.b = {0, 1, 0};
  segment.normals.fill(Vec3::Zero());
  segment.free_cone = true;
  sheet.shape.edges = {segment};
  sheet.pose.position = {0.5 * sheet_length, 0, 0};
  sheet.feature = {0, FeatureKind::Edge, 0};
  Mesh& mesh = sheet.cloth.mesh;
  for (const int v : sheet.chain) sheet.cloth.feature[v] = sheet.feature;
  for (std::size_t i = 1; i < sheet.chain.size(); ++i) {
    mesh.set_tag(mesh.find_edge(sheet.chain[i - 1], sheet.chain[i]), edge_tag(0, 0));
  }
  return sheet;
}

TEST(EolRows, EmptyInputHasTheRightShapes) {
  const Cloth cloth = make_cloth(make_grid({.cells = {2, 2}}));
  const DofMap dofs = make_dof_map(cloth);
  ConstraintOptions options;
  options.h = h;
  const ConstraintRows rows = build_constraints(cloth, dofs, {}, {}, {}, options);
  for (const SparseRows& A : {rows.A_eq, rows.A_in}) {
    EXPECT_EQ(A.rows(), 0);
    EXPECT_EQ(A.cols(), dofs.size());
  }
  EXPECT_EQ(rows.b_eq.size() + rows.b_in.size(), 0);
  EXPECT_TRUE(rows.eq.empty() && rows.in.empty());
}

TEST(EolRows, EdgeVertexHasOneInequalityAndTwoEqualities) {
  const EolSheet sheet = make_eol_sheet(0.5);
  const ConstraintRows rows = sheet.rows();
  const std::size_t n = sheet.chain.size();
  ASSERT_EQ(n, 5u);
  EXPECT_EQ(rows.in.size(), n);
  EXPECT_EQ(rows_of(rows.eq, RowKind::EolHold).size(), n);
  EXPECT_EQ(rows_of(rows.eq, RowKind::EolBorder).size(), 2u);
  EXPECT_EQ(rows_of(rows.eq, RowKind::EolTangent).size(), n - 2);
  EXPECT_EQ(rows.eq.size(), 2 * n);
  EXPECT_EQ(rows.A_in.rows(), rows.b_in.size());
  EXPECT_EQ(rows.A_eq.rows(), rows.b_eq.size());
  EXPECT_TRUE(rows.b_in.cwiseAbs().maxCoeff() < gap_round_off) << "at rest on the feature";
}

// The sheet turns by `bend` at the edge, so that the bisector of its normals turns by half of it.
TEST(EolRows, NormalIsTheBisectorOfTheFoldAndTurnsWithTheScene) {
  std::mt19937_64 rng(7);
  SCOPED_TRACE("seed 7");
  for (int trial = 0; trial < 20; ++trial) {
    const double bend = trial * std::acos(-1.0) / 40;
    EolSheet sheet = make_eol_sheet(bend, trial % 2 ? GridPattern::Cross : GridPattern::Right);
    place(sheet, random_rotation(rng), random_vector(rng, 1.0));
    const Vec3 expected = std::cos(bend / 2) * sheet.up + std::sin(bend / 2) * sheet.side;
    const ConstraintRows rows = sheet.rows();
    const DofMap dofs = make_dof_map(sheet.cloth);
    for (const int v : sheet.chain) {
      const std::vector<int> normals = rows_of(rows.in, RowKind::EolNormal, v);
      const std::vector<int> holds = rows_of(rows.eq, RowKind::EolHold, v);
      ASSERT_EQ(normals.size(), 1u);
      ASSERT_EQ(holds.size(), 1u);
      EXPECT_LT((world_part(rows.A_in, normals[0], dofs, v) - expected).norm(), round_off);
      EXPECT_NEAR(std::abs(world_part(rows.A_eq, holds[0], dofs, v).dot(sheet.along.cross(expected))), 1, round_off);
      EXPECT_EQ(material_part(rows.A_in, normals[0], dofs, v), Vec2(0, 0));
    }
    EXPECT_LT(rows.b_in.cwiseAbs().maxCoeff(), 5 * gap_round_off);
  }
}

// Every axis-aligned edge of a box in turn: a frame made from fixed components would vanish for some. The normal is
// a n0 + b n1 with a, b >= 0, whatever the cloth does.
TEST(EolRows, NormalLiesInTheConeOfAllTwelveBoxEdges) {
  EolSheet sheet = make_eol_sheet(0.3);
  const int v = sheet.chain[2];
  const Vec3 x = sheet.cloth.mesh.x[v];
  for (std::size_t e = 0; e < sheet.shape.edges.size(); ++e) {
    const SharpEdge& edge = sheet.shape.edges[e];
    sheet.feature.index = static_cast<int>(e);
    for (const int i : sheet.chain) sheet.cloth.feature[i] = sheet.feature;
    sheet.pose.position = x - 0.5 * (edge.a + edge.b);
    const ConstraintRows rows = sheet.rows();
    const Vec3 tangent = (edge.b - edge.a).normalized();
    for (const int r : rows_of(rows.in, RowKind::EolNormal, v)) {
      const Vec3& N = rows.in[r].normal;
      EXPECT_NEAR(N.norm(), 1, round_off);
      EXPECT_NEAR(N.dot(tangent), 0, round_off);
      EXPECT_GE(std::min(N.dot(edge.normals[0]), N.dot(edge.normals[1])), -round_off);
      EXPECT_NEAR(rows.b_in[r], 0, gap_round_off);
      const int hold = rows_of(rows.eq, RowKind::EolHold, v).front();
      EXPECT_NEAR(rows.eq[hold].normal.dot(N), 0, round_off);
      EXPECT_NEAR(rows.eq[hold].normal.dot(tangent), 0, round_off);
    }
  }
}

TEST(EolRows, BoundIsTheObstaclesVelocityAtTheVertex) {
  std::mt19937_64 rng(3);
  SCOPED_TRACE("seed 3");
  EolSheet sheet = make_eol_sheet(0.3);
  sheet.pose.velocity = random_vector(rng, 1.0);
  sheet.pose.spin = cross_matrix(random_vector(rng, 2.0));
  place(sheet, random_rotation(rng), random_vector(rng, 1.0));
  const ConstraintRows rows = sheet.rows();
  for (std::size_t r = 0; r < rows.in.size(); ++r) {
    const Vec3 arm = sheet.cloth.mesh.x[rows.in[r].vertex] - sheet.pose.position;
    const Vec3 velocity = sheet.pose.velocity + sheet.pose.spin * arm;
    EXPECT_NEAR(rows.b_in[static_cast<int>(r)], rows.in[r].normal.dot(velocity), 5 * gap_round_off);
  }
  for (const int r : rows_of(rows.eq, RowKind::EolHold)) {
    const Vec3 at = sheet.pose.velocity_at(sheet.cloth.mesh.x[rows.eq[r].vertex]);
    EXPECT_NEAR(rows.b_eq[r], rows.eq[r].normal.dot(at), 5 * gap_round_off);
  }
}

// What the rows leave free is sliding along the edge; with that, the vertex ends on the line where the edge then is.
TEST(EolRows, SlidingAlongATurningEdgeEndsOnTheEdge) {
  std::mt19937_64 rng(31);
  SCOPED_TRACE("seed 31");
  for (int trial = 0; trial < 20; ++trial) {
    EolSheet sheet = make_eol_sheet(0.3);
    sheet.pose.velocity = random_vector(rng, 1.0);
    const Mat3 turn = Eigen::AngleAxisd(uniform(rng, 0, 1), random_vector(rng, 1.0).normalized()).toRotationMatrix();
    sheet.pose.spin = (turn - Mat3::Identity()) / h;
    place(sheet, random_rotation(rng), random_vector(rng, 1.0));
    const ConstraintRows rows = sheet.rows();
    const Pose there{.position = sheet.pose.position + h * sheet.pose.velocity,
                     .rotation = sheet.pose.rotation + h * sheet.pose.spin * sheet.pose.rotation};
    const SharpEdge& edge = sheet.shape.edges[sheet.feature.index];
    const Vec3 tangent = there.rotation * (edge.b - edge.a).normalized();
    for (const int v : sheet.chain) {
      const int in = rows_of(rows.in, RowKind::EolNormal, v).front();
      const int hold = rows_of(rows.eq, RowKind::EolHold, v).front();
      const Vec3 end = sheet.cloth.mesh.x[v] +
                       h * (rows.b_in[in] * rows.in[in].normal + rows.b_eq[hold] * rows.eq[hold].normal + 2 * tangent);
      const Vec3 off = end - there.to_world(edge.a);
      EXPECT_LE((off - tangent.dot(off) * tangent).norm(), 5 * gap_round_off * h) << trial;
    }
  }
}

// A gap may close within the step, and not more; a penetration is pushed out, at the given speed at most. Across the
// normal the vertex is led back to its edge from either side, at that speed at most.
TEST(EolRows, GapEntersSignedAndBounded) {
  for (const double gap : {2e-3, 1e-5, -1e-5, -4e-4, -6e-4, -0.3}) {
    EolSheet sheet = make_eol_sheet(0.3);
    const int v = sheet.chain[2];
    const Vec3 away = gap * sheet.up;
    sheet.cloth.mesh.x[v] += away;
    const ConstraintRows rows = sheet.rows();
    for (const int r : rows_of(rows.in, RowKind::EolNormal, v)) {
      const double along = rows.in[r].normal.dot(away);
      EXPECT_NEAR(rows.b_in[r], std::min(-along / h, push_out_speed), gap_round_off) << "gap " << gap;
    }
    for (const int r : rows_of(rows.eq, RowKind::EolHold, v)) {
      const double across = rows.eq[r].normal.dot(away);
      EXPECT_NEAR(rows.b_eq[r], std::clamp(-across / h, -push_out_speed, push_out_speed), gap_round_off);
    }
  }
}

// A flat sheet over a corner: it is borne along its own normal, which lies in the cone of the three faces.
TEST(EolRows, CornerHoldsAcrossTheClothsNormalAndHasNoEulerianRow) {
  std::mt19937_64 rng(5);
  SCOPED_TRACE("seed 5");
  for (int trial = 0; trial < 10; ++trial) {
    EolSheet sheet = make_corner_sheet();
    const Mat3 Q = trial == 0 ? Mat3::Identity() : random_rotation(rng);
    place(sheet, Q, Vec3(1, 2, 3));
    const ConstraintRows rows = sheet.rows();
    ASSERT_EQ(rows.in.size(), 1u);
    EXPECT_LT((rows.in[0].normal - Q * Vec3::UnitZ()).norm(), round_off);
    ASSERT_EQ(rows.eq.size(), 2u);
    Mat3 frame;
    frame << rows.in[0].normal, rows.eq[0].normal, rows.eq[1].normal;
    EXPECT_LT((frame.transpose() * frame - Mat3::Identity()).norm(), round_off);
    for (int r = 0; r < 2; ++r) EXPECT_EQ(rows.eq[r].kind, RowKind::EolHold);
  }
}

TEST(EolRows, CornerVertexOnTheBorderKeepsTheBorderRule) {
  EolSheet sheet = make_eol_sheet();
  EolSheet corner = make_corner_sheet();
  sheet.shape = corner.shape;
  for (const int v : sheet.chain) sheet.cloth.feature[v] = {};
  const int v = sheet.chain.front();
  sheet.cloth.feature[v] = corner.feature;
  sheet.pose.position = sheet.cloth.mesh.x[v] - corner.shape.corners[corner.feature.index].position;
  Mesh& mesh = sheet.cloth.mesh;
  for (const int edge : mesh.edges()) mesh.set_tag(edge, 0);
  const ConstraintRows rows = sheet.rows();
  EXPECT_EQ(rows.in.size(), 1u);
  ASSERT_EQ(rows.eq.size(), 3u);
  EXPECT_EQ(rows_of(rows.eq, RowKind::EolBorder).size(), 1u);
}

// A nail: one inequality along its normal and two equalities across, whatever the normal.
TEST(EolRows, PointHoldsTheVertexOnItsTip) {
  std::mt19937_64 rng(11);
  SCOPED_TRACE("seed 11");
  for (int trial = 0; trial < 12; ++trial) {
    const Vec3 normal =
        trial < 6 ? Vec3(Vec3::Unit(trial / 2) * (trial % 2 ? -1 : 1)) : Vec3(random_rotation(rng) * Vec3::UnitZ());
    EolSheet sheet = make_nail_sheet(normal);
    sheet.pose.velocity = random_vector(rng, 1.0);
    const ConstraintRows rows = sheet.rows();
    ASSERT_EQ(rows.in.size(), 1u);
    ASSERT_EQ(rows.eq.size(), 2u);
    EXPECT_EQ(rows.in[0].kind, RowKind::EolNormal);
    EXPECT_LT((rows.in[0].normal - normal).norm(), round_off);
    EXPECT_NEAR(rows.b_in[0], normal.dot(sheet.pose.velocity), gap_round_off);
    Mat3 frame;
    frame << normal, rows.eq[0].normal, rows.eq[1].normal;
    EXPECT_LT((frame.transpose() * frame - Mat3::Identity()).norm(), round_off);
    for (int r = 0; r < 2; ++r) {
      EXPECT_EQ(rows.eq[r].kind, RowKind::EolHold);
      EXPECT_NEAR(rows.b_eq[r], rows.eq[r].normal.dot(sheet.pose.velocity), gap_round_off);
    }
  }
}

// Position drift across a nail is taken back, at the push-out speed at most, towards the tip from either side.
TEST(EolRows, HoldTakesDriftBackBounded) {
  for (const double drift : {1e-5, -1e-5, 0.2, -0.2}) {
    EolSheet sheet = make_nail_sheet(Vec3::UnitZ());
    const Vec3 aside(drift, -drift, 0);
    sheet.cloth.mesh.x[sheet.chain.front()] += aside;
    const ConstraintRows rows = sheet.rows();
    ASSERT_EQ(rows.eq.size(), 2u);
    for (int r = 0; r < 2; ++r) {
      const double offset = rows.eq[r].normal.dot(aside);
      const double back = std::copysign(std::min(std::abs(offset) / h, push_out_speed), -offset);
      EXPECT_NEAR(rows.b_eq[r], back, gap_round_off);
    }
  }
}

// What the equalities decide, an inequality can only contradict: a contact across a nail is dropped, one along it
// stays.
TEST(EolRows, HoldWinsOverContactsAcross) {
  std::mt19937_64 rng(23);
  SCOPED_TRACE("seed 23");
  for (int trial = 0; trial < 8; ++trial) {
    EolSheet sheet = make_nail_sheet(Vec3::UnitZ());
    const Mat3 Q = random_rotation(rng);
    place(sheet, Q, Vec3(0.1, 0.2, 0.3));
    Contact contact;
    contact.obstacle = 0;
    contact.n_vertices = 1;
    contact.vertices = {sheet.chain.front(), -1, -1};
    contact.weights = {1, 0, 0};
    contact.normal = Q * Vec3(0.6, -0.8, 0);
    EXPECT_TRUE(rows_of(sheet.rows({contact}).in, RowKind::Contact).empty());
    contact.normal = Q * Vec3(0, 0.6, 0.8);
    EXPECT_EQ(rows_of(sheet.rows({contact}).in, RowKind::Contact).size(), 1u);
  }
}

// Held by a pin and by a nail at once, the equalities could contradict each other: the pin alone holds.
TEST(EolRows, PinWinsOverHold) {
  EolSheet sheet = make_nail_sheet(Vec3(0.6, 0, 0.8));
  sheet.cloth.pins[sheet.chain.front()] = 1;
  PinState pin;
  pin.axes = {false, false, true};
  const ConstraintRows rows = sheet.rows({}, {pin});
  ASSERT_EQ(rows.eq.size(), 1u);
  EXPECT_EQ(rows.eq[0].kind, RowKind::Pin);
}

TEST(EolRows, WireHoldsAcrossAndLeavesTheTangentFree) {
  std::mt19937_64 rng(13);
  SCOPED_TRACE("seed 13");
  for (int trial = 0; trial < 8; ++trial) {
    EolSheet sheet = make_wire_sheet();
    sheet.pose.velocity = {0.1, 0.2, 0.3};
    place(sheet, trial == 0 ? Mat3::Identity() : random_rotation(rng), Vec3::Zero());
    const ConstraintRows rows = sheet.rows();
    EXPECT_TRUE(rows.in.empty());
    for (const int v : sheet.chain) {
      const std::vector<int> holds = rows_of(rows.eq, RowKind::EolHold, v);
      ASSERT_EQ(holds.size(), 2u);
      for (const int r : holds) {
        EXPECT_NEAR(rows.eq[r].normal.dot(sheet.along), 0, round_off);
        EXPECT_NEAR(rows.b_eq[r], rows.eq[r].normal.dot(sheet.pose.velocity), 5 * gap_round_off);
      }
      EXPECT_NEAR(rows.eq[holds[0]].normal.dot(rows.eq[holds[1]].normal), 0, round_off);
      EXPECT_EQ(rows_of(rows.eq, RowKind::EolTangent, v).size() + rows_of(rows.eq, RowKind::EolBorder, v).size(), 1u);
    }
  }
}

// With the wire's side known, it may push but not pull: one inequality along the flat sheet's normal, turned to the
// side away from the wire, and one hold across it.
TEST(EolRows, WireOnAKnownSidePushesOnly) {
  std::mt19937_64 rng(17);
  SCOPED_TRACE("seed 17");
  for (int trial = 0; trial < 8; ++trial) {
    EolSheet sheet = make_wire_sheet();
    const int side = trial % 2 == 0 ? 1 : -1;
    for (const int v : sheet.chain) sheet.cloth.feature[v].side = side;
    sheet.pose.velocity = {0.1, 0.2, 0.3};
    place(sheet, trial == 0 ? Mat3::Identity() : random_rotation(rng), Vec3::Zero());
    const ConstraintRows rows = sheet.rows();
    for (const int v : sheet.chain) {
      const std::vector<int> holds = rows_of(rows.eq, RowKind::EolHold, v);
      const std::vector<int> normals = rows_of(rows.in, RowKind::EolNormal, v);
      ASSERT_EQ(holds.size(), 1u);
      ASSERT_EQ(normals.size(), 1u);
      const Vec3 normal = rows.in[normals[0]].normal;
      EXPECT_NEAR(normal.dot(sheet.up), side, 10 * round_off);
      EXPECT_NEAR(rows.b_in[normals[0]], normal.dot(sheet.pose.velocity), 5 * gap_round_off);
      EXPECT_NEAR(rows.eq[holds[0]].normal.dot(normal), 0, round_off);
      EXPECT_NEAR(rows.eq[holds[0]].normal.dot(sheet.along), 0, round_off);
      EXPECT_NEAR(rows.b_eq[holds[0]], rows.eq[holds[0]].normal.dot(sheet.pose.velocity), 5 * gap_round_off);
    }
  }
}

TEST(EolRows, OfAHeldVertexKeepItWhereItIsInTheMaterial) {
  const EolSheet sheet = make_eol_sheet(0.5);
  const DofMap dofs = make_dof_map(sheet.cloth);
  ConstraintOptions options;
  options.h = h;
  options.held.resize(sheet.cloth.mesh.vertex_slots());
  for (const int v : {sheet.chain[0], sheet.chain[2]}) options.held[v] = 1;  // on the border, and within
  const ConstraintRows rows = build_constraints(sheet.cloth, dofs, {}, sheet.obstacles(), {}, options);
  const ConstraintRows free = sheet.rows();
  EXPECT_EQ(rows.in.size(), free.in.size());
  EXPECT_EQ(rows.eq.size(), free.eq.size() + 2);
  for (const int v : {sheet.chain[0], sheet.chain[2]}) {
    Mat2 both = Mat2::Zero();
    int n = 0;
    for (const RowKind kind : {RowKind::EolBorder, RowKind::EolTangent})
      for (const int r : rows_of(rows.eq, kind, v)) {
        ASSERT_LT(n, 2);
        both.row(n++) = material_part(rows.A_eq, r, dofs, v).transpose();
        EXPECT_EQ(rows.b_eq[r], 0);
      }
    EXPECT_EQ(std::abs(both.determinant()), 1) << "two rows at right angles";
  }
  options.held.pop_back();
  EXPECT_THROW(build_constraints(sheet.cloth, dofs, {}, sheet.obstacles(), {}, options), std::invalid_argument);
}

TEST(EolRows, RowsAreOrderedByVertexThenKind) {
  EolSheet sheet = make_wire_sheet();
  for (std::uint64_t& pins : sheet.cloth.pins) pins = 0;
  sheet.cloth.pins[0] = 1;
  const ConstraintRows rows = sheet.rows({}, {PinState{}});
  for (std::size_t r = 1; r < rows.eq.size(); ++r) {
    EXPECT_LE(std::tuple(rows.eq[r - 1].vertex, rows.eq[r - 1].kind), std::tuple(rows.eq[r].vertex, rows.eq[r].kind));
  }
}

TEST(EolRows, RefusesABrokenFeatureAndNumbersThatAreNotFinite) {
  EolSheet sheet = make_eol_sheet();
  EXPECT_THROW((void)sheet.rows({}, {}, 0.0), std::invalid_argument);
  EolSheet lost = make_eol_sheet();
  for (const int v : lost.chain) lost.cloth.feature[v].obstacle = 3;
  EXPECT_THROW((void)lost.rows(), std::invalid_argument);
  sheet.pose.velocity.x() = std::nan("");
  EXPECT_THROW((void)sheet.rows(), std::invalid_argument);
}

// What has lifted off is led by nothing, but its chain still says which of its motions through the material is one.
TEST(EolRows, OfAFoldThatHasLiftedOffOnlyTheTangentRuleIsLeft) {
  EolSheet sheet = make_eol_sheet(1.0);
  const int lifted = sheet.chain[sheet.chain.size() / 2];
  const auto rows_of = [&](int vertex) {
    const ConstraintRows rows = sheet.rows();
    std::vector<RowKind> kinds;
    for (const auto* list : {&rows.eq, &rows.in})
      for (const RowInfo& row : *list)
        if (row.vertex == vertex) kinds.push_back(row.kind);
    return kinds;
  };
  EXPECT_EQ(rows_of(lifted), (std::vector{RowKind::EolTangent, RowKind::EolHold, RowKind::EolNormal}));
  sheet.cloth.feature[lifted].lifted = true;
  EXPECT_EQ(rows_of(lifted), std::vector{RowKind::EolTangent});
  sheet.cloth.feature[lifted].away = 0.005;  // without a fold to follow none of them is: x and X could slide
  EXPECT_EQ(rows_of(lifted), (std::vector{RowKind::EolTangent, RowKind::EolTangent}));
  EXPECT_EQ(rows_of(sheet.chain[1]).size(), 3u);
}

}  // namespace
}  // namespace crease
