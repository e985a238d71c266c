// SPDX-License-Identifier: MIT
#pragma once

#include <limits>
#include <span>
#include <string>
#include <vector>

#include "crease/dynamics/assemble.hpp"
#include "crease/stepper/scene.hpp"
#include "output_steps.hpp"

namespace crease {

/// Sums over the rows of steps.csv; a resumed run adds up the rows it keeps.
class Tally {
 public:
  void add(const StepRow& row);
  const StepRow& sums() const { return sums_; }  ///< wall times, retries and remeshing counts, summed
  const StepRow& last() const { return last_; }
  const StepRow& deepest() const { return deepest_; }                  ///< row of the worst penetration
  double most_energy() const { return most_energy_; }                  ///< of all rows, -infinity without one [J]
  double most_kinetic_energy() const { return most_kinetic_energy_; }  ///< of all rows [J]

 private:
  StepRow sums_, last_, deepest_;
  double most_energy_ = -std::numeric_limits<double>::infinity(), most_kinetic_energy_ = 0;
};

/// Energies and momenta of all sheets together.
Energies measure(const Scene& scene, std::span<const Cloth> cloths);

struct Summary {
  bool finished = false;
  std::string why, command_line;
  int frames = 0;
  std::vector<std::string> left_out, warnings;
  Energies start;
};
std::string summary_json(const Scene& scene, const Summary& summary, const Tally& tally);

}  // namespace crease
