// SPDX-License-Identifier: MIT
#pragma once

#include <functional>

#include "sweep.hpp"

namespace crease::support {

/// A way of features under the sheet: poses at a time in [0, 1].
struct SweepCase {
  std::string name;
  std::vector<ObstacleShape> shapes;
  std::function<Sweep::Poses(double)> poses;
};

inline Pose flat_pose(double x, double y, double degrees) {
  Pose pose;
  pose.position = Vec3(x, y, 0);
  pose.rotation = Eigen::AngleAxisd(degrees * std::numbers::pi / 180, Vec3::UnitZ()).toRotationMatrix();
  return pose;
}

/// A box of (4, 4, 1) whose top is z = 0, with a corner at (x, y) and edges from there along its own +x and +y.
inline Pose corner_pose(double x, double y, double degrees) {
  Pose pose = flat_pose(x, y, degrees);
  pose.position += pose.rotation * Vec3(2, 2, -0.5);
  return pose;
}

inline ObstacleShape straight_wire() {
  ObstacleShape wire;
  wire.kind = ObstacleShape::Kind::Wire;
  wire.edges.push_back(
      {.a = Vec3(-2, 0, -1e-5), .b = Vec3(2, 0, -1e-5), .normals = {Vec3::Zero(), Vec3::Zero()}, .free_cone = true});
  return wire;
}

/// Sixteen tips, the nearest two 25 mm apart.
inline ObstacleShape nail_board() {
  ObstacleShape nails;
  nails.kind = ObstacleShape::Kind::Point;
  for (int i = 0; i < 16; ++i)
    nails.corners.push_back(
        {Vec3(0.13 * (i % 4) + 0.035 * (i / 4), 0.11 * (i / 4) - 0.1 * (i % 3), 0), {Vec3::UnitZ()}});
  nails.corners[15].position = nails.corners[6].position + Vec3(0.025, 0, 0);
  return nails;
}

/// A leg of the way, 0 to 1 in each, and the angle that belongs to it: mesh lines, nearly so, diagonals, anything.
inline std::pair<double, double> leg(double time) {
  static constexpr double angles[] = {0, 1e-7, 13, 45, 89.99, 90, 61, -30};
  const double all = time * 8;
  const int k = std::min(7, static_cast<int>(all));
  return {all - k, angles[k]};
}

inline std::vector<SweepCase> sweep_cases() {
  std::vector<SweepCase> cases;
  const ObstacleShape box = make_box(Vec3(4, 4, 1));
  // The middle of an edge: the corner is 2 m away.
  const auto edge_pose = [](double time) {
    const auto [t, angle] = leg(time);
    const double a = angle * std::numbers::pi / 180, across = 1.5 * t - 0.75;
    const Vec2 n(std::cos(a), std::sin(a)), along(-n.y(), n.x());
    const Vec2 corner = Vec2(0.5, 0.5) + across * n - 2 * along;
    return corner_pose(corner.x(), corner.y(), angle);
  };
  cases.push_back({"edge", {box}, [=](double time) { return Sweep::Poses{edge_pose(time)}; }});
  cases.push_back({"corner", {box}, [=](double time) {
                     const auto [t, angle] = leg(time);
                     return Sweep::Poses{corner_pose(1.05 - 1.1 * t, 0.9 - 0.7 * t, angle)};
                   }});
  cases.push_back({"crossing", {box, box}, [=](double time) {
                     const Pose other = corner_pose(2.2, 0.35 + 0.2 * time, 97);
                     return Sweep::Poses{edge_pose(time), other};
                   }});
  cases.push_back({"wire", {straight_wire()}, [](double time) {
                     const auto [t, angle] = leg(time);
                     return Sweep::Poses{flat_pose(0.3 + 0.05 * angle / 90, 0.45, angle + 180 * t)};
                   }});
  cases.push_back({"nails", {nail_board()}, [](double time) {
                     const auto [t, angle] = leg(time);
                     return Sweep::Poses{flat_pose(-0.4 + 1.2 * t, 0.3 + 0.2 * t, angle)};
                   }});
  return cases;
}

/// Judges n positions of the way; between its legs the features jump.
inline void run(Sweep& sweep, const SweepCase& features, int n) {
  double previous = 1;
  for (int i = 0; i < n && sweep.tally.broken.empty(); ++i) {
    const double time = (i + 0.5) / n, along = leg(time).first;
    if (along < previous) sweep.lift();
    previous = along;
    sweep.go_to(features.poses(time));
  }
}

inline std::string describe(const Sweep::Tally& t) {
  std::string text = std::to_string(t.positions) + " positions in " + std::to_string(t.calls) +
                     " calls: " + std::to_string(t.complete) + " complete, " + std::to_string(t.by_rule) +
                     " open at the border, " + std::to_string(t.refused) + " refused, " + std::to_string(t.silent) +
                     " silent; " + std::to_string(t.jams) + " jams, thin " + std::to_string(t.thin) +
                     ", smallest angle " + std::to_string(t.smallest_angle * 180 / std::numbers::pi) + " degrees";
  for (const auto& [reason, n] : t.reasons) text += "; " + reason + " " + std::to_string(n);
  return text;
}

}  // namespace crease::support
