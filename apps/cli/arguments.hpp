// SPDX-License-Identifier: MIT
#pragma once

#include <optional>
#include <string>
#include <utility>
#include <variant>
#include <vector>

namespace crease::cli {

/// Exit statuses that do not come from a run.
enum ExitStatus { ExitDone = 0, ExitUsage = 2, ExitFileTrouble = 3 };

/// What the command line asks for.
struct Arguments {
  std::string verb;
  std::string scene;                                           ///< file or name of a shipped scene
  std::string output;                                          ///< directory
  std::vector<std::pair<std::string, std::string>> overrides;  ///< --set path=value
  std::optional<double> until;
  int threads = 1;
  bool resume = false, force = false, quiet = false, paths = false;
  std::string command_line;
};

/// Arguments, or the exit status after help, the version or a usage error has been printed.
std::variant<Arguments, int> parse_arguments(int argc, const char* const* argv);

}  // namespace crease::cli
