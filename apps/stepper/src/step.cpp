// SPDX-License-Identifier: MIT
#include "crease/stepper/step.hpp"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <set>
#include <utility>

#include "active_rows.hpp"
#include "contact_keys.hpp"
#include "crease/base/require.hpp"
#include "crease/geometry/dof_map.hpp"
#include "crease/geometry/triangle.hpp"
#include "crease/geometry/wire.hpp"
#include "crease/solver/linear_solver.hpp"
#include "feature_tracking.hpp"
#include "runaways.hpp"

namespace crease {
namespace {

/// Solutions of one step, each with the contacts that the one before ran into.
constexpr int max_passes = 4;
/// ConstraintOptions::wire_clearance as a share of the contact threshold: above what a step's straight path misses of
/// the fold's turn, below the gap at which a vertex begins to ride on the wire.
constexpr double wire_clearance_share = 0.1;

class Stopwatch {
 public:
  /// Seconds since the last lap.
  double lap() {
    const auto now = std::chrono::steady_clock::now();
    return std::chrono::duration<double>(now - std::exchange(last_, now)).count();
  }

 private:
  std::chrono::steady_clock::time_point last_ = std::chrono::steady_clock::now();
};

std::vector<PosedObstacle> pose_all(std::span<const Obstacle> obstacles, double time, double h) {
  std::vector<PosedObstacle> posed;
  posed.reserve(obstacles.size());
  for (const Obstacle& obstacle : obstacles) posed.push_back({&obstacle.shape, mean_motion(obstacle, time, h)});
  return posed;
}

/// Into the memory of the last step's.
void make_problem(const AssembledSystem& system, const ConstraintRows& rows, const DofMap& dofs, QpProblem& problem) {
  problem.H = system.H;
  problem.f = system.rhs;
  problem.A_eq = rows.A_eq;
  problem.A_in = rows.A_in;
  problem.b_eq = rows.b_eq;
  problem.b_in = rows.b_in;
  problem.blocks = dof_blocks(dofs);
}

bool all_finite(const Cloth& cloth) {
  for (int i = 0; i < cloth.mesh.vertex_slots(); ++i)
    if (!cloth.mesh.x[i].allFinite() || !cloth.mesh.X[i].allFinite() || !cloth.v[i].allFinite() ||
        !cloth.V[i].allFinite())
      return false;
  return true;
}

/// Detection reaches as far as the velocities go at which it looks. True if the solution moves x farther past an
/// obstacle than that, by more than the threshold: forces, pins or contacts have sped it up.
bool outran(const Vec3& x, const Vec3& solved, const Vec3& looked, std::span<const PosedObstacle> obstacles, double h,
            double threshold) {
  return std::any_of(obstacles.begin(), obstacles.end(), [&](const PosedObstacle& obstacle) {
    const Vec3 there = obstacle.pose.velocity_at(x);
    return h * (solved - there).norm() > h * (looked - there).norm() + threshold;
  });
}

/// What the stages of one step hand on to each other.
struct Work {
  double time, h;
  StepOptions options;
  std::vector<PosedObstacle> posed;
  Cloth cloth;               // remeshed; its velocities are still those before the step
  std::vector<char> held{};  // see ConstraintOptions; empty or by vertex
  bool pushes_out = true;    // what is inside an obstacle, or off its feature
  std::vector<Contact> contacts{};
  DofMap dofs{};
  ConstraintRows rows{};
  QpResult solution{};
  StepReport report{};
  Stopwatch watch{};

