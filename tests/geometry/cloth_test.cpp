// SPDX-License-Identifier: MIT
#include "crease/geometry/cloth.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <set>
#include <stdexcept>

#include <Eigen/LU>

#include "crease/geometry/chain.hpp"
#include "crease/geometry/dof_map.hpp"
#include "crease/geometry/grid.hpp"
#include "support/meshes.hpp"

namespace crease {
namespace {

using support::Rng;
using support::uniform;

/// Momentum of the velocity field that is linear on each triangle, per unit of density, by the edge-midpoint rule
/// (exact for linear functions), with F from its definition Dx DX^-1.
Vec3 momentum(const Cloth& cloth, double* scale = nullptr) {
  const Mesh& mesh = cloth.mesh;
  Vec3 sum = Vec3::Zero();
  for (int f = 0; f < mesh.n_faces(); ++f) {
    const auto X = material_corners(mesh, f);
    const auto x = world_corners(mesh, f);
    Mat2 DX;
    DX << X[1] - X[0], X[2] - X[0];
    Mat32 Dx;
    Dx << x[1] - x[0], x[2] - x[0];
    const Mat32 F = Dx * DX.inverse();
    std::array<Vec3, 3> w;
    for (int k = 0; k < 3; ++k) w[k] = cloth.v[mesh.face(f)[k]] - F * cloth.V[mesh.face(f)[k]];
    for (int k = 0; k < 3; ++k) {
      const Vec3 part = DX.determinant() / 2 / 3 * 0.5 * (w[k] + w[(k + 1) % 3]);
      sum += part;
      if (scale != nullptr) *scale += part.norm();
    }
  }
  return sum;
}

/// A crumpled cloth with random velocities and random EOL vertices.
Cloth lively(Mesh mesh, Rng& rng) {
  support::crumple(mesh, rng, 0.03);
  Cloth cloth = make_cloth(std::move(mesh));
  for (int i = 0; i < cloth.mesh.n_vertices(); ++i) {
    cloth.v[i] = Vec3(uniform(rng, -1, 1), uniform(rng, -1, 1), uniform(rng, -1, 1));
    if (cloth.mesh.is_material_corner(i) || support::pick(rng, 3) != 0) continue;
    cloth.feature[i] = {0, FeatureKind::Corner, i};
    cloth.V[i] = Vec2(uniform(rng, -1, 1), uniform(rng, -1, 1));
  }
  return cloth;
}

TEST(MakeLagrangian, ConservesLinearMomentum) {
  for (const auto& [name, mesh] : support::all_meshes()) {
    SCOPED_TRACE(name);
    Rng rng(17);
    Cloth cloth = lively(mesh, rng);
    double scale = 0;
    const Vec3 before = momentum(cloth, &scale);
    for (int i = 0; i < cloth.mesh.n_vertices(); ++i) {
      if (!cloth.is_eol(i)) continue;
      make_lagrangian(cloth, i);
      ASSERT_EQ(validate(cloth), std::nullopt);
    }
    EXPECT_EQ(cloth.n_eol(), 0);
    EXPECT_LT((momentum(cloth) - before).norm(), 1e-14 * scale);
  }
}

TEST(MakeLagrangian, KeepsTheWorldVelocityAndClearsTheChain) {
  Cloth cloth = make_cloth(support::grid(GridPattern::Right, 4, 4));
  const int row = 2 * 5;
  for (int i = 0; i < 5; ++i) cloth.feature[row + i] = {0, FeatureKind::Edge, 3};
  for (int i = 0; i < 4; ++i) cloth.mesh.set_tag(cloth.mesh.find_edge(row + i, row + i + 1), edge_tag(0, 3));
  cloth.V[row + 2] = Vec2(1, 2);
  ASSERT_EQ(validate(cloth), std::nullopt);
  const Vec3 before = cloth.world_velocity(row + 2);
  make_lagrangian(cloth, row + 2);
  EXPECT_EQ(cloth.world_velocity(row + 2), before);
  EXPECT_EQ(cloth.v[row + 2], before);
  EXPECT_TRUE(chain_edges(cloth, row + 2, edge_tag(0, 3)).empty());
  EXPECT_EQ(chain_edges(cloth, row, edge_tag(0, 3)).size(), 1u);
  EXPECT_EQ(validate(cloth), std::nullopt);
}

TEST(Cloth, StandsStillInTheWorldWhileItsVerticesRunAlongIt) {
  // xdot = F Xdot: the vertex moves over material that does not move.
  Rng rng(2);
  Mesh mesh = support::grid(GridPattern::Irregular, 5, 5);
  for (std::size_t i = 0; i < mesh.X.size(); ++i) mesh.x[i] = Vec3(1.2 * mesh.X[i].x(), mesh.X[i].y(), mesh.X[i].x());
  Cloth cloth = make_cloth(mesh);
  for (int i = 0; i < mesh.n_vertices(); ++i) {
    cloth.feature[i] = {0, FeatureKind::Edge, 0};
    cloth.V[i] = Vec2(uniform(rng, -1, 1), uniform(rng, -1, 1));
    cloth.v[i] = Vec3(1.2 * cloth.V[i].x(), cloth.V[i].y(), cloth.V[i].x());
    EXPECT_LT(cloth.world_velocity(i).norm(), 1e-14);
  }
}

TEST(EdgeTag, IsUniqueAndNeverZero) {
  std::set<int> seen;
  for (const int obstacle : {0, 1, 2, 2046}) {
    for (const int index : {0, 1, 11, (1 << 20) - 1}) {
      const int tag = edge_tag(obstacle, index);
      EXPECT_GT(tag, 0);
      EXPECT_TRUE(seen.insert(tag).second);
      EXPECT_EQ(tag_feature(tag), (FeatureId{obstacle, FeatureKind::Edge, index}));
    }
  }
  EXPECT_THROW(edge_tag(-1, 0), std::invalid_argument);
  EXPECT_THROW(edge_tag(0, 1 << 20), std::invalid_argument);
  EXPECT_THROW(tag_feature(0), std::invalid_argument);
}

TEST(ValidateCloth, NamesEachBrokenInvariant) {
  const Cloth good = make_cloth(support::grid(GridPattern::Right, 4, 4));
  ASSERT_EQ(validate(good), std::nullopt);
  const int inner = 12;
  Cloth bad = good;
  bad.V[inner] = Vec2(1, 0);
  EXPECT_NE(validate(bad), std::nullopt);
  bad.feature[inner] = {0, FeatureKind::Edge, 0};
  EXPECT_EQ(validate(bad), std::nullopt);
  bad.V[inner].x() = std::numeric_limits<double>::quiet_NaN();
  EXPECT_NE(validate(bad), std::nullopt);
  bad = good;
  bad.feature[0] = {0, FeatureKind::Edge, 0};  // a corner of the sheet
  EXPECT_NE(validate(bad), std::nullopt);
  bad = good;
  bad.v.pop_back();
  EXPECT_NE(validate(bad), std::nullopt);
  bad = good;
  bad.mesh.set_tag(bad.mesh.find_edge(inner, inner + 1), edge_tag(0, 4));
  EXPECT_NE(validate(bad), std::nullopt);
  bad.feature[inner] = {0, FeatureKind::Edge, 4};
  bad.feature[inner + 1] = {0, FeatureKind::Edge, 5};
  EXPECT_NE(validate(bad), std::nullopt);
  bad.feature[inner + 1] = {0, FeatureKind::Corner, 5};
  EXPECT_EQ(validate(bad), std::nullopt);
  bad.feature[inner].away = 0.01;
  EXPECT_NE(validate(bad), std::nullopt) << "what lingers is lifted";
  bad.feature[inner].lifted = true;
  EXPECT_EQ(validate(bad), std::nullopt);
  bad.left = {{.feature = {0, FeatureKind::Edge, 4}, .from = 1, .to = 0.5}};
  EXPECT_NE(validate(bad), std::nullopt);
}

// Edge 4 of a box ends in two of its corners, and not in the others.
TEST(ValidateCloth, HoldsFeaturesAgainstTheObstacles) {
  const ObstacleShape box = make_box({1, 1, 1});
  const std::vector<PosedObstacle> obstacles{{&box, {}}};
  Cloth cloth = make_cloth(support::grid(GridPattern::Right, 4, 4));
  const int inner = 12;
  cloth.feature[inner] = {.obstacle = 0, .kind = FeatureKind::Edge, .index = 4, .lifted = true, .away = 0.01};
  cloth.mesh.set_tag(cloth.mesh.find_edge(inner, inner + 1), edge_tag(0, 4));
  int n_ends = 0;
  for (int corner = 0; corner < 9; ++corner) {
    cloth.feature[inner + 1] = {0, FeatureKind::Corner, corner};
    EXPECT_EQ(validate(cloth), std::nullopt) << "which corners there are is not asked";
    n_ends += validate(cloth, obstacles, 0.01) == std::nullopt;
  }
  EXPECT_EQ(n_ends, 2);
  cloth.feature[inner + 1] = cloth.feature[inner];
  EXPECT_EQ(validate(cloth, obstacles, 0.01), std::nullopt);
  EXPECT_NE(validate(cloth, {}, 0.01), std::nullopt);
  EXPECT_NE(validate(cloth, obstacles, 0.009), std::nullopt) << "lingers for longer";
  cloth.left = {{.feature = {0, FeatureKind::Edge, 11}, .from = 0, .to = 0.5, .age = 0.01}};
  EXPECT_EQ(validate(cloth, obstacles, 0.01), std::nullopt);
  cloth.left[0].feature.index = 12;
  EXPECT_NE(validate(cloth, obstacles, 0.01), std::nullopt);
}

TEST(DofMap, NumbersFiveUnknownsAtEolVerticesAndThreeElsewhere) {
  Rng rng(4);
  Cloth cloth = lively(support::grid(GridPattern::Cross, 3, 3), rng);
  const DofMap dofs = make_dof_map(cloth);
  EXPECT_EQ(dofs.size(), 3 * cloth.mesh.n_vertices() + 2 * cloth.n_eol());
  const VecX qdot = gather_velocity(cloth, dofs);
  Cloth copy = cloth;
  for (auto& v : copy.v) v.setZero();
  for (auto& V : copy.V) V.setZero();
  scatter_velocity(qdot, dofs, copy);
  EXPECT_EQ(copy.v, cloth.v);
  EXPECT_EQ(copy.V, cloth.V);
  for (int i = 0; i < cloth.mesh.n_vertices(); ++i) EXPECT_EQ(dofs.is_eol(i), cloth.is_eol(i));
  EXPECT_THROW(scatter_velocity(VecX::Zero(3), dofs, copy), std::invalid_argument);
}

// -- chains ----------------------------------------------------------------------------------------------------------

/// One obstacle edge along a direction, and a sheet whose middle row rides on it.
struct ChainScene {
  ObstacleShape shape;
  Cloth cloth;
  std::array<PosedObstacle, 1> obstacles;
  int row;

