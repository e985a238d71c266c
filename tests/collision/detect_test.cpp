// SPDX-License-Identifier: MIT
#include "crease/collision/detect.hpp"

#include <cmath>
#include <limits>
#include <map>
#include <set>
#include <stdexcept>
#include <vector>

#include <gtest/gtest.h>
#include <Eigen/Geometry>

#include "support/contact_oracle.hpp"
#include "support/meshes.hpp"

namespace crease {
namespace {

using support::ContactKey;
using support::key_of;
using support::Rng;
using support::uniform;

Vec3 random_point(Rng& rng, double size) {
  return {uniform(rng, -size, size), uniform(rng, -size, size), uniform(rng, -size, size)};
}

Mat3 random_rotation(Rng& rng) {
  return Eigen::AngleAxisd(uniform(rng, 0, M_PI), random_point(rng, 1).normalized()).toRotationMatrix();
}

// A bent, noisy sheet in random motion.
Cloth random_cloth(Rng& rng, double noise = 0.02) {
  Mesh mesh = support::grid(GridPattern::Irregular, 7, 6, rng());
  support::crumple(mesh, rng, noise);
  Cloth cloth = make_cloth(std::move(mesh));
  for (Vec3& v : cloth.v) v = random_point(rng, 1);
  return cloth;
}

// A box that meets the sheet, in random motion.
PosedObstacle random_box(Rng& rng, const ObstacleShape& shape) {
  PosedObstacle box{&shape, {}};
  box.pose.position = Vec3(uniform(rng, 0, 1.5), uniform(rng, 0, 1), uniform(rng, -0.4, 0.4));
  box.pose.rotation = random_rotation(rng);
  box.pose.velocity = random_point(rng, 1);
  box.pose.spin = cross_matrix(random_point(rng, 3));
  return box;
}

ObstacleShape random_shape(Rng& rng) {
  return make_box({uniform(rng, 0.02, 0.8), uniform(rng, 0.02, 0.8), uniform(rng, 0.02, 0.8)});
}

std::map<ContactKey, Contact> by_key(const std::vector<Contact>& contacts) {
  std::map<ContactKey, Contact> found;
  for (const Contact& c : contacts) EXPECT_TRUE(found.emplace(key_of(c), c).second) << "duplicate";
  return found;
}

void expect_well_formed(const Contact& c, const Cloth& cloth, const PosedObstacle& obstacle) {
  const int n = c.type == ContactType::VertexFace ? 1 : c.type == ContactType::EdgeEdge ? 2 : 3;
  ASSERT_EQ(c.n_vertices, n);
  Vec3 point = Vec3::Zero();
  double sum = 0;
  for (int k = 0; k < n; ++k) {
    point += c.weights[k] * cloth.mesh.x[c.vertices[k]];
    sum += c.weights[k];
    EXPECT_GE(c.weights[k], 0);
  }
  EXPECT_NEAR(sum, 1, 1e-14);
  EXPECT_NEAR(c.normal.norm(), 1, 1e-12);
  // The three say the same: the cloth's point stands off the obstacle's point by the distance along the normal.
  EXPECT_LE((point - c.point - c.distance * c.normal).norm(), 1e-9);
  EXPECT_LE((c.velocity - obstacle.pose.velocity_at(c.point)).norm(), 1e-14);
  EXPECT_NEAR(*signed_distance(*obstacle.shape, obstacle.pose, c.point), 0, 1e-9) << "point off the surface";
  if (c.type == ContactType::EdgeEdge) {
    EXPECT_EQ(c.halfedge, cloth.mesh.edge_of(c.halfedge));
    EXPECT_EQ(c.vertices[0], cloth.mesh.from(c.halfedge));
    EXPECT_EQ(c.vertices[1], cloth.mesh.to(c.halfedge));
    EXPECT_EQ(c.feature.kind, FeatureKind::Edge);
  } else if (c.type == ContactType::CornerFace) {
    EXPECT_EQ(c.vertices, cloth.mesh.face(c.face));
    EXPECT_EQ(c.feature.kind, FeatureKind::Corner);
  } else {
    EXPECT_EQ(c.feature, FeatureId{});
  }
}

TEST(Detect, FindsExactlyTheContactsOfBruteForce) {
  std::map<int, int> count;
  int penetrating = 0;
  for (std::uint64_t seed = 1; seed <= 150; ++seed) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    Rng rng(seed);
    Cloth cloth = random_cloth(rng);
    const ObstacleShape a = random_shape(rng), b = random_shape(rng);
    const std::vector<PosedObstacle> boxes{random_box(rng, a), random_box(rng, b)};
    // A few vertices ride on features, wherever they are: what matters is what the detector leaves out for it.
    for (int i = 0; i < 6; ++i) {
      const bool corner = support::pick(rng, 2) == 0;
      cloth.feature[support::pick(rng, cloth.mesh.n_vertices())] = {
          support::pick(rng, 2), corner ? FeatureKind::Corner : FeatureKind::Edge, support::pick(rng, corner ? 8 : 12)};
    }
    const DetectOptions options{uniform(rng, 0.0, 0.05), uniform(rng, 0.0, 0.05)};
    Detector detector;
    const auto found = by_key(detector.detect(cloth, boxes, options));
    std::map<ContactKey, double> expected;
    for (int o = 0; o < 2; ++o) expected.merge(support::BoxOracle(cloth, boxes[o], o, options).contacts());
    for (const auto& [key, contact] : found) {
      expect_well_formed(contact, cloth, boxes[key.obstacle]);
      ASSERT_TRUE(expected.count(key)) << "type " << key.type << " feature " << key.feature << " cloth " << key.cloth
                                       << " distance " << contact.distance;
      EXPECT_NEAR(contact.distance, expected[key], 1e-9);
      ++count[key.type];
      penetrating += key.type > 0 && contact.distance < 0;
    }
    for (const auto& [key, distance] : expected) {
      ASSERT_TRUE(found.count(key)) << "type " << key.type << " feature " << key.feature << " cloth " << key.cloth
                                    << " distance " << distance;
    }
  }
  // The comparison means something only if every type occurs, on both sides of zero.
  EXPECT_GT(count[0], 1000);
  EXPECT_GT(count[1], 100);
  EXPECT_GT(count[2], 10);
  EXPECT_GT(penetrating, 50);
}

TEST(Detect, GivesTheSameBytesAfterRefitRebuildAndFromANewDetector) {
  for (std::uint64_t seed = 1; seed <= 10; ++seed) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    Rng rng(seed);
    const ObstacleShape shape = random_shape(rng);
    const DetectOptions options{0.03, 0.01};
    Detector kept;
    Cloth cloth = random_cloth(rng);
    for (int step = 0; step < 20; ++step) {
      for (Vec3& x : cloth.mesh.x) x += random_point(rng, 0.05);
      if (step % 8 == 7) {  // other faces: rebuilt
        const int h = cloth.mesh.edges()[5];
        cloth.mesh.split(h, 0.5);
        cloth = make_cloth(cloth.mesh);
      }
      const PosedObstacle box = random_box(rng, shape);
      const auto a = kept.detect(cloth, {&box, 1}, options), b = Detector().detect(cloth, {&box, 1}, options);
      ASSERT_EQ(a.size(), b.size());
      for (std::size_t i = 0; i < a.size(); ++i) {
        EXPECT_EQ(key_of(a[i]), key_of(b[i]));
        EXPECT_EQ(a[i].distance, b[i].distance);
        EXPECT_EQ(a[i].normal, b[i].normal);
        EXPECT_EQ(a[i].point, b[i].point);
        EXPECT_EQ(a[i].weights, b[i].weights);
      }
    }
  }
}

