// SPDX-License-Identifier: MIT
// What a scene says reaches the program.
#include "support/scene_io.hpp"

#include <array>
#include <filesystem>
#include <fstream>

#include "crease/stepper/suggest.hpp"

namespace crease {
namespace {

TEST_F(SceneIo, NamesGivenByDefaultAreNamesOfNothingElse) {
  const LoadedScene loaded =
      load(with(smallest_scene, "\"material\": {}}]",
                "\"material\": {}, \"name\": \"cloth1\"}, {\"shape\": {\"grid\": {}}, \"material\": {}},"
                " {\"shape\": {\"grid\": {}}, \"material\": {}}]"));
  std::vector<std::string> names;
  for (const ClothSpec& cloth : loaded.scene.cloths) names.push_back(cloth.name);
  EXPECT_EQ(names, (std::vector<std::string>{"cloth1", "cloth3", "cloth2"}));
}

TEST_F(SceneIo, FillsTheDefaultsOfTheSmallestScene) {
  const Scene scene = load(smallest_scene).scene;
  EXPECT_EQ(scene.time_step, 0.005);
  EXPECT_EQ(scene.gravity, Vec3(0, 0, -9.81));
  ASSERT_EQ(scene.cloths.size(), 1u);
  const ClothSpec& cloth = scene.cloths[0];
  EXPECT_EQ(cloth.name, "cloth");
  EXPECT_EQ(cloth.material.density, 0.05);
  EXPECT_EQ(cloth.material.youngs, 50);
  EXPECT_EQ(cloth.material.poisson, 0.3);
  EXPECT_EQ(cloth.material.bending, 1e-5);
  EXPECT_EQ(cloth.material.damping, 0);
  EXPECT_EQ(cloth.remeshing, RemeshMethod::None);
  EXPECT_TRUE(cloth.pins.empty());
  EXPECT_TRUE(scene.obstacles.empty());
  EXPECT_EQ(scene.threshold, 1e-3);
  EXPECT_TRUE(scene.velocity_terms);
  EXPECT_EQ(scene.qp, QpMethod::ActiveSet);
  EXPECT_EQ(scene.tolerance, 1e-8);
  EXPECT_EQ(scene.fps, 60);
  EXPECT_EQ(scene.formats, std::vector{FrameFormat::Vtp});
}

TEST_F(SceneIo, ReadsEveryKey) {
  std::string text = full_scene;
  for (const auto& [what, by] : std::vector<std::pair<std::string, std::string>>{
           {"\"time_step\": 0.005", "\"time_step\": 0.002"},
           {"\"size\": [1, 1], \"cells\": [8, 8], \"pattern\": \"cross\", \"seed\": 1",
            "\"size\": [2, 1], \"cells\": [8, 6], \"pattern\": \"irregular\", \"seed\": 5"},
           {"\"origin\": [0, 0, 0], \"u\": [1, 0, 0], \"v\": [0, 1, 0]",
            "\"origin\": [1, 2, 3], \"u\": [0, 1, 0], \"v\": [0, 0, 1]"},
           {"\"velocity\": [0, 0, 0],", "\"velocity\": [1, 2, 3],"},
           {"\"axes\": \"xyz\"", "\"axes\": \"xz\""},
           {"\"angular_velocity\": [0, 0, 0]", "\"angular_velocity\": [0, 0, 5]"},
           {"\"degrees\": 0", "\"degrees\": 90"},
           {"\"active_set\"", "\"ipopt\""},
           {"\"velocity_terms\": true", "\"velocity_terms\": false"},
           {"[\"vtp\"]", "[\"obj\", \"vtp\"]"}})
    text = with(text, what, by);
  const LoadedScene loaded = load(text);
  const Scene& scene = loaded.scene;
  EXPECT_EQ(scene.name, "edge");
  EXPECT_EQ(scene.description, "all of it");
  EXPECT_EQ(scene.duration, 4);
  EXPECT_EQ(scene.time_step, 0.002);
  EXPECT_FALSE(scene.velocity_terms);
  EXPECT_EQ(scene.qp, QpMethod::Ipopt);
  EXPECT_EQ(scene.formats, (std::vector{FrameFormat::Obj, FrameFormat::Vtp}));

  const ClothSpec& cloth = scene.cloths.at(0);
  const auto& grid = std::get<GridOptions>(cloth.shape);
  EXPECT_EQ(grid.size, Vec2(2, 1));
  EXPECT_EQ(grid.cells, (std::array{8, 6}));
  EXPECT_EQ(grid.pattern, GridPattern::Irregular);
  EXPECT_EQ(grid.seed, 5u);
  EXPECT_EQ(grid.origin, Vec3(1, 2, 3));
  EXPECT_EQ(cloth.remeshing, RemeshMethod::Conformal);
  EXPECT_EQ(cloth.adapt.size, (std::array{0.02, 0.2}));
  const PinSpec& pin = cloth.pins.at(0);
  EXPECT_EQ(pin.where.name, "10");
  EXPECT_EQ(pin.axes, (std::array{true, false, true}));
  ASSERT_EQ(pin.motion.size(), 2u);
  EXPECT_EQ(pin.motion[1].time, 0.35);
  EXPECT_EQ(pin.motion[1].velocity, Vec3(0.1, 0, 0));
  EXPECT_EQ(pin.ramp, 0.1);
  EXPECT_EQ(pin.release, 2.0);

  const Obstacle& table = scene.obstacles.at(0);
  EXPECT_EQ(table.name, "table");
  EXPECT_EQ(table.shape.half_size, Vec3(0.6, 0.75, 0.5));
  EXPECT_EQ(table.start.position, Vec3(0.9175, 0.4425, -0.549));
  EXPECT_LT((table.start.rotation * Vec3::UnitX() - Vec3::UnitY()).norm(), 1e-15);
  EXPECT_EQ(table.motion.at(0).angular_velocity, Vec3(0, 0, 5));

  const Cloth& sheet = loaded.cloths.at(0);
  EXPECT_FALSE(validate(sheet).has_value());
  for (int i = 0; i < sheet.mesh.n_vertices(); ++i) {
    EXPECT_EQ(sheet.v[i], Vec3(1, 2, 3));
    EXPECT_LT((sheet.mesh.x[i] - Vec3(1, 2 + sheet.mesh.X[i].x(), 3 + sheet.mesh.X[i].y())).norm(), 1e-15);
  }
}

TEST_F(SceneIo, EveryNumberReachesTheScene) {
  const Scene scene =
      load(full_scene,
           {{"duration", "2.5"},
            {"gravity", "[1, 2, 3]"},
            {"cloths.0.material", R"({"density": 0.1, "youngs": 60, "poisson": 0.2, "bending": 2e-5, "damping": 0.4})"},
            {"cloths.0.remeshing.angle", "0.1"},
            {"cloths.0.remeshing.velocity", "0.6"},
            {"cloths.0.remeshing.compression", "0.007"},
            {"cloths.0.remeshing.aspect", "0.5"},
            {"contact.threshold", "0.004"},
            {"solver.tolerance", "1e-6"},
            {"output.fps", "24"},
            {"obstacles.0.motion.0", R"({"time": 0.5, "velocity": [4, 5, 6]})"}})
          .scene;
  EXPECT_EQ(scene.duration, 2.5);
  EXPECT_EQ(scene.gravity, Vec3(1, 2, 3));
  const Material& material = scene.cloths[0].material;
  EXPECT_EQ(material.density, 0.1);
  EXPECT_EQ(material.youngs, 60);
  EXPECT_EQ(material.poisson, 0.2);
  EXPECT_EQ(material.bending, 2e-5);
  EXPECT_EQ(material.damping, 0.4);
  const AdaptOptions& adapt = scene.cloths[0].adapt;
  EXPECT_EQ(adapt.angle, 0.1);
  EXPECT_EQ(adapt.velocity, 0.6);
  EXPECT_EQ(adapt.compression, 0.007);
  EXPECT_EQ(adapt.aspect, 0.5);
  EXPECT_EQ(scene.threshold, 0.004);
  EXPECT_EQ(scene.tolerance, 1e-6);
  EXPECT_EQ(scene.fps, 24);
  EXPECT_EQ(scene.obstacles[0].motion[0].time, 0.5);
  EXPECT_EQ(scene.obstacles[0].motion[0].velocity, Vec3(4, 5, 6));
  EXPECT_EQ(scene.obstacles[0].motion[0].angular_velocity, Vec3(0, 0, 0));
}

TEST_F(SceneIo, ResolvedSceneLoadsAsItself) {
  const std::string mesh = "v 0 0 0\nv 1 0 0\nv 0 1 0\nvt 0 0\nvt 1 0\nvt 0 1\nf 1/1 2/2 3/3\n";
  folder_.write("cloth.obj", mesh);
  const std::string with_mesh = with(smallest_scene, "{\"grid\": {}}", "{\"mesh\": \"./cloth.obj\"}");
  for (const std::string& text : {std::string(smallest_scene), std::string(full_scene), with_mesh,
                                  with(full_scene, "0.005", "0.0049999999999999992"),
                                  with(smallest_scene, "\"material\": {}", "\"material\": \"cotton\"")}) {
    const std::string resolved = load(text).resolved_json;
    const std::filesystem::path sub = folder_.path() / "sub";  // a resolved scene needs no neighbours
    std::filesystem::create_directories(sub);
    std::ofstream(sub / "scene.json") << resolved;
    EXPECT_EQ(load_scene(sub / "scene.json").resolved_json, resolved);
  }
  EXPECT_EQ(load(load(with(full_scene, "0.005", "0.0049999999999999992")).resolved_json).scene.time_step,
            0.0049999999999999992);
}

TEST_F(SceneIo, OverridesApplyInOrderBeforeValidation) {
  const LoadedScene loaded = load(full_scene, {{"time_step", "0.1"},
                                               {"time_step", "0.01"},
                                               {"contact.method", "eol"},
                                               {"contact.threshold", "0.002"},
                                               {"cloths.0.remeshing.size", "[0.03,0.1]"},
                                               {"cloths.0.name", "\"flag\""},
                                               {"cloths.0.pins.1.where.edge", "u0"}});
  EXPECT_EQ(loaded.scene.time_step, 0.01);
  EXPECT_EQ(loaded.scene.threshold, 0.002);
  EXPECT_EQ(loaded.scene.cloths[0].adapt.size, (std::array{0.03, 0.1}));
  EXPECT_EQ(loaded.scene.cloths[0].name, "flag");
  EXPECT_EQ(loaded.scene.cloths[0].pins.size(), 2u);
  EXPECT_NE(loaded.resolved_json.find("0.03, 0.1"), std::string::npos);
}

TEST_F(SceneIo, OverridesReachIntoWhatTheSceneLeavesOut) {
  EXPECT_FALSE(load(smallest_scene, {{"dynamics.velocity_terms", "false"}}).scene.velocity_terms);
  const std::string cotton = with(smallest_scene, "\"material\": {}", "\"material\": \"cotton\"");
  const Scene scene = load(cotton, {{"cloths.0.material.youngs", "77"}}).scene;
  EXPECT_EQ(scene.cloths[0].material.youngs, 77);
  EXPECT_EQ(scene.cloths[0].material.density, 0.187);
  const std::string unknown = with(smallest_scene, "\"material\": {}", "\"material\": \"cottn\"");
  EXPECT_EQ(load(unknown, {{"cloths.0.material", "cotton"}}).scene.cloths[0].material.density, 0.187);
}

TEST_F(SceneIo, ReadsPointsAndWires) {
  const std::string box = "\"box\": {\"size\": [1.2, 1.5, 1.0]}";
  const auto shape = [&](const std::string& by) { return load(with(full_scene, box, by)).scene.obstacles.at(0).shape; };
  const ObstacleShape point = shape("\"point\": {\"normal\": [0, 3, -4]}");
  EXPECT_EQ(point.kind, ObstacleShape::Kind::Point);
  ASSERT_EQ(point.corners.size(), 1u);
  EXPECT_LT((point.corners[0].normals.at(0) - Vec3(0, 0.6, -0.8)).norm(), 1e-15);
  EXPECT_EQ(shape("\"point\": {}").corners.at(0).normals.at(0), Vec3(0, 0, 1));
  const ObstacleShape wire = shape("\"wire\": {\"points\": [[0, 0, 0], [1, 0, 0], [1, 2, 0]]}");
  EXPECT_EQ(wire.kind, ObstacleShape::Kind::Wire);
  ASSERT_EQ(wire.edges.size(), 2u);
  EXPECT_EQ(wire.edges[1].b, Vec3(1, 2, 0));
}

TEST_F(SceneIo, SeveralClothsHaveTheirOwnNames) {
  const std::string cloth = "{\"shape\": {\"grid\": {}}, \"material\": {}}";
  const std::string two = with(smallest_scene, cloth, cloth + ", " + cloth);
  const LoadedScene loaded = load(two);
  EXPECT_EQ(loaded.cloths.size(), 2u);
  EXPECT_EQ(loaded.scene.cloths[0].name, "cloth0");
  EXPECT_EQ(loaded.scene.cloths[1].name, "cloth1");
  expect_problem(two, "/cloths/1/name", "taken", {{"cloths.0.name", "a"}, {"cloths.1.name", "a"}});
  const std::string table = "{\"box\": {\"size\": [1, 1, 1]}, \"name\": \"table\"}";
  expect_problem(full_scene, "/obstacles/1/name", "taken", {{"obstacles.1", table}});
}

TEST_F(SceneIo, ShippedMaterialsAreKnownByName) {
  const auto named = [](const std::string& name) {
    return with(smallest_scene, "\"material\": {}", "\"material\": \"" + name + "\"");
  };
  EXPECT_EQ(load(named("cotton")).scene.cloths[0].material.density, 0.187);
  expect_problem(named("coton"), "/cloths/0/material", "did you mean \"cotton\"?");
}

TEST(ShippedScenes, LoadAndAreNamedAfterTheirFile) {
  int n = 0;
  for (const auto& entry : std::filesystem::directory_iterator(CREASE_SCENES)) {
    if (entry.path().extension() != ".json") continue;
    SCOPED_TRACE(entry.path().string());
    const LoadedScene loaded = load_scene(entry.path());
    EXPECT_EQ(loaded.scene.name, entry.path().stem().string());
    EXPECT_GT(loaded.scene.description.size(), 20u);
    EXPECT_LT(loaded.scene.description.size(), 120u) << "one line of a list";
    for (const Cloth& cloth : loaded.cloths) EXPECT_EQ(validate(cloth), std::nullopt);
    ++n;
  }
  EXPECT_GE(n, 3);
}

TEST(NearestName, ForgivesAThirdOfTheLetters) {
  const std::vector<std::string> known{"run", "check", "schema"};
  EXPECT_EQ(nearest_name("runn", known), "run");
  EXPECT_EQ(nearest_name("chekc", known), "check");
  EXPECT_EQ(nearest_name("scheme", known), "schema");
  EXPECT_EQ(nearest_name("view", known), std::nullopt);
  EXPECT_EQ(nearest_name("", known), std::nullopt);
}

}  // namespace
}  // namespace crease
