// SPDX-License-Identifier: MIT
// What a scene may not say, and how it is told.
#include "crease/geometry/obj_io.hpp"
#include "support/scene_io.hpp"

#include <algorithm>
#include <random>

namespace crease {
namespace {

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

// 100 000 brackets took 10 GB for their pointers; as the value of an override, all of the stack.
TEST_F(SceneIo, BracketsWithoutEndAreRefused) {
  const std::string open(100000, '['), closed(100000, ']');
  for (const std::string& text : {open, open + closed, "{\"cloths\": " + open + closed + "}"})
    expect_problem(text, "", "at most 100 lists and objects");
  expect_problem(full_scene, "/cloths", "at most 100 lists and objects", {{"cloths", open + closed}});
  std::string path = "cloths.0.material.density";
  for (int k = 0; k < 100000; ++k) path += ".a";
  expect_problem(full_scene, "", "at most 100 lists and objects", {{path, "1"}});
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
      {"\"size\": [0.02, 0.2]", "\"size\": [1e-4, 2e-4]", "/cloths/0/remeshing/size", "a million"},
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
      {"\"threshold\": 0.001", "\"threshold\": 1", "/contact/threshold", "the length of the cloth, 1.0 m"},
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
           {"\"wire\": {\"points\": [[-1e308, 0, 0], [1, 0, 0]]}", "/obstacles/0/wire/points/0/0", "1000000000"}}) {
    SCOPED_TRACE(by);
    expect_problem(with(full_scene, box, by), pointer, says);
  }
}

TEST_F(SceneIo, RefusesVectorsThatNoSumSurvives) {
  expect_problem(with(full_scene, "[0, 0, -9.81]", "[0, 0, -1e300]"), "/gravity/2", "1000000000");
}

TEST_F(SceneIo, RefusesADeviceWithoutAnEnd) {
  EXPECT_THROW(load_scene("/dev/zero"), std::runtime_error);
  EXPECT_THROW(read_obj("/dev/zero"), std::runtime_error);
}

TEST_F(SceneIo, WhatComesLaterIsRefusedByName) {
  struct Case {
    std::string what, by, pointer;
  };
  for (const auto& [what, by, pointer] :
       std::vector<Case>{{"\"friction\": 0.0", "\"friction\": 0.3", "/contact/friction"},
                         {"\"self\": false", "\"self\": true", "/contact/self"},
                         {"\"linear\"", "\"newton\"", "/dynamics/integrator"}}) {
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

TEST_F(SceneIo, WhereNothingTouchesAnyThresholdWillDo) {
  const std::string wide = with(full_scene, "\"threshold\": 0.001", "\"threshold\": 10");
  EXPECT_NO_THROW(load(wide, {{"obstacles", "[]"}}));
  EXPECT_NO_THROW(load(with(full_scene, "\"threshold\": 0.001", "\"threshold\": 0.9")));
}

TEST_F(SceneIo, OneMistakeIsOneProblem) {
  // A grid gets its placement by default: nothing that the scene says.
  const std::string both = with(smallest_scene, "{\"grid\": {}}", "{\"grid\": {}, \"mesh\": \"cloth.obj\"}");
  EXPECT_EQ(pointers(problems(both)), std::vector<std::string>{"/cloths/0/shape"});
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

TEST_F(SceneIo, OverridesThatReachNothingAreRefused) {
  expect_problem(full_scene, "/contact/metod", "did you mean \"method\"?", {{"contact.metod", "eol"}});
  expect_problem(full_scene, "/cloths", "--set cloths.3.name", {{"cloths.3.name", "x"}});
  expect_problem(full_scene, "/cloths", "counted from 0", {{"cloths.first.name", "x"}});
  expect_problem(full_scene, "/time_step", "below a plain value", {{"time_step.x", "1"}});
}

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

}  // namespace
}  // namespace crease
