// SPDX-License-Identifier: MIT
// What has reached the disk, not only the kernel, before a run relies on it.
#include <sys/syscall.h>
#include <unistd.h>

#include <algorithm>
#include <mutex>
#include <thread>

#include <gtest/gtest.h>

#include "crease/stepper/run.hpp"
#include "support/runs.hpp"
#include "support/scene_text.hpp"

namespace {

std::mutex listening;                        ///< a run writes by a thread of its own
std::vector<std::string>* synced = nullptr;  ///< files handed to fsync, in order, while a test listens
std::vector<std::string>* waited = nullptr;  ///< those of them that the thread of the test has waited for
const std::thread::id tester = std::this_thread::get_id();

}  // namespace

/// Stands in front of the C library's in this program.
extern "C" int fsync(int descriptor) {
  {
    const std::lock_guard lock(listening);
    if (synced) {
      synced->push_back(std::filesystem::read_symlink("/proc/self/fd/" + std::to_string(descriptor)).string());
      if (std::this_thread::get_id() == tester) waited->push_back(synced->back());
    }
  }
  return static_cast<int>(syscall(SYS_fsync, descriptor));
}

namespace crease {
namespace {

using namespace testing;

class Durability : public ::testing::Test {
 protected:
  Durability() { synced = &files_, waited = &waited_; }
  ~Durability() override { synced = waited = nullptr; }

  /// Places in the order of fsync calls.
  std::vector<std::ptrdiff_t> places(const std::string& file) const {
    std::vector<std::ptrdiff_t> found;
    for (auto at = files_.begin(); (at = std::find(at, files_.end(), (folder_.path() / file).string())) != files_.end();
         ++at)
      found.push_back(at - files_.begin());
    return found;
  }

  const TestFolder folder_;
  std::vector<std::string> files_, waited_;
};

TEST_F(Durability, EveryFileIsOnTheDisk) {
  ASSERT_EQ(run_scene(hanging_scene(), {.directory = folder_.path()}).status, RunStatus::Done);
  for (const auto& entry : fs::recursive_directory_iterator(folder_.path())) {
    if (!entry.is_regular_file() || entry.path().filename() == "steps.csv") continue;
    const std::string name = fs::relative(entry.path(), folder_.path()).generic_string();
    EXPECT_FALSE(places(name + ".tmp").empty()) << name;
  }
}

// 45 steps, checkpoints after 20, 40 and 45: each relies on the rows before it.
TEST_F(Durability, RowsAndFramesAreOnTheDiskBeforeTheCheckpointThatReliesOnThem) {
  ASSERT_EQ(run_scene(hanging_scene(), {.directory = folder_.path()}).status, RunStatus::Done);
  const auto checkpoints = places("checkpoint.bin.tmp");
  ASSERT_EQ(checkpoints.size(), 4u);  // that of the start relies on nothing
  for (const char* needed : {"steps.csv", "frames"}) {
    const auto before = places(needed);
    ASSERT_EQ(before.size(), 3u) << needed;
    for (int k = 0; k < 3; ++k) {
      EXPECT_LT(before[k], checkpoints[k + 1]) << needed;
      EXPECT_GT(before[k], checkpoints[k]) << needed;
    }
  }
}

// A frame every three steps, each of two files: where a disk takes 7 ms for each, a run of the scene `edge` spent a
// quarter of its time waiting.
TEST_F(Durability, NoStepWaitsForTheDisk) {
  std::size_t before = 0;
  ASSERT_EQ(run_scene(hanging_scene(), {.directory = folder_.path()},
                      [&](const RunProgress& progress) {
                        if (progress.step == 1) before = waited_.size();
                        return true;
                      })
                .status,
            RunStatus::Done);
  EXPECT_GT(before, 0u);
  ASSERT_EQ(waited_.size(), before + 1) << ::testing::PrintToString(waited_);
  EXPECT_EQ(waited_.back(), (folder_.path() / "summary.json.tmp").string());
}

}  // namespace
}  // namespace crease
