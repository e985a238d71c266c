// SPDX-License-Identifier: MIT
#include "surroundings.hpp"

#include <algorithm>
#include <cmath>

#include <Eigen/Geometry>

namespace crease {

namespace {

// What is nearer to the surface than this share of the threshold is on it. Much more than rounding, so that a cloth
// that lies flat on an obstacle is judged alike wherever the scene stands.
constexpr double touch_share = 1e-3;

struct Ball {
  Vec3 centre = Vec3::Zero();
  double radius = 0;
};

Ball ball_around(std::span<const Swept> swept) {
  Ball ball;
  for (const Swept& piece : swept)
    for (const Vec3& x : piece.corners) ball.centre += x / (4 * static_cast<double>(swept.size()));
  for (const Swept& piece : swept)
    for (const Vec3& x : piece.corners) ball.radius = std::max(ball.radius, (x - ball.centre).norm());
  return ball;
}

double distance_to_segment(const Vec3& p, const Vec3& a, const Vec3& b) {
  const double length2 = (b - a).squaredNorm();
  const double t = length2 > 0 ? std::clamp((p - a).dot(b - a) / length2, 0.0, 1.0) : 0.0;
  return (a + t * (b - a) - p).norm();
}

// Whether a segment has points in a tetrahedron, clipped against its four faces. Beyond the new surface they must be by
// more than `touch`; of the old one and of the next piece they may be short by as much.
bool passes_through(const Vec3& a, const Vec3& b, const Swept& piece, double touch) {
  double from = 0, to = 1;
  for (std::size_t k = 0; k < 4; ++k) {
    const Vec3& on = piece.corners[(k + 1) % 4];
    Vec3 inward = (piece.corners[(k + 2) % 4] - on).cross(piece.corners[(k + 3) % 4] - on).normalized();
    if (inward.dot(piece.corners[k] - on) < 0) inward = -inward;
    const double depth = piece.made[k] ? touch : -touch;
    const double at_a = inward.dot(a - on) - depth, at_b = inward.dot(b - on) - depth;
    if (!(at_a > 0 || at_b > 0)) return false;
    if (at_a < 0) from = std::max(from, at_a / (at_a - at_b));
    if (at_b < 0) to = std::min(to, at_a / (at_a - at_b));
  }
  return from <= to;
}

}  // namespace

Surroundings::Surroundings(std::span<const PosedObstacle> obstacles, double threshold)
    : touch_(touch_share * threshold) {
  for (std::size_t k = 0; k < obstacles.size(); ++k) {
    const auto& [shape, pose] = obstacles[k];
    const int o = static_cast<int>(k);
    for (std::size_t i = 0; i < shape->edges.size(); ++i)
      features_.push_back({{o, FeatureKind::Edge, static_cast<int>(i)},
                           pose.to_world(shape->edges[i].a),
                           pose.to_world(shape->edges[i].b)});
    for (std::size_t i = 0; i < shape->corners.size(); ++i) {
      const Vec3 x = pose.to_world(shape->corners[i].position);
      features_.push_back({{o, FeatureKind::Corner, static_cast<int>(i)}, x, x});
    }
  }
}

bool Surroundings::allow(std::span<const Swept> swept, double shift, std::span<const FeatureId> held) const {
  if (features_.empty() || swept.empty() || shift <= touch_) return true;
  const Ball ball = ball_around(swept);
  return std::none_of(features_.begin(), features_.end(), [&](const Segment& s) {
    return distance_to_segment(ball.centre, s.a, s.b) < ball.radius + touch_ &&
           std::find(held.begin(), held.end(), s.id) == held.end() &&
           std::any_of(swept.begin(), swept.end(),
                       [&](const Swept& piece) { return passes_through(s.a, s.b, piece, touch_); });
  });
}

}  // namespace crease
