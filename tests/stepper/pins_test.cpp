// SPDX-License-Identifier: MIT
// Which vertices a pin holds.
#include "support/scene_io.hpp"

#include <algorithm>

namespace crease {
namespace {

class Pins : public SceneIo {
 protected:
  // Vertices that the pin `where` holds on a grid of 2 x 1 m with 4 x 2 cells, by brute force over the material
  // corners.
  std::vector<Vec2> held(const std::string& where, const std::string& pattern = "right") const {
    const LoadedScene loaded = load(smallest_scene, {{"cloths.0.shape.grid.size", "[2, 1]"},
                                                     {"cloths.0.shape.grid.cells", "[4, 2]"},
                                                     {"cloths.0.shape.grid.pattern", pattern},
                                                     {"cloths.0.pins.0", "{\"where\": {\"vertices\": [0]}}"},
                                                     {"cloths.0.pins.1", "{\"where\": " + where + "}"}});
    const Cloth& cloth = loaded.cloths.at(0);
    std::vector<Vec2> X;
    for (int i = 0; i < cloth.mesh.n_vertices(); ++i)
      if (cloth.pins[i] & 2) X.push_back(cloth.mesh.X[i]);
    return X;
  }
};

TEST_F(Pins, CornerIsNamedByItsUEndThenItsVEnd) {
  EXPECT_EQ(held(R"({"corner": "00"})"), std::vector{Vec2(0, 0)});
  EXPECT_EQ(held(R"({"corner": "10"})"), std::vector{Vec2(2, 0)});
  EXPECT_EQ(held(R"({"corner": "11"})"), std::vector{Vec2(2, 1)});
  EXPECT_EQ(held(R"({"corner": "01"})"), std::vector{Vec2(0, 1)});
}

TEST_F(Pins, EdgeHoldsAllItsVertices) {
  for (const std::string pattern : {"right", "cross", "irregular"}) {
    SCOPED_TRACE(pattern);
    for (const Vec2& X : held(R"({"edge": "u0"})", pattern)) EXPECT_EQ(X.x(), 0);
    for (const Vec2& X : held(R"({"edge": "u1"})", pattern)) EXPECT_NEAR(X.x(), 2, 1e-9);
    for (const Vec2& X : held(R"({"edge": "v0"})", pattern)) EXPECT_EQ(X.y(), 0);
    for (const Vec2& X : held(R"({"edge": "v1"})", pattern)) EXPECT_NEAR(X.y(), 1, 1e-9);
    EXPECT_EQ(held(R"({"edge": "u0"})", pattern).size(), 3u);
    EXPECT_EQ(held(R"({"edge": "v1"})", pattern).size(), 5u);
  }
}

TEST_F(Pins, MaterialPointHoldsTheNearestVertex) {
  EXPECT_EQ(held(R"({"material": [0.9, 0.6]})"), std::vector{Vec2(1, 0.5)});
  EXPECT_EQ(held(R"({"material": [2.2, 1.1]})"), std::vector{Vec2(2, 1)});
}

TEST_F(Pins, VerticesAreCountedFromZero) {
  const Cloth cloth = load(smallest_scene, {{"cloths.0.pins.0.where.vertices", "[3, 0, 3]"}}).cloths.at(0);
  for (int i = 0; i < cloth.mesh.n_vertices(); ++i) EXPECT_EQ(cloth.pins[i], i == 0 || i == 3 ? 1u : 0u);
}

TEST_F(Pins, SixtyFourAreHeldAndNoMore) {
  const auto pins = [](int n) {
    std::string list;
    for (int k = 0; k < n; ++k)
      list += (k ? "," : "") + std::string("{\"where\": {\"vertices\": [") + std::to_string(k) + "]}}";
    return Overrides{{"cloths.0.pins", "[" + list + "]"}};
  };
  EXPECT_EQ(load(smallest_scene, pins(64)).cloths[0].pins[63], std::uint64_t{1} << 63);
  expect_problem(smallest_scene, "/cloths/0/pins", "at most 64", pins(65));
}

TEST_F(Pins, TwoThatPullOneVertexApartAreRefused) {
  const Overrides apart{
      {"cloths.0.pins.0.where.edge", "u0"},
      {"cloths.0.pins.1", R"({"where": {"corner": "00"}, "motion": [{"time": 0, "velocity": [1, 0, 0]}]})"}};
  expect_problem(smallest_scene, "/cloths/0/pins/1", "that pin 0 moves differently", apart);
  Overrides by_axis = apart;
  by_axis.push_back({"cloths.0.pins.0.axes", "yz"});
  by_axis.push_back({"cloths.0.pins.1.axes", "x"});
  EXPECT_NO_THROW(load(smallest_scene, by_axis));
  EXPECT_NO_THROW(load(smallest_scene, {{"cloths.0.pins.0.where.edge", "u0"}, {"cloths.0.pins.1.where.edge", "v0"}}));
}

TEST_F(Pins, CornersOfAMeshFileAreThoseOfItsBoundingBox) {
  // A kite: no vertex stands in a corner of the box, so the nearest one is held.
  folder_.write("kite.obj",
                "v 0 0 0\nv 1.5 -1 0\nv 2.2 0.1 0\nv 1.6 1 0\nvt 0 0\nvt 1.5 -1\nvt 2.2 0.1\nvt 1.6 1\nf 1/1 2/2 "
                "3/3\nf 1/1 3/3 4/4\n");
  const std::string text = with(smallest_scene, "{\"grid\": {}}", "{\"mesh\": \"kite.obj\"}");
  const auto held_by = [&](const std::string& corner) {
    const Cloth cloth = load(text, {{"cloths.0.pins.0.where", R"({"corner": ")" + corner + "\"}"}}).cloths.at(0);
    return std::find(cloth.pins.begin(), cloth.pins.end(), 1u) - cloth.pins.begin();
  };
  EXPECT_EQ(held_by("00"), 0);
  EXPECT_EQ(held_by("10"), 1);
  EXPECT_EQ(held_by("11"), 3);
  EXPECT_EQ(held_by("01"), 0);
}

}  // namespace
}  // namespace crease
