// SPDX-License-Identifier: MIT
#include "crease/stepper/scene_io.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <filesystem>
#include <fstream>
#include <random>

#include "crease/stepper/suggest.hpp"
#include "support/scene_text.hpp"

namespace crease {
namespace {

using Overrides = std::vector<std::pair<std::string, std::string>>;

class SceneIo : public testing::Test {
 protected:
  LoadedScene load(const std::string& text, const Overrides& overrides = {}) const {
    return load_scene(folder_.write("scene.json", text), overrides);
  }

  std::vector<SceneProblem> problems(const std::string& text, const Overrides& overrides = {}) const {
    try {
      load(text, overrides);
    } catch (const SceneError& error) {
      return error.problems();
    }
    return {};
  }

  // The text is refused for exactly one reason, at this pointer, and says this.
  void expect_problem(const std::string& text, const std::string& pointer, const std::string& says,
                      const Overrides& overrides = {}) const {
    const auto found = problems(text, overrides);
    ASSERT_EQ(found.size(), 1u) << testing::PrintToString(pointers(found)) << " instead of " << pointer;
    EXPECT_EQ(found[0].pointer, pointer) << found[0].message;
    EXPECT_NE(found[0].message.find(says), std::string::npos) << found[0].message << "\nlacks " << says;
  }

  static std::vector<std::string> pointers(const std::vector<SceneProblem>& found) {
    std::vector<std::string> result;
    for (const SceneProblem& problem : found) result.push_back(problem.pointer);
    return result;
  }

