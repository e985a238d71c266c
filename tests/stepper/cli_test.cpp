// SPDX-License-Identifier: MIT
// The program itself, as a script sees it: exit status, standard output, standard error, files.
#include <sys/wait.h>

#include <array>
#include <cstdio>
#include <cstdlib>
#include <fstream>
#include <iterator>
#include <sstream>

#include <gtest/gtest.h>

#include "crease/stepper/scene_io.hpp"
#include "support/runs.hpp"
#include "support/scene_text.hpp"

namespace crease {
namespace {

class Cli : public ::testing::Test {
 protected:
  struct Outcome {
    int status;
    std::string out, err;
  };

  // Runs `crease ARGUMENTS` in the test's folder.
  Outcome crease(const std::string& arguments, const std::string& prefix = "") const {
    const std::string command = "cd '" + folder_.path().string() + "' && " + prefix + " '" CREASE_PROGRAM "' " +
                                arguments + " >out.txt 2>err.txt </dev/null";
    const int status = std::system(command.c_str());
    return {WIFEXITED(status) ? WEXITSTATUS(status) : -1, text("out.txt"), text("err.txt")};
  }

  std::string text(const std::string& name) const {
    std::ifstream in(folder_.path() / name);
    return {std::istreambuf_iterator<char>(in), {}};
  }

  bool exists(const std::string& name) const { return std::filesystem::exists(folder_.path() / name); }

  void expect_usage_error(const std::string& arguments, const std::string& says) const {
    const Outcome outcome = crease(arguments);
    EXPECT_EQ(outcome.status, 2) << arguments;
    EXPECT_EQ(outcome.out, "") << arguments;
    EXPECT_NE(outcome.err.find(says), std::string::npos) << arguments << " -> " << outcome.err;
  }

  TestFolder folder_;
};

// A sheet in free fall: three steps, no stage that can fail.
constexpr char short_scene[] = R"({
  "format": 1, "name": "short", "duration": 0.015,
  "cloths": [{"shape": {"grid": {"cells": [2, 2]}}, "material": {}}]
})";

TEST_F(Cli, HelpAndVersionGoToStandardOutput) {
  EXPECT_TRUE(crease("--version").out.starts_with("crease 0."));
  for (const std::string arguments : {"--help", "run --help", "check --help", "list --help", "schema --help",
                                      "study --help", "view --help", "export --help"}) {
    const Outcome outcome = crease(arguments);
    EXPECT_EQ(outcome.status, 0) << arguments;
    EXPECT_NE(outcome.out.find("Usage"), std::string::npos) << arguments;
    EXPECT_EQ(outcome.err, "") << arguments;
  }
}

TEST_F(Cli, UsageErrorsSayWhatWouldBeRight) {
  expect_usage_error("", "Usage");
  expect_usage_error("runn edge -o x", "did you mean \"run\"?");
  expect_usage_error("run edge -o x --forse", "did you mean \"--force\"?");
  expect_usage_error("run -o x", "SCENE");
  expect_usage_error("run edge", "--output");
  expect_usage_error("run edge -o x --set threshold", "path=value");
  expect_usage_error("run edge -o ''", "directory");
  expect_usage_error("run edge -o x --until nan", "time in seconds");
  expect_usage_error("run edge -o x --until -1", "time in seconds");
  expect_usage_error("run edge -o x --threads 0", "--threads: expected a number of threads");
  expect_usage_error("run edge -o x --threads many", "--threads: expected a number of threads");
  expect_usage_error("run edge -o x --threads 257", "--threads: expected a number of threads from 1 to 256");
  expect_usage_error("run edge -o x --force --resume", "--resume");
  expect_usage_error("run egde -o x", "did you mean \"edge\"?");
  expect_usage_error("check egde", "did you mean \"edge\"?");
  EXPECT_FALSE(exists("x"));
}

TEST_F(Cli, VerbsThatComeLaterAreRefusedByName) {
  expect_usage_error("study matrix.json -o out", "\"study\" is not available yet");
  expect_usage_error("view out", "\"view\" is not available yet");
  expect_usage_error("export out --format usda", "\"export\" is not available yet");
}

TEST_F(Cli, CheckPrintsTheResolvedScene) {
  const auto scene = folder_.write("scene.json", full_scene);
  const Outcome outcome = crease("check scene.json --set time_step=0.001 --set contact.method=eol");
  EXPECT_EQ(outcome.status, 0) << outcome.err;
  EXPECT_EQ(outcome.out, load_scene(scene, {{"time_step", "0.001"}}).resolved_json);
  folder_.write("resolved.json", outcome.out);
  EXPECT_EQ(crease("check resolved.json").out, outcome.out);
}

