// SPDX-License-Identifier: MIT
#pragma once

#include <span>
#include <vector>

#include "crease/collision/contact.hpp"
#include "crease/geometry/cloth.hpp"
#include "placed.hpp"

namespace crease {

/// What passes a sharp edge or corner of the obstacle within h: an edge of the cloth through a sharp edge, a corner
/// through a face. In the obstacle's own frame, to and from which the straight ways of the cloth's vertices are taken
/// with the poses of beginning and end, features stand still; the cloth's edge or face is in one plane with the feature
/// at the roots of a polynomial of second or third degree, all of which are found.
///
/// Contacts of the beginning, with the weights and the normal (turned to the end) of the moment of passing, directed to
/// the side from which the cloth came. `distance` is 0 and `velocity` that which takes the cloth's point to the
/// feature's place at the end: so the row is the plane there, exactly, wherever the point starts. What stays behind
/// that plane by no more than `depth` [m] is left out.
/// By feature, edges first, then by cloth edge; a corner has the first face that it meets.
std::vector<Contact> passed_features(const Cloth& cloth, const PlacedObstacle& obstacle, double h, double depth);

}  // namespace crease
