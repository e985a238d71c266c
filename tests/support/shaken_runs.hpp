// SPDX-License-Identifier: MIT
#pragma once

// A shipped scene run with its obstacles shaken and everything turned. The test's target defines CREASE_SCENES.

#include <gtest/gtest.h>
#include <cmath>
#include <filesystem>
#include <memory>
#include <optional>
#include <ostream>
#include <string>
#include <utility>
#include <vector>

#include "support/runs.hpp"
#include "support/scratch.hpp"
#include "support/shaken.hpp"

namespace crease::testing {

/// One of the scenes that ship, and what is changed of it.
struct ShakenScene {
  std::string name;
  std::vector<std::pair<std::string, std::string>> changes = {};  ///< as of `crease run --set`
  std::optional<double> until = std::nullopt;                     ///< [s]
};

inline void PrintTo(const ShakenScene& scene, std::ostream* out) {
  *out << scene.name;
}

inline double cloth_length(const LoadedScene& loaded) {
  const auto size = std::get<GridOptions>(loaded.scene.cloths.front().shape).size;
  return std::max(size[0], size[1]);
}

/// Runs it once and expects that it ends, with finite numbers in every row and the cloth outside everywhere: by .1 % of
/// its length, which is what the project promises of every scene.
/// @param label  tells apart what runs at the same time
inline void expect_ends_outside(const ShakenScene& shaken, const std::string& label, std::uint64_t seed) {
  constexpr double shift = 1e-3;  // [m]
  LoadedScene loaded = load_scene(std::filesystem::path(CREASE_SCENES) / (shaken.name + ".json"), shaken.changes);
  shake_scene(loaded, shift, seed);
  loaded.scene.formats.clear();
  const double allowed = 1e-3 * cloth_length(loaded);
  const auto piercing = std::make_shared<Piercing>(allowed);
  RunOptions options;
  options.directory = scratch_path("shaken_" + shaken.name + "_" + label);
  options.until = shaken.until;
  options.stages = watched_stages(piercing);
  std::filesystem::remove_all(options.directory);
  const RunResult result = run_scene(loaded, options);
  EXPECT_EQ(result.status, RunStatus::Done) << result.message;
  for (const auto& [name, values] : read_steps(options.directory))
    for (const double value : values) ASSERT_TRUE(std::isfinite(value)) << name;
  std::filesystem::remove_all(options.directory);
  EXPECT_LE(result.reached.worst_penetration, allowed);
  EXPECT_EQ(piercing->pierced(), 0);
  EXPECT_LE(piercing->farthest_from_wire(), allowed);
}

inline void expect_all_end_outside(const ShakenScene& shaken, const std::string& label) {
  for (std::uint64_t seed = 1; seed <= 10; ++seed) {
    SCOPED_TRACE(shaken.name + ", seed " + std::to_string(seed));
    expect_ends_outside(shaken, label, seed);
  }
}

inline std::string name_of(const ::testing::TestParamInfo<ShakenScene>& info) {
  return info.param.name;
}

}  // namespace crease::testing
