// SPDX-License-Identifier: MIT
#include "support/scene_text.hpp"

#include "crease/stepper/run.hpp"

#include <chrono>
#include <fstream>
#include <memory>
#include <thread>

#include <gtest/gtest.h>

#include "support/run_control.hpp"

namespace crease {
namespace {

using namespace testing;

TEST(Run, GivesOneRowAStepAndReachesTheDuration) {
  const TestFolder folder;
  LoadedScene loaded = hanging_scene();
  loaded.scene.duration = 0.0125;  // two and a half steps
  ASSERT_EQ(run_scene(loaded, {.directory = folder.path()}).status, RunStatus::Done);
  auto steps = read_steps(folder.path());
  EXPECT_EQ(steps["step"], (std::vector<double>{1, 2, 3}));
  EXPECT_EQ(steps["time"], (std::vector<double>{0.005, 0.01, 0.0125}));
  EXPECT_EQ(steps["time_step"].front(), 0.005);
  EXPECT_NEAR(steps["time_step"].back(), 0.0025, 1e-15);  // a difference of the two times above
}

// A block rises round a pinned corner: pins decide, so the cloth goes into it, and the run says so.
TEST(Run, WarnsOfClothInsideAnObstacle) {
  const TestFolder folder;
  LoadedScene loaded = hanging_scene();
  Obstacle block{.name = "block", .shape = make_box({0.2, 0.2, 0.2}), .start = {}, .motion = {}};
  block.start.position = loaded.cloths[0].mesh.x[0] - Vec3(0, 0, 0.105);
  block.motion = {{.time = 0, .velocity = {0, 0, 0.5}}};
  loaded.scene.obstacles = {block};
  const RunResult result = run_scene(loaded, {.directory = folder.path(), .until = 0.05});
  ASSERT_EQ(result.status, RunStatus::Done) << result.message;
  ASSERT_FALSE(result.warnings.empty());
  EXPECT_NE(result.warnings[0].find("inside an obstacle by 0.02 m at 0.05 s"), std::string::npos) << result.warnings[0];
}

// At 50 m/s a step of 5 ms bends the sheet by half its length, which no linearisation follows. At .5 m/s all is well;
// and with a hand that moves, energy may come from there.
TEST(Run, WarnsOfEnergyThatNothingGave) {
  const auto warnings_of = [](LoadedScene loaded, double speed, bool is_driven) {
    const TestFolder folder;
    for (Vec3& v : loaded.cloths[0].v) v.z() = -speed;
    loaded.scene.cloths[0].material.youngs = 5000;
    if (is_driven) loaded.scene.obstacles[0].motion = {{.time = 0, .velocity = {0.1, 0, 0}}};
    const RunResult result = run_scene(loaded, {.directory = folder.path(), .until = 0.01});
    EXPECT_EQ(result.status, RunStatus::Done) << result.message;
    std::string all;
    for (const std::string& warning : result.warnings) all += warning + "\n";
    return all;
  };
  EXPECT_NE(warnings_of(table_scene(), 50, false).find("the energy rose by"), std::string::npos);
  EXPECT_EQ(warnings_of(table_scene(), 0.5, false), "");
  EXPECT_EQ(warnings_of(table_scene(), 50, true).find("the energy rose by"), std::string::npos);
}

TEST(Run, WritesAFrameAtTheFirstStepEndAfterEachPeriod) {
  const TestFolder folder;
  const LoadedScene loaded = hanging_scene();
  ASSERT_EQ(run_scene(loaded, {.directory = folder.path()}).status, RunStatus::Done);
  const std::string list = bytes_of(folder.path() / "cloth.pvd");
  // 0.225 s at 60 frames a second: 0 .. 13; 5 ms steps: the k-th multiple of 1/60 s is met ceil(10 k / 3) steps in.
  for (int k = 0; k <= 13; ++k) {
    char name[32];
    std::snprintf(name, sizeof name, "frames/%06d", k);
    EXPECT_TRUE(fs::exists(folder.path() / (std::string(name) + ".vtp")));
    std::ifstream obj(folder.path() / (std::string(name) + ".obj"));
    std::string hash, word;
    double time = -1;
    obj >> hash >> word >> time;
    EXPECT_DOUBLE_EQ(time, 0.005 * ((10 * k + 2) / 3)) << name;
    EXPECT_NE(list.find(std::string(name) + ".vtp"), std::string::npos);
  }
  EXPECT_EQ(std::distance(fs::directory_iterator(folder.path() / "frames"), {}), 28);
}

TEST(Run, WritesAtMostOneFrameAStep) {
  const TestFolder folder;
  LoadedScene loaded = hanging_scene();
  loaded.scene.duration = 0.05;
  loaded.scene.fps = 1000;
  loaded.scene.formats = {FrameFormat::Obj};
  ASSERT_EQ(run_scene(loaded, {.directory = folder.path()}).status, RunStatus::Done);
  EXPECT_EQ(std::distance(fs::directory_iterator(folder.path() / "frames"), {}), 11);
}

TEST(Run, RepeatsItselfByteForByte) {
  const TestFolder folder;
  for (const LoadedScene& loaded : {hanging_scene(), table_scene()}) {
    SCOPED_TRACE(loaded.scene.name);
    const fs::path a = folder.path() / (loaded.scene.name + "_a"), b = folder.path() / (loaded.scene.name + "_b");
    ASSERT_EQ(run_scene(loaded, {.directory = a}).status, RunStatus::Done);
    ASSERT_EQ(run_scene(loaded, {.directory = b}).status, RunStatus::Done);
    EXPECT_EQ(differences(repeatable_bytes(a), repeatable_bytes(b)), Names());
  }
}

TEST(Run, FailsWithStepTimeAndStageAfterTenHalvings) {
  const TestFolder folder;
  RunOptions options{.directory = folder.path() / "run", .stages = failing_solver([](int call) { return call > 3; })};
  const RunResult result = run_scene(hanging_scene(), options);
  EXPECT_EQ(result.status, RunStatus::SimulationFailed);
  for (const char* part : {"step 4", "0.015 s to 0.02 s", "stage solve", "4.88281e-06 s"})  // 5 ms / 1024
    EXPECT_NE(result.message.find(part), std::string::npos) << result.message;
  EXPECT_EQ(read_steps(options.directory)["step"].size(), 3u);
  EXPECT_EQ(summary_of(options.directory)["why"], result.message);
  EXPECT_FALSE(summary_of(options.directory)["finished"]);
  EXPECT_EQ(run_scene(hanging_scene(), {.directory = options.directory, .resume = true}).status, RunStatus::Done);
}

// Calls: 1 is step 1. Step 2: calls 2, 3, 4 fail with h, h/2, h/4; then parts of 1/8, 1/8, 1/4, 1/2 pass: calls 5 to 8.
TEST(Run, CoversAFailedStepInPartsThatGrowAgain) {
  const TestFolder folder;
  std::vector<double> parts;
  RunOptions options{.directory = folder.path() / "run"};
  options.stages = [&parts, failing = failing_solver([](int call) { return call >= 2 && call <= 4; })](
                       const Scene& scene, const ClothSpec& spec) {
    Stages stages = failing(scene, spec);
    stages.detect = [&parts](const Cloth&, std::span<const PosedObstacle>, double h) {
      parts.push_back(h / 0.005);
      return std::vector<Contact>();
    };
    return stages;
  };
  LoadedScene loaded = hanging_scene();
  ASSERT_EQ(run_scene(loaded, options, stop_after(3)).status, RunStatus::Interrupted);
  EXPECT_EQ(parts, (std::vector<double>{1, 1, 0.5, 0.25, 0.125, 0.125, 0.25, 0.5, 1}));
  EXPECT_EQ(read_steps(options.directory)["retries"], (std::vector<double>{0, 3, 0}));
  EXPECT_EQ(summary_of(options.directory)["retries"], 3);
}

// Riders at a needle cross it in all but the shortest parts, in step after step. A run of throw, gravity off by 4e-9 of
// itself, had that for the rest of its time: 1023 retries a step, as parts of 1/1024 were short enough just so.
TEST(Run, DoesNotTakeStepAfterStepInTheSmallestParts) {
  const TestFolder folder;
  RunOptions options{.directory = folder.path() / "run", .until = 0.12};
  options.stages = [](const Scene& scene, const ClothSpec& spec) {
    Stages stages = make_stages(scene, spec);
    const auto too_fast = std::make_shared<std::vector<int>>();  // unknowns
    stages.constrain = [too_fast, constrain = stages.constrain](
                           const Cloth& cloth, const DofMap& dofs, std::span<const Contact> contacts,
                           std::span<const PosedObstacle> obstacles, std::span<const PinState> pins,
                           const ConstraintOptions& constraint_options) {
      too_fast->clear();
      if (constraint_options.held.empty() && constraint_options.h > 2.5 / 1024 * 5e-3)
        for (int v = 0; v < cloth.mesh.n_vertices(); ++v)
          if (cloth.is_eol(v) && !cloth.mesh.is_border_vertex(v)) too_fast->push_back(dofs.X(v));
      return constrain(cloth, dofs, contacts, obstacles, pins, constraint_options);
    };
    stages.solve = [too_fast, solve = stages.solve](const QpProblem& problem, std::span<const char> guess) {
      QpResult result = solve(problem, guess);
      for (const int i : *too_fast) result.q[i] = 1e5;
      return result;
    };
    return stages;
  };
  const LoadedScene loaded = load_scene(fs::path(CREASE_SCENES) / "lo_res.json", {});
  const RunResult result = run_scene(loaded, options);
  ASSERT_EQ(result.status, RunStatus::Done) << result.message;
  auto steps = read_steps(options.directory);
  EXPECT_GT(steps["eol_vertices"].back(), 0);
  EXPECT_GT(steps["held"].back(), 0);
  EXPECT_GE(steps["retries"].back(), 10);
  EXPECT_LE(steps["retries"].back(), 50) << "500 in parts of 1/512";
}

// The second sheet's solver fails once, on call 4 (step 2): the first one must take the two halves as well.
TEST(Run, StepsAllSheetsOrNone) {
  const TestFolder folder;
  LoadedScene loaded = hanging_scene();
  add_sheet(loaded, hanging_sheet());
  RunOptions options{.directory = folder.path() / "run", .stages = failing_solver([](int call) { return call == 4; })};
  ASSERT_EQ(run_scene(loaded, options, stop_after(3)).status, RunStatus::Interrupted);
  EXPECT_EQ(read_steps(options.directory)["retries"], (std::vector<double>{0, 1, 0}));

  LoadedScene alone = hanging_scene();
  RunOptions twice{.directory = folder.path() / "alone", .stages = failing_solver([](int call) { return call == 2; })};
  ASSERT_EQ(run_scene(alone, twice, stop_after(3)).status, RunStatus::Interrupted);
  auto both = read_steps(options.directory), one = read_steps(twice.directory);
  for (const char* column : {"kinetic_energy", "momentum_z", "membrane_energy"})
    for (int k = 0; k < 3; ++k) EXPECT_DOUBLE_EQ(both[column][k], 2 * one[column][k]) << column;  // doubling is exact
}

TEST(Run, TellsWhatTheSceneLeavesOut) {
  const TestFolder folder;
  LoadedScene loaded = hanging_scene();
  ASSERT_EQ(run_scene(loaded, {.directory = folder.path() / "pinned", .until = 0.01}).status, RunStatus::Done);
  EXPECT_EQ(summary_of(folder.path() / "pinned")["left_out"], Names({"detect", "remesh", "transfer"}));
  loaded.scene.cloths[0].pins.clear();
  for (auto& pins : loaded.cloths[0].pins) pins = 0;
  ASSERT_EQ(run_scene(loaded, {.directory = folder.path() / "free", .until = 0.01}).status, RunStatus::Done);
  EXPECT_EQ(summary_of(folder.path() / "free")["left_out"], Names({"detect", "remesh", "transfer", "constrain", "qp"}));
  for (const char* column : {"t_detect", "t_remesh", "t_transfer", "t_constrain", "qp_iterations"})
    EXPECT_EQ(read_steps(folder.path() / "free")[column], (std::vector<double>{0, 0})) << column;
}

// What is left out is what no sheet has, whoever chose the stages; its column is 0 because it is not called.
TEST(Run, AStageOfOnesOwnIsNotLeftOut) {
  const TestFolder folder;
  RunOptions options{.directory = folder.path() / "run", .until = 0.01};
  options.stages = [](const Scene& scene, const ClothSpec& spec) {
    Stages stages = make_stages(scene, spec);
    stages.detect = [](const Cloth&, std::span<const PosedObstacle>, double) {
      std::this_thread::sleep_for(std::chrono::milliseconds(2));
      return std::vector<Contact>();
    };
    return stages;
  };
  ASSERT_EQ(run_scene(hanging_scene(), options).status, RunStatus::Done);
  EXPECT_EQ(summary_of(options.directory)["left_out"], Names({"remesh", "transfer"}));
  auto steps = read_steps(options.directory);
  ASSERT_EQ(steps["t_detect"].size(), 2u);
  for (const double seconds : steps["t_detect"]) EXPECT_GE(seconds, 0.002);
}

// One exchange of the working set is never enough here, so the reference solver has to answer, and is seen to.
TEST(Run, CountsWhatTheSolverFellBackOn) {
  const TestFolder folder;
  const LoadedScene loaded = table_scene();
  RunOptions options{.directory = folder.path() / "short", .until = 0.05};
  options.stages = [](const Scene& scene, const ClothSpec& spec) {
    Stages stages = make_stages(scene, spec);
    stages.solve = [solver = std::shared_ptr<QpSolver>(make_qp_solver(scene.qp))](const QpProblem& problem,
                                                                                  std::span<const char>) {
      return solver->solve(problem, {.max_iterations = 1});
    };
    return stages;
  };
  ASSERT_EQ(run_scene(loaded, options).status, RunStatus::Done);
  ASSERT_EQ(run_scene(loaded, {.directory = folder.path() / "plain", .until = 0.05}).status, RunStatus::Done);
  auto fell_back = read_steps(options.directory), plain = read_steps(folder.path() / "plain");
  double sum = 0;
  for (const double count : fell_back["qp_fallbacks"]) sum += count;
  EXPECT_GT(sum, 0);
  EXPECT_EQ(summary_of(options.directory)["qp_fallbacks"], sum);
  EXPECT_EQ(plain["qp_fallbacks"], std::vector<double>(plain["step"].size(), 0.0));
  // Both solve to 1e-8 of the largest velocity.
  for (std::size_t k = 0; k < plain["step"].size(); ++k)
    EXPECT_NEAR(fell_back["momentum_z"][k], plain["momentum_z"][k], 1e-8);
}

TEST(Run, TakesAsManyStepsAsASceneMayAskFor) {
  const TestFolder folder;
  LoadedScene loaded = hanging_scene();
  loaded.scene.time_step = 1e-8;
  loaded.scene.duration = 1;  // 1e8 steps: the most that the reader accepts
  EXPECT_EQ(run_scene(loaded, {.directory = folder.path(), .until = 1e-8}).status, RunStatus::Done);
}

TEST(Run, ReportsItsProgressAfterEachStep) {
  const TestFolder folder;
  std::vector<RunProgress> seen;
  const RunResult result =
      run_scene(hanging_scene(), {.directory = folder.path(), .until = 0.02}, [&](const RunProgress& p) {
        seen.push_back(p);
        return true;
      });
  EXPECT_EQ(result.status, RunStatus::Done);
  ASSERT_EQ(seen.size(), 4u);
  for (int k = 0; k < 4; ++k) {
    EXPECT_EQ(seen[k].step, k + 1);
    EXPECT_DOUBLE_EQ(seen[k].time, 0.005 * (k + 1));
    EXPECT_EQ(seen[k].duration, 0.02);  // what is asked for, so that progress ends at 100 %
    EXPECT_EQ(seen[k].faces, 36);       // 3 x 3 cells, 4 triangles each
    EXPECT_GE(seen[k].wall, k ? seen[k - 1].wall : 0.0);
  }
}

}  // namespace
}  // namespace crease
