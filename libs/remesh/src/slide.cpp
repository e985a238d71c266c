// SPDX-License-Identifier: MIT
#include "slide.hpp"

#include <numbers>

#include "crease/geometry/triangle.hpp"
#include "transfer.hpp"

namespace crease {

std::optional<Slide> place_in_star(const Cloth& cloth, int vertex, const Vec2& X) {
  const Mesh& mesh = cloth.mesh;
  // On a border the point may be outside by rounding.
  constexpr double outside = -1e-12;
  std::optional<Slide> place;
  mesh.all_outgoing(vertex, [&](int h) {
    const int f = Mesh::face_of(h);
    const Vec3 b = barycentric(material_corners(mesh, f), X);
    if (!(b.minCoeff() >= outside)) return true;
    const auto x = world_corners(mesh, f);
    const auto w = corner_velocities(cloth, f);
    place = Slide{X, b[0] * x[0] + b[1] * x[1] + b[2] * x[2], b[0] * w[0] + b[1] * w[1] + b[2] * w[2]};
    return false;
  });
  return place;
}

std::vector<Vec2> ways_to_slide(const Mesh& mesh, int vertex) {
  if (mesh.is_border_vertex(vertex)) {
    const std::vector<int> around = mesh.neighbours(vertex);
    const Vec2 along = (mesh.X[around.front()] - mesh.X[around.back()]).normalized();
    return {along, -along};
  }
  constexpr double diagonal = 1 / std::numbers::sqrt2;
  return {{1, 0},  {diagonal, diagonal},   {0, 1},  {-diagonal, diagonal},
          {-1, 0}, {-diagonal, -diagonal}, {0, -1}, {diagonal, -diagonal}};
}

}  // namespace crease
