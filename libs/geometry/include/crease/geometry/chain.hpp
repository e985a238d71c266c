// SPDX-License-Identifier: MIT
#pragma once

#include <optional>
#include <span>
#include <vector>

#include "crease/base/types.hpp"
#include "crease/geometry/cloth.hpp"
#include "crease/geometry/obstacle.hpp"

namespace crease {

/// Tagged half-edges that leave `vertex` with the given tag (canonical half-edges of border edges included).
std::vector<int> chain_edges(const Cloth& cloth, int vertex, int tag);

/// Unit material tangent of the chain at an EOL edge vertex: mean of its fold edges' directions, each oriented along
/// the obstacle edge a -> b (world direction of the cloth edge . tangent > 0), so that two halves never cancel. With no
/// fold edge: the area-weighted mean of F^+ (pseudo-inverse) of the faces, applied to the obstacle's tangent.
/// @pre vertex is EOL on an edge
Vec2 chain_tangent(const Cloth& cloth, int vertex, std::span<const PosedObstacle> obstacles);

/// Largest angle [rad] by which the cloth is folded at an EOL vertex: between the normals of the two faces beside an
/// edge of its chain; 0 without one.
double fold_angle(const Cloth& cloth, int vertex);

/// What the vertex covers of sharp features: its corner, and the edges of the chains that it is in.
std::vector<LeftStretch> stretches_at(const Cloth& cloth, int vertex, std::span<const PosedObstacle> obstacles);

/// Whether a chain has left the corner, or the place `at` on the edge (WorldEdge::parameter), a short while ago.
bool was_left(const Cloth& cloth, const FeatureId& feature, double at);

/// Whether a chain has left more than `share` [m] of the edge between two places a short while ago.
bool was_left_between(const Cloth& cloth, const FeatureId& edge, double from, double to, double share);

/// Unit material vector orthogonal to the border at a border vertex (mean of its two border edges).
Vec2 border_normal(const Mesh& mesh, int vertex);

/// The equality rows on Xdot alone of one EOL vertex, unit vectors in material space: the border rule b on the border,
/// the tangent rule t at an interior vertex on an edge, none at corners.                       [WEIDNER18, Alg. 2]
std::vector<Vec2> eulerian_rows(const Cloth& cloth, int vertex, std::span<const PosedObstacle> obstacles);

}  // namespace crease
