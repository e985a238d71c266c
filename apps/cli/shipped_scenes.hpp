// SPDX-License-Identifier: MIT
#pragma once

#include <filesystem>
#include <stdexcept>
#include <string>
#include <vector>

namespace crease::cli {

/// The command line names something that does not exist.
struct UsageError : std::runtime_error {
  using std::runtime_error::runtime_error;
};

/// Files of the scenes that ship, by name; empty if the folder is not found.
std::vector<std::filesystem::path> shipped_scenes();

/// The file that SCENE on the command line means: itself, or the shipped scene of that name.
/// Throws UsageError for a bare name that is neither.
std::filesystem::path find_scene(const std::string& scene);

}  // namespace crease::cli
