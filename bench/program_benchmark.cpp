// SPDX-License-Identifier: MIT
//
// Whether the solver is right on the quadratic programs of real runs: takes programs from scenes' whole runs, evenly,
// has each solved by Ipopt too, and compares the objectives. Every program of the runs counts for the KKT residual, the
// iterations and the fallbacks. With --write, the programs that were compared are kept as files, which can be given
// instead of scenes, and which other solvers read. Ends with 1 if anything fails.
#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <limits>
#include <span>
#include <stdexcept>
#include <string>
#include <vector>

#include "crease/solver/qps.hpp"
#include "crease/stepper/run.hpp"
#include "measure.hpp"

namespace crease {
namespace {

/// Relative difference of two objectives that are one and the same: the reference stops at a residual of 1e-8.
constexpr double same_objective = 1e-6;
constexpr double largest_residual = 1e-9;

struct Tally {
  int programs = 0, compared = 0, differ = 0, fallbacks = 0, most_iterations = 0;
  int unsolved = 0, reference_unsolved = 0, unsolvable = 0;  ///< by us alone, by the reference alone, by both
  double residual = 0, difference = 0;

  void add(const Tally& other) {
    programs += other.programs;
    compared += other.compared;
    differ += other.differ;
    unsolved += other.unsolved;
    unsolvable += other.unsolvable;
    reference_unsolved += other.reference_unsolved;
    fallbacks += other.fallbacks;
    most_iterations = std::max(most_iterations, other.most_iterations);
    residual = std::max(residual, other.residual);
    difference = std::max(difference, other.difference);
  }
  void print(const std::string& name) const {
    std::printf("| %s | %d | %d | %d | %d | %d | %d | %d | %.0e | %.0e | %d |\n", name.c_str(), programs, unsolvable,
                unsolved, fallbacks, most_iterations, compared, reference_unsolved, residual, difference, differ);
    std::fflush(stdout);
  }
};

double objective(const QpProblem& problem, const VecX& q) {
  return 0.5 * q.dot(problem.H * q) - problem.f.dot(q);
}

/// What both of its terms are made of, where they cancel.
double objective_size(const QpProblem& problem, const VecX& q) {
  return std::max({std::abs(objective(problem, q)), 0.5 * q.dot(problem.H * q), std::abs(problem.f.dot(q))});
}

/// Of one scene's programs.
class Comparison {
 public:
  /// @param every   how many programs there are for one that is compared
  /// @param folder  where those go as files; empty: nowhere
  Comparison(std::string name, int every, std::filesystem::path folder)
      : name_(std::move(name)), every_(every), folder_(std::move(folder)) {}

  void count(const QpProblem& problem, const QpResult& ours) {
    tally.fallbacks += ours.fell_back;
    tally.most_iterations = std::max(tally.most_iterations, ours.iterations);
    const bool solved = ours.status == QpStatus::Solved;
    if (solved) tally.residual = std::max(tally.residual, ours.kkt_residual);
    if (tally.programs++ % every_ == 0 || !solved) {
      if (!folder_.empty()) write(problem);
      compare(problem, ours);
    }
  }

  Tally tally;

 private:
  void write(const QpProblem& problem) const {
    const std::string name = name_ + '_' + std::to_string(tally.programs);
    const std::filesystem::path path = folder_ / (name + ".qps");
    std::ofstream out(path);
    write_qps(out, problem, name);
    if (!out.flush()) throw std::runtime_error(path.string() + ": cannot be written");
  }

  void compare(const QpProblem& problem, const QpResult& ours) {
    ++tally.compared;
    const QpResult theirs = make_qp_solver(QpMethod::Ipopt)->solve(problem);
    const bool solved = ours.status == QpStatus::Solved, solved_there = theirs.status == QpStatus::Solved;
    tally.unsolved += !solved && solved_there;
    tally.reference_unsolved += solved && !solved_there;
    tally.unsolvable += !solved && !solved_there;
    if (!solved) std::fprintf(stderr, "ours: %s; Ipopt: %s\n", ours.message.c_str(), to_string(theirs.status));
    if (!solved || !solved_there) return;
    const double size = objective_size(problem, theirs.q);
    const double difference = std::abs(objective(problem, ours.q) - objective(problem, theirs.q)) /
                              std::max(size, std::numeric_limits<double>::min());
    tally.difference = std::max(tally.difference, difference);
    tally.differ += !(difference <= same_objective);
  }