TEST(Detect, OrdersByObstacleTypeFeatureAndClothWithoutDuplicates) {
  SCOPED_TRACE("seed 5");
  Rng rng(5);
  const Cloth cloth = random_cloth(rng);
  const ObstacleShape shape = make_box({0.5, 0.6, 0.4});
  const std::vector<PosedObstacle> boxes{random_box(rng, shape), random_box(rng, shape), random_box(rng, shape)};
  const auto contacts = Detector().detect(cloth, boxes, {0.1, 0});
  ASSERT_GT(contacts.size(), 20u);
  for (std::size_t i = 1; i < contacts.size(); ++i) EXPECT_LT(key_of(contacts[i - 1]), key_of(contacts[i]));
}

TEST(Detect, TurnsWithTheScene) {
  for (std::uint64_t seed = 1; seed <= 20; ++seed) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    Rng rng(seed);
    const Cloth cloth = random_cloth(rng);
    const ObstacleShape shape = random_shape(rng);
    const PosedObstacle box = random_box(rng, shape);
    const DetectOptions options{0.03, 0.02};
    const auto contacts = Detector().detect(cloth, {&box, 1}, options);
    const Mat3 R = random_rotation(rng);
    const Vec3 shift = random_point(rng, 1);
    Cloth turned = cloth;
    for (Vec3& x : turned.mesh.x) x = R * x + shift;
    for (Vec3& v : turned.v) v = R * v;
    const PosedObstacle turned_box{&shape,
                                   {R * box.pose.position + shift, R * box.pose.rotation, R * box.pose.velocity,
                                    R * box.pose.spin * R.transpose()}};
    const auto rotated = Detector().detect(turned, {&turned_box, 1}, options);
    ASSERT_EQ(contacts.size(), rotated.size());
    for (std::size_t i = 0; i < contacts.size(); ++i) {
      EXPECT_EQ(key_of(contacts[i]), key_of(rotated[i]));
      EXPECT_NEAR(contacts[i].distance, rotated[i].distance, 1e-12);
      EXPECT_LE((R * contacts[i].normal - rotated[i].normal).norm(), 1e-9);
      EXPECT_LE((R * contacts[i].velocity - rotated[i].velocity).norm(), 1e-9);
    }
  }
}

