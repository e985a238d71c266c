// SPDX-License-Identifier: MIT
//
// Every scene with Eulerian unknowns that ships, coarser, and some shorter: ten times with its obstacles shaken by a
// millimetre and everything turned at random.
#include <gtest/gtest.h>

#include "support/shaken_runs.hpp"

namespace crease {
namespace {

using testing::ShakenScene;

ShakenScene coarse(const std::string& name, const std::string& cells, const std::string& size,
                   std::optional<double> until = std::nullopt) {
  return {name, {{"cloths.0.shape.grid.cells", cells}, {"cloths.0.remeshing.size", size}}, until};
}

// The watch itself: a flat sheet that nobody holds comes down over a tip, straight or at a slant; one that is turned on
// its side goes past it, and one that stops short by half a millimetre has not pierced.
TEST(Piercing, CountsASheetThatComesDownOverATip) {
  const ObstacleShape tip = make_point({0, 0, 1});
  const PosedObstacle nail{&tip, {}};
  const auto pierced = [&](const Vec3& normal, const Vec3& way) {
    GridOptions grid;
    grid.cells = {3, 3};
    grid.u = Vec3::UnitY().cross(normal).normalized();
    grid.v = normal.cross(grid.u);
    Cloth cloth = make_cloth(make_grid(grid));
    const Vec3 middle = 0.47 * grid.u + 0.56 * grid.v;
    for (Vec3& x : cloth.mesh.x) x += 0.01 * normal - middle;
    for (Vec3& v : cloth.v) v = way;
    testing::Piercing watch(1e-3);
    watch.begin(cloth, {&nail, 1});
    const DofMap dofs = make_dof_map(cloth);
    watch.solved(dofs, gather_velocity(cloth, dofs), 1);
    for (Vec3& x : cloth.mesh.x) x += way;
    watch.look(cloth, {&nail, 1});
    return watch.pierced();
  };
  EXPECT_EQ(pierced({0, 0, 1}, {0.003, 0.002, -0.02}), 1);
  EXPECT_EQ(pierced({0.6, 0, 0.8}, {0, 0, -0.02}), 1);
  EXPECT_EQ(pierced({0.6, 0, 0.8}, {0, 0, -0.0105 / 0.8}), 0);
  EXPECT_EQ(pierced({1, 0, 0}, {-0.02, 0, 0}), 0);
  EXPECT_EQ(pierced({0, 0, 1}, {0, 0, -0.0105}), 0);
  EXPECT_EQ(pierced({0, 0, 1}, {0, 0, 0.02}), 0);
}

// A slope that lies on a tip (rise over run) is lowered by remeshing; then a step makes it flatter, a little more than
// the allowed millimetre down. What stands up when remeshing carries it over the tip has slipped off, whatever comes
// then.
TEST(Piercing, JudgesWhatRemeshingMovesAsWhatPasses) {
  const ObstacleShape tip = make_point({0, 0, 1});
  const PosedObstacle nail{&tip, {}};
  const auto pierced = [&](double depth, double slope) {
    GridOptions grid;
    grid.cells = {1, 1};
    Cloth cloth = make_cloth(make_grid(grid));
    const auto plane = [&](double height, double rise) {
      std::vector<Vec3> x;
      for (const Vec2& X : cloth.mesh.X) x.emplace_back(X.x() - 0.47, X.y() - 0.56, height + rise * (X.x() - 0.47));
      return x;
    };
    testing::Piercing watch(1e-3);
    cloth.mesh.x = plane(1e-5, slope);
    watch.look(cloth, {&nail, 1});
    cloth.mesh.x = plane(-depth, slope);
    watch.look(cloth, {&nail, 1});
    const std::vector<Vec3> end = plane(-1.1e-3, 0.5);
    for (std::size_t v = 0; v < end.size(); ++v) cloth.v[v] = end[v] - cloth.mesh.x[v];
    watch.begin(cloth, {&nail, 1});
    const DofMap dofs = make_dof_map(cloth);
    watch.solved(dofs, gather_velocity(cloth, dofs), 1);
    cloth.mesh.x = end;
    watch.look(cloth, {&nail, 1});
    return watch.pierced();
  };
  EXPECT_EQ(pierced(0, 0.5), 1);
  EXPECT_EQ(pierced(1.05e-3, 0.5), 1);
  EXPECT_EQ(pierced(2e-4, 20), 0);
}

class ShakenScenes : public ::testing::TestWithParam<ShakenScene> {};

TEST_P(ShakenScenes, EndWithTheClothOutside) {
  testing::expect_all_end_outside(GetParam(), "coarse");
}

// Until what is pulled has slid and what moves has gone through most of its way.
INSTANTIATE_TEST_SUITE_P(
    Coarse, ShakenScenes,
    ::testing::Values(coarse("drape_corner", "[8,8]", "[0.1,0.2]", 1.0), coarse("edge", "[8,8]", "[0.08,0.2]"),
                      coarse("jaws", "[8,8]", "[0.08,0.2]", 1.2), ShakenScene{"lo_res"},
                      coarse("nails", "[8,8]", "[0.1,0.2]", 1.0), coarse("prism", "[9,8]", "[0.1,0.2]", 0.8),
                      coarse("push", "[8,8]", "[0.08,0.2]", 1.5), coarse("tablecloth", "[10,10]", "[0.1,0.2]", 1.0),
                      coarse("throw", "[8,8]", "[0.1,0.2]"), coarse("wire", "[8,8]", "[0.08,0.2]")),
    testing::name_of);

}  // namespace
}  // namespace crease
