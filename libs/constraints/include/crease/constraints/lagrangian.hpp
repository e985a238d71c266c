// SPDX-License-Identifier: MIT
#pragma once

#include <span>
#include <vector>

#include "crease/base/types.hpp"
#include "crease/collision/contact.hpp"
#include "crease/geometry/cloth.hpp"
#include "crease/geometry/obstacle.hpp"

namespace crease {

/// What a method without Eulerian unknowns asks where the cloth touches a sharp edge or corner.
enum class LagrangianNormals {
  Averaged,  ///< one row along the mean of the faces' normals, as if the obstacle were smooth  [WEIDNER18, Fig. 3e]
  Cone       ///< one row along every face's normal: what an EOL vertex is given               [WEIDNER18, Fig. 3d]
};

/// The contacts of a cloth of Lagrangian vertices, with the normals of the sharp features that they touch in place of
/// their own: the methods that EOL is compared with.
///
/// A vertex within `threshold` / 4 of a sharp edge or corner, as conformal remeshing leaves them, stands on it and
/// answers for the cloth there; contacts of edges and faces with an end on the feature are left out. All others at the
/// feature answer where they touch it. Gaps are measured anew along each normal. Contacts with faces stay as they are.
/// Wires and their joints have no normals: there a vertex that stands on one answers half-way between the outermost
/// normals of its contacts, all others along their own, and all keep a gap of `threshold` / 10, since on a wire only
/// the gap tells the side that the cloth is on.
/// @pre the contacts name features of the obstacles
std::vector<Contact> lagrangian_contacts(const Cloth& cloth, std::span<const Contact> contacts,
                                         std::span<const PosedObstacle> obstacles, LagrangianNormals normals,
                                         double threshold);

/// Marks the free vertices that stand on a sharp feature as riding on it, and the mesh edges between two of them on one
/// edge as its chain, so that conformal remeshing keeps the chain that it made before. make_lagrangian() undoes it.
void mark_standing(Cloth& cloth, std::span<const PosedObstacle> obstacles, double threshold);

}  // namespace crease
