// SPDX-License-Identifier: MIT
#include "run_advance.hpp"

#include <algorithm>
#include <exception>
#include <utility>

#include "digits.hpp"

namespace crease {
namespace {

constexpr int most_halvings = 10;
constexpr int finest = 1 << most_halvings;  ///< smallest parts in a step
/// In the smallest part no sliding is too fast: what runs away there is a vertex of crumpled or degenerate cloth, which
/// would do so in any part. So it is where parts of 1/128 of a step, in which 150 m/s cross 2 cm of cloth in three, are
/// too long again and again.
constexpr int hardly_slides = finest / 128, patience = 32;

void add_times(const StageTimes& times, StepRow& row) {
  row.t_detect += times.detect;
  row.t_remesh += times.remesh;
  row.t_transfer += times.transfer;
  row.t_assemble += times.assemble;
  row.t_constrain += times.constrain;
  row.t_solve += times.solve;
  row.t_integrate += times.integrate;
}

struct CarriedColumns {
  double StepRow::*before;
  double StepRow::*after;
  double (*of)(const Carried&);
};
constexpr CarriedColumns carried_columns[] = {
    {&StepRow::mass_before_remesh, &StepRow::mass_after_remesh, [](const Carried& c) { return c.mass; }},
    {&StepRow::momentum_x_before_remesh, &StepRow::momentum_x_after_remesh,
     [](const Carried& c) { return c.momentum.x(); }},
    {&StepRow::momentum_y_before_remesh, &StepRow::momentum_y_after_remesh,
     [](const Carried& c) { return c.momentum.y(); }},
    {&StepRow::momentum_z_before_remesh, &StepRow::momentum_z_after_remesh,
     [](const Carried& c) { return c.momentum.z(); }},
    {&StepRow::angular_momentum_x_before_remesh, &StepRow::angular_momentum_x_after_remesh,
     [](const Carried& c) { return c.angular_momentum.x(); }},
    {&StepRow::angular_momentum_y_before_remesh, &StepRow::angular_momentum_y_after_remesh,
     [](const Carried& c) { return c.angular_momentum.y(); }},
    {&StepRow::angular_momentum_z_before_remesh, &StepRow::angular_momentum_z_after_remesh,
     [](const Carried& c) { return c.angular_momentum.z(); }},
    {&StepRow::kinetic_energy_before_remesh, &StepRow::kinetic_energy_after_remesh,
     [](const Carried& c) { return c.kinetic_energy; }},
};

/// Adds what a remeshing found and left; of parts after the first, only what it changed.
void add_carried(const StepReport& report, bool first_part, StepRow& row) {
  for (const CarriedColumns& column : carried_columns) {
    const double before = column.of(report.before_remesh), after = column.of(report.after_remesh);
    row.*column.before += first_part ? before : 0.0;
    row.*column.after += first_part ? after : after - before;
  }
}

/// Adds what an accepted part did. @param share  of the whole step's time
void add_work(const StepReport& report, double share, StepRow& row) {
  row.contacts += report.contacts;
  row.active_constraints += report.active_constraints;
  row.qp_iterations += report.qp_iterations;
  row.qp_fallbacks += report.qp_fell_back;
  row.kkt_residual = std::max(row.kkt_residual, report.kkt_residual);
  row.inserted += report.inserted;
  row.released += report.released;
  row.splits += report.splits;
  row.flips += report.flips;
  row.collapses += report.collapses;
  row.refusals += report.refusals;
  row.held += report.held;
  row.caught += report.caught;
  row.edge_reaction_x += share * report.edge_reaction.x();
  row.edge_reaction_y += share * report.edge_reaction.y();
  row.edge_reaction_z += share * report.edge_reaction.z();
  row.pin_reaction_x += share * report.pin_reaction.x();
  row.pin_reaction_y += share * report.pin_reaction.y();
  row.pin_reaction_z += share * report.pin_reaction.z();
}

template <class Stage>
bool has_none(const std::vector<Stages>& sheets, Stage stage) {
  return std::none_of(sheets.begin(), sheets.end(), [stage](const Stages& s) { return static_cast<bool>(s.*stage); });
}

std::vector<std::string> stages_left_out(const std::vector<Stages>& sheets) {
  std::vector<std::string> left_out;
  if (has_none(sheets, &Stages::detect)) left_out.push_back("detect");
  if (has_none(sheets, &Stages::remesh)) left_out.insert(left_out.end(), {"remesh", "transfer"});
  if (has_none(sheets, &Stages::constrain)) left_out.push_back("constrain");
  if (has_none(sheets, &Stages::solve)) left_out.push_back("qp");
  return left_out;
}

}  // namespace

/// What came of one part for all sheets: their new states, or why one of them failed.
struct Sheets::Attempt {
  std::vector<StepResult> results;
  std::string failure;
  bool worth_a_retry = true, ran_away = false;
};

Sheets::Sheets(const Scene& scene, MakeStages make_stages, int threads)
    : scene_(scene), make_stages_(std::move(make_stages)), threads_(threads) {}

void Sheets::restart(std::vector<Cloth> cloths) {
  cloths_ = std::move(cloths);
  make_steppers();
}

void Sheets::make_steppers() {
  steppers_.clear();
  std::vector<Stages> stages;
  for (const ClothSpec& spec : scene_.cloths)
    stages.push_back(make_stages_ ? make_stages_(scene_, spec) : make_stages(scene_, spec, threads_));
  left_out_ = stages_left_out(stages);
  for (std::size_t c = 0; c < stages.size(); ++c) {
    const ClothSpec& spec = scene_.cloths[c];
    // Half a threshold a step of the scene, and no faster in the parts of a step that is retried.
    const double push_out_speed = 0.5 * scene_.threshold / scene_.time_step;
    SheetSettings settings{spec.material,  {scene_.gravity, scene_.velocity_terms}, scene_.threshold,
                           push_out_speed, linger_steps * scene_.time_step,         spec.pins,
                           threads_};
    steppers_.emplace_back(std::move(settings), std::move(stages[c]));
  }
}

Sheets::Attempt Sheets::attempt(double time, double h, const StepOptions& options, StepRow& row) {
  Attempt attempt;
  for (std::size_t c = 0; c < cloths_.size(); ++c) {
    const std::string who = cloths_.size() > 1 ? "cloth '" + scene_.cloths[c].name + "', " : "";
    try {
      attempt.results.push_back(steppers_[c].step(cloths_[c], scene_.obstacles, time, h, options));
    } catch (const std::exception& error) {  // no numerics end like this: a smaller step would only hide it
      attempt.failure = who + "unexpected: " + error.what();
      attempt.worth_a_retry = false;
      return attempt;
    }
    const StepReport& report = attempt.results.back().report;
    add_times(report.times, row);
    if (report.status == StepStatus::Done) continue;
    attempt.ran_away = report.status == StepStatus::EulerianStepTooLong;
    attempt.failure = who + "stage " + report.stage + ": " + to_string(report.status);
    if (!report.message.empty()) attempt.failure += " (" + report.message + ")";
    return attempt;
  }
  return attempt;
}

std::optional<std::string> Sheets::advance(double time, double h, StepRow& row) {
  const std::vector<Cloth> before = cloths_;
  int done = 0, part = finest;  // of the step, in 1/finest
  StepOptions options;
  while (done < finest) {
    const double share = static_cast<double>(part) / finest;
    Attempt tried = attempt(time + h * done / finest, h * share, options, row);
    if (!tried.failure.empty()) {
      // What the failed attempt taught the steppers belongs to states that never came to be.
      make_steppers();
      const bool is_hopeless = part == 1 || (part <= hardly_slides && row.retries >= patience);
      if (tried.ran_away && is_hopeless && !std::exchange(options.hold_runaways, true)) {
        while (part < finest && done % (2 * part) == 0) part *= 2;
        continue;
      }
      if (part == 1 || !tried.worth_a_retry) {
        cloths_ = before;
        return tried.failure + (part < finest ? "; tried down to a step of " + digits(h * share, 6) + " s" : "");
      }
      ++row.retries;
      part /= 2;
      continue;
    }
    row.contacts = row.active_constraints = 0;  // of the last part
    for (std::size_t c = 0; c < cloths_.size(); ++c) {
      cloths_[c] = std::move(tried.results[c].cloth);
      add_work(tried.results[c].report, share, row);
      add_carried(tried.results[c].report, done == 0, row);
    }
    done += part;
    while (part < finest && done % (2 * part) == 0) part *= 2;
  }
  return std::nullopt;
}

}  // namespace crease