  TestFolder folder_;
};

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

TEST_F(SceneIo, ReportsEveryProblemAtOnce) {
  std::string text = full_scene;
  for (const auto& [what, by] :
       std::vector<std::pair<std::string, std::string>>{{"\"format\": 1", "\"format\": 2"},
                                                        {"\"name\": \"edge\"", "\"name\": \"my edge\""},
                                                        {"\"duration\": 4.0,", ""},
                                                        {"\"time_step\": 0.005", "\"time_step\": \"fast\""},
                                                        {"\"gravity\": [0, 0, -9.81]", "\"gravity\": [0, 0]"},
                                                        {"\"density\": 0.05", "\"density\": 1e999"},
                                                        {"\"youngs\": 50", "\"youngs\": NaN"},
                                                        {"\"poisson\": 0.3", "\"poisson\": 0.5"},
                                                        {"\"size\": [0.02, 0.2]", "\"size\": [0.2, 0.02]"},
                                                        {"\"time\": 0.35", "\"time\": 0"},
                                                        {"\"axis\": [0, 0, 1]", "\"axis\": [0, 0, 0]"},
                                                        {"\"threshold\"", "\"treshold\""},
                                                        {"\"friction\": 0.0", "\"friction\": 0.5"},
                                                        {"\"fps\": 60", "\"fps\": -Infinity"}})
    text = with(text, what, by);
  std::vector<std::string> found = pointers(problems(text));
  std::vector<std::string> expected{"/format",
                                    "/name",
                                    "/duration",
                                    "/time_step",
                                    "/gravity",
                                    "/cloths/0/material/density",
                                    "/cloths/0/material/youngs",
                                    "/cloths/0/material/poisson",
                                    "/cloths/0/remeshing/size",
                                    "/cloths/0/pins/0/motion/1/time",
                                    "/obstacles/0/rotation/axis",
                                    "/contact/treshold",
                                    "/contact/friction",
                                    "/output/fps"};
  std::sort(found.begin(), found.end());
  std::sort(expected.begin(), expected.end());
  EXPECT_EQ(found, expected);
}

TEST_F(SceneIo, MessageNamesFilePointerAndWhatWouldBeRight) {
  try {
    load(with(full_scene, "\"time_step\": 0.005", "\"time_step\": -1"));
    FAIL() << "accepted";
  } catch (const SceneError& error) {
    EXPECT_EQ(error.what(), (folder_.path() / "scene.json").string() + ": /time_step: must be a number > 0, got -1");
  }
}

TEST_F(SceneIo, SyntaxErrorsHaveLineAndColumn) {
  expect_problem("{\n  \"format\": 1,\n  \"name\" \"x\"\n}", "", "line 3, column");
  expect_problem("", "", "line 1, column 1");
  expect_problem("{\"format\": 1,}", "", "line 1, column 14");
  expect_problem("[1, 2", "", "line 1");
  expect_problem("{\"format\": nul}", "", "line 1");
  expect_problem("{nan: 1}", "", "line 1");
}

TEST_F(SceneIo, NumbersThatAreNotFiniteHavePointerAndPlace) {
  expect_problem(with(full_scene, "\"time_step\": 0.005", "\"time_step\": 1e999"), "/time_step",
                 "finite number, got 1e999");
  expect_problem(with(full_scene, "[0, 0, -9.81]", "[0, 0, -1e999]"), "/gravity/2", "finite number, got -1e999");
  expect_problem(with(full_scene, "[0, 0, -9.81]", "[NaN, 0, -9.81]"), "/gravity/0", "(line 3, column");
  expect_problem(full_scene, "/time_step", "finite number", {{"time_step", "1e999"}});
}

TEST_F(SceneIo, KeysGivenTwiceAreRefused) {
  expect_problem(with(full_scene, "\"fps\": 60", "\"fps\": 60, \"fps\": 30"), "/output/fps", "twice");
}

TEST_F(SceneIo, NothingButAnObjectIsAScene) {
  expect_problem("[]", "", "must be an object");
  expect_problem("null", "", "must be an object");
  expect_problem("3", "", "must be an object");
}

TEST_F(SceneIo, RangesAreChecked) {
  struct Case {
    std::string what, by, pointer, says;
  };
  const std::vector<Case> cases{
      {"\"duration\": 4.0", "\"duration\": -1", "/duration", ">= 0"},
      {"\"time_step\": 0.005", "\"time_step\": 0", "/time_step", "> 0"},
      {"\"time_step\": 0.005", "\"time_step\": 1e-12", "/time_step", "steps"},
      {"\"size\": [1, 1]", "\"size\": [1, 0]", "/cloths/0/shape/grid/size/1", "> 0"},
      {"\"size\": [1, 1]", "\"size\": [1, 1, 1]", "/cloths/0/shape/grid/size", "a list of 2"},
      {"\"cells\": [8, 8]", "\"cells\": [0, 8]", "/cloths/0/shape/grid/cells/0", ">= 1"},
      {"\"cells\": [8, 8]", "\"cells\": [8.5, 8]", "/cloths/0/shape/grid/cells/0", "an integer"},
      {"\"cells\": [8, 8]", "\"cells\": [4000, 4000]", "/cloths/0/shape/grid/cells", "a million"},
      {"\"cross\"", "\"crss\"", "/cloths/0/shape/grid/pattern", "did you mean \"cross\"?"},
      {"\"seed\": 1", "\"seed\": -1", "/cloths/0/shape/grid/seed", ">= 0"},
      {"\"u\": [1, 0, 0]", "\"u\": [0, 0, 0]", "/cloths/0/placement/u", "not be zero"},
      {"\"v\": [0, 1, 0]", "\"v\": [0, 0, 0]", "/cloths/0/placement/v", "not be zero"},
      {"\"v\": [0, 1, 0]", "\"v\": [-2, 0, 0]", "/cloths/0/placement", "parallel"},
      {"\"density\": 0.05", "\"density\": 0", "/cloths/0/material/density", "> 0"},
      {"\"youngs\": 50", "\"youngs\": 0", "/cloths/0/material/youngs", "> 0"},
      {"\"poisson\": 0.3", "\"poisson\": -0.1", "/cloths/0/material/poisson", ">= 0"},
      {"\"poisson\": 0.3", "\"poisson\": 1", "/cloths/0/material/poisson", "< 0.5"},
      {"\"bending\": 1e-5", "\"bending\": -1e-5", "/cloths/0/material/bending", ">= 0"},
      {"\"damping\": 0.0", "\"damping\": -1", "/cloths/0/material/damping", ">= 0"},
      {"\"size\": [0.02, 0.2]", "\"size\": [0, 0.2]", "/cloths/0/remeshing/size/0", "> 0"},
      {"\"size\": [0.02, 0.2]", "\"size\": [0.3, 0.2]", "/cloths/0/remeshing/size", "not be longer"},
      {"\"size\": [0.02, 0.2], ", "", "/cloths/0/remeshing/size", "is missing"},
      {"\"angle\": 0.3", "\"angle\": 0", "/cloths/0/remeshing/angle", "> 0"},
      {"\"aspect\": 0.2", "\"aspect\": 2", "/cloths/0/remeshing/aspect", "<= 1"},
      {"\"axes\": \"xyz\"", "\"axes\": \"\"", "/cloths/0/pins/0/axes", "one of \"xyz\""},
      {"\"corner\": \"10\"", "\"corner\": \"12\"", "/cloths/0/pins/0/where/corner", "one of \"00\""},
      {"\"corner\": \"10\"", "\"edge\": \"w0\"", "/cloths/0/pins/0/where/edge", "one of \"u0\""},
      {"\"corner\": \"10\"", "\"corner\": \"10\", \"edge\": \"u0\"", "/cloths/0/pins/0/where", "exactly one of"},
      {"\"corner\": \"10\"", "", "/cloths/0/pins/0/where", "got none"},
      {"\"corner\": \"10\"", "\"vertices\": []", "/cloths/0/pins/0/where/vertices", "1 or more"},
      {"\"corner\": \"10\"", "\"vertices\": [145]", "/cloths/0/pins/0/where", "vertices 0 to 144"},
      {"\"corner\": \"10\"", "\"material\": [1.5, 0.5]", "/cloths/0/pins/0/where", "holds no vertex"},
      {"\"ramp\": 0.1", "\"ramp\": -1", "/cloths/0/pins/0/ramp", ">= 0"},
      {"\"time\": 0.35", "\"time\": -1", "/cloths/0/pins/0/motion/1/time", ">= 0"},
      {"\"size\": [1.2, 1.5, 1.0]", "\"size\": [1.2, -1.5, 1.0]", "/obstacles/0/box/size/1", "> 0"},
      {"{\"size\": [1.2, 1.5, 1.0]}", "{}", "/obstacles/0/box/size", "is missing"},
      {"\"box\": {\"size\": [1.2, 1.5, 1.0]}, ", "", "/obstacles/0", "exactly one of box, point, wire, mesh"},
      {"\"degrees\": 0", "\"degrees\": \"0\"", "/obstacles/0/rotation/degrees", "a number, got \"0\""},
      {"\"threshold\": 0.001", "\"threshold\": 0", "/contact/threshold", "> 0"},
      {"\"friction\": 0.0", "\"friction\": -1", "/contact/friction", ">= 0"},
      {"\"velocity_terms\": true", "\"velocity_terms\": 1", "/dynamics/velocity_terms", "true or false"},
      {"\"tolerance\": 1e-8", "\"tolerance\": 0", "/solver/tolerance", "> 0"},
      {"\"fps\": 60", "\"fps\": 0", "/output/fps", "> 0"},
      {"\"fps\": 60", "\"fps\": 1e6", "/output/fps", "frames"},
      {"[\"vtp\"]", "[\"vtk\"]", "/output/formats/0", "did you mean \"vtp\"?"},
      {"[\"vtp\"]", "[\"vtp\", \"vtp\"]", "/output/formats/1", "twice"},
      {"[\"vtp\"]", "[]", "/output/formats", "1 or more"},
      {"\"name\": \"sheet\"", "\"name\": \"two\\nlines\"", "/cloths/0/name", "text that matches"},
  };
  for (const auto& [what, by, pointer, says] : cases) {
    SCOPED_TRACE(what + " -> " + by);
    expect_problem(with(full_scene, what, by), pointer, says);
  }
}

TEST_F(SceneIo, WhatIsRequiredIsNamed) {
  expect_problem(with(full_scene, "\"format\": 1, ", ""), "/format", "is missing; must be 1");
  expect_problem(with(full_scene, "\"name\": \"edge\", ", ""), "/name", "is missing");
  expect_problem(with(smallest_scene, ", \"material\": {}", ""), "/cloths/0/material", "is missing; must be the name");
  expect_problem(with(smallest_scene, "\"shape\": {\"grid\": {}}, ", ""), "/cloths/0/shape", "is missing");
  expect_problem(with(smallest_scene, "{\"shape\": {\"grid\": {}}, \"material\": {}}", ""), "/cloths", "1 or more");
}

TEST_F(SceneIo, UnknownKeysAreNamedEverywhere) {
  for (const auto& [before, pointer] : std::vector<std::pair<std::string, std::string>>{
           {"\"format\"", "/"},
           {"\"shape\"", "/cloths/0/"},
           {"\"grid\"", "/cloths/0/shape/"},
           {"\"cells\"", "/cloths/0/shape/grid/"},
           {"\"origin\"", "/cloths/0/placement/"},
           {"\"density\"", "/cloths/0/material/"},
           {"\"method\": \"conformal\"", "/cloths/0/remeshing/"},
           {"\"where\"", "/cloths/0/pins/0/"},
           {"\"corner\"", "/cloths/0/pins/0/where/"},
           {"\"time\": 0.35", "/cloths/0/pins/0/motion/1/"},
           {"\"box\"", "/obstacles/0/"},
           {"\"size\": [1.2", "/obstacles/0/box/"},
           {"\"axis\"", "/obstacles/0/rotation/"},
           {"\"time\": 0, \"velocity\": [0, 0, 0], \"angular", "/obstacles/0/motion/0/"},
           {"\"method\": \"eol\"", "/contact/"},
           {"\"integrator\"", "/dynamics/"},
           {"\"qp\"", "/solver/"},
           {"\"fps\"", "/output/"}}) {
    SCOPED_TRACE(before);
    expect_problem(with(full_scene, before, "\"a/b~c\": 0, " + before), pointer + "a~1b~0c", "unknown key; known are");
  }
  expect_problem(with(full_scene, "\"gravity\"", "\"gravty\""), "/gravty", "did you mean \"gravity\"?");
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

TEST_F(SceneIo, RefusesPointsAndWiresThatAreNone) {
  struct Case {
    std::string by, pointer, says;
  };
  const std::string box = "\"box\": {\"size\": [1.2, 1.5, 1.0]}";
  for (const auto& [by, pointer, says] : std::vector<Case>{
           {"\"point\": {\"normal\": [0, 0, 0]}", "/obstacles/0/point/normal", "must not be zero"},
           {"\"point\": {\"normal\": [0, 0, \"up\"]}", "/obstacles/0/point/normal/2", "a number"},
           {"\"point\": 7", "/obstacles/0/point", "an object"},
           {"\"wire\": {}", "/obstacles/0/wire/points", "is missing"},
           {"\"wire\": {\"points\": [[0, 0, 0]]}", "/obstacles/0/wire/points", "2 or more"},
           {"\"wire\": {\"points\": [[0, 0, 0], [1, 0]]}", "/obstacles/0/wire/points/1", "a list of 3"},
           {"\"wire\": {\"points\": [[0, 0, 0], [1, 0, 0], [1, 0, 0]]}", "/obstacles/0/wire/points/2", "unlike"},
           {"\"wire\": {\"points\": [[-1e308, 0, 0], [1e308, 0, 0]]}", "/obstacles/0/wire/points/1", "unlike"}}) {
    SCOPED_TRACE(by);
    expect_problem(with(full_scene, box, by), pointer, says);
  }
}

TEST_F(SceneIo, WhatComesLaterIsRefusedByName) {
  struct Case {
    std::string what, by, pointer;
  };
  const std::string box = "\"box\": {\"size\": [1.2, 1.5, 1.0]}";
  for (const auto& [what, by, pointer] :
       std::vector<Case>{{"\"friction\": 0.0", "\"friction\": 0.3", "/contact/friction"},
                         {"\"self\": false", "\"self\": true", "/contact/self"},
                         {"\"eol\"", "\"lagrangian_averaged\"", "/contact/method"},
                         {"\"eol\"", "\"lagrangian_cone\"", "/contact/method"},
                         {"\"linear\"", "\"newton\"", "/dynamics/integrator"},
                         {box, "\"mesh\": {\"file\": \"rock.obj\", \"sharp_angle\": 30}", "/obstacles/0/mesh"}}) {
    SCOPED_TRACE(by);
    expect_problem(with(full_scene, what, by), pointer, "not available yet");
  }
}

TEST_F(SceneIo, EolContactNeedsConformalMeshes) {
  const std::string none = with(full_scene, "\"conformal\"", "\"none\"");
  expect_problem(none, "/cloths/0/remeshing/method", "must be \"conformal\"");
  const std::string adaptive = with(full_scene, "\"conformal\"", "\"adaptive\"");
  expect_problem(adaptive, "/cloths/0/remeshing/method", "must be \"conformal\"");
  EXPECT_NO_THROW(load(none, {{"obstacles", "[]"}}));
  EXPECT_NO_THROW(load(adaptive, {{"obstacles", "[]"}}));
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

TEST_F(SceneIo, MeshTroubleStandsAtTheMesh) {
  const std::string text = with(smallest_scene, "{\"grid\": {}}", "{\"mesh\": \"cloth.obj\"}");
  const std::string square =
      "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nvt 0 0\nvt 1 0\nvt 1 1\nvt 0 1\nf 1/1 2/2 3/3\nf 1/1 3/3 4/4\n";
  const std::string pointer = "/cloths/0/shape/mesh";
  expect_problem(text, pointer, "No such file");
  folder_.write("cloth.obj", square);
  EXPECT_EQ(load(text).cloths.at(0).mesh.n_faces(), 2);
  EXPECT_NE(load(text).resolved_json.find((folder_.path() / "cloth.obj").string()), std::string::npos);
  expect_problem(text, "/cloths/0/placement", "only a grid", {{"cloths.0.placement.origin", "[0,0,0]"}});
  folder_.write("cloth.obj", with(square, "f 1/1 3/3 4/4", "f 1/1 4/4 3/3"));
  expect_problem(text, pointer, "cloth.obj:10: triangle is inverted");
  folder_.write("cloth.obj", square + "v 2 2 2\nvt 0.5 0.4\nf 1/1 2/2 5/5\n");
  expect_problem(text, pointer, "cloth.obj:13: edge 1-2");
  folder_.write("cloth.obj", with(square, "vt 0 1\n", "vt 0.5 0.5\n"));
  expect_problem(text, pointer, "cloth.obj:10: triangle of zero area");
  folder_.write("cloth.obj", with(square, "v 0 1 0\n", "v 0.5 0.5 0\n"));
  expect_problem(text, pointer, "triangle 2 has zero area in the world");
  folder_.write("cloth.obj", with(square, "v 0 1 0\n", "v 0 1 nan\n"));
  expect_problem(text, pointer, "cloth.obj:4: expected a finite number");
}

TEST_F(SceneIo, ShippedMaterialsAreKnownByName) {
  const auto named = [](const std::string& name) {
    return with(smallest_scene, "\"material\": {}", "\"material\": \"" + name + "\"");
  };
  EXPECT_EQ(load(named("cotton")).scene.cloths[0].material.density, 0.187);
  expect_problem(named("coton"), "/cloths/0/material", "did you mean \"cotton\"?");
}

TEST_F(SceneIo, OverridesThatReachNothingAreRefused) {
  expect_problem(full_scene, "/contact/metod", "did you mean \"method\"?", {{"contact.metod", "eol"}});
  expect_problem(full_scene, "/cloths", "--set cloths.3.name", {{"cloths.3.name", "x"}});
  expect_problem(full_scene, "/cloths", "counted from 0", {{"cloths.first.name", "x"}});
  expect_problem(full_scene, "/time_step", "below a plain value", {{"time_step.x", "1"}});
}

// -- pins -------------------------------------------------------------------------------------------------------------

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

// -- files ------------------------------------------------------------------------------------------------------------

TEST_F(SceneIo, AFileThatCannotBeReadIsNoSceneError) {
  for (const auto& file : {folder_.path() / "none.json", folder_.path()}) {
    try {
      load_scene(file);
      FAIL() << "read " << file;
    } catch (const SceneError&) {
      FAIL() << "a scene error for " << file;
    } catch (const std::runtime_error& error) {
      EXPECT_TRUE(std::string(error.what()).starts_with(file.string()));
    }
  }
}

TEST_F(SceneIo, DamagedTextIsRefusedOrReadButNeverCrashes) {
  const std::uint64_t seed = 11;
  SCOPED_TRACE(seed);
  std::mt19937_64 random(seed);
  const std::string bytes = "0123456789-+.eE\"\\{}[]:,/* \nnaNulltrue\xff" + std::string(1, '\0');
  int read = 0, refused = 0;
  for (int trial = 0; trial < 400; ++trial) {
    std::string text = full_scene;
    for (int change = trial % 3; change >= 0; --change) {
      const size_t at = random() % text.size();
      const size_t kind = random() % 3;
      if (kind == 0) text[at] = bytes[random() % bytes.size()];
      if (kind == 1) text.insert(at, 1, bytes[random() % bytes.size()]);
      if (kind == 2) text.erase(at, 1 + random() % 20);
    }
    try {
      const std::string resolved = load(text).resolved_json;
      EXPECT_EQ(load(resolved).resolved_json, resolved) << text;
      ++read;
    } catch (const SceneError& error) {
      EXPECT_FALSE(error.problems().empty());
      ++refused;
    }
  }
  EXPECT_GT(read, 10);
  EXPECT_GT(refused, 100);
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

// -- suggestions ------------------------------------------------------------------------------------------------------

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
