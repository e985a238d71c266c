// SPDX-License-Identifier: MIT
#include <numbers>
#include <stdexcept>

#include <nlohmann/json.hpp>

#include "crease/geometry/obj_io.hpp"
#include "scene_io_parts.hpp"

namespace crease {
namespace {

std::optional<TriangleSurface> read_surface(const std::string& file, const std::string& pointer,
                                            ProblemList& problems) {
  TriangleSurface surface;
  try {
    surface = read_surface_obj(file);
  } catch (const std::runtime_error& error) {
    problems.add(pointer, error.what());
    return std::nullopt;
  }
  const std::vector<std::string> found = surface_problems(surface);
  for (const std::string& problem : found) problems.add(pointer, file + ": " + problem);
  return found.empty() ? std::optional(std::move(surface)) : std::nullopt;
}

}  // namespace

void read_obstacle_meshes(const Json& filled, Scene& scene, ProblemList& problems) {
  for (std::size_t i = 0; i < scene.obstacles.size(); ++i) {
    const Json& json = filled["obstacles"][i];
    const std::string pointer = "/obstacles/" + std::to_string(i) + "/mesh";
    if (!json.is_object() || !json.contains("mesh") || !json["mesh"].is_object() || problems.under(pointer)) continue;
    const auto surface = read_surface(json["mesh"]["file"], pointer + "/file", problems);
    const double degrees = json["mesh"]["sharp_angle"];
    if (surface) scene.obstacles[i].shape = make_mesh(*surface, degrees * std::numbers::pi / 180);
  }
}

}  // namespace crease
