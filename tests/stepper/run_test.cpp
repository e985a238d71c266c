// SPDX-License-Identifier: MIT
#include "support/scene_text.hpp"

#include "crease/stepper/run.hpp"

#include <chrono>
#include <csignal>
#include <fstream>
#include <memory>
#include <thread>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "support/runs.hpp"

namespace crease {
namespace {

using namespace testing;
using Names = std::vector<std::string>;

nlohmann::json summary_of(const fs::path& directory) {
  return nlohmann::json::parse(bytes_of(directory / "summary.json"));
}

/// Interrupts after the given step of this call.
std::function<bool(const RunProgress&)> stop_after(int step) {
  return [step](const RunProgress& progress) { return progress.step < step; };
}

/// Stages whose solver fails where `fails(call)` says so, calls counted from 1 over all steps and sheets.
auto failing_solver(std::function<bool(int)> fails) {
  auto calls = std::make_shared<int>(0);
  return [calls, fails](const Scene& scene, const ClothSpec& spec) {
    Stages stages = make_stages(scene, spec);
    stages.solve = [calls, fails, shipped = stages.solve](const QpProblem& problem, std::span<const char> guess) {
      QpResult result = shipped(problem, guess);
      if (fails(++*calls)) result.status = QpStatus::IterationLimit;
      return result;
    };
    return stages;
  };
}

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

// Steps 20 and 40 have checkpoints: interruptions lie on them, right beside them, before the first and near the end.
TEST(Run, InterruptedAndResumedWritesTheSameBytes) {
  const TestFolder folder;
  for (const LoadedScene& loaded : {hanging_scene(), table_scene()}) {
    const fs::path whole = folder.path() / loaded.scene.name;
    ASSERT_EQ(run_scene(loaded, {.directory = whole}).status, RunStatus::Done);
    for (const int step : {1, 19, 20, 21, 39, 44}) {
      SCOPED_TRACE(loaded.scene.name + ", step " + std::to_string(step));
      const fs::path parts = folder.path() / (loaded.scene.name + std::to_string(step));
      const RunResult first = run_scene(loaded, {.directory = parts}, stop_after(step));
      EXPECT_EQ(first.status, RunStatus::Interrupted);
      EXPECT_EQ(read_steps(parts)["step"].size(), static_cast<std::size_t>(step));
      EXPECT_FALSE(summary_of(parts)["finished"]);
      EXPECT_EQ(run_scene(loaded, {.directory = parts, .resume = true}).status, RunStatus::Done);
      EXPECT_EQ(differences(repeatable_bytes(whole), repeatable_bytes(parts)), Names());
      EXPECT_TRUE(summary_of(parts)["finished"]);
    }
  }
}

TEST(RunDeathTest, KilledAndResumedWritesTheSameBytes) {
  const TestFolder folder;
  const LoadedScene loaded = hanging_scene();
  const fs::path whole = folder.path() / "whole", parts = folder.path() / "parts";
  ASSERT_EQ(run_scene(loaded, {.directory = whole}).status, RunStatus::Done);
  const auto kill_after = [](int step) {
    return [step](const RunProgress& progress) { return progress.step != step || raise(SIGKILL) == 0; };
  };
  EXPECT_EXIT(run_scene(loaded, {.directory = parts}, kill_after(33)), ::testing::KilledBySignal(SIGKILL), "");
  EXPECT_EXIT(run_scene(loaded, {.directory = parts, .resume = true}, kill_after(37)),
              ::testing::KilledBySignal(SIGKILL), "");
  // A forced run in its place, killed as soon as it stands, is the one that goes on.
  const fs::path forced = folder.path() / "forced";
  LoadedScene shorter = loaded;
  shorter.scene.duration = 0.05;
  shorter.resolved_json = R"({"name": "shorter"})";
  ASSERT_EQ(run_scene(shorter, {.directory = forced}).status, RunStatus::Done);
  EXPECT_EXIT(run_scene(loaded, {.directory = forced, .force = true}, kill_after(1)),
              ::testing::KilledBySignal(SIGKILL), "");
  EXPECT_EQ(run_scene(loaded, {.directory = forced, .resume = true}).status, RunStatus::Done);
  EXPECT_EQ(differences(repeatable_bytes(whole), repeatable_bytes(forced)), Names());
  // What a kill in the middle of writing leaves behind.
  std::ofstream(parts / "steps.csv", std::ios::app) << "38,0.19,0.0";
  std::ofstream(parts / "frames/000012.vtp.tmp") << "<?xml";
  std::ofstream(parts / "checkpoint.bin.tmp") << "crease";
  EXPECT_EQ(run_scene(loaded, {.directory = parts, .resume = true}).status, RunStatus::Done);
  EXPECT_EQ(differences(repeatable_bytes(whole), repeatable_bytes(parts)), Names());
}

TEST(Run, ResumesWhateverFollowsTheRowsOfItsCheckpoint) {
  const TestFolder folder;
  const LoadedScene loaded = hanging_scene();
  const fs::path whole = folder.path() / "whole", parts = folder.path() / "parts";
  ASSERT_EQ(run_scene(loaded, {.directory = whole}).status, RunStatus::Done);
  run_scene(loaded, {.directory = parts}, stop_after(25));
  std::ofstream(parts / "steps.csv", std::ios::app) << std::string(100, '\0') << "\n\n";  // the machine lost its power
  EXPECT_EQ(run_scene(loaded, {.directory = parts, .resume = true}).status, RunStatus::Done);
  EXPECT_EQ(differences(repeatable_bytes(whole), repeatable_bytes(parts)), Names());

  const std::string rows = bytes_of(parts / "steps.csv");
  for (const std::string& bad : {rows.substr(0, 1000), "\n" + rows, std::string(rows).replace(1500, 1, "x")}) {
    std::ofstream(parts / "steps.csv") << bad;
    const RunResult result = run_scene(loaded, {.directory = parts, .resume = true});
    EXPECT_EQ(result.status, RunStatus::FileTrouble);
    EXPECT_NE(result.message.find("steps.csv: "), std::string::npos) << result.message;
  }
}

TEST(Run, ResumedBeforeItsFirstCheckpointStartsFromTheBeginning) {
  const TestFolder folder;
  const fs::path whole = folder.path() / "whole", parts = folder.path() / "parts";
  const LoadedScene loaded = hanging_scene();
  fs::create_directories(parts);
  std::ofstream(parts / "checkpoint.bin.tmp") << "crease";
  ASSERT_EQ(run_scene(loaded, {.directory = whole}).status, RunStatus::Done);
  EXPECT_EQ(run_scene(loaded, {.directory = parts, .resume = true}).status, RunStatus::Done);
  EXPECT_EQ(differences(repeatable_bytes(whole), repeatable_bytes(parts)), Names());
}

TEST(Run, StoppedAtATimeGoesOnToTheSameBytes) {
  const TestFolder folder;
  const fs::path whole = folder.path() / "whole", parts = folder.path() / "parts";
  const LoadedScene loaded = hanging_scene();
  ASSERT_EQ(run_scene(loaded, {.directory = whole}).status, RunStatus::Done);
  EXPECT_EQ(run_scene(loaded, {.directory = parts, .until = 0.07}).status, RunStatus::Done);
  EXPECT_EQ(read_steps(parts)["time"].back(), 0.07);
  EXPECT_EQ(run_scene(loaded, {.directory = parts, .resume = true}).status, RunStatus::Done);
  EXPECT_EQ(differences(repeatable_bytes(whole), repeatable_bytes(parts)), Names());
}

TEST(Run, RefusesADirectoryThatIsNotEmptyAndLeavesItAlone) {
  const TestFolder folder;
  folder.write("precious.txt", "mine");
  const RunResult result = run_scene(hanging_scene(), {.directory = folder.path()});
  EXPECT_EQ(result.status, RunStatus::Refused);
  EXPECT_NE(result.message.find("not empty"), std::string::npos) << result.message;
  EXPECT_EQ(std::distance(fs::directory_iterator(folder.path()), {}), 1);
}

TEST(Run, ForcedReplacesAnEarlierRunAndNothingElse) {
  const TestFolder folder;
  const fs::path fresh = folder.path() / "fresh", used = folder.path() / "used";
  LoadedScene loaded = hanging_scene();
  ASSERT_EQ(run_scene(loaded, {.directory = used}).status, RunStatus::Done);
  std::ofstream(used / "precious.txt") << "mine";
  loaded.scene.duration = 0.05;  // fewer frames than there are already
  ASSERT_EQ(run_scene(loaded, {.directory = fresh}).status, RunStatus::Done);
  ASSERT_EQ(run_scene(loaded, {.directory = used, .force = true}).status, RunStatus::Done);
  EXPECT_EQ(differences(repeatable_bytes(fresh), repeatable_bytes(used)), Names{"precious.txt"});
}

// Everything an earlier run wrote, wall times too.
std::map<std::string, std::string> all_bytes(const fs::path& directory) {
  std::map<std::string, std::string> files;
  for (const auto& entry : fs::recursive_directory_iterator(directory))
    if (entry.is_regular_file()) files[fs::relative(entry.path(), directory).generic_string()] = bytes_of(entry.path());
  return files;
}

// The old checkpoint and frames once went before anything of the new run existed.
TEST(Run, ForcedAndFailingAtOnceLosesNothing) {
  const TestFolder folder;
  const LoadedScene loaded = hanging_scene();
  const fs::path used = folder.path() / "used";
  ASSERT_EQ(run_scene(loaded, {.directory = used}, stop_after(25)).status, RunStatus::Interrupted);
  const auto before = all_bytes(used);

  RunOptions options{.directory = used, .force = true, .stages = failing_solver([](int) { return true; })};
  const RunResult failed = run_scene(loaded, options);
  EXPECT_EQ(failed.status, RunStatus::SimulationFailed);
  for (const char* part : {"step 1", "0 s to 0.005 s", "stage solve", "left as it was"})
    EXPECT_NE(failed.message.find(part), std::string::npos) << failed.message;
  EXPECT_EQ(differences(all_bytes(used), before), Names());

  options.stages = [](const Scene&, const ClothSpec&) -> Stages { throw std::runtime_error("no such stage"); };
  EXPECT_THROW(run_scene(loaded, options), std::runtime_error);
  EXPECT_EQ(differences(all_bytes(used), before), Names());

  fs::create_directory(used / "checkpoint.bin.tmp");  // its own checkpoint cannot be written
  EXPECT_EQ(run_scene(loaded, {.directory = used, .force = true}).status, RunStatus::FileTrouble);
  EXPECT_EQ(differences(all_bytes(used), before), Names());
  fs::remove(used / "checkpoint.bin.tmp");

  EXPECT_EQ(run_scene(loaded, {.directory = used, .resume = true}).status, RunStatus::Done)
      << "the earlier run goes on";
}

TEST(Run, StoppedEarlyIsDoneButNotFinished) {
  const TestFolder folder;
  ASSERT_EQ(run_scene(hanging_scene(), {.directory = folder.path(), .until = 0.07}).status, RunStatus::Done);
  EXPECT_FALSE(summary_of(folder.path())["finished"]);
  EXPECT_NE(summary_of(folder.path())["why"].get<std::string>().find("0.07 s, as --until"), std::string::npos);
  ASSERT_EQ(run_scene(hanging_scene(), {.directory = folder.path(), .until = 5, .resume = true}).status,
            RunStatus::Done);
  EXPECT_TRUE(summary_of(folder.path())["finished"]) << "the scene ends before";
}

TEST(Run, ResumesOnlyWhatIsThereAndItsOwn) {
  const TestFolder folder;
  const LoadedScene loaded = hanging_scene();
  EXPECT_EQ(run_scene(loaded, {.directory = folder.path() / "nowhere", .resume = true}).status, RunStatus::Refused);
  EXPECT_FALSE(fs::exists(folder.path() / "nowhere"));

  folder.write("steps.csv", "step\n");
  const RunResult bare = run_scene(loaded, {.directory = folder.path(), .resume = true});
  EXPECT_EQ(bare.status, RunStatus::Refused);
  EXPECT_NE(bare.message.find("checkpoint"), std::string::npos) << bare.message;

  const fs::path run = folder.path() / "run";
  run_scene(loaded, {.directory = run}, stop_after(25));
  LoadedScene other = loaded;
  other.resolved_json = R"({"name": "other"})";
  EXPECT_EQ(run_scene(other, {.directory = run, .resume = true}).status, RunStatus::Refused);
}

TEST(Run, FindsADamagedCheckpoint) {
  const TestFolder folder;
  const LoadedScene loaded = hanging_scene();
  run_scene(loaded, {.directory = folder.path() / "run"}, stop_after(25));
  const fs::path file = folder.path() / "run/checkpoint.bin";
  const std::string good = bytes_of(file);
  std::string flipped = good;
  flipped[good.size() / 2] = static_cast<char>(flipped[good.size() / 2] ^ 1);
  for (const std::string& bad :
       {flipped, good.substr(0, good.size() / 2), good.substr(0, 10), std::string(), good + "x"}) {
    std::ofstream(file, std::ios::binary) << bad;
    const RunResult result = run_scene(loaded, {.directory = folder.path() / "run", .resume = true});
    EXPECT_EQ(result.status, RunStatus::FileTrouble);
    EXPECT_NE(result.message.find("checkpoint.bin"), std::string::npos) << result.message;
  }
}

TEST(Run, NamesThePathThatCannotBeWritten) {
  const TestFolder folder;
  const fs::path file = folder.write("file", "");
  const RunResult below_a_file = run_scene(hanging_scene(), {.directory = file / "run"});
  EXPECT_EQ(below_a_file.status, RunStatus::FileTrouble);
  EXPECT_NE(below_a_file.message.find(file.string()), std::string::npos) << below_a_file.message;

  // A directory stands where a file should be renamed to, in the middle of the run.
  const fs::path blocked = folder.path() / "run/frames/000003.vtp";
  const RunResult midway = run_scene(hanging_scene(), {.directory = folder.path() / "run"},
                                     [&](const RunProgress&) { return fs::create_directories(blocked), true; });
  EXPECT_EQ(midway.status, RunStatus::FileTrouble);
  EXPECT_NE(midway.message.find(blocked.string()), std::string::npos) << midway.message;
  EXPECT_FALSE(fs::exists(blocked.string() + ".tmp"));
  EXPECT_EQ(summary_of(folder.path() / "run")["why"], midway.message);
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

TEST(Run, KeepsASecondRunOutOfItsDirectory) {
  const TestFolder folder;
  const LoadedScene loaded = hanging_scene();
  const fs::path whole = folder.path() / "whole", shared = folder.path() / "shared";
  ASSERT_EQ(run_scene(loaded, {.directory = whole}).status, RunStatus::Done);
  const RunResult first = run_scene(loaded, {.directory = shared}, [&](const RunProgress& progress) {
    if (progress.step != 30) return true;
    for (const bool resume : {true, false}) {
      const RunResult second = run_scene(loaded, {.directory = shared, .force = !resume, .resume = resume});
      EXPECT_EQ(second.status, RunStatus::Refused);
      EXPECT_NE(second.message.find("another run"), std::string::npos) << second.message;
    }
    return true;
  });
  EXPECT_EQ(first.status, RunStatus::Done);
  EXPECT_EQ(differences(repeatable_bytes(whole), repeatable_bytes(shared)), Names());
}

// `run out/scene.json -o out --force` once put the resolved scene over the one somebody had written there.
TEST(Run, RefusesToReplaceTheFilesItsSceneIsReadFrom) {
  const TestFolder folder;
  const fs::path run = folder.path() / "run";
  LoadedScene loaded = hanging_scene();
  ASSERT_EQ(run_scene(loaded, {.directory = run, .until = 0.1}).status, RunStatus::Done);

  loaded.file = run / "../run/scene.json";
  EXPECT_EQ(run_scene(loaded, {.directory = run, .force = true}).status, RunStatus::Done) << "the same bytes";
  const std::string by_hand = "// mine\n" + loaded.resolved_json;
  std::ofstream(loaded.file) << by_hand;
  for (const bool resume : {true, false}) {
    const RunResult result = run_scene(loaded, {.directory = run, .force = !resume, .resume = resume});
    EXPECT_EQ(result.status, RunStatus::Refused);
    EXPECT_NE(result.message.find("scene.json"), std::string::npos) << result.message;
    EXPECT_EQ(bytes_of(run / "scene.json"), by_hand);
  }

  loaded.file = folder.path() / "elsewhere.json";
  const fs::path frame = run / "frames/000002.obj", other = run / "frames/start.obj";
  fs::copy_file(frame, other);
  loaded.scene.cloths[0].shape = frame;
  EXPECT_EQ(run_scene(loaded, {.directory = run, .force = true}).status, RunStatus::Refused);
  EXPECT_TRUE(fs::exists(frame));
  loaded.scene.cloths[0].shape = other;  // no name of a frame: stays
  EXPECT_EQ(run_scene(loaded, {.directory = run, .until = 0.01, .force = true}).status, RunStatus::Done);
  EXPECT_TRUE(fs::exists(other));
}

TEST(Run, TakesAsManyStepsAsASceneMayAskFor) {
  const TestFolder folder;
  LoadedScene loaded = hanging_scene();
  loaded.scene.time_step = 1e-8;
  loaded.scene.duration = 1;  // 1e8 steps: the most that the reader accepts
  EXPECT_EQ(run_scene(loaded, {.directory = folder.path(), .until = 1e-8}).status, RunStatus::Done);
}

TEST(Run, TellsWhereItStandsWhenNothingIsLeftToDo) {
  const TestFolder folder;
  const RunResult done = run_scene(hanging_scene(), {.directory = folder.path()});
  const RunResult again = run_scene(hanging_scene(), {.directory = folder.path(), .resume = true});
  for (const RunResult& result : {done, again}) {
    EXPECT_EQ(result.status, RunStatus::Done);
    EXPECT_EQ(result.reached.step, 45);
    EXPECT_EQ(result.reached.time, 0.225);
  }
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
