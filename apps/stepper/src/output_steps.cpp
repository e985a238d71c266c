// SPDX-License-Identifier: MIT
#include "output_steps.hpp"

#include <array>
#include <charconv>
#include <stdexcept>
#include <string_view>

namespace crease {
namespace {

struct Column {
  std::string_view name;
  double StepRow::*value;
  bool is_wall_time = false;
};

constexpr auto columns = std::to_array<Column>({
    {"step", &StepRow::step},
    {"time", &StepRow::time},
    {"time_step", &StepRow::time_step},
    {"faces", &StepRow::faces},
    {"vertices", &StepRow::vertices},
    {"eol_vertices", &StepRow::eol_vertices},
    {"contacts", &StepRow::contacts},
    {"active_constraints", &StepRow::active_constraints},
    {"qp_iterations", &StepRow::qp_iterations},
    {"kkt_residual", &StepRow::kkt_residual},
    {"retries", &StepRow::retries},
    {"kinetic_energy", &StepRow::kinetic_energy},
    {"membrane_energy", &StepRow::membrane_energy},
    {"bending_energy", &StepRow::bending_energy},
    {"gravitational_energy", &StepRow::gravitational_energy},
    {"momentum_x", &StepRow::momentum_x},
    {"momentum_y", &StepRow::momentum_y},
    {"momentum_z", &StepRow::momentum_z},
    {"max_penetration", &StepRow::max_penetration},
    {"t_detect", &StepRow::t_detect, true},
    {"t_remesh", &StepRow::t_remesh, true},
    {"t_transfer", &StepRow::t_transfer, true},
    {"t_assemble", &StepRow::t_assemble, true},
    {"t_constrain", &StepRow::t_constrain, true},
    {"t_solve", &StepRow::t_solve, true},
    {"t_integrate", &StepRow::t_integrate, true},
    {"t_output", &StepRow::t_output, true},
    {"t_total", &StepRow::t_total, true},
    {"inserted", &StepRow::inserted},
    {"released", &StepRow::released},
    {"splits", &StepRow::splits},
    {"flips", &StepRow::flips},
    {"collapses", &StepRow::collapses},
    {"refusals", &StepRow::refusals},
    {"angular_momentum_x", &StepRow::angular_momentum_x},
    {"angular_momentum_y", &StepRow::angular_momentum_y},
    {"angular_momentum_z", &StepRow::angular_momentum_z},
    {"edge_reaction_x", &StepRow::edge_reaction_x},
    {"edge_reaction_y", &StepRow::edge_reaction_y},
    {"edge_reaction_z", &StepRow::edge_reaction_z},
    {"pin_reaction_x", &StepRow::pin_reaction_x},
    {"pin_reaction_y", &StepRow::pin_reaction_y},
    {"pin_reaction_z", &StepRow::pin_reaction_z},
    {"qp_fallbacks", &StepRow::qp_fallbacks},
    {"mass_before_remesh", &StepRow::mass_before_remesh},
    {"momentum_x_before_remesh", &StepRow::momentum_x_before_remesh},
    {"momentum_y_before_remesh", &StepRow::momentum_y_before_remesh},
    {"momentum_z_before_remesh", &StepRow::momentum_z_before_remesh},
    {"angular_momentum_x_before_remesh", &StepRow::angular_momentum_x_before_remesh},
    {"angular_momentum_y_before_remesh", &StepRow::angular_momentum_y_before_remesh},
    {"angular_momentum_z_before_remesh", &StepRow::angular_momentum_z_before_remesh},
    {"kinetic_energy_before_remesh", &StepRow::kinetic_energy_before_remesh},
    {"mass_after_remesh", &StepRow::mass_after_remesh},
    {"momentum_x_after_remesh", &StepRow::momentum_x_after_remesh},
    {"momentum_y_after_remesh", &StepRow::momentum_y_after_remesh},
    {"momentum_z_after_remesh", &StepRow::momentum_z_after_remesh},
    {"angular_momentum_x_after_remesh", &StepRow::angular_momentum_x_after_remesh},
    {"angular_momentum_y_after_remesh", &StepRow::angular_momentum_y_after_remesh},
    {"angular_momentum_z_after_remesh", &StepRow::angular_momentum_z_after_remesh},
    {"kinetic_energy_after_remesh", &StepRow::kinetic_energy_after_remesh},
    {"held", &StepRow::held},
    {"caught", &StepRow::caught},
});

constexpr int wall_time_digits = 6;  // a microsecond

void append(std::string& text, double value, bool is_wall_time) {
  char digits[64];
  const auto end =
      is_wall_time ? std::to_chars(digits, digits + sizeof digits, value, std::chars_format::fixed, wall_time_digits)
                   : std::to_chars(digits, digits + sizeof digits, value);
  text.append(digits, end.ptr);
}

StepRow parse_row(std::string_view line, std::size_t number) {
  StepRow row;
  const char* at = line.data();
  const char* const end = at + line.size();
  for (std::size_t c = 0; c < columns.size(); ++c) {
    const auto parsed = std::from_chars(at, end, row.*columns[c].value);
    const bool last = c + 1 == columns.size();
    const bool stop_fits = last ? parsed.ptr == end : parsed.ptr != end && *parsed.ptr == ',';
    if (parsed.ec != std::errc() || !stop_fits)
      throw std::runtime_error("line " + std::to_string(number) + ": expected a number and then " +
                               (last ? "the end of the line" : "a comma") + " in column " +
                               std::string(columns[c].name));
    at = last ? parsed.ptr : parsed.ptr + 1;
  }
  return row;
}

}  // namespace

std::string steps_header() {
  std::string text;
  for (const Column& column : columns) {
    if (!text.empty()) text += ',';
    text += column.name;
  }
  return text + '\n';
}

std::string to_csv(const StepRow& row) {
  std::string text;
  for (const Column& column : columns) {
    if (!text.empty()) text += ',';
    append(text, row.*column.value, column.is_wall_time);
  }
  return text + '\n';
}

std::vector<StepRow> parse_steps(const std::string& text, std::size_t most) {
  const std::string header = steps_header();
  if (text.compare(0, header.size(), header) != 0)
    throw std::runtime_error("line 1: expected the header of this version");
  std::vector<StepRow> rows;
  for (std::size_t at = header.size(); at < text.size() && rows.size() < most;) {
    const std::size_t end = text.find('\n', at);
    if (end == std::string::npos) break;
    rows.push_back(parse_row(std::string_view(text).substr(at, end - at), rows.size() + 2));
    at = end + 1;
  }
  return rows;
}

}  // namespace crease
