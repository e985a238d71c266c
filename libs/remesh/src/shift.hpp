// SPDX-License-Identifier: MIT
#pragma once

#include "guard.hpp"

// How far an operation would move the surface in the world, exactly: two piecewise linear surfaces over one piece of
// material differ most at a vertex of their overlay, which is a vertex of one of them or a crossing of their edges.
namespace crease {

/// @param ring  what ring_after() says of the same vertex and target: it knows how far the vertex itself is left behind
double shift_after(const Cloth& cloth, int vertex, const Target& target, const Ring& ring);

/// @pre mesh.can_flip(h)
double flip_shift(const Mesh& mesh, int h);

}  // namespace crease