  bool fail(StepStatus status, std::string stage, std::string message) {
    report.status = status;
    report.stage = std::move(stage);
    report.message = std::move(message);
    return false;
  }
};

/// True if the solution moves a vertex ten times as fast as anything that could move it: cloth, obstacles, pins, and
/// what pushes it out. As where two edges of a thin plate push the ends of a short lever apart.
bool is_flung(const Work& work, const SheetSettings& settings) {
  constexpr double most_times = 10;
  double before = settings.push_out_speed + work.h * settings.dynamics.gravity.norm(), after = 0;
  for (int v = 0; v < work.cloth.mesh.n_vertices(); ++v) {
    before = std::max(before, work.cloth.v[v].norm());
    after = std::max(after, work.solution.q.segment<3>(work.dofs.x(v)).norm());
  }
  for (const Contact& contact : work.contacts) before = std::max(before, contact.velocity.norm());
  if (work.rows.b_eq.size() > 0) before = std::max(before, work.rows.b_eq.cwiseAbs().maxCoeff());
  return after > most_times * before;
}

/// The cloth at the end of the step that the solution says.
Cloth moved(const Work& work) {
  Cloth next = work.cloth;
  scatter_velocity(work.solution.q, work.dofs, next);
  for (int v = 0; v < next.mesh.n_vertices(); ++v) {
    next.mesh.x[v] += work.h * next.v[v];
    if (next.is_eol(v)) next.mesh.X[v] += work.h * next.V[v];
  }
  return next;
}

/// Holds these vertices for the rest of the step; false if all of them are already.
bool hold(Work& work, const std::vector<int>& vertices) {
  const int before = work.report.held;
  work.held.resize(static_cast<std::size_t>(work.cloth.mesh.n_vertices()));
  for (const int v : vertices)
    if (std::exchange(work.held[v], 1) == 0) ++work.report.held;
  return work.report.held > before;
}

Carried carried(const Motion& motion, double density) {
  return {density * motion.area, density * motion.linear, density * motion.angular, density * motion.kinetic};
}

void read_multipliers(Work& work) {
  const auto& rows = work.rows;
  const auto& solution = work.solution;
  StepReport& report = work.report;
  report.active_constraints =
      static_cast<int>(rows.eq.size() + std::count(solution.active.begin(), solution.active.end(), 1));
  for (std::size_t r = 0; r < rows.in.size(); ++r)
    if (rows.in[r].kind == RowKind::EolNormal)
      report.edge_reaction += solution.lambda_in[static_cast<int>(r)] / work.h * rows.in[r].normal;
  for (std::size_t r = 0; r < rows.eq.size(); ++r) {
    const Vec3 force = solution.lambda_eq[static_cast<int>(r)] / work.h * rows.eq[r].normal;
    if (rows.eq[r].kind == RowKind::Pin) report.pin_reaction += force;
    if (rows.eq[r].kind == RowKind::EolHold) report.edge_reaction += force;
  }
}

}  // namespace

const char* to_string(StepStatus status) {
  switch (status) {
    case StepStatus::Done:
      return "done";
    case StepStatus::QpFailed:
      return "quadratic program failed";
    case StepStatus::NotFinite:
      return "state is not finite";
    case StepStatus::ContactsUnsettled:
      return "new contacts with every solution";
    case StepStatus::EulerianStepTooLong:
      return "material step too long for the triangles ahead";
  }
  return "unknown";
}

struct SheetStepper::Impl {
  Impl(SheetSettings given, Stages made)
      : settings(std::move(given)), stages(std::move(made)), assembler(settings.threads), linear(settings.threads) {}

  SheetSettings settings;
  Stages stages;
  Assembler assembler;
  LinearSolver linear;                      // where there is no solve stage
  const AssembledSystem* system = nullptr;  // the assembler's, of the step under way
  // Of the last accepted assembly: reused while faces and EOL set stay.
  std::vector<std::array<int, 3>> faces;
  std::vector<char> eol;
  ActiveRows active;  // in the last solution
  QpProblem problem;

  // The stages of Algorithm 1, in order; false = the step failed and the report says why.
  void detect(Work& work);
  void remesh(Work& work);
  bool assemble(Work& work);
  void constrain(Work& work);
  QpStatus solve(Work& work);
  bool solve_rows(Work& work);
  bool constrain_and_solve(Work& work);
  bool find_motion(Work& work, Cloth& next);
  void integrate(Work& work, Cloth next, std::span<const Obstacle> obstacles);

