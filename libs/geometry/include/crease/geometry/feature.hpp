// SPDX-License-Identifier: MIT
#pragma once

#include <array>
#include <vector>

#include "crease/base/types.hpp"

namespace crease {

enum class FeatureKind { None, Edge, Corner };

/// Names one sharp feature of one obstacle.
struct FeatureId {
  int obstacle = -1;
  FeatureKind kind = FeatureKind::None;
  int index = -1;  ///< into ObstacleShape::edges or ::corners
  /// A wire has no inside, so it has to be remembered on which side of the sheet it is: +1 if the sheet's own normal
  /// (of its faces' orientation) points away from it, -1 if towards it, 0 if unknown or if the shape tells.
  int side = 0;
  /// True of a vertex that is off its feature and nothing leads: it touches obstacles like any other. Either its fold
  /// has lifted off an edge of a solid, and the vertex keeps its five unknowns, so that the fold goes on through the
  /// material as a wave does along a string (`away` is 0); or it lingers, on a feature of any kind (`away` > 0).
  bool lifted = false;
  /// How long the vertex has been off its feature, if it lingers [s]: there is no fold to follow, so its material
  /// coordinates stay (Xdot = 0) and it moves as a Lagrangian one, but its chain is still there should it come back.
  double away = 0;
  /// Of places: two sheets on the two sides of a wire are on the same feature, and so is a fold that has lifted off it.
  bool operator==(const FeatureId& other) const {
    return obstacle == other.obstacle && kind == other.kind && index == other.index;
  }
};

/// A sharp point: the corner of a box, the tip of a nail, the joint of a wire.
struct SharpCorner {
  Vec3 position;  ///< local coordinates [m]
  std::vector<Vec3>
      normals;  ///< unit outward normals of the faces that meet there (3 on a box, 1 on a nail, 0 on a wire)
  std::vector<int> patches = {};  ///< of a mesh: the parts of its surface that meet there, see ObstacleShape::patch
};

/// A sharp edge between two flat faces, or one segment of a wire.
struct SharpEdge {
  Vec3 a = Vec3::Zero(), b = Vec3::Zero();  ///< local end points [m]; the tangent runs from a to b
  /// Unit outward normals of its two faces; zero on a wire.
  std::array<Vec3, 2> normals{Vec3::Zero(), Vec3::Zero()};
  std::array<int, 2> corners{-1, -1};  ///< indices of the corners at a and b, -1 = none
  bool free_cone = false;              ///< true on a wire: any normal orthogonal to the tangent
  std::vector<int> patches = {};       ///< of a mesh: the parts of its surface beside it, see ObstacleShape::patch
};

}  // namespace crease
