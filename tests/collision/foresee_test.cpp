// SPDX-License-Identifier: MIT
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <random>
#include <set>
#include <vector>

#include <Eigen/Geometry>

#include "crease/collision/detect.hpp"
#include "support/meshes.hpp"

namespace crease {
namespace {

constexpr double h = 5e-3, depth = 1e-4;

Vec3 point_of(const Cloth& cloth, const Contact& contact, double seconds) {
  Vec3 x = Vec3::Zero();
  for (int k = 0; k < contact.n_vertices; ++k)
    x += contact.weights[k] * (cloth.mesh.x[contact.vertices[k]] + seconds * cloth.v[contact.vertices[k]]);
  return x;
}

/// n . xdot - (n . v - distance / h) of a contact's row, times h: how far the motion breaks it.
double slack_of(const Cloth& cloth, const Contact& contact, const Pose& pose) {
  const Vec3 n = pose.turned(contact.normal, h);
  const Vec3 way = point_of(cloth, contact, h) - point_of(cloth, contact, 0);
  return n.dot(way) - (n.dot(h * contact.velocity) - contact.distance);
}

Cloth sheet(int n = 9) {
  GridOptions options;
  options.cells = {n, n};
  options.pattern = GridPattern::Irregular;
  return make_cloth(make_grid(options));
}

// A tip passes a flat sheet at up to 50 m/s, a quarter of a metre a step, the sheet being at rest or moving along: the
// face that it meets holds the point where the tip's way crosses the plane.
TEST(Foresee, FindsTheFaceThatAFastTipMeets) {
  std::mt19937 rng(7);
  std::uniform_real_distribution<double> unit(0, 1);
  const ObstacleShape tip = make_point({0, 0, 1});
  for (int k = 0; k < 500; ++k) {
    SCOPED_TRACE(k);
    Cloth cloth = sheet();
    const Vec3 drift(20 * unit(rng), 20 * unit(rng), k % 2 == 0 ? 0.0 : 30 * unit(rng));
    for (Vec3& v : cloth.v) v = drift;
    const double speed = 1 + 49 * unit(rng), when = unit(rng);
    const Vec3 relative = Vec3(unit(rng) - 0.5, unit(rng) - 0.5, 1).normalized() * speed;
    const Vec3 met(0.2 + 0.6 * unit(rng), 0.2 + 0.6 * unit(rng), 0);  // on the sheet as it is at the start
    Pose pose;
    pose.velocity = relative + drift;
    pose.position = met - when * h * relative;
    const PosedObstacle nail{&tip, pose};
    const auto contacts = Detector().foresee(cloth, {&nail, 1}, h, depth);
    if ((1 - when) * h * relative.z() < 1.01 * depth || when * h * relative.z() < 1e-9) continue;
    ASSERT_EQ(contacts.size(), 1u);
    EXPECT_EQ(contacts[0].type, ContactType::CornerFace);
    // Looked for a tenth of a millimetre inside, the way crosses that much later.
    EXPECT_LE((point_of(cloth, contacts[0], 0) - met).norm(), 1.5 * depth);
    EXPECT_GT(contacts[0].normal.z(), 1 - 1e-9);
    EXPECT_NEAR(slack_of(cloth, contacts[0], pose), -(1 - when) * h * relative.z(), 1e-9);
  }
}

// A wire rises through a flat sheet and moves aside: what it meets are the mesh edges that its line crosses in the
// plane of the sheet at that moment.
TEST(Foresee, FindsEveryEdgeThatAFastWireMeets) {
  std::mt19937 rng(11);
  std::uniform_real_distribution<double> unit(0, 1);
  const ObstacleShape wire = make_wire({{-0.3, 0, 0}, {0.3, 0, 0}});
  for (int k = 0; k < 200; ++k) {
    SCOPED_TRACE(k);
    const Cloth cloth = sheet();
    const Vec3 velocity(20 * unit(rng) - 10, 20 * unit(rng) - 10, 5 + 45 * unit(rng));
    const double when = 0.1 + 0.8 * unit(rng);
    const Vec3 met(0.5, 0.3 + 0.4 * unit(rng), 0);
    PosedObstacle obstacle{&wire, {}};
    obstacle.pose.velocity = velocity;
    obstacle.pose.position = met - when * h * velocity;
    std::set<int> expected, found;
    for (const int e : cloth.mesh.edges()) {
      const Vec3 &a = cloth.mesh.x[cloth.mesh.from(e)], &b = cloth.mesh.x[cloth.mesh.to(e)];
      if ((a.y() - met.y()) * (b.y() - met.y()) >= 0) continue;
      const double x = a.x() + (met.y() - a.y()) / (b.y() - a.y()) * (b.x() - a.x());
      if (std::abs(x - met.x()) < 0.3 && std::abs(b.y() - a.y()) > 0.036 * (b - a).norm()) expected.insert(e);
    }
    for (const Contact& contact : Detector().foresee(cloth, {&obstacle, 1}, h, depth)) {
      ASSERT_EQ(contact.type, ContactType::EdgeEdge);
      found.insert(contact.halfedge);
      EXPECT_LT(slack_of(cloth, contact, obstacle.pose), -depth);
    }
    // Edges within 2 degrees of the wire's direction have no normal and are left out.
    for (const int e : expected) EXPECT_TRUE(found.contains(e)) << e;
    EXPECT_LE(found.size(), expected.size() + 1);
  }
}

// Random cloths thrown at a box that flies and spins: whatever is foreseen is a row that the motion breaks by more than
// the depth, so that no solution of it can be the same motion.
TEST(Foresee, CutsOffTheMotionThatRunsInto) {
  std::mt19937 rng(3);
  std::normal_distribution<double> normal(0, 1);
  const auto vector = [&](double scale) { return Vec3(scale * Vec3(normal(rng), normal(rng), normal(rng))); };
  const ObstacleShape box = make_box({0.3, 0.4, 0.2});
  int n = 0;
  for (int k = 0; k < 60; ++k) {
    SCOPED_TRACE(k);
    Cloth cloth = sheet();
    for (Vec3& x : cloth.mesh.x) x += vector(2e-3);
    for (Vec3& v : cloth.v) v = vector(3);
    Obstacle obstacle{.name = "box", .shape = box, .start = {}, .motion = {{0, vector(10), vector(20)}}};
    obstacle.start.position = Vec3(0.5, 0.5, -0.13);
    // The mean motion of the step, which takes the pose exactly to its end.
    Pose pose = pose_at(obstacle, 0);
    const Pose end = pose_at(obstacle, h);
    pose.velocity = (end.position - pose.position) / h;
    pose.spin = (end.rotation * pose.rotation.transpose() - Mat3::Identity()) / h;
    const PosedObstacle posed{&box, pose};
    for (const Contact& contact : Detector().foresee(cloth, {&posed, 1}, h, depth)) {
      ++n;
      EXPECT_LT(slack_of(cloth, contact, pose), -0.99 * depth) << static_cast<int>(contact.type);
    }
  }
  EXPECT_GT(n, 500);
}

// What lies on a table and slides on it, or comes down to it exactly, runs into nothing; nor does what lifts off.
TEST(Foresee, LeavesAloneWhatSlidesOrLands) {
  const ObstacleShape table = make_box({0.5, 5, 1});
  PosedObstacle posed{&table, {}};
  posed.pose.position = {0.55, 0.5, -0.5};
  for (const Vec3& v : {Vec3(3, 1, 0), Vec3(0, 0, 0), Vec3(0, 0, 2), Vec3(-2, 0, 1)}) {
    Cloth cloth = sheet();
    for (Vec3& w : cloth.v) w = v;
    EXPECT_TRUE(Detector().foresee(cloth, {&posed, 1}, h, depth).empty()) << v.transpose();
  }
  Cloth landing = sheet();
  for (std::size_t i = 0; i < landing.mesh.x.size(); ++i) {
    landing.mesh.x[i].z() = 0.01;
    landing.v[i].z() = -0.01 / h;
  }
  EXPECT_TRUE(Detector().foresee(landing, {&posed, 1}, h, depth).empty());
}

// An edge of the cloth that is not across the rim at the beginning, but 2 mm deep in it at the end, and at no vertex.
TEST(Foresee, FindsTheEdgeThatCutsARimOnlyAtTheEnd) {
  const ObstacleShape table = make_box({1, 5, 1});
  PosedObstacle posed{&table, {}};
  posed.pose.position = {0.5, 0, -0.5};  // rim along y at x = z = 0
  Cloth cloth =
      make_cloth(Mesh({{0, 0}, {1, 0}, {0, 1}}, {{-0.02, 0, 0.001}, {-0.001, 0.01, 0.02}, {-9, 0, 9}}, {{0, 1, 2}}));
  const Vec3 moved(0.0, 0.01, 0.016);
  cloth.v[1] = (moved + Vec3(0.018, 0, -0.012) - cloth.mesh.x[1]) / h;
  cloth.v[0] = (Vec3(-0.02, 0, -0.01) - cloth.mesh.x[0]) / h;
  ASSERT_TRUE(Detector().detect(cloth, {&posed, 1}, {.threshold = 1e-3}).empty());
  const auto contacts = Detector().foresee(cloth, {&posed, 1}, h, depth);
  ASSERT_FALSE(contacts.empty());
  for (const Contact& contact : contacts) {
    EXPECT_EQ(contact.type, ContactType::EdgeEdge);
    EXPECT_GE(contact.distance, 0);
    EXPECT_LT(slack_of(cloth, contact, posed.pose), -depth);
  }
}

TEST(Foresee, RefusesWhatIsNotFinite) {
  const ObstacleShape tip = make_point({0, 0, 1});
  const PosedObstacle nail{&tip, {}};
  Cloth cloth = sheet();
  EXPECT_THROW(Detector().foresee(cloth, {&nail, 1}, 0, depth), std::invalid_argument);
  EXPECT_THROW(Detector().foresee(cloth, {&nail, 1}, h, -1), std::invalid_argument);
  cloth.v[2].x() = std::numeric_limits<double>::quiet_NaN();
  EXPECT_THROW(Detector().foresee(cloth, {&nail, 1}, h, depth), std::invalid_argument);
}

}  // namespace
}  // namespace crease
