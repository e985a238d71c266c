// SPDX-License-Identifier: MIT
// Rows of contacts and pins, and what happens where they meet.
#include <gtest/gtest.h>

#include "constraints/eol_sheet.hpp"

namespace crease {
namespace {

using namespace crease::testing;

constexpr double h = 1e-2;
constexpr double push_out_speed = 0.1;  // the default of ConstraintOptions
constexpr double round_off = 1e-13;     // sums of a handful of terms of size 1

Contact vertex_face(int vertex, const Vec3& normal, double gap, const Vec3& velocity = Vec3::Zero()) {
  Contact contact;
  contact.type = ContactType::VertexFace;
  contact.obstacle = 0;
  contact.n_vertices = 1;
  contact.vertices = {vertex, -1, -1};
  contact.weights = {1, 0, 0};
  contact.normal = normal;
  contact.distance = gap;
  contact.velocity = velocity;
  return contact;
}

/// A plain sheet, all Lagrangian, with vertices 0.. on it.
struct Plain {
  Cloth cloth = make_cloth(make_grid({.cells = {3, 3}, .pattern = GridPattern::Right}));
  DofMap dofs = make_dof_map(cloth);
  ObstacleShape box = make_box({1, 1, 1});
  Pose pose;
  double wire_clearance = 0;
  ConstraintRows rows(const std::vector<Contact>& contacts, const std::vector<PinState>& pins = {}) const {
    ConstraintOptions options;
    options.h = h;
    options.wire_clearance = wire_clearance;
    const std::vector<PosedObstacle> obstacles = {{&box, pose}};
    return build_constraints(cloth, dofs, contacts, obstacles, pins, options);
  }
};

// The mean motion over h of an obstacle that turns by up to a radian in it.
Pose turning(std::mt19937_64& rng) {
  Pose pose{.position = random_vector(rng, 1), .rotation = random_rotation(rng), .velocity = random_vector(rng, 1)};
  const Mat3 turn = Eigen::AngleAxisd(uniform(rng, 0, 1), random_vector(rng, 1).normalized()).toRotationMatrix();
  pose.spin = (turn - Mat3::Identity()) / h;
  return pose;
}

TEST(ContactRows, SlidingOnATurningFaceEndsOnTheFace) {
  std::mt19937_64 rng(29);
  SCOPED_TRACE("seed 29");
  for (int trial = 0; trial < 50; ++trial) {
    Plain plain;
    plain.pose = turning(rng);
    const Vec3 normal = plain.pose.rotation.col(2), x = plain.pose.to_world({0.3, -0.2, 0.5});
    const ConstraintRows rows = plain.rows({vertex_face(5, normal, 0, plain.pose.velocity_at(x))});
    ASSERT_EQ(rows.in.size(), 1u);
    const Vec3 n = rows.in[0].normal, slip = random_vector(rng, 2);
    const Vec3 end = x + h * (rows.b_in[0] * n + slip - n.dot(slip) * n);
    const Pose there{.position = plain.pose.position + h * plain.pose.velocity,
                     .rotation = plain.pose.rotation + h * plain.pose.spin * plain.pose.rotation};
    EXPECT_NEAR(there.to_local(end).z(), 0.5, round_off) << trial;
  }
}

TEST(ContactRows, EachTypeIsOneRowWithTheContactsWeights) {
  std::mt19937_64 rng(17);
  SCOPED_TRACE("seed 17");
  const Plain plain;
  for (int n = 1; n <= 3; ++n) {
    Contact contact = vertex_face(5, random_rotation(rng) * Vec3::UnitX(), 2e-4, random_vector(rng, 1));
    contact.type = n == 1 ? ContactType::VertexFace : n == 2 ? ContactType::EdgeEdge : ContactType::CornerFace;
    contact.n_vertices = n;
    contact.vertices = {7, n > 1 ? 2 : -1, n > 2 ? 4 : -1};
    contact.weights = n == 1   ? std::array{1.0, 0.0, 0.0}
                      : n == 2 ? std::array{0.3, 0.7, 0.0}
                               : std::array{0.2, 0.3, 0.5};
    const ConstraintRows rows = plain.rows({contact});
    ASSERT_EQ(rows.in.size(), 1u);
    EXPECT_TRUE(rows.eq.empty());
    EXPECT_EQ(rows.in[0].kind, RowKind::Contact);
    EXPECT_EQ(rows.in[0].vertex, n == 1 ? 7 : 2) << "the lowest";
    EXPECT_EQ(rows.in[0].feature.obstacle, contact.obstacle) << "also for a face, which is no feature";
    EXPECT_EQ(rows.A_in.nonZeros(), 3 * n);
    for (int i = 0; i < n; ++i) {
      EXPECT_EQ(world_part(rows.A_in, 0, plain.dofs, contact.vertices[i]), contact.weights[i] * contact.normal);
    }
    EXPECT_NEAR(rows.b_in[0], contact.normal.dot(contact.velocity) - contact.distance / h, round_off);
  }
}

TEST(ContactRows, GapEntersSignedAndBounded) {
  const Plain plain;
  for (const double gap : {5e-3, 1e-5, 0.0, -1e-5, -6e-4, -1.0}) {
    const ConstraintRows rows = plain.rows({vertex_face(5, Vec3::UnitZ(), gap)});
    EXPECT_NEAR(rows.b_in[0], std::min(-gap / h, push_out_speed), round_off) << "gap " << gap;
  }
}

TEST(ContactRows, KeepClearOfAWire) {
  Plain plain;
  plain.box = make_wire({Vec3(-1, 0, 0), Vec3(1, 0, 0)});
  plain.wire_clearance = 1e-4;
  for (const double gap : {3e-4, 1e-4, 4e-5}) {
    const ConstraintRows rows = plain.rows({vertex_face(5, Vec3::UnitZ(), gap)});
    ASSERT_EQ(rows.b_in.size(), 1);
    EXPECT_NEAR(rows.b_in[0], (1e-4 - gap) / h, round_off) << gap;  // at the end of the step the gap is 1e-4
  }
}

TEST(ContactRows, VertexWithoutWeightTakesNoPart) {
  const Plain plain;
  Contact contact = vertex_face(5, Vec3::UnitZ(), 0);
  contact.type = ContactType::CornerFace;
  contact.n_vertices = 3;
  contact.vertices = {3, 5, 6};
  contact.weights = {1e-17, 1.0, 0.0};
  const ConstraintRows rows = plain.rows({contact});
  ASSERT_EQ(rows.in.size(), 1u);
  EXPECT_EQ(rows.A_in.nonZeros(), 3);
  EXPECT_EQ(rows.in[0].vertex, 5);
}

// x + h xdot of the contact point must stay outside, so the row is on the mesh velocity: nothing of Xdot enters.
TEST(ContactRows, EolVertexTakesPartWithItsMeshVelocity) {
  const EolSheet sheet = make_eol_sheet(0.4);
  const DofMap dofs = make_dof_map(sheet.cloth);
  const int eol = sheet.chain[1], plain = eol == 0 ? 1 : 0;
  Contact contact = vertex_face(eol, Vec3(0, 0.6, 0.8), 0);
  contact.type = ContactType::EdgeEdge;
  contact.n_vertices = 2;
  contact.vertices = {eol, plain, -1};
  contact.weights = {0.25, 0.75, 0};
  const ConstraintRows rows = sheet.rows({contact, vertex_face(eol, Vec3(0, 1, 0), 0)});
  const std::vector<int> found = rows_of(rows.in, RowKind::Contact);
  ASSERT_EQ(found.size(), 2u);
  for (const int r : found) EXPECT_EQ(material_part(rows.A_in, r, dofs, eol), Vec2(0, 0));
  EXPECT_EQ(rows.A_in.row(found[0]).nonZeros() + rows.A_in.row(found[1]).nonZeros(), 9);
}

TEST(ContactRows, SeveralOnOneVertexAreToldApartBySlot) {
  const Plain plain;
  const ConstraintRows rows = plain.rows(
      {vertex_face(5, Vec3::UnitZ(), 0), vertex_face(5, Vec3::UnitX(), 0), vertex_face(2, Vec3::UnitX(), 0)});
  ASSERT_EQ(rows.in.size(), 3u);
  EXPECT_EQ(rows.in[0].vertex, 2);
  EXPECT_EQ(rows.in[1].slot, 0);
  EXPECT_EQ(rows.in[2].slot, 1);
  EXPECT_EQ(rows.in[1].normal, Vec3(0, 0, 1)) << "order of arrival";
}

TEST(ContactRows, RefusesForeignVerticesAndNaN) {
  const Plain plain;
  EXPECT_THROW((void)plain.rows({vertex_face(99, Vec3::UnitZ(), 0)}), std::invalid_argument);
  EXPECT_THROW((void)plain.rows({vertex_face(1, Vec3::UnitZ(), std::nan(""))}), std::invalid_argument);
  EXPECT_THROW((void)plain.rows({vertex_face(1, Vec3(0, std::nan(""), 1), 0)}), std::invalid_argument);
}

PinState pin(int index, std::array<bool, 3> axes, const Vec3& velocity, bool released = false) {
  return {.index = index, .axes = axes, .velocity = velocity, .released = released};
}

TEST(PinRows, HoldTheirAxesAtTheScriptedVelocity) {
  Plain plain;
  plain.cloth.pins[6] = 1u << 2;
  const ConstraintRows rows =
      plain.rows({}, {pin(2, {true, false, true}, {1, 2, 3}), pin(0, {true, true, true}, {9, 9, 9})});
  ASSERT_EQ(rows.eq.size(), 2u);
  for (int r = 0; r < 2; ++r) {
    const int axis = 2 * r;
    EXPECT_EQ(rows.eq[r].kind, RowKind::Pin);
    EXPECT_EQ(rows.eq[r].slot, axis);
    EXPECT_EQ(world_part(rows.A_eq, r, plain.dofs, 6), Vec3(Vec3::Unit(axis)));
    EXPECT_EQ(rows.b_eq[r], axis + 1);
  }
}

TEST(PinRows, ReleasedPinGivesNoRow) {
  Plain plain;
  plain.cloth.pins[6] = 1;
  EXPECT_TRUE(plain.rows({}, {pin(0, {true, true, true}, {1, 2, 3}, true)}).eq.empty());
  EXPECT_TRUE(plain.rows({}).eq.empty());
}

TEST(PinRows, FirstPinWinsPerAxis) {
  Plain plain;
  plain.cloth.pins[6] = 0b111;
  const ConstraintRows rows =
      plain.rows({}, {pin(1, {true, true, true}, {9, 9, 9}, true), pin(2, {true, false, false}, {1, 1, 1}),
                      pin(0, {true, true, false}, {2, 2, 2})});
  ASSERT_EQ(rows.eq.size(), 2u);
  EXPECT_EQ(rows.b_eq[0], 1);
  EXPECT_EQ(rows.b_eq[1], 2);
}

TEST(PinRows, WinOverInequalitiesTheyWouldContradict) {
  Plain plain;
  plain.cloth.pins[5] = 1;  // held in z
  plain.cloth.pins[6] = 2;  // held in full
  const std::vector<PinState> pins{pin(0, {false, false, true}, Vec3::Zero()),
                                   pin(1, {true, true, true}, Vec3::Zero())};
  const auto n_rows = [&](const Contact& contact) { return plain.rows({contact}, pins).in.size(); };

  EXPECT_EQ(n_rows(vertex_face(5, Vec3::UnitZ(), -1e-3)), 0u) << "normal along the held axis";
  EXPECT_EQ(n_rows(vertex_face(5, Vec3(1e-3, 0, 1).normalized(), -1e-3)), 0u) << "but for a thousandth";
  EXPECT_EQ(n_rows(vertex_face(5, Vec3(0.6, 0, 0.8), -1e-3)), 1u);
  EXPECT_EQ(n_rows(vertex_face(5, Vec3::UnitX(), -1e-3)), 1u);
  EXPECT_EQ(n_rows(vertex_face(6, Vec3(0.6, 0, 0.8), -1e-3)), 0u);

  Contact across = vertex_face(5, Vec3::UnitZ(), -1e-3);
  across.type = ContactType::EdgeEdge;
  across.n_vertices = 2;
  across.weights = {0.5, 0.5, 0};
  across.vertices = {5, 6, -1};
  EXPECT_EQ(n_rows(across), 0u) << "both ends held along the normal";
  across.vertices = {6, 1, -1};
  EXPECT_EQ(n_rows(across), 1u) << "the free end can give way";
}

TEST(PinRows, WinOverTheFeatureOfAnEolVertexButNotOverItsEulerianRow) {
  EolSheet sheet = make_eol_sheet(0.3);
  const int v = sheet.chain[2];
  sheet.cloth.pins[v] = 1;
  const ConstraintRows full = sheet.rows({}, {pin(0, {true, true, true}, Vec3::Zero())});
  EXPECT_TRUE(rows_of(full.in, RowKind::EolNormal, v).empty());
  EXPECT_EQ(rows_of(full.eq, RowKind::EolTangent, v).size(), 1u);
  const ConstraintRows vertical = sheet.rows({}, {pin(0, {false, false, true}, Vec3::Zero())});
  const std::vector<int> left = rows_of(vertical.in, RowKind::EolNormal, v);
  ASSERT_EQ(left.size(), 1u);
  const Vec3 bisector = std::cos(0.15) * sheet.up + std::sin(0.15) * sheet.side;
  EXPECT_LT((vertical.in[left[0]].normal - bisector).norm(), 1e-13) << "the pin leaves 15 % of it free";
  EXPECT_TRUE(rows_of(vertical.eq, RowKind::EolHold, v).empty());
}

}  // namespace
}  // namespace crease
