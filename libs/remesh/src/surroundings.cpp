// SPDX-License-Identifier: MIT
#include "surroundings.hpp"

#include <algorithm>
#include <cmath>
#include <optional>

#include <Eigen/Geometry>

namespace crease {

namespace {

// A surface that moves by less than this share of the threshold has not moved.
constexpr double at_rest_share = 1e-3;
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

// Whether a segment has points inside a tetrahedron, clipped against its four faces. One with no volume has no inside.
bool passes_through(const Vec3& a, const Vec3& b, const std::array<Vec3, 4>& corners) {
  double from = 0, to = 1;
  for (std::size_t k = 0; k < 4; ++k) {
    const Vec3 &p = corners[(k + 1) % 4], &q = corners[(k + 2) % 4], &r = corners[(k + 3) % 4];
    Vec3 inward = (q - p).cross(r - p);
    const double height = inward.dot(corners[k] - p);
    if (height == 0) return false;
    if (height < 0) inward = -inward;
    const double at_a = inward.dot(a - p), at_b = inward.dot(b - p);
    if (at_a <= 0 && at_b <= 0) return false;
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

bool Surroundings::allow(std::span<const std::array<Vec3, 4>> swept, double shift) const {
  if (obstacles_.empty() || swept.empty() || shift <= at_rest_share * threshold_) return true;
  if (shift > largest_shift_share * threshold_ && any_near(swept)) return false;
  return std::none_of(features_.begin(), features_.end(), [&](const Segment& s) {
    return std::any_of(swept.begin(), swept.end(),
                       [&](const auto& corners) { return passes_through(s.a, s.b, corners); });
  });
}

}  // namespace crease
