// SPDX-License-Identifier: MIT
#pragma once

#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "crease/stepper/run.hpp"
#include "output_steps.hpp"

namespace crease {

/// The sheets of a scene, advanced together: a step is taken by every one of them or by none.
class Sheets {
 public:
  using MakeStages = std::function<Stages(const Scene&, const ClothSpec&)>;
  /// @param scene  must outlive this
  /// @param make_stages  empty: the function of that name
  Sheets(const Scene& scene, MakeStages make_stages, int threads);

  /// Goes on from these cloths with steppers that remember nothing.
  void restart(std::vector<Cloth> cloths);

  /// Advances from `time` to `time + h`, in parts where the whole fails. Fills the row's columns about contacts,
  /// solving, remeshing, reactions and stage times, and its retries. Ends by construction: parts are h/2^k with k <=
  /// 10, and each failure halves the part at hand.
  /// @return what failed, or nothing; after a failure the cloths are those before the step
  std::optional<std::string> advance(double time, double h, StepRow& row);

  const std::vector<Cloth>& cloths() const { return cloths_; }

  /// Stages that no sheet has: of "detect", "remesh", "transfer", "constrain", "qp".
  const std::vector<std::string>& left_out() const { return left_out_; }

 private:
  struct Attempt;
  Attempt attempt(double time, double h, const StepOptions& options, StepRow& row);
  void make_steppers();

  const Scene& scene_;
  MakeStages make_stages_;
  int threads_;
  std::vector<SheetStepper> steppers_;
  std::vector<Cloth> cloths_;
  std::vector<std::string> left_out_;
};

}  // namespace crease
