// SPDX-License-Identifier: MIT
#include "commands.hpp"

#include <algorithm>
#include <csignal>
#include <iomanip>
#include <iostream>
#include <stdexcept>

#include "crease/stepper/run.hpp"
#include "progress.hpp"
#include "shipped_scenes.hpp"

namespace crease::cli {
namespace {

volatile std::sig_atomic_t stop_requested = 0;

// The step under way is finished first; a second signal finds the default action and ends the program at once.
void stop_on_signals() {
  struct sigaction action {};
  action.sa_handler = [](int) { stop_requested = 1; };
  // Without SA_RESTART, a write under way would fail and the run with it.
  action.sa_flags = static_cast<int>(SA_RESETHAND | SA_RESTART);
  sigaction(SIGINT, &action, nullptr);
  sigaction(SIGTERM, &action, nullptr);
}

// A file that may not grow any further is trouble like a full disk, and progress that nobody reads any more none at
// all: the write fails with a reason, instead of the program with a signal.
void fail_writes_without_signals() {
  std::signal(SIGXFSZ, SIG_IGN);
  std::signal(SIGPIPE, SIG_IGN);
}

// Standard output may be a full disk or a closed pipe; a result that nobody got is not success.
int printed() {
  if (std::cout.flush()) return ExitDone;
  std::cerr << "crease: standard output cannot be written\n";
  return ExitFileTrouble;
}

int run(const Arguments& arguments) {
  stop_on_signals();
  fail_writes_without_signals();
  const LoadedScene loaded = load_scene(find_scene(arguments.scene), arguments.overrides);
  RunOptions options;
  options.directory = arguments.output;
  options.until = arguments.until;
  options.force = arguments.force;
  options.resume = arguments.resume;
  options.threads = arguments.threads;
  options.command_line = arguments.command_line;

  Progress progress(loaded.scene.name, arguments.quiet);
  const RunResult result = run_scene(loaded, options, [&](const RunProgress& now) {
    progress.update(now);
    return stop_requested == 0;
  });
  progress.finish();
  for (const std::string& warning : result.warnings)
    if (!arguments.quiet) std::cerr << loaded.scene.name << ": warning: " << warning << '\n';
  if (result.status != RunStatus::Done) {
    std::cerr << "crease: " << result.message << '\n';
    if (result.status == RunStatus::Interrupted) std::cerr << "crease: continue with --resume\n";
  } else if (!arguments.quiet) {
    std::cerr << loaded.scene.name << ": done, " << result.reached.step << " steps to " << result.reached.time
              << " s in " << clock_text(result.reached.wall) << "; results in " << arguments.output << '\n';
    if (result.reached.worst_penetration > loaded.scene.threshold)
      std::cerr << loaded.scene.name << ": the cloth was up to " << 1e3 * result.reached.worst_penetration
                << " mm inside an obstacle, more than contact.threshold; when, says summary.json\n";
  }
  return static_cast<int>(result.status);
}

int check(const Arguments& arguments) {
  std::cout << load_scene(find_scene(arguments.scene), arguments.overrides).resolved_json;
  return printed();
}

int list(const Arguments& arguments) {
  const std::vector<std::filesystem::path> files = shipped_scenes();
  if (files.empty()) throw std::runtime_error("the shipped scenes are not where this program was built or installed");
  size_t width = 0;
  for (const auto& file : files) width = std::max(width, file.stem().string().size());
  for (const auto& file : files) {
    if (arguments.paths)
      std::cout << file.string() << '\n';
    else
      std::cout << std::left << std::setw(static_cast<int>(width) + 2) << file.stem().string()
                << load_scene(file).scene.description << '\n';
  }
  return printed();
}

int dispatch(const Arguments& arguments) {
  if (arguments.verb == "run") return run(arguments);
  if (arguments.verb == "check") return check(arguments);
  if (arguments.verb == "list") return list(arguments);
  if (arguments.verb == "schema") {
    std::cout << scene_schema();
    return printed();
  }
  std::cerr << "crease: \"" << arguments.verb << "\" is not available yet\n";
  return ExitUsage;
}

}  // namespace

int execute(const Arguments& arguments) {
  try {
    return dispatch(arguments);
  } catch (const SceneError& error) {
    std::cerr << error.what() << '\n';
    return ExitUsage;
  } catch (const UsageError& error) {
    std::cerr << "crease: " << error.what() << '\n';
    return ExitUsage;
  } catch (const std::runtime_error& error) {
    std::cerr << "crease: " << error.what() << '\n';
    return ExitFileTrouble;
  } catch (const std::exception& error) {  // a bug of ours, or no memory
    std::cerr << "crease: failed: " << error.what() << '\n';
    return static_cast<int>(RunStatus::SimulationFailed);
  }
}

}  // namespace crease::cli
