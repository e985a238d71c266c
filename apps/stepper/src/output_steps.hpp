// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "crease/base/types.hpp"

namespace crease {

/// One row of steps.csv. Counts are kept as doubles too, so that one table names, prints and reads every column.
///
/// Sheets are summed. Sizes, energies, momenta and penetration are those of the state at `time`, the end of the step;
/// contacts and constraints those of its last part; iterations, remeshing and wall times are summed over its parts,
/// wall times also over the attempts that failed.
struct StepRow {
  double step = 0, time = 0, time_step = 0, faces = 0, vertices = 0, eol_vertices = 0;
  double contacts = 0, active_constraints = 0, qp_iterations = 0, kkt_residual = 0, retries = 0;
  double kinetic_energy = 0, membrane_energy = 0, bending_energy = 0, gravitational_energy = 0;
  double momentum_x = 0, momentum_y = 0, momentum_z = 0, max_penetration = 0;
  double t_detect = 0, t_remesh = 0, t_transfer = 0, t_assemble = 0, t_constrain = 0, t_solve = 0, t_integrate = 0;
  double t_output = 0, t_total = 0;
  double inserted = 0, released = 0, splits = 0, flips = 0, collapses = 0, refusals = 0;
  double angular_momentum_x = 0, angular_momentum_y = 0, angular_momentum_z = 0;
  double edge_reaction_x = 0, edge_reaction_y = 0, edge_reaction_z = 0;  ///< mean over the step [N]
  double pin_reaction_x = 0, pin_reaction_y = 0, pin_reaction_z = 0;     ///< mean over the step [N]

  double qp_fallbacks = 0;  ///< solves that the reference had to answer
  double held = 0;          ///< EOL vertices, see StepOptions::hold_runaways
  double caught = 0;        ///< parts of the step, see StepReport
  /// What the sheets that are remeshed carry beside it. Where a step is taken in parts: before the first one's
  /// remeshing, and the same with what every part's remeshing changed. Angular momenta are about each sheet's centre.
  double mass_before_remesh = 0, momentum_x_before_remesh = 0, momentum_y_before_remesh = 0;
  double momentum_z_before_remesh = 0, angular_momentum_x_before_remesh = 0, angular_momentum_y_before_remesh = 0;
  double angular_momentum_z_before_remesh = 0, kinetic_energy_before_remesh = 0;
  double mass_after_remesh = 0, momentum_x_after_remesh = 0, momentum_y_after_remesh = 0;
  double momentum_z_after_remesh = 0, angular_momentum_x_after_remesh = 0, angular_momentum_y_after_remesh = 0;
  double angular_momentum_z_after_remesh = 0, kinetic_energy_after_remesh = 0;

  double energy() const { return kinetic_energy + membrane_energy + bending_energy + gravitational_energy; }
  Vec3 momentum() const { return {momentum_x, momentum_y, momentum_z}; }
};

std::string steps_header();              ///< with newline
std::string to_csv(const StepRow& row);  ///< with newline; shortest digits that read back the same number

/// The first `most` rows of a steps.csv, or as many as there are; what follows may be anything that a machine which
/// lost its power left. A last line without newline, as a killed run leaves it, is not counted. Throws
/// std::runtime_error naming the first line that is none of ours.
std::vector<StepRow> parse_steps(const std::string& text, std::size_t most);

}  // namespace crease
