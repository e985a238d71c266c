// SPDX-License-Identifier: MIT
#pragma once

#include <array>
#include <cmath>
#include <map>
#include <numbers>
#include <string>
#include <vector>

#include <Eigen/Dense>
#include <Eigen/Geometry>

#include "crease/geometry/obstacle.hpp"

/// Closed triangle meshes for tests: solids whose features are known, and an inside test that knows no nearest points.
namespace crease::support {

/// The surface of make_box(size): same vertices, same triangles.
inline TriangleSurface box_surface(const Vec3& size) {
  const ObstacleShape box = make_box(size);
  return {box.vertices, box.triangles};
}

/// Every triangle in four, new vertices in the middle of the edges.
inline TriangleSurface quartered(const TriangleSurface& surface) {
  TriangleSurface fine{surface.vertices, {}};
  std::map<std::array<int, 2>, int> middle;
  const auto between = [&](int a, int b) {
    const auto [it, is_new] = middle.try_emplace({std::min(a, b), std::max(a, b)}, fine.vertices.size());
    if (is_new) fine.vertices.push_back(0.5 * (surface.vertices[a] + surface.vertices[b]));
    return it->second;
  };
  for (const auto& [a, b, c] : surface.triangles) {
    const int ab = between(a, b), bc = between(b, c), ca = between(c, a);
    fine.triangles.insert(fine.triangles.end(), {{a, ab, ca}, {b, bc, ab}, {c, ca, bc}, {ab, bc, ca}});
  }
  return fine;
}

/// A polygon in the plane (y, z), counter-clockwise, star-shaped about its first corner, drawn out along x over
/// [-length / 2, length / 2].
inline TriangleSurface prism_surface(const std::vector<Vec2>& polygon, double length) {
  TriangleSurface prism;
  const int n = static_cast<int>(polygon.size());
  for (const double x : {-length / 2, length / 2})
    for (const Vec2& p : polygon) prism.vertices.emplace_back(x, p.x(), p.y());
  for (int k = 0; k < n; ++k) {
    const int next = (k + 1) % n;
    prism.triangles.push_back({n + k, k, next});
    prism.triangles.push_back({n + k, next, n + next});
    if (k == 0 || next == 0) continue;
    prism.triangles.push_back({0, next, k});
    prism.triangles.push_back({n, n + k, n + next});
  }
  return prism;
}

/// A ridge along x at the origin with this angle [rad] inside the solid, both sides equally steep and `height` long.
inline TriangleSurface ridge_surface(double angle, double length, double height = 1) {
  const double y = height * std::sin(angle / 2), z = -height * std::cos(angle / 2);
  return prism_surface({{0, 0}, {-y, z}, {y, z}}, length);
}

/// Two bars at right angles: one edge bends inwards.
inline TriangleSurface l_surface() {
  return prism_surface({{0, 0}, {0, 1}, {-1, 1}, {-1, -1}, {1, -1}, {1, 0}}, 1);
}

/// A ball by quartering an octahedron.
inline TriangleSurface ball_surface(double radius, int rounds) {
  TriangleSurface ball;
  for (int k = 0; k < 3; ++k)
    for (const double s : {1.0, -1.0}) ball.vertices.push_back(s * Vec3::Unit(k));
  for (const int x : {0, 1})
    for (const int y : {2, 3})
      for (const int z : {4, 5}) {
        const bool even = (x + y + z) % 2 == 0;
        ball.triangles.push_back(even ? std::array<int, 3>{x, y, z} : std::array<int, 3>{x, z, y});
      }
  for (int k = 0; k < rounds; ++k) ball = quartered(ball);
  for (Vec3& p : ball.vertices) p = radius * p.normalized();
  return ball;
}

/// Solid angle of the whole surface seen from p over 4 pi: 1 inside, 0 outside.                     [OOSTEROM83]
inline double winding_number(const TriangleSurface& surface, const Vec3& p) {
  double sum = 0;
  for (const auto& [i, j, k] : surface.triangles) {
    const Vec3 a = surface.vertices[i] - p, b = surface.vertices[j] - p, c = surface.vertices[k] - p;
    const double la = a.norm(), lb = b.norm(), lc = c.norm();
    sum += 2 * std::atan2(a.dot(b.cross(c)), la * lb * lc + a.dot(b) * lc + b.dot(c) * la + c.dot(a) * lb);
  }
  return sum / (4 * std::numbers::pi);
}

struct NamedSurface {
  std::string name;
  TriangleSurface surface;
};
inline std::vector<NamedSurface> all_surfaces() {
  return {{"box", box_surface({0.4, 1.0, 0.6})},
          {"quartered box", quartered(box_surface({0.4, 1.0, 0.6}))},
          {"blade", ridge_surface(20 * std::numbers::pi / 180, 1)},
          {"l", l_surface()},
          {"quartered l", quartered(l_surface())},
          {"ball", ball_surface(0.7, 2)}};
}

}  // namespace crease::support
