// SPDX-License-Identifier: MIT
//
// What a step costs, stage by stage, against one factorisation and one solve of its own matrix: of every step of a
// scene's run, in the same process and on one thread, so that the machine's drift hits both. Processor time of the
// thread; medians. Ipopt solves one program in fifty for comparison, unless told not to: on large meshes it takes
// minutes. On request gusts blow on the sheet, which a scene has no word for, and the mesh stays from some step on.
// Several threads are compared with one by the clock, which alone shows how they wait for each other, and by the
// processor time of the busier one, which is left where the others find no core of their own.
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <ctime>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <limits>
#include <memory>
#include <numbers>
#include <random>
#include <string>
#include <utility>
#include <vector>

#include "crease/geometry/dof_map.hpp"
#include "crease/geometry/triangle.hpp"
#include "crease/solver/linear_solver.hpp"
#include "crease/stepper/run.hpp"
#include "measure.hpp"

namespace crease {
namespace {

constexpr int ipopt_every = 50;

/// Processor time of one call, unless another clock is asked for.
template <class Call>
auto timed(double& seconds, Call&& call, clockid_t clock = CLOCK_THREAD_CPUTIME_ID) {
  const double start = seconds_of(clock);
  auto result = call();
  seconds += seconds_of(clock) - start;
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
  bool changed = false;  ///< the pattern of the matrix: remeshed, or EOL vertices have come or gone
};

/// Impulses of a wind on a sheet within a step of length h, in the unknowns of `dofs`: (f, -F^T f), as all forces of a
/// sheet. The gusts have up to twice the weight and stand in a lattice that moves on, so that what is lifted comes down
/// again; at the start every vertex gets a velocity of its own on top of that.
VecX wind_impulse(const Cloth& cloth, const DofMap& dofs, double density, double time, double h) {
  constexpr double gust = 20, cell = 0.35, period = 0.2, first_speed = 0.3;  // [m/s^2], [m], [s], [m/s]
  constexpr double turn = 2 * std::numbers::pi;
  VecX impulse = VecX::Zero(dofs.size());
  std::mt19937 random(1);
  for (int v = 0; v < cloth.mesh.n_vertices(); ++v) {
    double area = 0;
    for (const int half_edge : cloth.mesh.outgoing(v)) area += cloth.mesh.material_area(Mesh::face_of(half_edge)) / 3;
    const Vec2& X = cloth.mesh.X[v];
    Vec3 kick(0, 0, h * gust * std::sin(turn * (X.x() / cell + time / period)) * std::sin(turn * X.y() / cell));
    for (double& k : kick)
      if (time == 0) k += first_speed * std::uniform_real_distribution(-1.0, 1.0)(random);
    kick *= density * area;
    impulse.segment<3>(dofs.x(v)) += kick;
    if (dofs.is_eol(v)) impulse.segment<2>(dofs.X(v)) -= vertex_deformation_gradient(cloth.mesh, v).transpose() * kick;
  }
  return impulse;
}

struct Wishes {
  bool ask_ipopt = true, wind = false;
  std::size_t remeshed = std::numeric_limits<std::size_t>::max();  ///< steps after which nothing is remeshed any more
};

class Measurement {
 public:
  explicit Measurement(const Wishes& wishes) : wishes_(wishes) {}
  Stages wrap(const Scene& scene, const ClothSpec& spec);
  void end_step(const RunProgress& progress);
  void report(const std::string& scene) const;

 private:
  QpResult measure_program(const QpProblem& problem, std::span<const char> guess, const Stages& stages);
  void factor_and_solve(const QpProblem& problem);

