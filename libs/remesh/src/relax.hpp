// SPDX-License-Identifier: MIT
#pragma once

#include <span>
#include <vector>

#include "crease/geometry/mesh.hpp"

namespace crease {

struct Move {
  int vertex;
  Vec2 X;
};

/// Places where the edges of all these vertices have lengths in [short_below, 1] x longest, found by letting one after
/// another slide; no altitude over a side that stays sinks below a fifth of `longest`. Nothing where a budget of turns
/// does not find them.
/// @pre is_free_to_slide
std::vector<Move> relax(const Mesh& mesh, std::span<const int> vertices, double longest);

}  // namespace crease
