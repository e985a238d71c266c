// SPDX-License-Identifier: MIT
#include <algorithm>
#include <cmath>

#include <nlohmann/json.hpp>

#include "scene_io_parts.hpp"

namespace crease {
namespace {

constexpr double most_steps = 1e8;   // beyond, a run takes months and a step number no longer fits every counter
constexpr double most_frames = 1e6;  // frames are numbered with six digits
constexpr double most_cells = 1e6;   // a million cells are four million triangles: far more than a step can solve
constexpr double thin_angle = 1e-6;  // u and v nearer to parallel than this make a line of the sheet [rad]

std::string item(const char* list, size_t i) {
  return std::string("/") + list + "/" + std::to_string(i);
}

void check_motion(const std::vector<MotionKey>& motion, const std::string& pointer, ProblemList& problems) {
  for (size_t i = 1; i < motion.size(); ++i)
    if (motion[i].time <= motion[i - 1].time)  // false when either was refused (NaN)
      problems.add(pointer + "/motion/" + std::to_string(i) + "/time",
                   "must be later than the entry before it: times ascend");
}

void check_names(const Json& filled, const char* list, ProblemList& problems) {
  std::vector<std::string> taken;
  for (size_t i = 0; i < filled[list].size(); ++i) {
    const Json& entry = filled[list][i];
    if (!entry.is_object() || !entry["name"].is_string()) continue;
    const std::string name = entry["name"];
    if (std::find(taken.begin(), taken.end(), name) != taken.end())
      problems.add(item(list, i) + "/name", "\"" + name + "\" is taken by an entry before it; give each its own name");
    taken.push_back(name);
  }
}

void check_placement(const ClothSpec& cloth, const Json& json, const std::string& pointer, ProblemList& problems) {
  if (!std::holds_alternative<GridOptions>(cloth.shape)) {
    if (json.contains("placement") && !problems.at(pointer + "/shape"))  // which says what is wrong already
      problems.add(pointer + "/placement", "only a grid is placed; a mesh file holds its own world positions");
    return;
  }
  const auto& grid = std::get<GridOptions>(cloth.shape);
  if (double(grid.cells[0]) * grid.cells[1] > most_cells)
    problems.add(pointer + "/shape/grid/cells", "must be at most a million cells together");
  const auto direction = [&](const Vec3& axis, const char* key) {
    const double largest = axis.cwiseAbs().maxCoeff();
    if (largest > 0) return Vec3((axis / largest).normalized());
    problems.add(pointer + "/placement/" + key, "must not be zero: it is where the material axis points");
    return Vec3(Vec3::Zero());
  };
  const Vec3 u = direction(grid.u, "u"), v = direction(grid.v, "v");
  if (u.squaredNorm() > 0 && v.squaredNorm() > 0 && u.cross(v).norm() < thin_angle)
    problems.add(pointer + "/placement", "u and v must not be parallel: they span the sheet");
}

void check_remeshing(const Scene& scene, const ClothSpec& cloth, const std::string& pointer, ProblemList& problems) {
  const std::string size = pointer + "/remeshing/size", method = pointer + "/remeshing/method";
  if (!problems.under(size)) {
    const auto [shortest, longest] = cloth.adapt.size;
    if (cloth.remeshing != RemeshMethod::None && shortest == 0)
      problems.add(size,
                   "is missing; adaptive and conformal remeshing need the shortest and the longest edge, such as "
                   "[0.02, 0.2] m");
    if (shortest > longest) problems.add(size, "the shortest edge must not be longer than the longest");
    if (const auto* grid = std::get_if<GridOptions>(&cloth.shape);
        grid != nullptr && cloth.remeshing != RemeshMethod::None && longest > 0 &&
        grid->size[0] / longest * (grid->size[1] / longest) > most_cells)
      problems.add(size, "asks for more than a million cells: the longest edge must be longer");
  }
  if (!scene.obstacles.empty() && scene.contact == ContactMethod::Eol && cloth.remeshing != RemeshMethod::Conformal &&
      !problems.under(pointer + "/remeshing") && !problems.under("/contact"))
    problems.add(method,
                 "must be \"conformal\": contact.method \"eol\" puts mesh edges on the sharp features of obstacles");
}

// Within its reach everything touches at once, also what is behind an obstacle: a step with a mesh of 68 triangles then
// takes half a minute, and what comes of it means nothing.
void check_threshold(const Scene& scene, const ClothSpec& cloth, const std::string& pointer, ProblemList& problems) {
  const auto* grid = std::get_if<GridOptions>(&cloth.shape);
  if (grid == nullptr || scene.obstacles.empty() || problems.under("/contact") || problems.under(pointer + "/shape"))
    return;
  const double length = std::max(grid->size[0], grid->size[1]);
  if (scene.threshold >= length)
    problems.add("/contact/threshold", "must be less than the length of the cloth, " + Json(length).dump() +
                                           " m, and is best a thousandth of it: it is where a contact begins");
}

void check_cloth(const Scene& scene, const Json& json, size_t i, ProblemList& problems) {
  const ClothSpec& cloth = scene.cloths[i];
  const std::string pointer = item("cloths", i);
  check_placement(cloth, json, pointer, problems);
  check_remeshing(scene, cloth, pointer, problems);
  check_threshold(scene, cloth, pointer, problems);
  for (size_t k = 0; k < cloth.pins.size(); ++k)
    check_motion(cloth.pins[k].motion, pointer + "/pins/" + std::to_string(k), problems);
}

// Refused already, or absent: not to be judged here.
bool can_judge(const Json& json, const char* key, const std::string& pointer, const ProblemList& problems) {
  return json.contains(key) && json[key].is_object() && !problems.under(pointer + "/" + key);
}

bool is_zero(const Json& vector) {
  return std::all_of(vector.begin(), vector.end(), [](const Json& number) { return number == 0; });
}

Vec3 as_point(const Json& json) {
  return {json[0].get<double>(), json[1].get<double>(), json[2].get<double>()};
}

void check_obstacle(const Json& json, const Obstacle& obstacle, const std::string& pointer, ProblemList& problems) {
  check_motion(obstacle.motion, pointer, problems);
  if (can_judge(json, "rotation", pointer, problems) && is_zero(json["rotation"]["axis"]))
    problems.add(pointer + "/rotation/axis", "must not be zero: it is what the obstacle is turned about");
  if (can_judge(json, "point", pointer, problems) && is_zero(json["point"]["normal"]))
    problems.add(pointer + "/point/normal", "must not be zero: it is the side that the cloth is on");
  if (!can_judge(json, "wire", pointer, problems)) return;
  const Json& points = json["wire"]["points"];
  for (size_t i = 1; i < points.size(); ++i)
    if (!is_segment(as_point(points[i - 1]), as_point(points[i])))
      problems.add(pointer + "/wire/points/" + std::to_string(i),
                   "must be unlike the point before it, and near enough "
                   "for their distance to be a number");
}

}  // namespace

void check_scene(const Scene& scene, const Json& filled, ProblemList& problems) {
  if (scene.duration / scene.time_step > most_steps)
    problems.add("/time_step", "duration / time_step must be at most 1e8 steps; take longer steps");
  if (scene.duration * scene.fps >= most_frames)
    problems.add("/output/fps", "duration * fps must be less than 1e6 frames; write fewer a second");
  check_names(filled, "cloths", problems);
  check_names(filled, "obstacles", problems);
  for (size_t i = 0; i < scene.cloths.size(); ++i)
    if (!filled["cloths"][i].is_null()) check_cloth(scene, filled["cloths"][i], i, problems);
  for (size_t i = 0; i < scene.obstacles.size(); ++i)
    if (!filled["obstacles"][i].is_null())
      check_obstacle(filled["obstacles"][i], scene.obstacles[i], item("obstacles", i), problems);
}

}  // namespace crease
