// SPDX-License-Identifier: MIT
#include "output_summary.hpp"

#include <nlohmann/json.hpp>

namespace crease {
namespace {

using Json = nlohmann::ordered_json;

Json to_json(const Vec3& p) {
  return Json::array({p.x(), p.y(), p.z()});
}

std::string dotted(int a, int b, int c) {
  return std::to_string(a) + "." + std::to_string(b) + "." + std::to_string(c);
}

/// Seconds of each stage and its share of the whole.
Json stages_json(const StepRow& sums) {
  const double known = sums.t_detect + sums.t_remesh + sums.t_transfer + sums.t_assemble + sums.t_constrain +
                       sums.t_solve + sums.t_integrate + sums.t_output;
  const auto entry = [&](double seconds) {
    return Json{{"wall_s", seconds}, {"share", sums.t_total > 0 ? seconds / sums.t_total : 0.0}};
  };
  return {{"detect", entry(sums.t_detect)},
          {"remesh", entry(sums.t_remesh)},
          {"transfer", entry(sums.t_transfer)},
          {"assemble", entry(sums.t_assemble)},
          {"constrain", entry(sums.t_constrain)},
          {"solve", entry(sums.t_solve)},
          {"integrate", entry(sums.t_integrate)},
          {"output", entry(sums.t_output)},
          {"other", entry(std::max(0.0, sums.t_total - known))}};
}

Json versions_json() {
  return {
      {"eigen", dotted(EIGEN_WORLD_VERSION, EIGEN_MAJOR_VERSION, EIGEN_MINOR_VERSION)},
      {"nlohmann_json", dotted(NLOHMANN_JSON_VERSION_MAJOR, NLOHMANN_JSON_VERSION_MINOR, NLOHMANN_JSON_VERSION_PATCH)},
      {"suitesparse", CREASE_SUITESPARSE_VERSION},
      {"ipopt", CREASE_IPOPT_VERSION},
      {"fcl", CREASE_FCL_VERSION}};
}

}  // namespace

void Tally::add(const StepRow& row) {
  sums_.retries += row.retries;
  sums_.qp_fallbacks += row.qp_fallbacks;
  sums_.inserted += row.inserted;
  sums_.released += row.released;
  sums_.splits += row.splits;
  sums_.flips += row.flips;
  sums_.collapses += row.collapses;
  sums_.refusals += row.refusals;
  sums_.held += row.held;
  sums_.caught += row.caught;
  sums_.t_detect += row.t_detect;
  sums_.t_remesh += row.t_remesh;
  sums_.t_transfer += row.t_transfer;
  sums_.t_assemble += row.t_assemble;
  sums_.t_constrain += row.t_constrain;
  sums_.t_solve += row.t_solve;
  sums_.t_integrate += row.t_integrate;
  sums_.t_output += row.t_output;
  sums_.t_total += row.t_total;
  if (row.max_penetration > deepest_.max_penetration) deepest_ = row;
  most_energy_ = std::max(most_energy_, row.energy());
  most_kinetic_energy_ = std::max(most_kinetic_energy_, row.kinetic_energy);
  last_ = row;
}

Energies measure(const Scene& scene, std::span<const Cloth> cloths) {
  Energies all;
  for (std::size_t c = 0; c < cloths.size(); ++c)
    all += measure_energies(cloths[c], scene.cloths[c].material, scene.gravity);
  return all;
}

std::string summary_json(const Scene& scene, const Summary& summary, const Tally& tally) {
  const StepRow& last = tally.last();
  const StepRow& sums = tally.sums();
  const bool stepped = last.step > 0;
  const double energy = stepped ? last.energy() : summary.start.total();
  const Vec3 momentum = stepped ? last.momentum() : summary.start.momentum;
  Json json = {{"format", 1}, {"scene", scene.name}, {"finished", summary.finished}, {"why", summary.why}};
  json["steps"] = static_cast<int>(last.step);
  json["time"] = last.time;
  json["duration"] = scene.duration;
  json["frames"] = summary.frames;
  json["wall_s"] = sums.t_total;
  json["ms_per_step"] = stepped ? 1e3 * sums.t_total / last.step : 0.0;
  json["retries"] = static_cast<int>(sums.retries);
  json["qp_fallbacks"] = static_cast<int>(sums.qp_fallbacks);
  json["refusals"] = static_cast<int>(sums.refusals);
  json["held"] = static_cast<int>(sums.held);
  json["caught"] = static_cast<int>(sums.caught);
  json["stages"] = stages_json(sums);
  json["left_out"] = summary.left_out;
  json["warnings"] = summary.warnings;
  json["worst_penetration"] = {{"value", tally.deepest().max_penetration}, {"time", tally.deepest().time}};
  json["energy"] = {{"start", summary.start.total()}, {"end", energy}, {"drift", energy - summary.start.total()}};
  json["momentum"] = {{"start", to_json(summary.start.momentum)},
                      {"end", to_json(momentum)},
                      {"drift", (momentum - summary.start.momentum).norm()}};
  json["command_line"] = summary.command_line;
  json["build"] = {{"version", CREASE_VERSION}, {"type", CREASE_BUILD_TYPE}, {"compiler", __VERSION__}};
  json["libraries"] = versions_json();
  return json.dump(2, ' ', false, Json::error_handler_t::replace) + "\n";
}

}  // namespace crease