  bool same_topology(const Cloth& cloth);
  void forget();
};

bool SheetStepper::Impl::same_topology(const Cloth& cloth) {
  std::vector<std::array<int, 3>> now_faces(static_cast<std::size_t>(cloth.mesh.n_faces()));
  std::vector<char> now_eol(static_cast<std::size_t>(cloth.mesh.n_vertices()));
  for (int f = 0; f < cloth.mesh.n_faces(); ++f) now_faces[f] = cloth.mesh.face(f);
  for (int v = 0; v < cloth.mesh.n_vertices(); ++v) now_eol[v] = cloth.is_eol(v);
  const bool same = now_faces == faces && now_eol == eol;
  faces = std::move(now_faces);
  eol = std::move(now_eol);
  return same;
}

/// What was remembered is of a mesh that a failed step has thrown away.
void SheetStepper::Impl::forget() {
  faces.clear();
  eol.clear();
  active.forget();
}

SheetStepper::SheetStepper(SheetSettings settings, Stages stages)
    : impl_(std::make_unique<Impl>(std::move(settings), std::move(stages))) {
  require_valid(impl_->settings.material);
  require(impl_->stages.solve || !impl_->stages.constrain,
          "SheetStepper: expected a solve stage, as there is one that constrains; got an empty function");
}
SheetStepper::~SheetStepper() = default;
SheetStepper::SheetStepper(SheetStepper&&) noexcept = default;

void SheetStepper::Impl::detect(Work& work) {
  if (!stages.detect) return;
  work.contacts = stages.detect(work.cloth, work.posed, work.h);
  work.report.contacts = static_cast<int>(work.contacts.size());
  work.report.times.detect += work.watch.lap();
}

void SheetStepper::Impl::remesh(Work& work) {
  if (!stages.remesh) return;
  RemeshResult remeshed = stages.remesh(work.cloth, work.contacts, work.posed, work.h);
  const RemeshReport& done = remeshed.report;
  StepReport& report = work.report;
  report.inserted = done.inserted;
  report.released = done.released;
  report.splits = done.splits;
  report.flips = done.flips;
  report.collapses = done.collapses;
  report.refusals = static_cast<int>(done.refusals.size());
  report.before_remesh = carried(done.before, settings.material.density);
  report.after_remesh = carried(done.after, settings.material.density);
  report.times.remesh = work.watch.lap();
  if (!done.changed) return;
  active.renumber(done.vertex_map);
  work.cloth = std::move(remeshed.cloth);
  spread_wire_sides(work.cloth, work.posed);
  report.times.transfer = work.watch.lap();
  detect(work);  // contacts name vertices: find them again on the new mesh
}

bool SheetStepper::Impl::assemble(Work& work) {
  work.dofs = make_dof_map(work.cloth);
  system = &assembler.assemble(work.cloth, work.dofs, settings.material, settings.dynamics, work.h,
                               same_topology(work.cloth));
  StepReport& report = work.report;
  report.energies = system->energies;
  report.times.assemble = work.watch.lap();
  return system->rhs.allFinite() || work.fail(StepStatus::NotFinite, "assemble", "forces are not finite");
}

void SheetStepper::Impl::constrain(Work& work) {
  if (!stages.constrain) return;
  std::vector<PinState> pins;
  for (std::size_t k = 0; k < settings.pins.size(); ++k)
    pins.push_back(pin_state(settings.pins[k], static_cast<int>(k), work.time, work.h));
  ConstraintOptions options;
  options.h = work.h;
  options.push_out_speed = work.pushes_out ? settings.push_out_speed : 0;
  options.wire_clearance = wire_clearance_share * settings.threshold;
  options.held = work.held;
  work.rows = stages.constrain(work.cloth, work.dofs, work.contacts, work.posed, pins, options);
  work.report.times.constrain += work.watch.lap();
}

QpStatus SheetStepper::Impl::solve(Work& work) {
  make_problem(*system, work.rows, work.dofs, problem);
  if (stages.solve) {
    const bool solved = work.solution.q.size() == work.dofs.size();
    const VecX motion = solved ? work.solution.q : gather_velocity(work.cloth, work.dofs);
    work.solution = stages.solve(problem, active.guess(work.rows, motion));
  } else {
    work.solution = linear.solve(problem);
  }
  const QpResult& solution = work.solution;
  work.report.qp_iterations += solution.iterations;
  work.report.qp_fell_back = work.report.qp_fell_back || solution.fell_back;
  work.report.kkt_residual = solution.kkt_residual;
  work.report.times.solve += work.watch.lap();
  if (solution.status == QpStatus::Solved && stages.solve) active.remember(work.rows, solution);
  return solution.status;
}

// Cloth caught between features may be asked to leave each of them through another: no motion can, or only an absurd
// one. Rows that push nothing out are met by the motion of the obstacles, if it is one; then the cloth stays for now.
bool SheetStepper::Impl::solve_rows(Work& work) {
  QpStatus status = solve(work);
  const bool is_caught = status == QpStatus::Infeasible || (status == QpStatus::Solved && is_flung(work, settings));
  if (is_caught && std::exchange(work.pushes_out, false)) {
    const VecX b_eq = work.rows.b_eq, b_in = work.rows.b_in;
    constrain(work);
    work.report.caught = work.rows.b_eq != b_eq || work.rows.b_in != b_in;
    if (work.report.caught != 0) status = solve(work);
  }
  return status == QpStatus::Solved ||
         work.fail(StepStatus::QpFailed, "solve", std::string(to_string(status)) + ": " + work.solution.message);
}

// Where the solution moves the cloth farther than detection looked, it looks again, that far; what it finds joins the
// constraints. Contacts are only ever added, and each time costs a pass of the budget.
bool SheetStepper::Impl::constrain_and_solve(Work& work) {
  std::vector<Vec3> looked = work.cloth.v;  // as far as detection went
  std::set<ContactKey> detected = keys_of(work.contacts), inside;
  for (int pass = 0; pass < max_passes; ++pass) {
    const std::size_t n_rows = work.rows.in.size();
    constrain(work);
    if (pass > 0 && work.rows.in.size() == n_rows) return true;  // pins decide whatever was added
    if (!solve_rows(work)) return false;
    if (!stages.detect || !stages.constrain || !work.solution.q.allFinite()) return true;
    Cloth moved = work.cloth;
    bool farther = false;
    for (int v = 0; v < work.cloth.mesh.n_vertices(); ++v) {
      moved.v[v] = work.solution.q.segment<3>(work.dofs.x(v));
      if (!outran(work.cloth.mesh.x[v], moved.v[v], looked[v], work.posed, work.h, settings.threshold)) continue;
      looked[v] = moved.v[v];
      farther = true;
    }
    int n = stages.foresee ? add_foreseen(work.contacts, inside, stages.foresee(moved, work.posed, work.h)) : 0;
    if (farther) {
      moved.v = looked;
      n += add_new(work.contacts, detected, stages.detect(moved, work.posed, work.h));
    }
    work.report.contacts = static_cast<int>(work.contacts.size());
    work.report.times.detect += work.watch.lap();
    if (n == 0) return true;
  }
  return work.fail(StepStatus::ContactsUnsettled, "solve", "every solution runs into obstacles that are not in it yet");
}

// Solves, and again with those EOL vertices held that may not go on: each time more of them, so it ends.
bool SheetStepper::Impl::find_motion(Work& work, Cloth& next) {
  while (constrain_and_solve(work)) {
    next = moved(work);
    if (!all_finite(next)) return work.fail(StepStatus::NotFinite, "integrate", "a position or velocity is not finite");
    Runaways found = find_runaways(work.cloth, next);
    if (!found.too_far.empty() && !work.options.hold_runaways)
      return work.fail(StepStatus::EulerianStepTooLong, "integrate",
                       "an EOL vertex would cross more than 0.3 of a triangle");
    found.too_far.insert(found.too_far.end(), found.at_needles.begin(), found.at_needles.end());
    if (found.too_far.empty() || !hold(work, found.too_far)) return true;  // if all are held, what is left is rounding
  }
  return false;
}

void SheetStepper::Impl::integrate(Work& work, Cloth next, std::span<const Obstacle> obstacles) {
  work.report.released += track_features(
      next, obstacles, {work.time + work.h, work.h, settings.threshold, settings.linger, settings.material});
  read_multipliers(work);
  work.cloth = std::move(next);
  work.report.times.integrate = work.watch.lap();
}

StepResult SheetStepper::step(const Cloth& cloth, std::span<const Obstacle> obstacles, double time, double h,
                              const StepOptions& options) {
  require(h > 0, "SheetStepper::step: expected h > 0");
  require(cloth.mesh.is_compact(), "SheetStepper::step: expected a compact mesh");
  require(all_finite(cloth), "SheetStepper::step: expected finite positions and velocities");
  Work work{.time = time, .h = h, .options = options, .posed = pose_all(obstacles, time, h), .cloth = cloth};
  impl_->detect(work);
  impl_->remesh(work);
  Cloth next;
  if (!impl_->assemble(work) || !impl_->find_motion(work, next)) {
    impl_->forget();
    return {cloth, std::move(work.report)};
  }
  impl_->integrate(work, std::move(next), obstacles);
  return {std::move(work.cloth), std::move(work.report)};
}

}  // namespace crease