  Wishes wishes_;
  double time_ = 0;   ///< at the beginning of the step [s]
  VecX gust_;         ///< impulse of the wind in it
  BlockGraph graph_;  ///< of the last program
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
  BlockGraph graph = graph_of(problem.H, problem.blocks);
  now_.changed |= graph.starts != graph_.starts || graph.inner != graph_.inner || graph.outer != graph_.outer;
  const double lift = 1e-6 * problem.H.diagonal().maxCoeff();
  const MatX b = problem.f;
  for (const auto& [factor, seconds] : {std::pair{own_.get(), &now_.own}, std::pair{cholmod_.get(), &now_.cholmod}}) {
    if (!factor->analyze(graph)) std::exit((std::fprintf(stderr, "step_benchmark: analysis failed\n"), 1));
    timed(*seconds, [&] { return factor->factorize(problem.H, {}, lift) && factor->solve(b).allFinite(); });
  }
  graph_ = std::move(graph);
}

QpResult Measurement::measure_program(const QpProblem& problem, std::span<const char> guess, const Stages& stages) {
  QpResult result = timed(now_.solve, [&] { return stages.solve(problem, guess); });
  timed(now_.aside, [&] {
    worst_residual_ = std::max(worst_residual_, result.kkt_residual);
    if (now_.programs++ == 0) factor_and_solve(problem);
    if (n_programs_++ % ipopt_every == 0 && wishes_.ask_ipopt) {
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
  Stages plain = make_stages(scene, spec);
  Stages stages;
  if (plain.detect)
    stages.detect = [this, plain](const auto&... given) {
      return timed(now_.detect, [&] { return plain.detect(given...); });
    };
  if (plain.remesh)
    stages.remesh = [this, plain](const Cloth& cloth, const auto&... given) {
      if (steps_.size() >= wishes_.remeshed) return RemeshResult{cloth, {}};
      return timed(now_.remesh, [&] { return plain.remesh(cloth, given...); });
    };
  if (plain.foresee)
    stages.foresee = [this, plain](const auto&... given) {
      return timed(now_.detect, [&] { return plain.foresee(given...); });
    };
  if (plain.constrain)
    stages.constrain = [this, plain, density = spec.material.density](
                           const Cloth& cloth, const DofMap& dofs, std::span<const Contact> contacts,
                           std::span<const PosedObstacle> obstacles, std::span<const PinState> pins,
                           const ConstraintOptions& options) {
      if (wishes_.wind) gust_ = timed(now_.aside, [&] { return wind_impulse(cloth, dofs, density, time_, options.h); });
      return timed(now_.constrain, [&] { return plain.constrain(cloth, dofs, contacts, obstacles, pins, options); });
    };
  // Without a solve stage the stepper solves by itself, where it is not seen from here: by the same means.
  if (!plain.solve)
    plain.solve = [linear = std::make_shared<LinearSolver>()](const QpProblem& problem, std::span<const char>) {
      return linear->solve(problem);
    };
  stages.solve = [this, plain](const QpProblem& problem, std::span<const char> guess) {
    if (gust_.size() == 0) return measure_program(problem, guess, plain);
    QpProblem blown;
    timed(now_.aside, [&] {
      blown = problem;
      blown.f += gust_;
      return 0;
    });
    return measure_program(blown, guess, plain);
  };
  return stages;
}

void Measurement::end_step(const RunProgress& progress) {
  const double time = seconds_of(CLOCK_THREAD_CPUTIME_ID);
  now_.whole = time - last_ - now_.aside;
  time_ = progress.time;
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
  for (const bool changed : {false, true})
    std::printf(" %.2f (%.2f) |", ratio(&S::solve, &S::own, changed, 0.5), ratio(&S::solve, &S::own, changed, 0.9));
  std::printf(" %.2f | %.2f |", ratio(&S::solve, &S::cholmod, false, 0.5), ratio(&S::solve, &S::cholmod, true, 0.5));
  std::printf(" %.2f | %.2f |", ratio(&S::whole, &S::cholmod, false, 0.5), ratio(&S::whole, &S::cholmod, true, 0.5));
  std::printf(ipopt_ratio_.empty() ? " - |" : " %.0f |", quantile(ipopt_ratio_, 0.5));
  std::printf(" %.0e | %.0f |\n", worst_residual_, peak_memory());
  std::fflush(stdout);
}

using Changes = std::vector<std::pair<std::string, std::string>>;

void measure(const std::string& file, double until, const Changes& changes, const Wishes& wishes) {
  const std::filesystem::path directory =
      std::filesystem::temp_directory_path() / ("crease_step_benchmark_" + std::to_string(getpid()));
  Measurement measurement(wishes);
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

/// Seconds of a run, step by step.
struct ClockedRun {
  std::vector<double> qp, whole;  ///< by the clock
  std::vector<double> busier;     ///< processor time of the caller, or of all other threads where that is more
  int most_faces = 0;
  std::string end;  ///< all of the state that it ends with
};

ClockedRun clocked_run(const LoadedScene& scene, double until, int threads) {
  const std::filesystem::path directory =
      std::filesystem::temp_directory_path() / ("crease_step_benchmark_" + std::to_string(getpid()));
  ClockedRun run;
  double qp = 0;
  RunOptions options;
  options.directory = directory;
  options.force = true;
  options.until = until;
  options.threads = threads;
  options.stages = [&](const Scene& described, const ClothSpec& spec) {
    Stages stages = make_stages(described, spec, threads);
    if (!stages.solve) return stages;
    stages.solve = [&qp, solve = stages.solve](const auto&... given) {
      return timed(
          qp, [&] { return solve(given...); }, CLOCK_MONOTONIC);
    };
    return stages;
  };
  const auto now = [] {
    return std::array{seconds_of(CLOCK_MONOTONIC), seconds_of(CLOCK_THREAD_CPUTIME_ID),
                      seconds_of(CLOCK_PROCESS_CPUTIME_ID)};
  };
  auto last = now();
  run_scene(scene, options, [&](const RunProgress& progress) {
    const auto [clock, own, all] = now();
    run.qp.push_back(std::exchange(qp, 0));
    run.whole.push_back(clock - last[0]);
    run.busier.push_back(std::max(own - last[1], (all - last[2]) - (own - last[1])));
    run.most_faces = std::max(run.most_faces, progress.faces);
    last = now();
    return true;
  });
  std::ifstream checkpoint(directory / "checkpoint.bin", std::ios::binary);
  run.end.assign(std::istreambuf_iterator<char>(checkpoint), {});
  std::filesystem::remove_all(directory);
  return run;
}

/// The runs take turns. Of a step counts the turn in which it took least, as others on the cores only add to it.
void compare_threads(const std::string& file, double until, const Changes& changes, int threads) {
  constexpr int turns = 3;
  constexpr std::array times{&ClockedRun::qp, &ClockedRun::whole, &ClockedRun::busier};
  const LoadedScene scene = load_scene(file, changes);
  std::array<ClockedRun, 2> best;
  for (int turn = 0; turn < turns; ++turn)
    for (const int k : {0, 1}) {
      ClockedRun run = clocked_run(scene, until, k == 0 ? 1 : threads);
      if (turn + k > 0 && (run.end.empty() || run.end != best[0].end))
        std::exit((std::fprintf(stderr, "step_benchmark: %s: %d threads end elsewhere\n", file.c_str(), threads), 1));
      if (turn == 0) best[k] = run;
      for (const auto time : times)
        for (std::size_t step = 0; step < run.whole.size(); ++step)
          (best[k].*time)[step] = std::min((best[k].*time)[step], (run.*time)[step]);
    }
  std::printf("| %s | %d | %zu |", std::filesystem::path(file).stem().c_str(), best[0].most_faces,
              best[0].whole.size());
  for (const auto time : times) {
    std::vector<double> ratios;
    for (std::size_t step = 0; step < (best[0].*time).size(); ++step)
      ratios.push_back((best[0].*time)[step] / (best[1].*time)[step]);
    for (const ClockedRun& run : best) std::printf(" %.2f |", 1e3 * quantile(run.*time, 0.5));
    std::printf(" %.2f |", quantile(ratios, 0.5));
  }
  std::printf("\n");
  std::fflush(stdout);
}

}  // namespace
}  // namespace crease

int main(int argc, char** argv) {
  if (argc < 3) {
    std::fprintf(
        stderr,
        "usage: step_benchmark SECONDS SCENE.json.. [--set KEY=VALUE].. [--no-ipopt] [--wind] [--still STEPS]\n"
        "                      [--threads N]\n"
        "  --wind         gusts of twice the sheet's weight\n"
        "  --still STEPS  no remeshing after so many steps\n"
        "  --threads N    instead: the whole step in so many threads against one\n");
    return 2;
  }
  std::vector<std::string> scenes;
  crease::Changes changes;
  crease::Wishes wishes;
  int threads = 0;
  for (int i = 2; i < argc; ++i) {
    const std::string word = argv[i];
    if (word == "--set" && i + 1 < argc) {
      const std::string change = argv[++i];
      changes.emplace_back(change.substr(0, change.find('=')), change.substr(change.find('=') + 1));
    } else if (word == "--no-ipopt") {
      wishes.ask_ipopt = false;
    } else if (word == "--wind") {
      wishes.wind = true;
    } else if (word == "--still" && i + 1 < argc) {
      wishes.remeshed = std::strtoul(argv[++i], nullptr, 10);
    } else if (word == "--threads" && i + 1 < argc) {
      threads = std::max(1, std::atoi(argv[++i]));
    } else {
      scenes.push_back(word);
    }
  }
  if (threads > 0) {
    std::printf(
        "Milliseconds in one thread, in %d, and the ratio.\n\n"
        "| scene | faces | steps | QP, by the clock | %d | ratio | whole step, by the clock | %d | ratio "
        "| whole step, busier thread | %d | ratio |\n|---|---|---|---|---|---|---|---|---|---|---|---|\n",
        threads, threads, threads, threads);
    for (const std::string& scene : scenes) crease::compare_threads(scene, std::atof(argv[1]), changes, threads);
    return 0;
  }
  std::printf(
      "Milliseconds; ratios of steps that keep the mesh / of those that change it.\n\n"
      "| scene | faces | steps | detect | remesh | constrain | QP | the rest | whole step | own factor + solve | "
      "CHOLMOD's "
      "| QP / own's (p90) | changed (p90) | QP / CHOLMOD's | changed | step / CHOLMOD's | changed | Ipopt / QP | KKT "
      "residual, "
      "largest | peak memory [MB] "
      "|\n|---|---|---|---|---|---|---|---|---|---|---|---|---|---|---|---|---|---|---|---|\n");
  for (const std::string& scene : scenes) crease::measure(scene, std::atof(argv[1]), changes, wishes);
}
