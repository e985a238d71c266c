// SPDX-License-Identifier: MIT
#pragma once

#include <optional>
#include <vector>

#include "crease/geometry/cloth.hpp"
#include "guard.hpp"
#include "metric.hpp"
#include "slide.hpp"

// A chain moves through the material, and the vertices ahead must not be run over: one that is taken out of the way at
// the distance d, where the facets meet at the angle a, moves the surface by d sin a, and beside a fold that is
// millimetres at any d that a step does not cross. So they slide ahead of the chain as it comes, each time by little,
// until they come so near to the next ones that nobody sees one of the two go.
namespace crease {

/// Free vertices beside those that ride on an obstacle edge, ascending.
std::vector<int> vertices_beside_chains(const Cloth& cloth);

/// The way out for a vertex that crowds a chain, as far as the limits and its faces let it; nothing where there is none
/// or no need.
/// @param size  its metric: the room is a share of the local size
std::optional<Slide> slide_from_chain(const Cloth& cloth, int vertex, const Tensor& size, const GuardLimits& limits);

}  // namespace crease
