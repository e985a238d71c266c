// SPDX-License-Identifier: MIT
#pragma once

#include <unistd.h>

#include <filesystem>
#include <string>

namespace crease::testing {

/// A path among the temporary files that no other running process has: tests may run beside each other, also twice.
inline std::filesystem::path scratch_path(const std::string& name) {
  return std::filesystem::temp_directory_path() / ("crease_" + name + "_" + std::to_string(getpid()));
}

}  // namespace crease::testing
