// SPDX-License-Identifier: MIT
#include "output_obstacles.hpp"

#include <nlohmann/json.hpp>

namespace crease {
namespace {

using Json = nlohmann::ordered_json;

Json to_json(const Vec3& p) {
  return Json::array({p.x(), p.y(), p.z()});
}

const char* kind_name(ObstacleShape::Kind kind) {
  switch (kind) {
    case ObstacleShape::Kind::Box:
      return "box";
    case ObstacleShape::Kind::Point:
      return "point";
    case ObstacleShape::Kind::Wire:
      return "wire";
    case ObstacleShape::Kind::Mesh:
      return "mesh";
  }
  return "";
}

Json shape_json(const ObstacleShape& shape) {
  Json json;
  json["kind"] = kind_name(shape.kind);
  json["vertices"] = Json::array();
  for (const Vec3& vertex : shape.vertices) json["vertices"].push_back(to_json(vertex));
  json["triangles"] = shape.triangles;
  json["sharp_edges"] = Json::array();
  for (const SharpEdge& edge : shape.edges) json["sharp_edges"].push_back({to_json(edge.a), to_json(edge.b)});
  json["sharp_corners"] = Json::array();
  for (const SharpCorner& corner : shape.corners) json["sharp_corners"].push_back(to_json(corner.position));
  return json;
}

Json pose_json(const Pose& pose, double time) {
  Json rows = Json::array();
  for (int i = 0; i < 3; ++i) rows.push_back(to_json(pose.rotation.row(i).transpose()));
  return {{"time", time}, {"position", to_json(pose.position)}, {"rotation", rows}};
}

}  // namespace

std::string obstacles_json(std::span<const Obstacle> obstacles, std::span<const double> frame_times) {
  Json all = Json::array();
  for (const Obstacle& obstacle : obstacles) {
    Json json = {{"name", obstacle.name}};
    json.update(shape_json(obstacle.shape));
    json["poses"] = Json::array();
    for (const double time : frame_times) json["poses"].push_back(pose_json(pose_at(obstacle, time), time));
    all.push_back(std::move(json));
  }
  return Json{{"format", 1}, {"obstacles", std::move(all)}}.dump(-1, ' ', false, Json::error_handler_t::replace) + "\n";
}

}  // namespace crease