// The same sheet with every triangle's order reversed: its own normal says the opposite, the obstacle's does not.
TEST(Detect, TakesItsSignsFromTheObstacleNotFromTheCloth) {
  for (std::uint64_t seed = 1; seed <= 20; ++seed) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    Rng rng(seed);
    const Cloth cloth = random_cloth(rng);
    std::vector<Vec2> X = cloth.mesh.X;
    for (Vec2& P : X) P.x() = -P.x();
    std::vector<std::array<int, 3>> faces;
    for (int f = 0; f < cloth.mesh.n_faces(); ++f) {
      const auto& [a, b, c] = cloth.mesh.face(f);
      faces.push_back({a, c, b});
    }
    Cloth flipped = make_cloth(Mesh(X, cloth.mesh.x, faces));
    flipped.v = cloth.v;
    const ObstacleShape shape = random_shape(rng);
    const PosedObstacle box = random_box(rng, shape);
    const DetectOptions options{0.03, 0.01};
    const auto a = Detector().detect(cloth, {&box, 1}, options), b = Detector().detect(flipped, {&box, 1}, options);
    ASSERT_EQ(a.size(), b.size());
    // Half-edges have other numbers: compare the sets of (type, feature, cloth vertices).
    const auto place_of = [](const Contact& c) {
      std::vector<int> vertices(c.vertices.begin(), c.vertices.begin() + c.n_vertices);
      std::sort(vertices.begin(), vertices.end());
      return std::tuple(c.type, c.feature.index, vertices);
    };
    std::map<std::tuple<ContactType, int, std::vector<int>>, Contact> there;
    for (const Contact& c : b) there.emplace(place_of(c), c);
    for (const Contact& c : a) {
      ASSERT_TRUE(there.count(place_of(c)));
      const Contact& d = there.at(place_of(c));
      EXPECT_LE((c.normal - d.normal).norm(), 1e-9);
      EXPECT_NEAR(c.distance, d.distance, 1e-12);
    }
  }
}

