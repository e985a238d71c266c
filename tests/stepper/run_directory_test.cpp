// SPDX-License-Identifier: MIT
#include "support/scene_text.hpp"

#include "crease/stepper/run.hpp"

#include <csignal>
#include <fstream>

#include <gtest/gtest.h>

#include "support/run_control.hpp"

namespace crease {
namespace {

using namespace testing;

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

// A frame that somebody has deleted was not noticed: the run ended as if all were there, and cloth.pvd named it.
TEST(Run, TellsWhichFramesAreMissingWhenItIsResumed) {
  const TestFolder folder;
  const LoadedScene loaded = hanging_scene();
  const fs::path parts = folder.path() / "parts";
  ASSERT_EQ(run_scene(loaded, {.directory = parts}, stop_after(30)).status, RunStatus::Interrupted);
  fs::remove(parts / "frames/000002.vtp");
  const RunResult one = run_scene(loaded, {.directory = parts, .resume = true}, stop_after(35));
  ASSERT_EQ(one.warnings.size(), 1u);
  EXPECT_EQ(one.warnings.front().rfind("frames/000002.vtp is missing", 0), 0u) << one.warnings.front();
  fs::remove(parts / "frames/000001.vtp");
  const RunResult two = run_scene(loaded, {.directory = parts, .resume = true});
  EXPECT_EQ(two.status, RunStatus::Done);
  ASSERT_EQ(two.warnings.size(), 1u);
  EXPECT_EQ(two.warnings.front().rfind("frames/000001.vtp and 1 more are missing", 0), 0u) << two.warnings.front();
  EXPECT_EQ(summary_of(parts)["warnings"].size(), 1u);
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

// The new run's checkpoint stands in the old one's place, and nothing else has happened yet.
TEST(Run, ForcedAndKilledBeforeItClearedTheFolderResumesToTheSameBytes) {
  const TestFolder folder;
  const fs::path fresh = folder.path() / "fresh", used = folder.path() / "used";
  LoadedScene other = hanging_scene();
  other.scene.formats = {FrameFormat::Obj};
  other.resolved_json = R"({"name": "other"})";
  ASSERT_EQ(run_scene(hanging_scene(), {.directory = used}).status, RunStatus::Done);
  ASSERT_EQ(run_scene(other, {.directory = fresh}, stop_after(1)).status, RunStatus::Interrupted);
  fs::copy_file(fresh / "checkpoint.bin", used / "checkpoint.bin", fs::copy_options::overwrite_existing);
  for (const fs::path& directory : {fresh, used})
    ASSERT_EQ(run_scene(other, {.directory = directory, .resume = true}).status, RunStatus::Done);
  EXPECT_EQ(differences(repeatable_bytes(fresh), repeatable_bytes(used)), Names());
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

  // No checkpoint was written that relies on it.
  fs::remove_all(blocked);
  const RunResult resumed = run_scene(hanging_scene(), {.directory = folder.path() / "run", .resume = true});
  EXPECT_EQ(resumed.status, RunStatus::Done);
  EXPECT_EQ(resumed.warnings, Names());
  EXPECT_TRUE(fs::exists(blocked));
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

}  // namespace
}  // namespace crease
