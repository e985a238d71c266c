// SPDX-License-Identifier: MIT
#pragma once

#include <array>
#include <cstdint>

#include "crease/base/types.hpp"
#include "crease/geometry/mesh.hpp"

namespace crease {

enum class GridPattern { Cross, Alternating, Right, Irregular };

struct GridOptions {
  Vec2 size{1, 1};  ///< material size [m]
  std::array<int, 2> cells{10, 10};
  GridPattern pattern = GridPattern::Cross;
  std::uint64_t seed = 1;      ///< Irregular only; same seed, same mesh on every machine
  Vec3 origin = Vec3::Zero();  ///< world = origin + U u + V v
  Vec3 u{1, 0, 0}, v{0, 1, 0};
};

/// Rectangle [0,W] x [0,H] in material space. Cross: 4 triangles a cell about its centre; Alternating: diagonals change
/// direction from cell to cell; Right: one diagonal; Irregular: jittered points, Delaunay, about 2 triangles a cell,
/// the border straight and the corners kept.
Mesh make_grid(const GridOptions& options);

}  // namespace crease
