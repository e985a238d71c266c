// SPDX-License-Identifier: MIT
#pragma once

#include <functional>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "crease/collision/detect.hpp"
#include "crease/constraints/rows.hpp"
#include "crease/dynamics/assemble.hpp"
#include "crease/geometry/cloth.hpp"
#include "crease/remesh/remesh.hpp"
#include "crease/solver/qp_solver.hpp"
#include "crease/stepper/scene.hpp"

namespace crease {

enum class StepStatus { Done, QpFailed, NotFinite, ContactsUnsettled, EulerianStepTooLong };
const char* to_string(StepStatus status);

/// Seconds of wall time a stage took.
struct StageTimes {
  double detect = 0, remesh = 0, transfer = 0, assemble = 0, constrain = 0, solve = 0, integrate = 0;
};

/// Mass, momentum and kinetic energy of a sheet beside a remeshing.
struct Carried {
  double mass = 0;                       ///< [kg]
  Vec3 momentum = Vec3::Zero();          ///< [kg m/s]
  Vec3 angular_momentum = Vec3::Zero();  ///< about the centre of mass [kg m^2/s]
  double kinetic_energy = 0;             ///< [J]
};

/// What one step of one sheet did; the numbers of a row of steps.csv.
struct StepReport {
  StepStatus status = StepStatus::Done;
  std::string stage, message;  ///< where and why it failed
  int contacts = 0, active_constraints = 0, qp_iterations = 0;
  int inserted = 0, released = 0, refusals = 0;
  int splits = 0, flips = 0, collapses = 0;
  Carried before_remesh, after_remesh;  ///< zeros where the stage is left out
  bool qp_fell_back = false;            ///< see QpResult
  int held = 0;  ///< EOL vertices that kept their material coordinates: at needles, and see StepOptions::hold_runaways
  int caught = 0;  ///< 1 if nothing could be pushed out, as the rows contradicted each other
  double kkt_residual = 0;
  Energies energies;                  ///< before the step
  Vec3 edge_reaction = Vec3::Zero();  ///< force of all EOL vertices' contacts on the cloth [N]
  Vec3 pin_reaction = Vec3::Zero();   ///< force of all pins on the cloth [N]
  StageTimes times;
};

/// The stages of Algorithm 1 as replaceable functions; an empty one is left out and costs nothing.
struct Stages {
  std::function<std::vector<Contact>(const Cloth&, std::span<const PosedObstacle>, double h)> detect;
  std::function<RemeshResult(const Cloth&, std::span<const Contact>, std::span<const PosedObstacle>, double h)> remesh;
  std::function<ConstraintRows(const Cloth&, const DofMap&, std::span<const Contact>, std::span<const PosedObstacle>,
                               std::span<const PinState>, const ConstraintOptions&)>
      constrain;
  /// What the velocities of the cloth lead into within h and `detect` did not foresee; empty: nobody looks.
  std::function<std::vector<Contact>(const Cloth&, std::span<const PosedObstacle>, double h)> foresee;
  std::function<QpResult(const QpProblem&, std::span<const char> guess)> solve;  ///< empty: H q = f, no QP
};

/// SheetSettings::linger of a run, in time steps of its scene: cloth that rattles over an edge is back by then.
inline constexpr double linger_steps = 2;

/// Everything of a sheet that lives from step to step.
struct SheetSettings {
  Material material;
  DynamicsOptions dynamics;
  double threshold = 1e-3;      ///< contact threshold [m]
  double push_out_speed = 0.1;  ///< see ConstraintOptions [m/s]
  /// How long a chain that is off its feature may come back to it, and none begins where one has ended; 0: both at once
  /// [s]. A run has `linger_steps` of its steps; whoever calls step() alone sets it likewise.
  double linger = 0;
  std::vector<PinSpec> pins;
  int threads = 1;  ///< of assembly, and of the linear solve where there is no solve stage
};

struct StepOptions {
  /// A last resort: an EOL vertex that would cross more of a triangle than one step may does not fail the step, but
  /// keeps its material coordinates in it, like those at needles in any step. It still stands on its feature; the cloth
  /// does not slide there for that long.
  bool hold_runaways = false;
};

struct StepResult {
  Cloth cloth;
  StepReport report;
};

/// Advances one sheet; see step().
class SheetStepper {
 public:
  /// Throws std::invalid_argument if the material is not valid, or if `stages` has rows to constrain and none to solve.
  SheetStepper(SheetSettings settings, Stages stages);
  ~SheetStepper();
  SheetStepper(SheetStepper&&) noexcept;

  /// One linearly implicit step from `time` to `time + h` (Algorithm 1):
  /// detect -> conform and adapt -> transfer -> assemble -> rows -> solve -> integrate. The given cloth is not changed,
  /// so a failed step leaves nothing behind.
  StepResult step(const Cloth& cloth, std::span<const Obstacle> obstacles, double time, double h,
                  const StepOptions& options = {});

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

/// The shipped stages for a scene's sheet: none that it does not need.
/// @param threads  of the factorisation in the solve stage
Stages make_stages(const Scene& scene, const ClothSpec& spec, int threads = 1);

/// Two remeshing passes as one, the second of which began with the cloth of the first: reports added up, the map and
/// the refusals in the numbering of the second's result.
RemeshResult chain_passes(RemeshResult first, RemeshResult second);

/// Mean velocity of a pin over [time, time + h]: exact integral of the smoothed script.
PinState pin_state(const PinSpec& pin, int index, double time, double h);

}  // namespace crease
