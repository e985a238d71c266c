// SPDX-License-Identifier: MIT
//
// How adapt() thins chains: what is left is even, on its feature, and as sparse as its sizes allow.
#include <algorithm>
#include <cmath>
#include <numbers>
#include <numeric>
#include <string>
#include <vector>

#include <gtest/gtest.h>
#include <Eigen/Geometry>

#include "crease/geometry/grid.hpp"
#include "crease/remesh/remesh.hpp"
#include "remesh/same_bits.hpp"
#include "remesh/sliding_sheet.hpp"
#include "support/contacts.hpp"
#include "support/meshes.hpp"
#include "support/surface_change.hpp"

namespace crease {
namespace {

using support::Rng;
using support::SlidingSheet;
using support::uniform;

constexpr double degree = std::numbers::pi / 180;

// One size everywhere, so that metric lengths are material lengths over it.
AdaptOptions one_size(double size) {
  AdaptOptions options;
  options.size = {size, size};
  return options;
}

std::vector<int> chain_of(const SlidingSheet& sheet) {
  std::vector<int> chain;
  for (int v = 0; v < sheet.cloth.mesh.n_vertices(); ++v)
    if (sheet.cloth.is_eol(v)) chain.push_back(v);
  std::sort(chain.begin(), chain.end(),
            [&](int a, int b) { return sheet.cloth.mesh.x[a].y() < sheet.cloth.mesh.x[b].y(); });
  return chain;
}

std::vector<double> lengths(const SlidingSheet& sheet, const std::vector<int>& chain, double size) {
  std::vector<double> result;
  for (std::size_t i = 1; i < chain.size(); ++i)
    result.push_back((sheet.cloth.mesh.X[chain[i]] - sheet.cloth.mesh.X[chain[i - 1]]).norm() / size);
  return result;
}

void set_random_velocities(std::uint64_t seed, Cloth& cloth) {
  Rng rng(seed);
  for (int v = 0; v < cloth.mesh.n_vertices(); ++v) {
    cloth.v[v] = Vec3(uniform(rng, -1, 1), uniform(rng, -1, 1), uniform(rng, -1, 1));
    if (cloth.is_eol(v)) cloth.V[v] = Vec2(uniform(rng, -1, 1), uniform(rng, -1, 1));
  }
}

// Three edges of L = .55: no collapse may leave 1.1, but two of .825 do as well.
TEST(ThinChains, MakesTwoEvenEdgesOfThree) {
  GridOptions grid;
  grid.size = Vec2(0.4, 1);
  grid.cells = {2, 3};
  grid.pattern = GridPattern::Right;
  Cloth cloth = make_cloth(make_grid(grid));
  std::vector<int> chain;
  for (int v = 0; v < cloth.mesh.n_vertices(); ++v)
    if (std::abs(cloth.mesh.X[v].x() - 0.2) < 1e-12) chain.push_back(v);
  ASSERT_EQ(chain.size(), 4U);
  for (std::size_t i = 0; i < chain.size(); ++i) {
    cloth.feature[chain[i]] = tag_feature(edge_tag(0, 1));
    cloth.V[chain[i]] = Vec2(0.3, 0.1);
    if (i > 0) cloth.mesh.set_tag(cloth.mesh.find_edge(chain[i - 1], chain[i]), edge_tag(0, 1));
  }
  ASSERT_EQ(validate(cloth), std::nullopt);
  const RemeshResult result = adapt(cloth, one_size(1 / 1.65));
  EXPECT_EQ(validate(result.cloth), std::nullopt);
  ASSERT_EQ(result.cloth.n_eol(), 3);
  for (int v = 0; v < result.cloth.mesh.n_vertices(); ++v) {
    if (!result.cloth.is_eol(v) || result.cloth.mesh.is_border_vertex(v)) continue;
    EXPECT_LE((result.cloth.mesh.X[v] - Vec2(0.2, 0.5)).norm(), 1e-12);
    EXPECT_LE((result.cloth.V[v] - Vec2(0.3, 0.1)).norm(), 1e-12);
  }
  EXPECT_FALSE(adapt(result.cloth, one_size(1 / 1.65)).report.changed);
}

// Of 8 edges in a row 7 are made if they may be .92 long, but for one at the end of a chain and where it would stretch
// other edges or leave thin triangles. (Without the slides: half as many again as the fewest.)
TEST(ThinChains, LeavesHardlyMoreEdgesThanTheSizesAskFor) {
  double edges = 0, fewest = 0;
  for (const GridPattern pattern : {GridPattern::Cross, GridPattern::Right, GridPattern::Irregular}) {
    for (const double degrees : {0.0, 20.0}) {
      for (const double size : {0.055, 0.06, 0.07, 0.085, 0.1, 0.15}) {
        SCOPED_TRACE("pattern " + std::to_string(static_cast<int>(pattern)) + ", angle " + std::to_string(degrees) +
                     ", size " + std::to_string(size));
        SlidingSheet sheet({.pattern = pattern, .angle = degrees * degree, .place = 0.613});
        sheet.cloth = sheet.conform({}).cloth;
        set_random_velocities(5, sheet.cloth);
        const RemeshResult result = adapt(sheet.cloth, one_size(size));
        sheet.cloth = result.cloth;
        EXPECT_EQ(sheet.trouble(), std::nullopt);
        const std::vector<int> chain = chain_of(sheet);
        for (const int v : chain) {
          EXPECT_LE(sheet.cloth.mesh.x[v].cwiseProduct(Vec3(1, 0, 1)).norm(), 1e-12);
          EXPECT_LE(std::abs(sheet.s(sheet.cloth.mesh.X[v])), 1e-12);
        }
        const std::vector<double> length = lengths(sheet, chain, size);
        edges += static_cast<double>(length.size());
        fewest += std::ceil(std::accumulate(length.begin(), length.end(), 0.0) / 0.92);
        for (const double l : length) EXPECT_LE(l, 1 + 1e-9);
        const Motion &before = result.report.before, &after = result.report.after;
        EXPECT_LE((after.linear - before.linear).norm(), 1e-12);
        EXPECT_LE((after.angular - before.angular).norm(), 1e-12);
        EXPECT_LE(after.kinetic, before.kinetic * (1 + 1e-12));
        // Vertices that make room for the chain take some passes.
        RemeshResult again = adapt(sheet.cloth, one_size(size));
        int passes = 1;
        for (; again.report.changed && passes < 100; ++passes) again = adapt(again.cloth, one_size(size));
        EXPECT_LT(passes, 100);
      }
    }
  }
  EXPECT_LE(edges, 1.25 * fewest);
}

// Where the sheet is bent a chain that is thinned is a chord through the material, and that moves the surface.
TEST(ThinChains, MovesABentSheetUnseen) {
  Rng rng(3);
  int thinned = 0;
  for (const double degrees : {0.0, 25.0}) {
    for (const double curl : {0.0, 0.2, 2.0}) {
      SlidingSheet sheet({.pattern = GridPattern::Irregular, .angle = degrees * degree, .place = 0.613});
      sheet.cloth = sheet.conform({}).cloth;
      sheet.bend(-60 * degree, curl);
      for (int pass = 0; pass < 5; ++pass) {
        const RemeshResult result = adapt(sheet.cloth, one_size(uniform(rng, 0.06, 0.1)));
        EXPECT_LE(testing::surface_change(sheet.cloth.mesh, result.cloth.mesh).distance, 2e-4);
        thinned += sheet.cloth.n_eol() - result.cloth.n_eol();
        sheet.cloth = result.cloth;
        EXPECT_EQ(validate(sheet.cloth), std::nullopt);
        for (const int v : chain_of(sheet)) EXPECT_LE(sheet.cloth.mesh.x[v].cwiseProduct(Vec3(1, 0, 1)).norm(), 1e-12);
      }
    }
  }
  EXPECT_GT(thinned, 20);
}

// A plan whose later slides are refused takes back the earlier ones, and what they did to the velocities some rings
// around.
TEST(ThinChains, LeavesNothingOfARefusedPlan) {
  int refused = 0;
  for (const double degrees : {10.0, 25.0, 40.0}) {
    for (const double size : {0.07, 0.08, 0.1}) {
      SlidingSheet sheet({.pattern = GridPattern::Irregular, .angle = degrees * degree, .place = 0.613});
      sheet.cloth = sheet.conform({}).cloth;
      sheet.bend(-60 * degree, 2);
      set_random_velocities(7, sheet.cloth);
      Cloth cloth = sheet.cloth;
      for (int v = 0; v < cloth.mesh.n_vertices(); ++v)
        for (const int u : cloth.mesh.neighbours(v))
          if (cloth.is_eol(v) && !cloth.is_eol(u)) cloth.pins[u] = 1;
      for (int pass = 0; pass < 100; ++pass) {
        const RemeshResult result = adapt(cloth, one_size(size));
        if (result.report.changed) {
          cloth = result.cloth;
          continue;
        }
        for (const int n : result.report.kept_back) refused += n;
        testing::expect_same_bits(result.cloth, cloth);
        break;
      }
    }
  }
  EXPECT_GT(refused, 0);
}

// Pins, the border and the corners of a box hold their vertices where they are.
TEST(ThinChains, LeavesWhatIsHeld) {
  const ObstacleShape box = make_box(Vec3(0.37, 0.41, 0.2));
  for (const GridPattern pattern : {GridPattern::Cross, GridPattern::Irregular}) {
    GridOptions grid;
    grid.cells = {15, 15};
    grid.pattern = pattern;
    Cloth cloth = make_cloth(make_grid(grid));
    PosedObstacle posed{&box, {}};
    posed.pose.position = Vec3(0.48, 0.53, -0.1);
    posed.pose.rotation = Eigen::AngleAxisd(13 * degree, Vec3::UnitZ()).toRotationMatrix();
    const std::span<const PosedObstacle> obstacles(&posed, 1);
    for (int pass = 0; pass < 2; ++pass)
      cloth = conform(cloth, support::feature_contacts(cloth, obstacles, 1e-3), obstacles, {}).cloth;
    for (int v = 0; v < cloth.mesh.n_vertices(); ++v)
      if (cloth.feature[v].kind == FeatureKind::Edge && v % 5 == 0) cloth.pins[v] = 1;
    const RemeshResult result = adapt(cloth, one_size(0.12), obstacles);
    EXPECT_LT(result.cloth.n_eol(), cloth.n_eol());
    EXPECT_EQ(validate(result.cloth), std::nullopt);
    for (int v = 0; v < cloth.mesh.n_vertices(); ++v) {
      if (cloth.feature[v].kind != FeatureKind::Corner && !(cloth.is_eol(v) && cloth.pins[v] != 0)) continue;
      const int now = result.report.vertex_map[v];
      ASSERT_NE(now, Mesh::none);
      EXPECT_EQ(result.cloth.mesh.X[now], cloth.mesh.X[v]);
      EXPECT_EQ(result.cloth.mesh.x[now], cloth.mesh.x[v]);
    }
  }
  SlidingSheet sheet({.pattern = GridPattern::Irregular, .angle = 20 * degree});
  sheet.cloth = sheet.conform({}).cloth;
  const RemeshResult result = adapt(sheet.cloth, one_size(0.12));
  for (const int v : chain_of(sheet)) {
    if (!sheet.cloth.mesh.is_border_vertex(v)) continue;
    ASSERT_NE(result.report.vertex_map[v], Mesh::none);
    EXPECT_EQ(result.cloth.mesh.X[result.report.vertex_map[v]], sheet.cloth.mesh.X[v]);
  }
}

}  // namespace
}  // namespace crease