  std::string name_;
  int every_;
  std::filesystem::path folder_;
};

Tally measure_scene(const std::string& file, int count, const std::filesystem::path& folder) {
  const LoadedScene loaded = load_scene(file, {});
  const int steps = static_cast<int>(loaded.scene.duration / loaded.scene.time_step);
  const std::string name = std::filesystem::path(file).stem().string();
  Comparison comparison(name, std::max(1, steps / std::max(1, count)), folder);
  RunOptions options;
  options.directory = std::filesystem::temp_directory_path() / ("crease_program_benchmark_" + std::to_string(getpid()));
  options.force = true;
  options.stages = [&](const Scene& scene, const ClothSpec& spec) {
    Stages stages = make_stages(scene, spec);
    if (!stages.solve) return stages;
    stages.solve = [&comparison, plain = stages](const QpProblem& problem, std::span<const char> guess) {
      QpResult result = plain.solve(problem, guess);
      comparison.count(problem, result);
      return result;
    };
    return stages;
  };
  const RunResult result = run_scene(loaded, options);
  if (result.status != RunStatus::Done) std::fprintf(stderr, "%s: %s\n", file.c_str(), result.message.c_str());
  std::filesystem::remove_all(options.directory);
  if (comparison.tally.programs > 0) comparison.tally.print(name);
  return comparison.tally;
}

/// Each solved from nothing, without a guess.
Tally measure_files(std::span<const std::string> files) {
  Comparison comparison("", 1, {});
  for (const std::string& file : files) {
    std::ifstream in(file);
    try {
      const QpProblem problem = read_qps(in);
      comparison.count(problem, make_qp_solver(QpMethod::ActiveSet)->solve(problem));
    } catch (const std::runtime_error& error) {
      throw std::runtime_error(file + ": " + error.what());
    }
  }
  return comparison.tally;
}

Tally measure(std::vector<std::string> arguments) {
  std::filesystem::path folder;
  if (const auto write = std::find(arguments.begin(), arguments.end(), "--write"); write != arguments.end()) {
    if (write + 1 == arguments.end()) throw std::invalid_argument("--write: expected a folder");
    folder = write[1];
    std::filesystem::create_directories(folder);
    arguments.erase(write, write + 2);
  }
  const bool are_files = !arguments.empty() && arguments[0].ends_with(".qps");
  if (!are_files && arguments.size() < 2) throw std::invalid_argument("expected programs or scenes");
  if (are_files) return measure_files(arguments);
  const std::span<const std::string> scenes = std::span(arguments).subspan(1);
  const int each =
      (std::atoi(arguments[0].c_str()) + static_cast<int>(scenes.size()) - 1) / static_cast<int>(scenes.size());
  Tally all;
  for (const std::string& scene : scenes) all.add(measure_scene(scene, each, folder));
  return all;
}

}  // namespace
}  // namespace crease

int main(int argc, char** argv) {
  std::printf(
      "| scene | programs | without a solution | not solved | fallbacks | most exchanges | given to Ipopt too | not "
      "solved "
      "there | KKT residual, largest | objectives differ, most | by more than 1e-6 "
      "|\n|---|---|---|---|---|---|---|---|---|---|---|\n");
  try {
    const crease::Tally all = crease::measure({argv + 1, argv + argc});
    all.print("all");
    return all.unsolved == 0 && all.differ == 0 && all.residual <= crease::largest_residual ? 0 : 1;
  } catch (const std::exception& error) {
    std::fprintf(stderr,
                 "%s\nusage: program_benchmark PROGRAMS SCENE.json.. [--write FOLDER]\n       program_benchmark "
                 "PROGRAM.qps..\n",
                 error.what());
    return 2;
  }
}
