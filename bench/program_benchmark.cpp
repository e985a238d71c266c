// SPDX-License-Identifier: MIT
//
// Whether the solver is right on the quadratic programs of real runs: takes programs from scenes' whole runs, evenly,
// has each solved by Ipopt too, and compares the objectives. Every program of the runs counts for the KKT residual, the
// iterations and the fallbacks. Ends with 1 if anything fails.
#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <limits>
#include <string>
#include <vector>

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

class Comparison {
 public:
  explicit Comparison(int every) : every_(every) {}

  QpResult solve(const QpProblem& problem, std::span<const char> guess, const Stages& stages) {
    QpResult result = stages.solve(problem, guess);
    tally.fallbacks += result.fell_back;
    tally.most_iterations = std::max(tally.most_iterations, result.iterations);
    const bool solved = result.status == QpStatus::Solved;
    if (solved) tally.residual = std::max(tally.residual, result.kkt_residual);
    if (tally.programs++ % every_ == 0 || !solved) compare(problem, result);
    return result;
  }

  Tally tally;

 private:
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

  int every_;
};

Tally measure(const std::string& file, int count) {
  const LoadedScene loaded = load_scene(file, {});
  const int steps = static_cast<int>(loaded.scene.duration / loaded.scene.time_step);
  Comparison comparison(std::max(1, steps / std::max(1, count)));
  RunOptions options;
  options.directory = std::filesystem::temp_directory_path() / ("crease_program_benchmark_" + std::to_string(getpid()));
  options.force = true;
  options.stages = [&](const Scene& scene, const ClothSpec& spec) {
    Stages stages = make_stages(scene, spec);
    if (!stages.solve) return stages;
    stages.solve = [&comparison, plain = stages](const QpProblem& problem, std::span<const char> guess) {
      return comparison.solve(problem, guess, plain);
    };
    return stages;
  };
  const RunResult result = run_scene(loaded, options);
  if (result.status != RunStatus::Done) std::fprintf(stderr, "%s: %s\n", file.c_str(), result.message.c_str());
  std::filesystem::remove_all(options.directory);
  if (comparison.tally.programs > 0) comparison.tally.print(std::filesystem::path(file).stem().string());
  return comparison.tally;
}

}  // namespace
}  // namespace crease

int main(int argc, char** argv) {
  if (argc < 3) {
    std::fprintf(stderr, "usage: program_benchmark PROGRAMS SCENE.json..\n");
    return 2;
  }
  std::printf(
      "| scene | programs | without a solution | not solved | fallbacks | most exchanges | given to Ipopt too | not "
      "solved "
      "there | KKT residual, largest | objectives differ, most | by more than 1e-6 "
      "|\n|---|---|---|---|---|---|---|---|---|---|---|\n");
  crease::Tally all;
  const int each = (std::atoi(argv[1]) + argc - 3) / (argc - 2);
  for (int i = 2; i < argc; ++i) all.add(crease::measure(argv[i], each));
  all.print("all");
  const bool right = all.unsolved == 0 && all.differ == 0 && all.residual <= crease::largest_residual;
  return right ? 0 : 1;
}
