// SPDX-License-Identifier: MIT
#include "crease/geometry/mesh.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <set>
#include <stdexcept>

#include "support/meshes.hpp"

namespace crease {
namespace {

using support::all_meshes;

std::vector<Vec3> flat(const std::vector<Vec2>& X) {
  std::vector<Vec3> x;
  for (const Vec2& P : X) x.emplace_back(P.x(), P.y(), 0);
  return x;
}

/// The message of the exception that building this mesh throws, or "" if it does not.
std::string complaint(const std::vector<Vec2>& X, const std::vector<std::array<int, 3>>& faces) {
  try {
    const Mesh mesh(X, flat(X), faces);
  } catch (const std::invalid_argument& e) {
    return e.what();
  }
  return "";
}

const std::vector<Vec2> square = {{0, 0}, {1, 0}, {1, 1}, {0, 1}};

TEST(Mesh, AcceptsEveryShapeOfCloth) {
  for (const auto& [name, mesh] : all_meshes()) {
    SCOPED_TRACE(name);
    EXPECT_EQ(mesh.validate(), std::nullopt);
    EXPECT_TRUE(mesh.is_compact());
  }
  EXPECT_EQ(Mesh().validate(), std::nullopt);
}

TEST(Mesh, NamesTheFirstBadFace) {
  EXPECT_EQ(complaint(square, {{0, 1, 2}, {0, 2, 3}}), "");
  EXPECT_NE(complaint(square, {{0, 1, 2}, {0, 2, 4}}).find("face 1 names vertex 4 of 4"), std::string::npos);
  EXPECT_NE(complaint(square, {{0, -1, 2}}).find("face 0 names vertex -1"), std::string::npos);
  EXPECT_NE(complaint(square, {{0, 1, 2}, {0, 2, 2}}).find("face 1 names a vertex twice"), std::string::npos);
  EXPECT_NE(complaint(square, {{0, 1, 2}, {0, 3, 2}}).find("face 1 is inverted"), std::string::npos);
  EXPECT_NE(complaint({{0, 0}, {1, 0}, {2, 0}}, {{0, 1, 2}}).find("face 0 has no area"), std::string::npos);
  EXPECT_NE(complaint(square, {{0, 1, 2}, {0, 2, 3}, {1, 2, 0}}).find("face 2 makes an edge"), std::string::npos);
  EXPECT_NE(complaint(square, {{0, 1, 2}}).find("vertex 3 is in no face"), std::string::npos);
}

TEST(Mesh, RefusesFacesThatMeetInOneVertexOnly) {
  const std::vector<Vec2> X = {{0, 0}, {1, 0}, {1, 1}, {-1, 0}, {-1, -1}};
  EXPECT_NE(complaint(X, {{0, 1, 2}, {0, 3, 4}}).find("vertex 0 non-manifold"), std::string::npos);
}

TEST(Mesh, RefusesFacesThatGoRoundAVertexTwice) {
  // Six triangles of 120 degrees each: every one is fine, and every edge has two faces.
  std::vector<Vec2> X = {{0, 0}};
  std::vector<std::array<int, 3>> faces;
  for (int i = 0; i < 6; ++i) {
    const double angle = i * 2 * std::numbers::pi / 3, radius = 1 + 0.1 * i;
    X.emplace_back(radius * std::cos(angle), radius * std::sin(angle));
    faces.push_back({0, 1 + i, 1 + (i + 1) % 6});
  }
  EXPECT_NE(complaint(X, faces).find("round vertex 0 more than once"), std::string::npos);
}

TEST(Mesh, RefusesNumbersThatAreNotFiniteAndArraysThatDiffer) {
  auto X = square;
  X[2].x() = std::numeric_limits<double>::quiet_NaN();
  EXPECT_NE(complaint(X, {{0, 1, 2}, {0, 2, 3}}).find("vertex 2"), std::string::npos);
  EXPECT_THROW(Mesh(square, {}, {{0, 1, 2}}), std::invalid_argument);
}

TEST(Mesh, FindsEveryEdgeFromBothEnds) {
  for (const auto& [name, mesh] : all_meshes()) {
    SCOPED_TRACE(name);
    std::set<std::pair<int, int>> joined;
    for (const int h : mesh.edges()) {
      const int a = mesh.from(h), b = mesh.to(h);
      EXPECT_EQ(mesh.edge_of(mesh.find_edge(a, b)), h);
      EXPECT_EQ(mesh.edge_of(mesh.find_edge(b, a)), h);
      if (!mesh.is_border(h)) {
        EXPECT_EQ(mesh.find_edge(b, a), mesh.twin(h));
      }
      joined.insert({a, b});
      joined.insert({b, a});
    }
    for (int a = 0; a < mesh.n_vertices(); ++a) {
      for (int b = 0; b < mesh.n_vertices(); ++b) {
        EXPECT_EQ(mesh.find_edge(a, b) != Mesh::none, joined.contains({a, b}));
      }
    }
  }
}

TEST(Mesh, WalksAVertexCounterClockwiseFromBorderToBorder) {
  for (const auto& [name, mesh] : all_meshes()) {
    SCOPED_TRACE(name);
    for (int v = 0; v < mesh.n_vertices(); ++v) {
      const auto around = mesh.neighbours(v);
      const auto out = mesh.outgoing(v);
      const bool border = mesh.is_border_vertex(v);
      ASSERT_EQ(around.size(), out.size() + (border ? 1 : 0));
      for (std::size_t i = 0; i < out.size(); ++i) {
        const int next = around[(i + 1) % around.size()];
        EXPECT_EQ(mesh.to(out[i]), around[i]);
        EXPECT_EQ(mesh.opposite(out[i]), next);
        EXPECT_GT(orient2d(mesh.X[v], mesh.X[around[i]], mesh.X[next]), 0);
      }
      if (!border) continue;
      EXPECT_TRUE(mesh.is_border(mesh.find_edge(v, around.front())));
      EXPECT_TRUE(mesh.is_border(mesh.find_edge(v, around.back())));
    }
  }
}

TEST(Mesh, TurnsByARightAngleAtTheCornersOfASquareOnly) {
  const Mesh mesh = support::grid(GridPattern::Irregular, 6, 5);
  int corners = 0;
  for (int v = 0; v < mesh.n_vertices(); ++v) {
    if (!mesh.is_border_vertex(v)) continue;
    const double turn = mesh.border_turn(v);
    // Rounding of the border positions against an edge length of 0.1.
    if (turn > 1e-12) {
      EXPECT_NEAR(turn, std::numbers::pi / 2, 1e-12);
    }
    corners += mesh.is_material_corner(v) ? 1 : 0;
  }
  EXPECT_EQ(corners, 4);
}

TEST(Mesh, TurnsAtReEntrantCornersToo) {
  const Mesh mesh = support::l_shape();
  int corners = 0;
  for (int v = 0; v < mesh.n_vertices(); ++v) corners += mesh.is_material_corner(v) ? 1 : 0;
  EXPECT_EQ(corners, 6);
}

TEST(Mesh, ReportsADamagedPosition) {
  Mesh mesh = support::grid(GridPattern::Right);
  const Vec2 saved = mesh.X[10];
  mesh.X[10] += Vec2(10, 10);
  EXPECT_NE(mesh.validate(), std::nullopt);
  mesh.X[10] = saved;
  EXPECT_EQ(mesh.validate(), std::nullopt);
  mesh.x[3].z() = std::numeric_limits<double>::infinity();
  EXPECT_NE(mesh.validate(), std::nullopt);
}

TEST(Mesh, TagsBothSidesOfAnEdge) {
  Mesh mesh = support::grid(GridPattern::Right);
  for (const int h : mesh.edges()) {
    mesh.set_tag(h, 7);
    EXPECT_EQ(mesh.tag(h), 7);
    if (mesh.twin(h) != Mesh::none) {
      EXPECT_EQ(mesh.tag(mesh.twin(h)), 7);
    }
  }
  EXPECT_EQ(mesh.validate(), std::nullopt);
}

}  // namespace
}  // namespace crease
