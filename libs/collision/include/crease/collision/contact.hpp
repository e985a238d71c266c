// SPDX-License-Identifier: MIT
#pragma once

#include <array>
#include <vector>

#include "crease/base/types.hpp"
#include "crease/geometry/obstacle.hpp"

namespace crease {

enum class ContactType {
  VertexFace,  ///< a cloth vertex at an obstacle face (or near its rim)
  EdgeEdge,    ///< a cloth edge across an obstacle edge
  CornerFace   ///< a sharp obstacle corner at a cloth face
};

/// One place where the cloth touches an obstacle, or will within the look-ahead. Plain data, world coordinates.
struct Contact {
  ContactType type = ContactType::VertexFace;
  int obstacle = -1;
  FeatureId feature;   ///< the sharp edge or corner; kind None for VertexFace, and with the index of a blunt edge
  int n_vertices = 0;  ///< cloth vertices involved: 1, 2 or 3
  std::array<int, 3> vertices{-1, -1, -1};
  std::array<double, 3> weights{0, 0, 0};  ///< cloth point = sum weights * x[vertices], sum = 1
  int halfedge = -1;                       ///< EdgeEdge: canonical half-edge of the cloth edge, from = vertices[0]
  int face = -1;                           ///< CornerFace: the cloth face
  Vec3 point = Vec3::Zero();               ///< closest point on the obstacle [m]
  Vec3 normal = Vec3::Zero();              ///< unit, from the obstacle to the cloth's side; sign from the obstacle
  double distance = 0;                     ///< gap along normal, negative = penetration [m]
  Vec3 velocity = Vec3::Zero();            ///< of the obstacle at `point` [m/s]
};

}  // namespace crease
