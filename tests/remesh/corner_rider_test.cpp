// SPDX-License-Identifier: MIT
//
// How many vertices may ride on one corner: one a layer of cloth; and that one does where a side of a face is near.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "crease/collision/detect.hpp"
#include "crease/geometry/grid.hpp"
#include "crease/remesh/remesh.hpp"

namespace crease {
namespace {

int vertex_at(const Cloth& cloth, const Vec2& X) {
  for (int v = 0; v < cloth.mesh.n_vertices(); ++v)
    if ((cloth.mesh.X[v] - X).norm() < 1e-9) return v;
  return Mesh::none;
}

int n_riders(const Cloth& cloth) {
  return static_cast<int>(std::count_if(cloth.feature.begin(), cloth.feature.end(),
                                        [](const FeatureId& id) { return id.kind == FeatureKind::Corner; }));
}

/// The unit square with vertices .1 m apart, and in the middle of every cell.
Cloth sheet() {
  return make_cloth(make_grid({.size = {1, 1}, .cells = {10, 10}}));
}

struct Nail {
  ObstacleShape shape = make_point({0, 0, 1});
  PosedObstacle posed;
  explicit Nail(const Vec3& tip) : posed{&shape, {}} { posed.pose.position = tip; }
};

/// The tip meets the face round its place on the flat sheet, just above it.
Contact tip_at_face(const Cloth& cloth, const Vec2& X) {
  Contact contact{.type = ContactType::CornerFace, .obstacle = 0, .feature = {0, FeatureKind::Corner, 0}};
  for (int f = 0; f < cloth.mesh.n_faces(); ++f) {
    const auto [i, j, k] = cloth.mesh.face(f);
    const Vec2 a = cloth.mesh.X[i] - X, b = cloth.mesh.X[j] - X, c = cloth.mesh.X[k] - X;
    const auto cross = [](const Vec2& p, const Vec2& q) { return p.x() * q.y() - p.y() * q.x(); };
    const Vec3 w(cross(b, c), cross(c, a), cross(a, b));
    if (w.minCoeff() < 0) continue;
    contact.n_vertices = 3;
    contact.vertices = {i, j, k};
    contact.weights = {w[0] / w.sum(), w[1] / w.sum(), w[2] / w.sum()};
    contact.face = f;
  }
  contact.point = {X.x(), X.y(), 0};
  contact.normal = {0, 0, 1};
  return contact;
}

// A vertex that hovers over a tip, or lags behind it, may stand in another face than the one over the tip. Within
// `merge` it is the same layer of cloth, and two on one point would have no room between them; beyond it is another.
TEST(CornerRider, IsTheOnlyOneOfItsLayer) {
  for (const double merge : {0.2, 0.1}) {
    SCOPED_TRACE(merge);
    const Vec2 place(0.64, 0.53);  // .143 m from the rider
    const Nail nail(Vec3(place.x(), place.y(), 0));
    Cloth cloth = sheet();
    const int rider = vertex_at(cloth, {0.5, 0.5});
    cloth.feature[rider] = {0, FeatureKind::Corner, 0};
    ConformOptions options;
    options.snap = 0.1;  // so that the rider, .143 m aside, has not left the tip
    options.merge = merge;
    const Contact contact = tip_at_face(cloth, place);
    const RemeshResult result = conform(cloth, {&contact, 1}, {&nail.posed, 1}, options);
    EXPECT_EQ(validate(result.cloth), std::nullopt);
    EXPECT_EQ(n_riders(result.cloth), merge > 0.143 ? 1 : 2);
    EXPECT_EQ(result.report.inserted, merge > 0.143 ? 0 : 1);
  }
}

// Two layers hang on one tip, the cloth between them folded along X = .55; as it is drawn away both riders come to the
// same material point. Left alone, the triangle between them shrank to a quarter of a millimetre in the scene `jaws`,
// shaken, and no step was short enough.
TEST(CornerRider, LetsGoWhereASecondOneHasComeNear) {
  for (const double merge : {0.2, 0.1}) {
    SCOPED_TRACE(merge);
    Cloth cloth = sheet();
    for (int v = 0; v < cloth.mesh.n_vertices(); ++v) {
      const Vec2& X = cloth.mesh.X[v];
      cloth.mesh.x[v] = {-std::abs(X.x() - 0.55), X.y(), 0};
      cloth.v[v] = {std::sin(5 * X.x()), std::cos(3 * X.y()), 0.2};
    }
    const int first = vertex_at(cloth, {0.5, 0.5}), second = vertex_at(cloth, {0.6, 0.5});
    ASSERT_LT((cloth.mesh.x[first] - cloth.mesh.x[second]).norm(), 1e-12);
    const Nail nail(cloth.mesh.x[first]);
    for (const int v : {first, second}) cloth.feature[v] = {0, FeatureKind::Corner, 0};
    cloth.V[second] = {-0.3, 0.1};
    ConformOptions options;
    options.merge = merge;
    const Motion before = motion(cloth);
    const RemeshResult result = conform(cloth, {}, {&nail.posed, 1}, options);
    EXPECT_EQ(validate(result.cloth), std::nullopt);
    EXPECT_EQ(n_riders(result.cloth), merge > 0.15 ? 1 : 2);  // within three quarters of `merge`: see conforming.hpp
    EXPECT_EQ(result.report.released, merge > 0.15 ? 1 : 0);
    EXPECT_LE((motion(result.cloth).linear - before.linear).norm(), 1e-12);
    EXPECT_LE(motion(result.cloth).kinetic, before.kinetic * (1 + 1e-12));
  }
}

// Exactly on one side of a face and near another: split there, the face would lose its area. It was not asked what
// strain such a face has; then no vertex came to be.
TEST(CornerRider, BeginsToRideWhereATipIsOnOneSideOfAFaceAndNearAnother) {
  const ObstacleShape tip = make_point(Vec3::UnitZ());
  PosedObstacle posed{&tip, {}};
  for (const Vec2& aside : {Vec2(1, 1), Vec2(-1, -1)}) {
    const Vec2 P = Vec2(0.5, 0.5) + 0.0021 * aside;  // .3 of `merge` from a vertex, .21 from two sides
    posed.pose.position = Vec3(P.x(), P.y(), 0);
    for (int first = 0; first < 2; ++first) {
      Cloth cloth = make_cloth(make_grid({.size = {1, 1}, .cells = {8, 8}, .pattern = GridPattern::Right}));
      std::vector<Contact> contacts = Detector().detect(cloth, {&posed, 1}, {1e-3, 5e-3});
      std::erase_if(contacts, [](const Contact& contact) { return contact.type != ContactType::CornerFace; });
      if (first != 0) std::reverse(contacts.begin(), contacts.end());
      const RemeshResult result = conform(cloth, contacts, {&posed, 1}, {});
      EXPECT_EQ(result.cloth.n_eol(), 1);
      EXPECT_TRUE(result.report.refusals.empty());
    }
  }
}

}  // namespace
}  // namespace crease
