// SPDX-License-Identifier: MIT
#pragma once

#include "guard.hpp"

// What an operation would do to the energy of the membrane. Its measure: the uniform strain that the patch, were it
// unstrained, would have to take on to hold as much energy as the patch gains,
//   e = sqrt((sum' A |S - I|^2 - sum A |S - I|^2) / sum A),  F = R S,  ' after the operation,
// and 0 where it gains none; infinite where a face would turn over or lose its area. For nu = 0 it gains E e^2 / 2
// times its area [J]; by that one material stands for all.
namespace crease {

/// Of a vertex that goes to its target.
double strain_gained(const Mesh& mesh, int vertex, const Target& target);

/// Of a split of edge h whose vertex goes to the target, into the face at h.
/// @pre h is no border
double strain_gained_by_split(const Mesh& mesh, int h, const Target& target);

/// @pre mesh.can_flip(h)
double strain_gained_by_flip(const Mesh& mesh, int h);

}  // namespace crease
