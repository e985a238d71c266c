// SPDX-License-Identifier: MIT
#pragma once

#include <optional>
#include <vector>

#include "crease/geometry/cloth.hpp"

namespace crease {

/// Where a vertex slides to along the surface, with what the surface has there.
struct Slide {
  Vec2 X;
  Vec3 x, v;
  double shift = 0;  ///< by how much this moves the surface, once that is known [m]
};

/// The point of the vertex's faces at X: where it is and how its material moves; nothing outside of them.
std::optional<Slide> place_in_star(const Cloth& cloth, int vertex, const Vec2& X);

/// Unit vectors: along the border, or to eight sides.
std::vector<Vec2> ways_to_slide(const Mesh& mesh, int vertex);

}  // namespace crease
