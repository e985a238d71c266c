// SPDX-License-Identifier: MIT
//
// What a step costs, stage by stage, against one factorisation and one solve of its own matrix: of every step of a
// scene's run, in the same process and on one thread, so that the machine's drift hits both. Processor time of the
// thread; medians. Ipopt solves one program in fifty for comparison, unless told not to: on large meshes it takes
// minutes.
#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <ctime>
#include <filesystem>
#include <string>
#include <utility>
#include <vector>

#include "crease/geometry/dof_map.hpp"
#include "crease/stepper/run.hpp"
#include "measure.hpp"

namespace crease {
namespace {

constexpr int ipopt_every = 50;

/// Processor time of one call.
template <class Call>
auto timed(double& seconds, Call&& call) {
  const double start = seconds_of(CLOCK_THREAD_CPUTIME_ID);
  auto result = call();
  seconds += seconds_of(CLOCK_THREAD_CPUTIME_ID) - start;
  return result;
}

double quantile(std::vector<double> values, double share) {
  if (values.empty()) return 0;
  std::sort(values.begin(), values.end());
  return values[static_cast<std::size_t>(share * static_cast<double>(values.size() - 1))];
}

/// The time of one step; of several attempts at it, all.
struct StepTimes {
  double detect = 0, remesh = 0, constrain = 0, solve = 0, whole = 0;
  double rest = 0;                         ///< of the whole: assembly, integration, a second look for contacts, output
  double own = 0, cholmod = 0, aside = 0;  ///< factor and solve, and all that is measured beside the step
  int programs = 0;
  bool changed = false;  ///< the mesh or the EOL set
};

class Measurement {
 public:
  explicit Measurement(bool ask_ipopt) : ask_ipopt_(ask_ipopt) {}
  Stages wrap(const Scene& scene, const ClothSpec& spec);
  void end_step(const RunProgress& progress);
  void report(const std::string& scene) const;

 private:
  QpResult measure_program(const QpProblem& problem, std::span<const char> guess, const Stages& stages);
  void factor_and_solve(const QpProblem& problem);