  explicit ChainScene(const Vec3& tangent) {
    shape.edges.push_back({-tangent, tangent, {Vec3::UnitZ(), Vec3::UnitY()}});
    cloth = make_cloth(support::grid(GridPattern::Cross, 4, 4));
    for (auto& P : cloth.mesh.X) P -= Vec2(0.4, 0.4);  // the material origin in the middle of the chain
    row = 2 * 5;
    for (int i = 0; i < 5; ++i) cloth.feature[row + i] = {0, FeatureKind::Edge, 0};
    for (int i = 0; i < 4; ++i) cloth.mesh.set_tag(cloth.mesh.find_edge(row + i, row + i + 1), edge_tag(0, 0));
    obstacles[0] = {&shape, {}};
  }
};

TEST(ChainTangent, RunsAlongTheObstacleEdgeOnBothSidesOfTheOrigin) {
  for (const double sign : {1.0, -1.0}) {
    ChainScene scene(Vec3(sign, 0, 0));
    for (int i = 0; i < 5; ++i) {
      const Vec2 t = chain_tangent(scene.cloth, scene.row + i, scene.obstacles);
      EXPECT_LT((t - Vec2(sign, 0)).norm(), 1e-14);
    }
  }
}

TEST(ChainTangent, IsTheMeanOfTwoFoldEdgesThatTurn) {
  ChainScene scene(Vec3(1, 0, 0));
  scene.cloth.mesh.X[scene.row + 2] += Vec2(0, 0.05);
  const auto& X = scene.cloth.mesh.X;
  const Vec2 in = X[scene.row + 2] - X[scene.row + 1], out = X[scene.row + 3] - X[scene.row + 2];
  const Vec2 expected = (in.normalized() + out.normalized()).normalized();
  EXPECT_LT((chain_tangent(scene.cloth, scene.row + 2, scene.obstacles) - expected).norm(), 1e-14);
}

TEST(ChainTangent, WithoutFoldEdgesPullsTheObstacleTangentBack) {
  ChainScene scene(Vec3(1, 2, 0.5).normalized());
  Mat32 F;
  F << 1.1, 0.2, -0.3, 0.9, 0.4, 0.1;
  for (std::size_t i = 0; i < scene.cloth.mesh.X.size(); ++i) scene.cloth.mesh.x[i] = F * scene.cloth.mesh.X[i];
  for (const int h : scene.cloth.mesh.edges()) scene.cloth.mesh.set_tag(h, 0);
  const Mat2 normal = F.transpose() * F;
  const Vec2 expected = (normal.inverse() * F.transpose() * Vec3(1, 2, 0.5)).normalized();
  EXPECT_LT((chain_tangent(scene.cloth, scene.row + 2, scene.obstacles) - expected).norm(), 1e-13);
}

// Folded nearly back to back over an edge, the sheet has next to nothing of the mean F of its two sides left across the
// fold: through that, a fold askew to the edge by .05 rad was one by .7 rad in the material.
TEST(ChainTangent, WithoutFoldEdgesRunsAlongASharpFold) {
  const double askew = 0.05;
  for (const double angle : {0.5, 2.0, 3.0, 3.13}) {
    ChainScene scene(Vec3(std::cos(askew), std::sin(askew), 0));
    const Vec2 centre = scene.cloth.mesh.X[scene.row + 2];
    for (std::size_t i = 0; i < scene.cloth.mesh.X.size(); ++i) {
      const Vec2 at = scene.cloth.mesh.X[i] - centre;
      scene.cloth.mesh.x[i] = {at.x(), at.y() * std::cos(angle / 2), -std::abs(at.y()) * std::sin(angle / 2)};
    }
    for (const int h : scene.cloth.mesh.edges()) scene.cloth.mesh.set_tag(h, 0);
    const Vec2 t = chain_tangent(scene.cloth, scene.row + 2, scene.obstacles);
    EXPECT_LE(std::abs(t.y()), std::sin(askew)) << angle;
  }
}

TEST(ChainTangent, TurnsWithTheObstacle) {
  ChainScene scene(Vec3(0, 0, 1));
  scene.obstacles[0].pose.rotation << 0, 0, -1, 0, 1, 0, 1, 0, 0;  // z -> -x
  EXPECT_LT((chain_tangent(scene.cloth, scene.row + 2, scene.obstacles) - Vec2(-1, 0)).norm(), 1e-14);
}

TEST(FoldAngle, IsTheOneBetweenTheTwoSidesOfTheChain) {
  for (const double angle : {0.0, 1e-3, 0.2, 1.5, 3.1}) {
    Cloth cloth = make_cloth(make_grid({.size = {1, 1}, .cells = {4, 2}, .pattern = GridPattern::Right}));
    Mesh& mesh = cloth.mesh;
    int middle = -1;
    for (int v = 0; v < mesh.n_vertices(); ++v) {
      const double beyond = mesh.X[v].x() - 0.5;
      if (beyond > 1e-9) mesh.x[v] = {0.5 + beyond * std::cos(angle), mesh.X[v].y(), -beyond * std::sin(angle)};
      if (std::abs(beyond) < 1e-9) cloth.feature[v] = {0, FeatureKind::Edge, 3};
      if (std::abs(beyond) < 1e-9 && !mesh.is_border_vertex(v)) middle = v;
    }
    EXPECT_EQ(fold_angle(cloth, middle), 0) << "no chain";
    for (const int h : mesh.edges())
      if (cloth.is_eol(mesh.from(h)) && cloth.is_eol(mesh.to(h))) mesh.set_tag(h, edge_tag(0, 3));
    EXPECT_NEAR(fold_angle(cloth, middle), angle, 1e-14);
  }
}

TEST(BorderNormal, PointsOutwardOnEverySide) {
  const Mesh mesh = support::grid(GridPattern::Irregular, 5, 4);
  for (int v = 0; v < mesh.n_vertices(); ++v) {
    if (!mesh.is_border_vertex(v) || mesh.is_material_corner(v)) continue;
    const Vec2& P = mesh.X[v];
    const Vec2 expected(P.x() == 0 ? -1 : (P.x() == 1 ? 1 : 0), P.y() == 0 ? -1 : (P.y() == mesh.X.back().y() ? 1 : 0));
    EXPECT_LT((border_normal(mesh, v) - expected).norm(), 1e-14);
  }
  EXPECT_THROW(border_normal(mesh, 7), std::invalid_argument);
}

TEST(EulerianRows, HoldTheBorderTheTangentOrNothing) {
  ChainScene scene(Vec3(1, 0, 0));
  Cloth& cloth = scene.cloth;
  const auto rows = [&](int v) { return eulerian_rows(cloth, v, scene.obstacles); };
  EXPECT_TRUE(rows(0).empty());  // Lagrangian
  ASSERT_EQ(rows(scene.row).size(), 1u);
  EXPECT_LT((rows(scene.row)[0] - Vec2(-1, 0)).norm(), 1e-14);
  ASSERT_EQ(rows(scene.row + 2).size(), 1u);
  EXPECT_LT((rows(scene.row + 2)[0] - Vec2(1, 0)).norm(), 1e-14);
  cloth.feature[scene.row + 2].kind = FeatureKind::Corner;
  EXPECT_TRUE(rows(scene.row + 2).empty());
  cloth.feature[scene.row].kind = FeatureKind::Corner;
  EXPECT_EQ(rows(scene.row).size(), 1u);
}

}  // namespace
}  // namespace crease
