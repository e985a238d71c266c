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
  double margin = 0;        ///< and by this much more, as forces may change that motion meanwhile [m]
};

/// Finds contacts; keeps its bounding-volume tree between calls (refitted while the topology stays, else rebuilt).
///
/// Broad phase: FCL's AABB tree over the cloth's faces against each obstacle's bounds and those of each of its sharp
/// features, grown by threshold + look-ahead motion. Narrow phase, typed by feature (FCL has no feature types):
///  - VertexFace: every cloth vertex in reach of the surface. The normal is that of the nearest face; for a vertex
///    beyond a face's rim, the direction from the nearest rim point (in the cone of the rim's normals); inside, the
///    face of least depth. A vertex on the rim itself (within 1e-9 m) takes the cloth's own normal there, turned
///    outwards and limited to the cone: any normal of the cone keeps it out, and this one pushes a flat sheet nowhere
///    but up.
///  - EdgeEdge: a cloth edge that crosses a sharp edge near it: closest points inside both segments, not parallel
///    (angle > 2 degrees), the common normal inside the cone of the feature's normals (tolerance 2 degrees). Of a wire,
///    the normal points to the side the cloth is on. Blunt edges of a mesh are met alike (the tolerance is at most
///    their bend), but for what is within the threshold of a vertex that rides on the obstacle.
///  - CornerFace: a corner whose projection falls into a cloth face, the face normal (turned outward) in the cone; of a
///    tip with one normal, in its half space.
/// Segments and faces are closed, so a feature that passes exactly through a cloth vertex is reported, with weights 0
/// and 1, by several of the edges or faces there.
/// Penetrations of edges and corners are reported at any depth, provided that the cloth's edge or face reaches as deep
/// below every face of the solid: else some face is the shorter way out. Behind points and wires, which have no inside,
/// the threshold + look-ahead bounds the depth; so it does in a mesh that is not convex, is round or has an acute edge.
/// A vertex outside a mesh that is not convex has one VertexFace contact with every place that is nearer than all
/// around it: two in a groove. An EOL vertex produces no VertexFace contact with the obstacle it rides on (a convex
/// shape cannot be entered from one of its features but through the faces that meet there, which its own rows guard; of
/// another shape only the parts beside the feature are left out); edges or faces with an EOL vertex on the same
/// feature, or edges with one on a corner at the feature's end, produce no EdgeEdge / CornerFace contact with that
/// feature. Order of the result is deterministic: by obstacle, type, feature index, cloth index. No duplicates. Throws
/// std::invalid_argument for numbers that are not finite.
class Detector {
 public:
  Detector();
  ~Detector();
  Detector(Detector&&) noexcept;
  Detector& operator=(Detector&&) noexcept;
  std::vector<Contact> detect(const Cloth& cloth, std::span<const PosedObstacle> obstacles,
                              const DetectOptions& options);

  /// What the cloth's velocities run into within `h`: contacts of the end of the motion that are then deeper inside
  /// than `depth` [m], told as contacts of its beginning (`distance` is the gap that the motion closes, along the
  /// normal that the obstacle has turned to at the end; positive unless the cloth was inside before); and sharp edges
  /// and corners that pass the cloth on the way, wherever the end finds them, with `distance` 0 and as `velocity` that
  /// which takes the cloth's point to the feature's place at the end. As constraints, all of them cut off this motion.
  /// Deterministic: first those of the end, then those on the way. Throws as detect().
  std::vector<Contact> foresee(const Cloth& cloth, std::span<const PosedObstacle> obstacles, double h, double depth);

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

/// Deepest point of the cloth inside any obstacle with a surface [m], 0 if none: sampled at the vertices and on a
/// barycentric lattice of `level` subdivisions inside every face, since a fold that cuts a corner shows at no vertex.
double max_penetration(const Cloth& cloth, std::span<const PosedObstacle> obstacles, int level = 4);

}  // namespace crease