  bool ask_ipopt_;
  StepTimes now_;
  double last_ = seconds_of(CLOCK_THREAD_CPUTIME_ID);
  double worst_residual_ = 0;
  int n_programs_ = 0, most_faces_ = 0;
  std::vector<StepTimes> steps_;
  std::vector<double> ipopt_ratio_;
  std::unique_ptr<BlockCholesky> own_ = make_block_cholesky();
  std::unique_ptr<BlockCholesky> cholmod_ = make_block_cholesky({CholeskyMethod::Cholmod, FrontKernelSet::Best});
};

/// The floor: numbers only, the analysis is not counted. Held unknowns do not change the pattern, so none are held; the
/// lift makes the undecided unknowns of flat cloth regular.
void Measurement::factor_and_solve(const QpProblem& problem) {
  const BlockGraph graph = graph_of(problem.H, problem.blocks);
  const double lift = 1e-6 * problem.H.diagonal().maxCoeff();
  const MatX b = problem.f;
  for (const auto& [factor, seconds] : {std::pair{own_.get(), &now_.own}, std::pair{cholmod_.get(), &now_.cholmod}}) {
    if (!factor->analyze(graph)) std::exit((std::fprintf(stderr, "step_benchmark: analysis failed\n"), 1));
    timed(*seconds, [&] { return factor->factorize(problem.H, {}, lift) && factor->solve(b).allFinite(); });
  }
}

QpResult Measurement::measure_program(const QpProblem& problem, std::span<const char> guess, const Stages& stages) {
  QpResult result = timed(now_.solve, [&] { return stages.solve(problem, guess); });
  timed(now_.aside, [&] {
    worst_residual_ = std::max(worst_residual_, result.kkt_residual);
    if (now_.programs++ == 0) factor_and_solve(problem);
    if (n_programs_++ % ipopt_every == 0 && ask_ipopt_) {
      double ours = 0, theirs = 0;
      timed(ours, [&] { return stages.solve(problem, guess); });
      timed(theirs, [&] { return make_qp_solver(QpMethod::Ipopt)->solve(problem); });
      ipopt_ratio_.push_back(theirs / ours);
    }
    return 0;
  });
  return result;
}

Stages Measurement::wrap(const Scene& scene, const ClothSpec& spec) {
  const Stages plain = make_stages(scene, spec);
  Stages stages;
  if (plain.detect)
    stages.detect = [this, plain](const auto&... given) {
      return timed(now_.detect, [&] { return plain.detect(given...); });
    };
  if (plain.remesh)
    stages.remesh = [this, plain](const auto&... given) {
      RemeshResult result = timed(now_.remesh, [&] { return plain.remesh(given...); });
      const RemeshReport& report = result.report;
      now_.changed |= report.splits + report.flips + report.collapses + report.inserted + report.released > 0;
      return result;
    };
  if (plain.constrain)
    stages.constrain = [this, plain](const auto&... given) {
      return timed(now_.constrain, [&] { return plain.constrain(given...); });
    };
  if (plain.solve)
    stages.solve = [this, plain](const QpProblem& problem, std::span<const char> guess) {
      return measure_program(problem, guess, plain);
    };
  return stages;
}

void Measurement::end_step(const RunProgress& progress) {
  const double time = seconds_of(CLOCK_THREAD_CPUTIME_ID);
  now_.whole = time - last_ - now_.aside;
  now_.rest = now_.whole - now_.detect - now_.remesh - now_.constrain - now_.solve;
  steps_.push_back(std::exchange(now_, {}));
  most_faces_ = std::max(most_faces_, progress.faces);
  last_ = seconds_of(CLOCK_THREAD_CPUTIME_ID);
}

void Measurement::report(const std::string& scene) const {
  const auto median = [&](double StepTimes::*time) {
    std::vector<double> values;
    for (const StepTimes& step : steps_) values.push_back(1e3 * step.*time);
    return quantile(values, 0.5);
  };
  const auto ratio = [&](double StepTimes::*time, double StepTimes::*floor, bool changed, double share) {
    std::vector<double> values;
    for (const StepTimes& step : steps_)
      if (step.programs == 1 && step.changed == changed) values.push_back(step.*time / step.*floor);
    return quantile(values, share);
  };
  using S = StepTimes;
  std::printf("| %s | %d | %zu |", scene.c_str(), most_faces_, steps_.size());
  for (double S::*time : {&S::detect, &S::remesh, &S::constrain, &S::solve, &S::rest, &S::whole, &S::own, &S::cholmod})
    std::printf(" %.2f |", median(time));
  std::printf(" %.2f (%.2f) | %.2f |", ratio(&S::solve, &S::own, false, 0.5), ratio(&S::solve, &S::own, false, 0.9),
              ratio(&S::solve, &S::own, true, 0.5));
  std::printf(" %.2f | %.2f |", ratio(&S::solve, &S::cholmod, false, 0.5), ratio(&S::solve, &S::cholmod, true, 0.5));
  std::printf(" %.2f | %.2f |", ratio(&S::whole, &S::cholmod, false, 0.5), ratio(&S::whole, &S::cholmod, true, 0.5));
  std::printf(ipopt_ratio_.empty() ? " - |" : " %.0f |", quantile(ipopt_ratio_, 0.5));
  std::printf(" %.0e | %.0f |\n", worst_residual_, peak_memory());
  std::fflush(stdout);
}

using Changes = std::vector<std::pair<std::string, std::string>>;

void measure(const std::string& file, double until, const Changes& changes, bool ask_ipopt) {
  const std::filesystem::path directory = std::filesystem::temp_directory_path() / "crease_step_benchmark";
  Measurement measurement(ask_ipopt);
  RunOptions options;
  options.directory = directory;
  options.force = true;
  options.until = until;
  options.stages = [&](const Scene& scene, const ClothSpec& spec) { return measurement.wrap(scene, spec); };
  const RunResult result = run_scene(load_scene(file, changes), options, [&](const RunProgress& progress) {
    measurement.end_step(progress);
    return true;
  });
  if (result.status != RunStatus::Done) std::fprintf(stderr, "%s: %s\n", file.c_str(), result.message.c_str());
  measurement.report(std::filesystem::path(file).stem().string());
  std::filesystem::remove_all(directory);
}

}  // namespace
}  // namespace crease

int main(int argc, char** argv) {
  if (argc < 3) {
    std::fprintf(stderr, "usage: step_benchmark SECONDS SCENE.json.. [--set KEY=VALUE].. [--no-ipopt]\n");
    return 2;
  }
  std::vector<std::string> scenes;
  crease::Changes changes;
  bool ask_ipopt = true;
  for (int i = 2; i < argc; ++i) {
    const std::string word = argv[i];
    if (word == "--set" && i + 1 < argc) {
      const std::string change = argv[++i];
      changes.emplace_back(change.substr(0, change.find('=')), change.substr(change.find('=') + 1));
    } else if (word == "--no-ipopt") {
      ask_ipopt = false;
    } else {
      scenes.push_back(word);
    }
  }
  std::printf(
      "Milliseconds; ratios of steps that keep the mesh / of those that change it.\n\n"
      "| scene | faces | steps | detect | remesh | constrain | QP | the rest | whole step | own factor + solve | "
      "CHOLMOD's "
      "| QP / own's (p90) | changed | QP / CHOLMOD's | changed | step / CHOLMOD's | changed | Ipopt / QP | KKT "
      "residual, "
      "largest | peak memory [MB] "
      "|\n|---|---|---|---|---|---|---|---|---|---|---|---|---|---|---|---|---|---|---|---|\n");
  for (const std::string& scene : scenes) crease::measure(scene, std::atof(argv[1]), changes, ask_ipopt);
}
