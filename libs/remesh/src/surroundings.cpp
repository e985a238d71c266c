// SPDX-License-Identifier: MIT
#include "surroundings.hpp"

#include <algorithm>
#include <cmath>
#include <optional>

#include <Eigen/Geometry>

namespace crease {

namespace {

// What is inside a tetrahedron by less than this share of the threshold is on its surface: cloth that lies on an
// obstacle touches features without passing them.
constexpr double touch_share = 1e-3;
constexpr double largest_shift_share = 0.5;

struct Ball {
  Vec3 centre = Vec3::Zero();
  double radius = 0;
};

Ball ball_around(std::span<const std::array<Vec3, 4>> swept) {
  Ball ball;
  for (const auto& corners : swept)
    for (const Vec3& x : corners) ball.centre += x / (4 * static_cast<double>(swept.size()));
  for (const auto& corners : swept)
    for (const Vec3& x : corners) ball.radius = std::max(ball.radius, (x - ball.centre).norm());
  return ball;
}

double distance_to_segment(const Vec3& p, const Vec3& a, const Vec3& b) {
  const double length2 = (b - a).squaredNorm();
  const double t = length2 > 0 ? std::clamp((p - a).dot(b - a) / length2, 0.0, 1.0) : 0.0;
  return (a + t * (b - a) - p).norm();
}

// The normal of each face, towards the corner opposite to it, with the altitude of that corner.
struct Side {
  Vec3 on, inward;
  double altitude;
};
std::array<Side, 4> sides(const std::array<Vec3, 4>& corners) {
  std::array<Side, 4> result;
  for (std::size_t k = 0; k < 4; ++k) {
    const Vec3& on = corners[(k + 1) % 4];
    Vec3 inward = (corners[(k + 2) % 4] - on).cross(corners[(k + 3) % 4] - on).normalized();
    const double altitude = inward.dot(corners[k] - on);
    if (altitude < 0) inward = -inward;
    result[k] = {on, inward, std::abs(altitude)};
  }
  return result;
}

// No two points of the tetrahedron that face each other across it are farther apart.
double thickness(const std::array<Vec3, 4>& corners) {
  const auto s = sides(corners);
  return std::min({s[0].altitude, s[1].altitude, s[2].altitude, s[3].altitude});
}

// Whether a segment has points in a tetrahedron by more than `depth`, clipped against its four faces. In a fan the
// faces at the first two corners, where neighbours meet, are not the surface's: there nothing may slip through.
bool passes_through(const Vec3& a, const Vec3& b, const std::array<Vec3, 4>& corners, bool in_fan, double surface) {
  double from = 0, to = 1;
  const auto s = sides(corners);
  for (std::size_t k = 0; k < 4; ++k) {
    const Side& side = s[k];
    const double depth = in_fan && k >= 2 ? -surface : surface;
    const double at_a = side.inward.dot(a - side.on) - depth, at_b = side.inward.dot(b - side.on) - depth;
    if (!(at_a > 0 || at_b > 0)) return false;
    if (at_a < 0) from = std::max(from, at_a / (at_a - at_b));
    if (at_b < 0) to = std::min(to, at_a / (at_a - at_b));
  }
  return from <= to;
}

}  // namespace

Surroundings::Surroundings(std::span<const PosedObstacle> obstacles, double threshold)
    : obstacles_(obstacles), threshold_(threshold) {
  for (const PosedObstacle& o : obstacles) {
    for (const SharpEdge& e : o.shape->edges) features_.push_back({o.pose.to_world(e.a), o.pose.to_world(e.b)});
    for (const SharpCorner& c : o.shape->corners)
      features_.push_back({o.pose.to_world(c.position), o.pose.to_world(c.position)});
  }
}

bool Surroundings::any_near(std::span<const std::array<Vec3, 4>> swept) const {
  const Ball ball = ball_around(swept);
  const double reach = ball.radius + threshold_;
  const bool feature = std::any_of(features_.begin(), features_.end(), [&](const Segment& s) {
    return distance_to_segment(ball.centre, s.a, s.b) < reach;
  });
  return feature || std::any_of(obstacles_.begin(), obstacles_.end(), [&](const PosedObstacle& o) {
           const bool has_distance =
               o.shape->kind == ObstacleShape::Kind::Box;  // of the others only sharp features are known
           return has_distance && *signed_distance(*o.shape, o.pose, ball.centre) < reach;
         });
}

bool Surroundings::allow(std::span<const std::array<Vec3, 4>> swept) const {
  if (obstacles_.empty() || swept.empty()) return true;
  const bool moves = std::any_of(swept.begin(), swept.end(), [&](const auto& corners) {
    return thickness(corners) > largest_shift_share * threshold_;
  });
  if (moves && any_near(swept)) return false;
  return std::none_of(features_.begin(), features_.end(), [&](const Segment& s) {
    return std::any_of(swept.begin(), swept.end(), [&](const auto& corners) {
      return passes_through(s.a, s.b, corners, swept.size() > 1, touch_share * threshold_);
    });
  });
}

}  // namespace crease