// A box rising at 1 m/s under a sheet at rest 4 mm above it: out of reach without look-ahead, in reach with 5 ms of it;
// a sheet that rises with the box stays out of reach.
TEST(Detect, LooksAheadByTheRelativeMotion) {
  GridOptions grid;
  grid.cells = {4, 4};
  Cloth cloth = make_cloth(make_grid(grid));
  const ObstacleShape shape = make_box({3, 3, 1});
  PosedObstacle box{&shape, {}};
  box.pose.position = {0.5, 0.5, -0.504};
  box.pose.velocity = {0, 0, 1};
  EXPECT_TRUE(Detector().detect(cloth, {&box, 1}, {1e-3, 0}).empty());
  EXPECT_EQ(Detector().detect(cloth, {&box, 1}, {1e-3, 0.005}).size(), cloth.mesh.X.size());
  for (Vec3& v : cloth.v) v = {0, 0, 1};
  EXPECT_TRUE(Detector().detect(cloth, {&box, 1}, {1e-3, 0.005}).empty());
}

TEST(Detect, GivesTheVelocityOfATurningObstacleAtThePoint) {
  GridOptions grid;
  grid.cells = {4, 4};
  const Cloth cloth = make_cloth(make_grid(grid));
  const ObstacleShape shape = make_box({3, 3, 1});
  PosedObstacle box{&shape, {}};
  box.pose.position = {0.5, 0.5, -0.5};
  box.pose.velocity = {0, 0, 0.5};
  box.pose.spin = cross_matrix({0, 2, 0});
  const auto contacts = Detector().detect(cloth, {&box, 1}, {});
  ASSERT_EQ(contacts.size(), cloth.mesh.X.size());
  for (const Contact& c : contacts) {
    // omega x r with r = (x - 1/2, y - 1/2, 1/2): the top runs along x, and tips down where x > 1/2.
    EXPECT_LE((c.velocity - Vec3(1, 0, 0.5 - 2 * (c.point.x() - 0.5))).norm(), 1e-14);
  }
}

TEST(Detect, LeavesOutRemovedSlotsOfTheMesh) {
  Mesh mesh = support::grid(GridPattern::Irregular, 6, 6, 3);
  for (const int h : mesh.edges()) {
    if (!mesh.can_collapse(h)) continue;
    mesh.collapse(h);
    break;
  }
  ASSERT_FALSE(mesh.is_compact());
  const Cloth cloth = make_cloth(mesh);
  const ObstacleShape shape = make_box({5, 5, 1});
  PosedObstacle box{&shape, {}};
  box.pose.position.z() = -0.5;
  EXPECT_EQ(static_cast<int>(Detector().detect(cloth, {&box, 1}, {}).size()), mesh.n_vertices());
}

TEST(Detect, RefusesInputThatMakesNoSense) {
  Cloth cloth = make_cloth(support::grid(GridPattern::Right));
  const ObstacleShape shape = make_box({1, 1, 1});
  const PosedObstacle box{&shape, {}}, nothing{};
  Detector detector;
  EXPECT_THROW(detector.detect(cloth, {&box, 1}, {-1, 0}), std::invalid_argument);
  EXPECT_THROW(detector.detect(cloth, {&box, 1}, {1e-3, std::nan("")}), std::invalid_argument);
  EXPECT_THROW(detector.detect(cloth, {&nothing, 1}, {}), std::invalid_argument);
  cloth.mesh.x[3].y() = std::numeric_limits<double>::quiet_NaN();
  EXPECT_THROW(detector.detect(cloth, {&box, 1}, {}), std::invalid_argument);
  EXPECT_TRUE(detector.detect(make_cloth(support::grid(GridPattern::Right)), {}, {}).empty());
}

}  // namespace
}  // namespace crease
