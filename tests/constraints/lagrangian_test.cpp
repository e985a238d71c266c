// SPDX-License-Identifier: MIT
#include "crease/constraints/lagrangian.hpp"

#include <algorithm>
#include <stdexcept>

#include <gtest/gtest.h>
#include <Eigen/Geometry>

#include "crease/collision/detect.hpp"
#include "support/meshes.hpp"

namespace crease {
namespace {

using support::Rng;
using support::uniform;

constexpr double threshold = 1e-3;

/// A box whose edge along y is the y axis, its faces z = 0 (x < 0) and x = 0 (z < 0); turned and moved with the cloth.
struct EdgeScene {
  ObstacleShape shape = make_box({2, 2, 2});
  PosedObstacle obstacle{&shape, {}};
  Cloth cloth;
  Mat3 R = Mat3::Identity();

  explicit EdgeScene(const std::vector<Vec3>& x, const Mat3& turn = Mat3::Identity()) : R(turn) {
    Mesh mesh({{0, 0}, {1, 0}, {1, 1}, {0, 1}}, {x[0], x[1], x[2], x[3]}, {{0, 1, 2}, {0, 2, 3}});
    cloth = make_cloth(std::move(mesh));
    for (Vec3& p : cloth.mesh.x) p = R * p;
    obstacle.pose.position = R * Vec3(-1, 0, -1);
    obstacle.pose.rotation = R;
    obstacle.pose.velocity = {0.1, 0.2, 0.3};
  }
  std::vector<Contact> detected() const { return Detector().detect(cloth, {&obstacle, 1}, {threshold, 0, 0}); }
  std::vector<Contact> asked(LagrangianNormals normals) const {
    return lagrangian_contacts(cloth, detected(), {&obstacle, 1}, normals, threshold);
  }
};

Mat3 turned() {
  return Eigen::AngleAxisd(0.7, Vec3(1, 2, -1).normalized()).toRotationMatrix();
}

// A sheet that leans over the edge at 30 degrees, above it by 4e-4 m along its normal: no vertex is near.
EdgeScene leaning() {
  const Vec3 along(std::cos(M_PI / 6), 0, -std::sin(M_PI / 6)), normal(std::sin(M_PI / 6), 0, std::cos(M_PI / 6));
  const Vec3 at = 4e-4 * normal;
  return EdgeScene({at - 0.3 * along - Vec3(0, 0.2, 0), at + 0.3 * along - Vec3(0, 0.2, 0),
                    at + 0.3 * along + Vec3(0, 0.3, 0), at - 0.3 * along + Vec3(0, 0.3, 0)},
                   turned());
}

TEST(LagrangianContacts, AskAlongTheMeanOfTheNormals) {
  const EdgeScene scene = leaning();
  const auto detected = scene.detected();
  const auto asked = scene.asked(LagrangianNormals::Averaged);
  ASSERT_EQ(asked.size(), detected.size());
  const Vec3 mean = scene.R * Vec3(1, 0, 1).normalized();
  int edges = 0;
  for (std::size_t k = 0; k < asked.size(); ++k) {
    if (asked[k].type != ContactType::EdgeEdge) continue;
    ++edges;
    EXPECT_EQ(asked[k].vertices, detected[k].vertices);
    EXPECT_LE((asked[k].normal - mean).norm(), 1e-14);
    EXPECT_NEAR(asked[k].distance, 4e-4 * std::cos(M_PI / 12), 1e-15) << "15 degrees between the two";
    EXPECT_LE((asked[k].velocity - Vec3(0.1, 0.2, 0.3)).norm(), 1e-15);
  }
  EXPECT_EQ(edges, 3);
}

TEST(LagrangianContacts, AskAlongEveryNormalOfTheCone) {
  const EdgeScene scene = leaning();
  const auto asked = scene.asked(LagrangianNormals::Cone);
  ASSERT_EQ(asked.size(), 6u);
  int top = 0;
  for (const Contact& c : asked) {
    const bool is_top = (c.normal - scene.R * Vec3::UnitZ()).norm() < 1e-14;
    top += is_top;
    EXPECT_LE((c.normal - scene.R * (is_top ? Vec3::UnitZ() : Vec3::UnitX())).norm(), 1e-14);
    EXPECT_NEAR(c.distance, 4e-4 * (is_top ? std::cos(M_PI / 6) : std::sin(M_PI / 6)), 1e-15);
  }
  EXPECT_EQ(top, 3);
}

// Two vertices of a fold on the edge: each asks once, and none of the edges and faces that meet in it.
TEST(LagrangianContacts, OfAVertexThatStandsOnAFeatureAnswerForTheClothThere) {
  for (const double off : {0.0, 1e-4}) {
    SCOPED_TRACE(off);
    EdgeScene scene({{0, 0.1, off}, {0, 0.4, off}, {-0.3, 0.4, 0}, {-0.3, 0.1, 0}}, turned());
    const auto averaged = scene.asked(LagrangianNormals::Averaged), cone = scene.asked(LagrangianNormals::Cone);
    const auto of = [&](const std::vector<Contact>& contacts, int v) {
      return std::count_if(contacts.begin(), contacts.end(),
                           [&](const Contact& c) { return c.n_vertices == 1 && c.vertices[0] == v; });
    };
    for (const int v : {0, 1}) EXPECT_EQ(of(averaged, v), 1) << v;
    for (const int v : {0, 1}) EXPECT_EQ(of(cone, v), 2) << v;
    for (const int v : {2, 3}) EXPECT_EQ(of(cone, v), 1) << "on the top, away from the edge";
    EXPECT_EQ(averaged.size(), 4u);
    EXPECT_EQ(cone.size(), 6u);
    for (const Contact& c : averaged) {
      const Vec3 local = c.vertices[0] < 2 ? Vec3(1, 0, 1).normalized() : Vec3(0, 0, 1);
      EXPECT_LE((c.normal - scene.R * local).norm(), 1e-14);
    }
  }
}

// The corner at (0, 1, 0), its normals x, y, z, under the middle of a face and under a vertex.
TEST(LagrangianContacts, AskTheThreeNormalsOfACorner) {
  for (const bool vertex : {false, true}) {
    SCOPED_TRACE(vertex);
    const Vec3 normal = Vec3(1, 1, 1).normalized(), p = Vec3(1, -1, 0).normalized(), q = normal.cross(p);
    const Vec3 at = Vec3(0, 1, 0) + 1e-4 * normal - (vertex ? Vec3(Vec3::Zero()) : Vec3(0.2 * p + 0.1 * q));
    EdgeScene scene({at, at + 0.6 * p, at + 0.6 * p + 0.6 * q, at + 0.6 * q}, turned());
    const auto asked = scene.asked(LagrangianNormals::Cone);
    std::vector<Contact> corner;
    std::copy_if(asked.begin(), asked.end(), std::back_inserter(corner),
                 [](const Contact& c) { return c.feature.kind == FeatureKind::Corner; });
    ASSERT_EQ(corner.size(), 3u);
    for (const Contact& c : corner) {
      EXPECT_EQ(c.n_vertices, vertex ? 1 : 3);
      EXPECT_NEAR(c.distance, 1e-4 / std::sqrt(3), 1e-15);
    }
    const auto averaged = scene.asked(LagrangianNormals::Averaged);
    const auto found = std::find_if(averaged.begin(), averaged.end(),
                                    [](const Contact& c) { return c.feature.kind == FeatureKind::Corner; });
    ASSERT_NE(found, averaged.end());
    EXPECT_LE((found->normal - scene.R * normal).norm(), 1e-13);
    EXPECT_NEAR(found->distance, 1e-4, 1e-15);
  }
}

// A wire has no normals: the contact stays, but for the gap that tells its side.
TEST(LagrangianContacts, KeepATenthOfTheThresholdToAWire) {
  EdgeScene scene({{-0.3, -0.2, 5e-4}, {0.3, -0.2, 5e-4}, {0.3, 0.3, 5e-4}, {-0.3, 0.3, 5e-4}});
  scene.shape = make_wire({{0, -1, 0}, {0, 1, 0}});
  scene.obstacle.pose.position.setZero();
  const auto detected = scene.detected();
  ASSERT_EQ(detected.size(), 3u);
  for (const LagrangianNormals normals : {LagrangianNormals::Averaged, LagrangianNormals::Cone}) {
    const auto asked = scene.asked(normals);
    ASSERT_EQ(asked.size(), 3u);
    for (std::size_t k = 0; k < 3; ++k) {
      EXPECT_EQ(asked[k].normal, detected[k].normal);
      EXPECT_NEAR(asked[k].distance, 4e-4, 1e-15);
    }
  }
}

// Folded over the wire by 2 x 60 degrees, two vertices of the fold on it: each pushes along the fold's bisector.
TEST(LagrangianContacts, OfAVertexOnAWireAskAlongTheBisectorOfTheFold) {
  for (const double angle : {30.0, 60.0, 85.0}) {
    SCOPED_TRACE(angle);
    const double c = std::cos(angle * M_PI / 180), s = std::sin(angle * M_PI / 180), z = 2e-4;
    EdgeScene scene({{0, 0, 0}, {0, 0, 0}, {0, 0, 0}, {0, 0, 0}});
    scene.shape = make_wire({{0, -1, 0}, {0, 1, 0}});
    scene.obstacle.pose.position.setZero();
    scene.cloth = make_cloth(Mesh({{-1, 0}, {0, 0}, {1, 0}, {-1, 1}, {0, 1}, {1, 1}},
                                  {{-0.3 * c, 0, z - 0.3 * s},
                                   {0, 0, z},
                                   {0.3 * c, 0, z - 0.3 * s},
                                   {-0.3 * c, 0.3, z - 0.3 * s},
                                   {0, 0.3, z},
                                   {0.3 * c, 0.3, z - 0.3 * s}},
                                  {{0, 1, 4}, {0, 4, 3}, {1, 2, 5}, {1, 5, 4}}));
    const auto asked = scene.asked(LagrangianNormals::Averaged);
    ASSERT_EQ(asked.size(), 2u);
    for (const Contact& contact : asked) {
      EXPECT_EQ(contact.n_vertices, 1);
      EXPECT_EQ(contact.vertices[0], &contact == &asked[0] ? 1 : 4);
      EXPECT_LE((contact.normal - Vec3::UnitZ()).norm(), 1e-12);
      EXPECT_NEAR(contact.distance, z - 1e-4, 1e-15);
    }
  }
}

// What conformal remeshing is told: the two on the edge ride on it, joined by its chain; not the corner of the cloth.
TEST(MarkStanding, TagsTheMeshEdgesBetweenVerticesOnAnEdge) {
  EdgeScene scene({{0, 0, 0}, {0, 0, 0}, {0, 0, 0}, {0, 0, 0}});
  Mesh mesh = support::grid(GridPattern::Alternating, 6, 5);
  for (std::size_t i = 0; i < mesh.X.size(); ++i) {  // folded over the edge at X = .6
    const double u = mesh.X[i].x() - 0.6;
    mesh.x[i] = u < 0 ? Vec3(u, mesh.X[i].y() - 0.5, 1e-4) : Vec3(1e-4, mesh.X[i].y() - 0.5, -u);
  }
  scene.cloth = make_cloth(std::move(mesh));
  scene.cloth.pins[3 + 7 * 2] = 1;
  mark_standing(scene.cloth, {&scene.obstacle, 1}, threshold);
  EXPECT_EQ(validate(scene.cloth), std::nullopt);
  int tagged = 0;
  for (const int h : scene.cloth.mesh.edges()) tagged += scene.cloth.mesh.tag(h) != 0;
  EXPECT_EQ(scene.cloth.n_eol(), 5) << "6 on the edge, of which one is pinned";
  EXPECT_EQ(tagged, 3) << "5 edges, of which two end at the pin";
  for (int v = 0; v < scene.cloth.mesh.n_vertices(); ++v)
    if (scene.cloth.is_eol(v)) make_lagrangian(scene.cloth, v);
  for (const int h : scene.cloth.mesh.edges()) EXPECT_EQ(scene.cloth.mesh.tag(h), 0);
}

TEST(LagrangianContacts, RefuseContactsWithObstaclesThatAreNotThere) {
  const EdgeScene scene = leaning();
  const auto detected = scene.detected();
  EXPECT_THROW(lagrangian_contacts(scene.cloth, detected, {}, LagrangianNormals::Cone, threshold),
               std::invalid_argument);
  EXPECT_THROW(lagrangian_contacts(scene.cloth, detected, {&scene.obstacle, 1}, LagrangianNormals::Cone, -1),
               std::invalid_argument);
}

}  // namespace
}  // namespace crease