TEST_F(Cli, CheckPrintsEveryProblemWithFileAndPointer) {
  folder_.write("bad.json", with(with(full_scene, "\"density\": 0.05", "\"density\": -1"), "\"fps\"", "\"fsp\""));
  const Outcome outcome = crease("check bad.json");
  EXPECT_EQ(outcome.status, 2);
  EXPECT_EQ(outcome.out, "");
  EXPECT_EQ(outcome.err,
            "bad.json: /cloths/0/material/density: must be a number > 0, got -1\n"
            "bad.json: /output/fsp: unknown key; did you mean \"fps\"?\n");
}

TEST_F(Cli, FilesThatCannotBeReadOrWrittenHaveTheirOwnStatus) {
  EXPECT_EQ(crease("check none.json").status, 3);
  EXPECT_NE(crease("check none.json").err.find("none.json: cannot be read: No such file"), std::string::npos);
  EXPECT_EQ(crease("check .").status, 3);
  const std::string full_disk = "'" CREASE_PROGRAM "' check edge >/dev/full 2>/dev/null";
  EXPECT_EQ(WEXITSTATUS(std::system(full_disk.c_str())), 3);
  const std::string closed = "'" CREASE_PROGRAM "' check edge >&- 2>/dev/null";
  EXPECT_EQ(WEXITSTATUS(std::system(closed.c_str())), 3);
}

TEST_F(Cli, ListNamesScenesThatCheckAccepts) {
  const Outcome names = crease("list"), paths = crease("list --paths");
  EXPECT_EQ(names.status, 0);
  EXPECT_EQ(paths.status, 0);
  std::istringstream lines(names.out), files(paths.out);
  int n = 0;
  for (std::string line, file; std::getline(lines, line) && std::getline(files, file); ++n) {
    const std::string name = line.substr(0, line.find(' '));
    EXPECT_TRUE(std::filesystem::is_regular_file(file)) << file;
    EXPECT_EQ(crease("check " + name).out, crease("check '" + file + "'").out);
    EXPECT_GT(line.size(), name.size() + 20) << "no description: " << line;
  }
  EXPECT_GE(n, 3);
}

TEST_F(Cli, AFolderNamedAfterASceneDoesNotHideTheScene) {
  std::filesystem::create_directory(folder_.path() / "edge");
  EXPECT_EQ(crease("check edge").status, 0);
}

TEST_F(Cli, SchemaIsPrinted) {
  EXPECT_EQ(crease("schema").out, scene_schema());
}

TEST_F(Cli, RunWritesResultsAndReportsOnStandardErrorOnly) {
  folder_.write("scene.json", short_scene);
  const Outcome outcome = crease("run scene.json -o out");
  EXPECT_EQ(outcome.status, 0) << outcome.err;
  EXPECT_EQ(outcome.out, "");
  EXPECT_NE(outcome.err.find("short: done, 3 steps"), std::string::npos) << outcome.err;
  EXPECT_TRUE(exists("out/scene.json"));
  EXPECT_TRUE(exists("out/frames/000000.vtp"));
  EXPECT_NE(text("out/summary.json").find("run scene.json -o out"), std::string::npos) << "the command line";

  EXPECT_EQ(crease("run scene.json -o out").status, 2) << "the directory is not empty";
  const Outcome resumed = crease("run scene.json -o out --resume");
  EXPECT_EQ(resumed.status, 0) << resumed.err;
  EXPECT_NE(resumed.err.find("short: done, 3 steps to 0.015 s"), std::string::npos) << resumed.err;
  const Outcome quiet = crease("run scene.json -o out --force --quiet --threads 1");
  EXPECT_EQ(quiet.status, 0) << quiet.err;
  EXPECT_EQ(quiet.err, "");
}

