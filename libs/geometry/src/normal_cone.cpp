// SPDX-License-Identifier: MIT
#include "crease/geometry/normal_cone.hpp"

#include <algorithm>
#include <cmath>

#include <Eigen/Dense>

namespace crease {
namespace {

// A coefficient of a cone's generator counts as non-negative down to here: round-off of unit vectors.
constexpr double sign_slack = 1e-12;

// Generators closer to dependent than this span no new direction [sine of their angle].
constexpr double rank_tolerance = 1e-9;

// Orthogonal projection onto the span of two generators, zero if it leaves their cone.
Vec3 onto_pair(const Vec3& a, const Vec3& b, const Vec3& d) {
  const double ab = a.dot(b), det = 1 - ab * ab;
  if (det < rank_tolerance * rank_tolerance) return Vec3::Zero();
  const double alpha = (a.dot(d) - ab * b.dot(d)) / det, beta = (b.dot(d) - ab * a.dot(d)) / det;
  return alpha >= -sign_slack && beta >= -sign_slack ? Vec3(alpha * a + beta * b) : Vec3(Vec3::Zero());
}

bool inside_triple(const Vec3& a, const Vec3& b, const Vec3& c, const Vec3& d) {
  const double volume = a.dot(b.cross(c));
  if (std::abs(volume) < rank_tolerance) return false;
  const Vec3 weights = Vec3(d.dot(b.cross(c)), d.dot(c.cross(a)), d.dot(a.cross(b))) / volume;
  return weights.minCoeff() >= -sign_slack;
}

}  // namespace

Vec3 mean_normal(std::span<const Vec3> normals) {
  Vec3 sum = Vec3::Zero();
  for (const Vec3& n : normals) sum += n;
  const double length = sum.norm();
  return length > rank_tolerance ? Vec3(sum / length) : Vec3(Vec3::Zero());
}

// The projection onto a convex cone is the longest of the projections onto the cones of one, two or three generators
// (Caratheodory); a direction inside one of the triples is its own projection.
Vec3 nearest_in_cone(std::span<const Vec3> normals, const Vec3& direction) {
  Vec3 best = Vec3::Zero();
  double best_dot = -2;
  for (const Vec3& n : normals) {
    const double dot = n.dot(direction);
    if (dot > best_dot) {
      best = n;
      best_dot = dot;
    }
  }
  for (std::size_t i = 0; i < normals.size(); ++i) {
    for (std::size_t j = i + 1; j < normals.size(); ++j) {
      const Vec3 p = onto_pair(normals[i], normals[j], direction);
      if (p.norm() > std::max(best_dot, rank_tolerance)) {
        best_dot = p.norm();
        best = p / best_dot;
      }
      for (std::size_t k = j + 1; k < normals.size(); ++k) {
        if (inside_triple(normals[i], normals[j], normals[k], direction)) return direction;
      }
    }
  }
  return best;
}

bool in_cone(std::span<const Vec3> normals, const Vec3& direction, double tolerance) {
  if (normals.size() == 1) return normals[0].dot(direction) > std::sin(tolerance);
  const Vec3 nearest = nearest_in_cone(normals, direction);
  return std::atan2(nearest.cross(direction).norm(), nearest.dot(direction)) <= tolerance;
}

}  // namespace crease
