// SPDX-License-Identifier: MIT
#pragma once

#include <memory>
#include <span>
#include <vector>

#include "crease/collision/contact.hpp"
#include "crease/geometry/cloth.hpp"
#include "crease/geometry/obstacle.hpp"

namespace crease {

struct DetectOptions {
  double threshold = 1e-3;  ///< contacts nearer than this are always reported [m]
  double look_ahead = 0;    ///< and those that relative motion can bring nearer than it within this time [s]
};

/// Finds contacts; keeps its bounding-volume tree between calls (refitted while the topology stays, else rebuilt).
///
/// Broad phase: FCL's AABB tree over the cloth's faces against each obstacle's bounds, grown by threshold + look-ahead
/// motion. Narrow phase, typed by feature (FCL has no feature types):
///  - VertexFace: every cloth vertex in reach of the surface. The normal is that of the nearest face; for a vertex
///    beyond a face's rim, the direction from the nearest rim point (limited to the cone of the rim's normals); inside, the face of least depth.
///  - EdgeEdge: a cloth edge that crosses a sharp edge near it: closest points inside both segments, not parallel
///    (angle > 2 degrees), the common normal inside the cone of the feature's normals (tolerance 2 degrees).
///  - CornerFace: a corner whose projection falls into a cloth face, the face normal (turned outward) in the cone.
/// EOL vertices already on a feature produce no VertexFace contact with that feature's obstacle faces that meet in it;
/// edges or faces with an EOL vertex on the same feature produce no EdgeEdge / CornerFace contact with that feature.
/// Order of the result is deterministic: by obstacle, type, feature index, cloth index. No duplicates.
class Detector {
 public:
  Detector();
  ~Detector();
  Detector(Detector&&) noexcept;
  Detector& operator=(Detector&&) noexcept;
  std::vector<Contact> detect(const Cloth& cloth, std::span<const PosedObstacle> obstacles, const DetectOptions& options);

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

/// Deepest point of the cloth inside any obstacle with a surface [m], 0 if none: sampled at the vertices and on a
/// barycentric lattice of `level` subdivisions inside every face, since a fold that cuts a corner shows at no vertex.
double max_penetration(const Cloth& cloth, std::span<const PosedObstacle> obstacles, int level = 4);

}  // namespace crease
