// SPDX-License-Identifier: MIT
#include <algorithm>
#include <cmath>
#include <numbers>

#include <nlohmann/json.hpp>

#include "scene_io_parts.hpp"

namespace crease {
namespace {

bool given(const Json& object, const char* key) {
  return object.contains(key) && !object[key].is_null();
}

// Each reader leaves `out` as it is when the key is absent or was refused.
template <typename T>
void read(const Json& object, const char* key, T& out) {
  if (given(object, key)) out = object[key].get<T>();
}

template <int n>
void read(const Json& object, const char* key, Eigen::Matrix<double, n, 1>& out) {
  if (!given(object, key)) return;
  Eigen::Matrix<double, n, 1> value;
  for (int k = 0; k < n; ++k) {
    if (object[key][k].is_null()) return;
    value[k] = object[key][k].get<double>();
  }
  out = value;
}

template <typename Number>
void read(const Json& object, const char* key, std::array<Number, 2>& out) {
  if (!given(object, key) || object[key][0].is_null() || object[key][1].is_null()) return;
  out = {object[key][0].get<Number>(), object[key][1].get<Number>()};
}

template <typename Enum>
void read_enum(const Json& object, const char* key, Enum& out,
               std::initializer_list<std::pair<const char*, Enum>> names) {
  if (!given(object, key)) return;
  for (const auto& [name, value] : names)
    if (object[key] == name) out = value;
}

const Json& child(const Json& object, const char* key) {
  static const Json none = Json::object();
  return given(object, key) ? object[key] : none;
}

const Json& list(const Json& object, const char* key) {
  static const Json none = Json::array();
  return given(object, key) ? object[key] : none;
}

// A refused entry keeps its place, so that the indices of problems found later stay right.
std::vector<MotionKey> read_motion(const Json& object) {
  std::vector<MotionKey> motion;
  for (const Json& entry : list(object, "motion")) {
    MotionKey& key = motion.emplace_back();
    key.time = std::nan("");
    if (entry.is_null()) continue;
    read(entry, "time", key.time);
    read(entry, "velocity", key.velocity);
    read(entry, "angular_velocity", key.angular_velocity);
  }
  return motion;
}

GridOptions read_grid(const Json& grid, const Json& placement) {
  GridOptions options;
  read(grid, "size", options.size);
  read(grid, "cells", options.cells);
  read(grid, "seed", options.seed);
  read_enum(grid, "pattern", options.pattern,
            {{"cross", GridPattern::Cross},
             {"alternating", GridPattern::Alternating},
             {"right", GridPattern::Right},
             {"irregular", GridPattern::Irregular}});
  read(placement, "origin", options.origin);
  read(placement, "u", options.u);
  read(placement, "v", options.v);
  return options;
}

PinSpec read_pin(const Json& json) {
  PinSpec pin;
  const Json& where = child(json, "where");
  if (given(where, "edge")) {
    pin.where.kind = PinWhere::Kind::Edge;
    read(where, "edge", pin.where.name);
  } else if (given(where, "material")) {
    pin.where.kind = PinWhere::Kind::Material;
    read(where, "material", pin.where.material);
  } else if (given(where, "vertices")) {
    pin.where.kind = PinWhere::Kind::Vertices;
    for (const Json& vertex : where["vertices"])
      if (!vertex.is_null()) pin.where.vertices.push_back(vertex.get<int>());
  } else {
    read(where, "corner", pin.where.name);
  }
  std::string axes = "xyz";
  read(json, "axes", axes);
  for (int k = 0; k < 3; ++k) pin.axes[k] = axes.find("xyz"[k]) != std::string::npos;
  pin.motion = read_motion(json);
  read(json, "ramp", pin.ramp);
  if (given(json, "release")) pin.release = json["release"].get<double>();
  return pin;
}

ClothSpec read_cloth(const Json& json) {
  ClothSpec cloth;
  read(json, "name", cloth.name);
  const Json& shape = child(json, "shape");
  if (given(shape, "mesh"))
    cloth.shape = std::filesystem::path(shape["mesh"].get<std::string>());
  else
    cloth.shape = read_grid(child(shape, "grid"), child(json, "placement"));
  read(json, "velocity", cloth.velocity);

  const Json& material = child(json, "material");
  read(material, "density", cloth.material.density);
  read(material, "youngs", cloth.material.youngs);
  read(material, "poisson", cloth.material.poisson);
  read(material, "bending", cloth.material.bending);
  read(material, "damping", cloth.material.damping);

  const Json& remeshing = child(json, "remeshing");
  read_enum(
      remeshing, "method", cloth.remeshing,
      {{"none", RemeshMethod::None}, {"adaptive", RemeshMethod::Adaptive}, {"conformal", RemeshMethod::Conformal}});
  read(remeshing, "size", cloth.adapt.size);
  read(remeshing, "angle", cloth.adapt.angle);
  read(remeshing, "velocity", cloth.adapt.velocity);
  read(remeshing, "compression", cloth.adapt.compression);
  read(remeshing, "aspect", cloth.adapt.aspect);

  for (const Json& pin : list(json, "pins")) cloth.pins.push_back(pin.is_null() ? PinSpec{} : read_pin(pin));
  return cloth;
}

std::vector<Vec3> read_points(const Json& wire) {
  std::vector<Vec3> points;
  for (const Json& entry : list(wire, "points")) {
    Vec3& point = points.emplace_back(Vec3::Constant(std::nan("")));
    if (!entry.is_array()) continue;
    for (int k = 0; k < 3; ++k)
      if (entry[static_cast<size_t>(k)].is_number()) point[k] = entry[static_cast<size_t>(k)].get<double>();
  }
  return points;
}

bool makes_a_wire(const std::vector<Vec3>& points) {
  return points.size() >= 2 && std::adjacent_find(points.begin(), points.end(), [](const Vec3& a, const Vec3& b) {
                                 return !is_segment(a, b);
                               }) == points.end();
}

// What cannot be made is a unit box: check_scene() tells what is wrong with it. So is a mesh until its file is read:
// see read_obstacle_meshes().
ObstacleShape read_shape(const Json& json) {
  Vec3 size = Vec3::Ones(), normal = Vec3::UnitZ();
  if (given(json, "point")) {
    read(json["point"], "normal", normal);
    if (!normal.isZero(0)) return make_point(normal);
  }
  if (given(json, "wire")) {
    const std::vector<Vec3> points = read_points(json["wire"]);
    if (makes_a_wire(points)) return make_wire(points);
  }
  read(child(json, "box"), "size", size);
  return make_box(size);
}

Obstacle read_obstacle(const Json& json) {
  Obstacle obstacle;
  read(json, "name", obstacle.name);
  obstacle.shape = read_shape(json);
  read(json, "position", obstacle.start.position);
  Vec3 axis = Vec3::UnitZ();
  double degrees = 0;
  read(child(json, "rotation"), "axis", axis);
  read(child(json, "rotation"), "degrees", degrees);
  // By the largest component first: the squares of very large or small components leave the range of a double.
  if (const double largest = axis.cwiseAbs().maxCoeff(); largest > 0)
    obstacle.start.rotation =
        Eigen::AngleAxisd(degrees * std::numbers::pi / 180, (axis / largest).normalized()).toRotationMatrix();
  obstacle.motion = read_motion(json);
  return obstacle;
}

}  // namespace

bool is_segment(const Vec3& a, const Vec3& b) {
  const double length = (b - a).norm();
  return std::isfinite(length) && length > 0;
}

Scene read_scene(const Json& filled) {
  Scene scene;
  read(filled, "name", scene.name);
  read(filled, "description", scene.description);
  read(filled, "duration", scene.duration);
  read(filled, "time_step", scene.time_step);
  read(filled, "gravity", scene.gravity);
  for (const Json& cloth : list(filled, "cloths"))
    scene.cloths.push_back(cloth.is_null() ? ClothSpec{} : read_cloth(cloth));
  for (const Json& obstacle : list(filled, "obstacles"))
    scene.obstacles.push_back(read_obstacle(obstacle.is_null() ? Json::object() : obstacle));
  read_enum(child(filled, "contact"), "method", scene.contact,
            {{"eol", ContactMethod::Eol},
             {"lagrangian_averaged", ContactMethod::LagrangianAveraged},
             {"lagrangian_cone", ContactMethod::LagrangianCone}});
  read(child(filled, "contact"), "threshold", scene.threshold);
  read(child(filled, "dynamics"), "velocity_terms", scene.velocity_terms);
  read_enum(child(filled, "solver"), "qp", scene.qp, {{"active_set", QpMethod::ActiveSet}, {"ipopt", QpMethod::Ipopt}});
  read(child(filled, "solver"), "tolerance", scene.tolerance);
  read(child(filled, "output"), "fps", scene.fps);
  scene.formats.clear();
  for (const Json& format : list(child(filled, "output"), "formats"))
    if (!format.is_null()) scene.formats.push_back(format == "obj" ? FrameFormat::Obj : FrameFormat::Vtp);
  return scene;
}

}  // namespace crease
