// SPDX-License-Identifier: MIT
//
// Triangle meshes as obstacles: a box and its mesh must be told apart by nobody.
#include <algorithm>
#include <cmath>
#include <numbers>
#include <vector>

#include <gtest/gtest.h>
#include <Eigen/Geometry>

#include "crease/collision/detect.hpp"
#include "crease/collision/separation.hpp"
#include "support/meshes.hpp"
#include "support/surfaces.hpp"

namespace crease {
namespace {

using support::Rng;
using support::uniform;

constexpr double degree = std::numbers::pi / 180;

Vec3 random_point(Rng& rng, double size) {
  return {uniform(rng, -size, size), uniform(rng, -size, size), uniform(rng, -size, size)};
}

Cloth random_cloth(Rng& rng) {
  Mesh mesh = support::grid(GridPattern::Irregular, 7, 6, rng());
  support::crumple(mesh, rng, 0.02);
  Cloth cloth = make_cloth(std::move(mesh));
  for (Vec3& v : cloth.v) v = random_point(rng, 1);
  return cloth;
}

Pose random_pose(Rng& rng) {
  Pose pose;
  pose.position = Vec3(uniform(rng, 0, 1.5), uniform(rng, 0, 1), uniform(rng, -0.4, 0.4));
  pose.rotation = Eigen::AngleAxisd(uniform(rng, 0, M_PI), random_point(rng, 1).normalized());
  pose.velocity = random_point(rng, 1);
  pose.spin = cross_matrix(random_point(rng, 3));
  return pose;
}

/// The feature of `to` at the place of one of `from`.
FeatureId translate(const FeatureId& id, const ObstacleShape& from, const ObstacleShape& to) {
  FeatureId found = id;
  found.index = -1;
  if (id.kind == FeatureKind::Corner) {
    for (std::size_t c = 0; c < to.corners.size(); ++c)
      if (to.corners[c].position == from.corners[id.index].position) found.index = static_cast<int>(c);
  } else if (id.kind == FeatureKind::Edge) {
    const SharpEdge& edge = from.edges[id.index];
    for (std::size_t e = 0; e < to.edges.size(); ++e)
      if ((to.edges[e].a == edge.a && to.edges[e].b == edge.b) || (to.edges[e].a == edge.b && to.edges[e].b == edge.a))
        found.index = static_cast<int>(e);
  }
  return found;
}

int cloth_index(const Contact& c) {
  return c.type == ContactType::VertexFace ? c.vertices[0] : c.type == ContactType::EdgeEdge ? c.halfedge : c.face;
}

/// By place, so that lists with different numbers of features can be compared.
void sort_by_place(std::vector<Contact>& contacts, const ObstacleShape& from, const ObstacleShape& to) {
  for (Contact& c : contacts)
    if (c.type != ContactType::VertexFace) c.feature = translate(c.feature, from, to);
  std::sort(contacts.begin(), contacts.end(), [](const Contact& a, const Contact& b) {
    return std::tuple(a.type, a.feature.index, cloth_index(a)) < std::tuple(b.type, b.feature.index, cloth_index(b));
  });
}

// Hundreds of cloths, penetrating and at rest on the rims, some of their vertices riding on features.
TEST(MeshObstacle, HasTheContactsOfTheBoxItDescribes) {
  SCOPED_TRACE("seed 1");
  Rng rng(1);
  std::array<int, 3> seen{};
  for (int round = 0; round < 400; ++round) {
    const Vec3 size(uniform(rng, 0.02, 0.8), uniform(rng, 0.02, 0.8), uniform(rng, 0.02, 0.8));
    const ObstacleShape box = make_box(size);
    TriangleSurface surface = support::box_surface(size);
    if (round % 2 == 1) surface = support::quartered(surface);
    const ObstacleShape mesh = make_mesh(surface, 30 * degree);
    const Pose pose = random_pose(rng);
    Cloth cloth = random_cloth(rng);
    for (int i = 0; i < 6; ++i) {  // exactly on faces, edges and corners
      const int v = support::pick(rng, cloth.mesh.n_vertices());
      Vec3 p = 0.5 * size.cwiseProduct(random_point(rng, 1));
      for (int axis = 0; axis <= i % 3; ++axis) p[axis] = std::copysign(0.5 * size[axis], p[axis]);
      cloth.mesh.x[v] = pose.to_world(p);
    }
    Cloth other = cloth;
    for (int i = 0; i < 4; ++i) {
      const int v = support::pick(rng, cloth.mesh.n_vertices());
      const FeatureId id{0, i % 2 == 0 ? FeatureKind::Edge : FeatureKind::Corner, support::pick(rng, 8)};
      cloth.feature[v] = id;
      other.feature[v] = translate(id, box, mesh);
    }
    const DetectOptions options{1e-3, round % 3 == 0 ? 0.0 : 0.01, 0};
    const PosedObstacle posed_box{&box, pose}, posed_mesh{&mesh, pose};
    auto a = Detector().detect(cloth, {&posed_box, 1}, options);
    auto b = Detector().detect(other, {&posed_mesh, 1}, options);
    ASSERT_EQ(a.size(), b.size()) << round;
    sort_by_place(a, box, box);
    sort_by_place(b, mesh, box);
    for (std::size_t k = 0; k < a.size(); ++k) {
      ++seen[static_cast<std::size_t>(a[k].type)];
      ASSERT_EQ(a[k].type, b[k].type);
      ASSERT_EQ(a[k].feature, b[k].feature);
      ASSERT_EQ(cloth_index(a[k]), cloth_index(b[k]));
      EXPECT_NEAR(a[k].distance, b[k].distance, 1e-14);
      EXPECT_LE((a[k].point - b[k].point).norm(), 1e-13);
      EXPECT_LE((a[k].velocity - b[k].velocity).norm(), 1e-12);
      // A direction from a rim to a point 1e-9 m away at the least, coordinates of a metre: 1e-16 / 1e-9.
      EXPECT_LE((a[k].normal - b[k].normal).norm(), 1e-6);
      for (int i = 0; i < 3; ++i) EXPECT_NEAR(a[k].weights[i], b[k].weights[i], 1e-12);
    }
  }
  for (const int n : seen) EXPECT_GT(n, 1000);
}

TEST(MeshObstacle, HasThePenetrationOfTheBoxItDescribes) {
  SCOPED_TRACE("seed 2");
  Rng rng(2);
  for (int round = 0; round < 50; ++round) {
    const Vec3 size(0.4, 0.8, 0.3);
    const ObstacleShape box = make_box(size), mesh = make_mesh(support::quartered(support::box_surface(size)), 0.5);
    const Pose pose = random_pose(rng);
    const Cloth cloth = random_cloth(rng);
    const PosedObstacle a{&box, pose}, b{&mesh, pose};
    EXPECT_NEAR(max_penetration(cloth, {&a, 1}), max_penetration(cloth, {&b, 1}), 1e-14);
  }
}

// A cloth edge across a ridge of any angle, as in the cross section: over it by `gap`, leaning by up to half of what
// the ridge bends.
TEST(MeshObstacle, MeetsClothAcrossRidgesOfTwentyToHundredAndFiftyDegrees) {
  SCOPED_TRACE("seed 3");
  Rng rng(3);
  for (const double angle : {20, 45, 60, 90, 120, 149}) {
    SCOPED_TRACE(angle);
    const ObstacleShape ridge = make_mesh(support::ridge_surface(angle * degree, 4, 2), 30 * degree);
    const auto top = std::find_if(ridge.edges.begin(), ridge.edges.end(),
                                  [](const SharpEdge& e) { return e.a.tail<2>().isZero() && e.b.tail<2>().isZero(); });
    ASSERT_NE(top, ridge.edges.end());
    const int index = static_cast<int>(top - ridge.edges.begin());
    for (int i = 0; i < 200; ++i) {
      const double lean = uniform(rng, -0.95, 0.95) * (90 - angle / 2) * degree, gap = uniform(rng, -9e-4, 9e-4);
      const Vec3 normal(0, -std::sin(lean), std::cos(lean)), along(0, std::cos(lean), std::sin(lean));
      const Vec3 across = (along + uniform(rng, -0.5, 0.5) * Vec3::UnitX()).normalized();
      const Vec3 at = Vec3(uniform(rng, -0.5, 0.5), 0, 0) + gap * normal;
      Pose pose;
      pose.position = random_point(rng, 1);
      pose.rotation = Eigen::AngleAxisd(uniform(rng, 0, M_PI), random_point(rng, 1).normalized());
      const auto world = [&](const Vec3& p) { return pose.to_world(p); };
      // Borders of a triangle: its edge 0-1 lies across the ridge.
      const Cloth cloth = make_cloth(
          Mesh({{0, 0}, {1, 0}, {0, 1}},
               {world(at - 0.3 * across), world(at + 0.4 * across), world(at - 0.3 * across + 0.3 * Vec3::UnitX())},
               {{0, 1, 2}}));
      const PosedObstacle posed{&ridge, pose};
      const auto contacts = Detector().detect(cloth, {&posed, 1}, {1e-3, 0, 0});
      const auto found = std::find_if(contacts.begin(), contacts.end(), [&](const Contact& c) {
        return c.feature == FeatureId{0, FeatureKind::Edge, index} && c.halfedge == cloth.mesh.edge_of(0);
      });
      ASSERT_NE(found, contacts.end());
      EXPECT_NEAR(found->distance, gap, 1e-12);
      EXPECT_LE((found->normal - pose.rotation * normal).norm(), 1e-12);
    }
  }
}

// An edge that is too blunt to be a feature holds up the cloth across it as the same edge does where it is one. What a
// coarse cloth bends round would else be seen at its vertices only.
TEST(MeshObstacle, MeetsClothAcrossABluntEdgeAsAcrossASharpOne) {
  SCOPED_TRACE("seed 5");
  Rng rng(5);
  for (const double angle : {151, 165, 178}) {
    SCOPED_TRACE(angle);
    const auto surface = support::quartered(support::ridge_surface(angle * degree, 4, 2));
    const ObstacleShape blunt = make_mesh(surface, 30 * degree), sharp = make_mesh(surface, 1 * degree);
    ASSERT_EQ(blunt.edges.size() + 1, sharp.edges.size());
    for (int i = 0; i < 200; ++i) {
      const double lean = uniform(rng, -0.95, 0.95) * (90 - angle / 2) * degree, gap = uniform(rng, -9e-4, 9e-4);
      const Vec3 normal(0, -std::sin(lean), std::cos(lean)), along(0, std::cos(lean), std::sin(lean));
      const Vec3 at = Vec3(uniform(rng, -0.5, 0.5), 0, 0) + gap * normal;
      const Cloth cloth =
          make_cloth(Mesh({{0, 0}, {1, 0}, {0, 1}},
                          {at - 0.3 * along, at + 0.4 * along, at - 0.3 * along + 0.3 * Vec3::UnitX()}, {{0, 1, 2}}));
      const auto across = [&](const ObstacleShape& shape, FeatureKind kind) {
        const PosedObstacle posed{&shape, {}};
        const auto contacts = Detector().detect(cloth, {&posed, 1}, {1e-3, 0, 0});
        const auto found = std::find_if(contacts.begin(), contacts.end(), [&](const Contact& c) {
          return c.type == ContactType::EdgeEdge && c.feature.kind == kind && c.halfedge == cloth.mesh.edge_of(0);
        });
        return found == contacts.end() ? Contact{} : *found;
      };
      const Contact one = across(blunt, FeatureKind::None), other = across(sharp, FeatureKind::Edge);
      ASSERT_EQ(one.n_vertices, 2);
      EXPECT_EQ(one.vertices, other.vertices);
      EXPECT_NEAR(one.distance, gap, 1e-12);
      EXPECT_NEAR(one.distance, other.distance, 1e-12);
      EXPECT_LE((one.normal - normal).norm(), 1e-12);
    }
  }
}

// The vertex at one end of the cloth edge rides on a sharp edge 0.1 mm from the blunt one: its rows keep the cloth out.
TEST(MeshObstacle, LeavesABluntEdgeToAVertexThatRidesBesideIt) {
  // Sharp at the origin (90 degrees), blunt at the other corners of the upper side.
  const auto surface =
      support::prism_surface({{0, 0}, {-1, 0}, {-1, -1}, {1e-4, -1}, {1e-4, -1e-4 / std::tan(0.2)}}, 4);
  const ObstacleShape shape = make_mesh(surface, 30 * degree);
  ASSERT_EQ(shape.blunt_edges.size(), 1u);
  int ridge = -1;
  for (std::size_t e = 0; e < shape.edges.size(); ++e)
    if (shape.edges[e].a.tail<2>().isZero() && shape.edges[e].b.tail<2>().isZero()) ridge = static_cast<int>(e);
  ASSERT_GE(ridge, 0);
  const PosedObstacle posed{&shape, {}};
  Cloth cloth = make_cloth(Mesh({{0, 0}, {1, 0}, {0, 1}}, {{0, 0, 0}, {0, 0.01, -0.1}, {0.3, 0, 0}}, {{0, 1, 2}}));
  const auto has_blunt = [&] {
    const auto contacts = Detector().detect(cloth, {&posed, 1}, {1e-3, 0, 0});
    return std::any_of(contacts.begin(), contacts.end(), [&](const Contact& c) {
      return c.type == ContactType::EdgeEdge && c.feature.kind == FeatureKind::None &&
             c.halfedge == cloth.mesh.edge_of(0);
    });
  };
  EXPECT_TRUE(has_blunt());
  cloth.feature[0] = {0, FeatureKind::Edge, ridge};
  EXPECT_FALSE(has_blunt());
}

// As TriangleDistance.IsTheSmallestGapOfAllContacts does for boxes: FCL, every triangle of the mesh one by one.
TEST(MeshObstacle, HasNoContactNearerThanTheWholeTriangle) {
  SCOPED_TRACE("seed 4");
  Rng rng(4);
  for (const auto& [name, surface] : support::all_surfaces()) {
    SCOPED_TRACE(name);
    const ObstacleShape shape = make_mesh(surface, 1 * degree);  // every edge that bends outwards is a feature
    int apart = 0, equal = 0;
    for (int i = 0; i < 4000; ++i) {
      const Vec3 centre = random_point(rng, 1.2);
      std::array<Vec3, 3> x{centre, centre, centre};
      for (Vec3& p : x) p += random_point(rng, 0.3);
      const PosedObstacle obstacle{&shape, {}};
      const double distance = triangle_distance(x, obstacle).value();
      if (distance == 0) continue;
      const Cloth cloth = make_cloth(Mesh({{0, 0}, {1, 0}, {0, 1}}, {x[0], x[1], x[2]}, {{0, 1, 2}}));
      double smallest = 1e9;
      // What is farther behind an edge than the threshold does not count: less than the solids are thick.
      for (const Contact& c : Detector().detect(cloth, {&obstacle, 1}, {0.1, 0}))
        smallest = std::min(smallest, c.distance);
      if (distance > 0.1) continue;
      EXPECT_GE(smallest, distance - 1e-9);
      ++apart;
      equal += smallest < distance + 1e-9;
    }
    EXPECT_GT(apart, 100);
    EXPECT_GT(equal, 0.8 * apart) << "but for corners at the rim of the triangle";
  }
}

// The groove of l_surface() is along x at y = z = 0: a vertex in it is kept off both of its sides.
TEST(MeshObstacle, HoldsAVertexInAGrooveOffBothSides) {
  const ObstacleShape l = make_mesh(support::l_surface(), 30 * degree);
  const PosedObstacle obstacle{&l, {}};
  Cloth cloth =
      make_cloth(Mesh({{0, 0}, {1, 0}, {0, 1}}, {{0, 4e-4, 6e-4}, {0.2, 0.3, 0.3}, {-0.2, 0.3, 0.3}}, {{0, 1, 2}}));
  const auto contacts = Detector().detect(cloth, {&obstacle, 1}, {1e-3, 0, 0});
  ASSERT_EQ(contacts.size(), 2u);
  for (const Contact& c : contacts) {
    EXPECT_EQ(c.vertices[0], 0);
    EXPECT_NEAR(c.distance, c.normal.y() > 0.5 ? 4e-4 : 6e-4, 1e-15);
  }
  EXPECT_NEAR(contacts[0].normal.dot(contacts[1].normal), 0, 1e-15);
}

// A vertex that rides on the L's upper edge is held there by its own normals; the other arm of the L is still in its
// way.
TEST(MeshObstacle, KeepsARidingVertexOffTheRestOfItsOwnSurface) {
  const ObstacleShape l = make_mesh(support::l_surface(), 30 * degree);
  const PosedObstacle obstacle{&l, {}};
  const Vec3 at(0, 1, 0);  // edge of the lower arm: along x at y = 1, z = 0; the vertex hovers over it a little
  int edge = -1;
  for (std::size_t e = 0; e < l.edges.size(); ++e)
    if ((l.edges[e].a - l.edges[e].b).normalized().cross(Vec3::UnitX()).norm() < 1e-9 &&
        (l.edges[e].a - at).tail<2>().norm() < 1e-9)
      edge = static_cast<int>(e);
  ASSERT_GE(edge, 0);
  Cloth cloth = make_cloth(
      Mesh({{0, 0}, {1, 0}, {0, 1}}, {at + Vec3(0, 0, 1e-4), {0.2, 1.3, 0.3}, {-0.2, 1.3, 0.3}}, {{0, 1, 2}}));
  cloth.feature[0] = {0, FeatureKind::Edge, edge};
  EXPECT_TRUE(Detector().detect(cloth, {&obstacle, 1}, {1e-3, 0, 0}).empty());
  const auto far = Detector().detect(cloth, {&obstacle, 1}, {1.01, 0, 0});
  const auto found =
      std::find_if(far.begin(), far.end(), [](const Contact& c) { return c.vertices[0] == 0 && c.n_vertices == 1; });
  ASSERT_NE(found, far.end());
  EXPECT_NEAR(found->distance, 1, 1e-12);
  EXPECT_LE((found->normal - Vec3::UnitY()).norm(), 1e-12);
}

}  // namespace
}  // namespace crease
