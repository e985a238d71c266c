// SPDX-License-Identifier: MIT
#pragma once

#include <string>
#include <vector>

#include "crease/stepper/scene_io.hpp"

namespace crease {

/// Distance in the material under which conformal vertices and their neighbours are merged [m]: features nearer to each
/// other than this cannot each have a vertex of their own.                                         [WEIDNER18,
/// Sec. 6.1]
double merge_distance(const Cloth& cloth, const AdaptOptions& options);

/// What the scene asks of a mesh that it cannot do, in words; nothing if all is well. Looks at time 0 at corners, tips
/// and wires that are nearer to each other than merge_distance(), but for those in one place, which share a vertex.
std::vector<std::string> unresolved_features(const LoadedScene& loaded);

}  // namespace crease
