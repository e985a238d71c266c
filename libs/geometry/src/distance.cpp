// SPDX-License-Identifier: MIT
#include "crease/geometry/distance.hpp"

#include <algorithm>

#include <Eigen/Geometry>

namespace crease {
namespace {

// Two directions are parallel below this angle [rad]: their cross product then holds only round-off.
constexpr double parallel_angle = 1e-9;

double project(const Vec3& p, const Vec3& a, const Vec3& direction) {
  const double length2 = direction.squaredNorm();
  return length2 > 0 ? std::clamp(direction.dot(p - a) / length2, 0.0, 1.0) : 0.0;
}

}  // namespace

// The minimum over the rectangle [0, 1]^2 lies inside it or on one of its sides. All five candidates are evaluated and
// the best is kept: branch-free clamping loses digits when the segments are nearly parallel, a comparison does not.
SegmentPair closest_segments(const Vec3& a0, const Vec3& a1, const Vec3& b0, const Vec3& b1) {
  const Vec3 da = a1 - a0, db = b1 - b0;
  const Vec3 normal = da.cross(db);
  const double limit = parallel_angle * da.norm() * db.norm();
  SegmentPair best{0, 0, (a0 - b0).norm(), !(normal.norm() > limit)};
  const auto offer = [&](double s, double t) {
    const double distance = ((a0 - b0) + s * da - t * db).norm();
    if (distance < best.distance) best = {s, t, distance, best.parallel};
  };
  offer(0, project(a0, b0, db));
  offer(1, project(a1, b0, db));
  offer(project(b0, a0, da), 0);
  offer(project(b1, a0, da), 1);
  if (!best.parallel) {
    const Vec3 ab = b0 - a0;
    const double s = ab.cross(db).dot(normal) / normal.squaredNorm();
    const double t = ab.cross(da).dot(normal) / normal.squaredNorm();
    if (s > 0 && s < 1 && t > 0 && t < 1) offer(s, t);
  }
  return best;
}

// Inside the prism over the triangle the foot of the perpendicular, else the closest point on the three sides. The foot
// is compared with the sides all the same: on a sliver its weights may be nothing but round-off.
Vec3 closest_on_triangle(const Vec3& p, const std::array<Vec3, 3>& triangle) {
  const Vec3 &a = triangle[0], &b = triangle[1], &c = triangle[2];
  Vec3 best = Vec3::UnitX();
  double best_distance = (a - p).squaredNorm();
  const auto offer = [&](const Vec3& weights) {
    const double distance = (weights[0] * a + weights[1] * b + weights[2] * c - p).squaredNorm();
    if (!(distance < best_distance)) return;
    best_distance = distance;
    best = weights;
  };
  for (int k = 0; k < 3; ++k) {
    const Vec3& from = triangle[static_cast<std::size_t>(k)];
    const double t = project(p, from, triangle[static_cast<std::size_t>((k + 1) % 3)] - from);
    Vec3 weights = Vec3::Zero();
    weights[k] = 1 - t;
    weights[(k + 1) % 3] = t;
    offer(weights);
  }
  const Vec3 normal = (b - a).cross(c - a);
  const Vec3 foot(normal.dot((b - p).cross(c - p)), normal.dot((c - p).cross(a - p)), normal.dot((a - p).cross(b - p)));
  if ((foot.array() >= 0).all() && foot.sum() > 0) offer(foot / foot.sum());
  return best;
}

}  // namespace crease
