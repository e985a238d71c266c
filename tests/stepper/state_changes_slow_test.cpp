// SPDX-License-Identifier: MIT
//
// A chain that begins, ends and begins again from step to step costs a remeshing each time and can be seen. Of scenes
// whose cloth rests or slides on its features none does; where cloth rattles over an edge at metres a second some do
// (docs/validation.md counts them).
#include <gtest/gtest.h>
#include <filesystem>

#include "support/chain_cover.hpp"
#include "support/runs.hpp"
#include "support/scratch.hpp"

namespace crease {
namespace {

class StateChanges : public ::testing::TestWithParam<const char*> {};

TEST_P(StateChanges, AreNotTakenBackInTheNextStep) {
  LoadedScene loaded = load_scene(std::filesystem::path(CREASE_SCENES) / (std::string(GetParam()) + ".json"), {});
  loaded.scene.formats.clear();
  const auto cover = std::make_shared<testing::ChainCover>();
  RunOptions options;
  options.directory = testing::scratch_path(std::string("state_changes_") + GetParam());
  options.stages = testing::ChainCover::watched(cover);
  std::filesystem::remove_all(options.directory);
  const RunResult result = run_scene(loaded, options);
  std::filesystem::remove_all(options.directory);
  ASSERT_EQ(result.status, RunStatus::Done) << result.message;
  EXPECT_GT(cover->changes(), 100) << "places 5 mm apart along an edge of half a metre and more";
  EXPECT_EQ(cover->taken_back(), 0);
}

INSTANTIATE_TEST_SUITE_P(AsShipped, StateChanges, ::testing::Values("edge", "lo_res", "wire"),
                         [](const auto& scene) { return std::string(scene.param); });

}  // namespace
}  // namespace crease