// A unit sheet without remeshing, half a metre deep in a box that is 1 m high: nothing fails, but it is said.
TEST_F(Cli, RunSaysHowDeepTheClothWasInAnObstacle) {
  folder_.write("scene.json", with(short_scene, "\"cloths\"",
                                   R"("contact": {"method": "lagrangian_averaged"},
                                      "obstacles": [{"box": {"size": [3, 3, 1]}}], "cloths")"));
  const Outcome outcome = crease("run scene.json -o out");
  EXPECT_EQ(outcome.status, 0) << outcome.err;
  EXPECT_NE(outcome.err.find("mm inside an obstacle"), std::string::npos) << outcome.err;
  EXPECT_EQ(crease("run scene.json -o clear --set obstacles.0.position=[0,0,-9]").err.find("inside"),
            std::string::npos);
}

// Another process has other addresses, another environment, another folder and other rubbish in the memory it is given
// (MALLOC_PERTURB_ of glibc); none of them may show.
TEST_F(Cli, TwoProcessesWriteTheSameBytes) {
  const std::string coarse =
      " --quiet --until 0.5 --set cloths.0.shape.grid.cells=[8,8] --set cloths.0.remeshing.size=[0.06,0.15]"
      " --set 'output.formats=[\"vtp\",\"obj\"]' -o ";
  const Outcome first = crease("run edge" + coarse + "one");
  const Outcome second = crease("run edge" + coarse + "a_longer_name/two",
                                "mkdir a_longer_name && env -i MALLOC_PERTURB_=165 PADDING=" + std::string(5000, 'x'));
  ASSERT_EQ(first.status, 0) << first.err;
  ASSERT_EQ(second.status, 0) << second.err;
  const auto one = folder_.path() / "one", two = folder_.path() / "a_longer_name/two";
  EXPECT_EQ(testing::differences(testing::repeatable_bytes(one), testing::repeatable_bytes(two)),
            std::vector<std::string>());
  auto steps = testing::read_steps(one);
  EXPECT_GT(steps["eol_vertices"].back(), 3) << "the fold is not there yet";
  EXPECT_GT(steps["faces"].back(), 200);
}

// A sheet large enough to be shared out, in contact, with a fold.
TEST_F(Cli, AnyNumberOfThreadsWritesTheSameBytes) {
  ASSERT_EQ(crease("run edge --quiet --until 0.1 -o one").status, 0);
  ASSERT_EQ(crease("run edge --quiet --until 0.1 -o three --threads 3").status, 0);
  EXPECT_EQ(testing::differences(testing::repeatable_bytes(folder_.path() / "one"),
                                 testing::repeatable_bytes(folder_.path() / "three")),
            std::vector<std::string>());
  EXPECT_GT(testing::read_steps(folder_.path() / "one")["faces"].back(), 1000);
}

TEST_F(Cli, RefusedSceneWritesNothing) {
  folder_.write("scene.json", with(short_scene, "0.015", "-1"));
  EXPECT_EQ(crease("run scene.json -o out").status, 2);
  EXPECT_FALSE(exists("out"));
}

TEST_F(Cli, ADirectoryThatCannotBeMadeIsFileTrouble) {
  folder_.write("scene.json", short_scene);
  folder_.write("file", "");
  EXPECT_EQ(crease("run scene.json -o file/out").status, 3);
}

// Closed, standard error lent its number to steps.csv, and progress was written into the table.
TEST_F(Cli, AClosedStandardErrorIsNoResultFile) {
  folder_.write("scene.json", with(short_scene, "0.015", "1000"));
  const std::string command = "cd '" + folder_.path().string() +
                              "' && { '" CREASE_PROGRAM
                              "' run scene.json -o out 2>&- & } && while [ ! -s out/steps.csv ]; do sleep 0.1; done && "
                              "readlink /proc/$!/fd/2 >fd.txt; kill $!; wait";
  EXPECT_EQ(std::system(command.c_str()), 0);
  EXPECT_EQ(text("fd.txt"), "/dev/null\n");
}

// Both ended the program by a signal, without a word and without a summary.
TEST_F(Cli, ALimitOnFileSizesIsFileTroubleAndUnreadProgressIsNone) {
  folder_.write("scene.json", short_scene);
  const Outcome limited = crease("run scene.json -o limited", "ulimit -f 1 &&");  // 512 or 1024 bytes
  EXPECT_EQ(limited.status, 3);
  EXPECT_NE(limited.err.find("File too large"), std::string::npos) << limited.err;
  const std::string unread =
      "cd '" + folder_.path().string() +
      "' && mkfifo pipe && { sleep 60 <pipe & } && exec 3>pipe && kill $! && wait $!; '" CREASE_PROGRAM
      "' run scene.json -o unread 2>&3";
  EXPECT_EQ(WEXITSTATUS(std::system(unread.c_str())), 0);
  EXPECT_TRUE(exists("unread/summary.json"));
}

// The signal comes when the first rows are there, however long the program takes to get going.
TEST_F(Cli, SignalEndsTheRunAfterAStepAndResumeFinishesIt) {
  folder_.write("scene.json", with(short_scene, "0.015", "1000"));
  for (const std::string signal : {"INT", "TERM"}) {
    SCOPED_TRACE(signal);
    const std::string command = "cd '" + folder_.path().string() + "' && { '" CREASE_PROGRAM "' run scene.json -o " +
                                signal + " 2>err.txt & } && while [ ! -s " + signal +
                                "/steps.csv ] && kill -0 $!; do sleep 0.1; done; kill -" + signal + " $!; wait $!";
    const int status = std::system(command.c_str());
    EXPECT_EQ(WEXITSTATUS(status), 130) << text("err.txt");
    EXPECT_NE(text("err.txt").find("--resume"), std::string::npos) << text("err.txt");
  }
  const Outcome resumed = crease("run scene.json -o TERM --resume --until 0.01");
  EXPECT_EQ(resumed.status, 0) << resumed.err;
}

}  // namespace
}  // namespace crease
