// SPDX-License-Identifier: MIT
#pragma once

#include <optional>
#include <span>
#include <vector>

#include "crease/collision/contact.hpp"
#include "crease/collision/detect.hpp"
#include "crease/geometry/cloth.hpp"
#include "placed.hpp"

namespace crease {

/// A penetration of an edge or corner may be deeper than the cloth reaches below the feature's own faces by this
/// fraction of the threshold: a cloth vertex that lies just inside the rim must not hide that the cloth passes over the
/// edge.
constexpr double own_face_slack = 0.1;

/// Bound of |distance| for all penetrations of a piece of cloth that is nowhere deeper than the threshold below some
/// face, as a multiple of the threshold; see is_way_out().
constexpr double shallow_bound = 1.2;

/// One obstacle against one cloth: tests a single pair of features at a time.
///
/// A pair is in reach if its gap is at most threshold + look_ahead * |velocity of the cloth there relative to the
/// obstacle|. A penetration of an edge or corner counts at any depth, as long as the pair is where the cloth would
/// leave the solid: see is_way_out().
class NarrowPhase {
 public:
  NarrowPhase(const Cloth& cloth, const PlacedObstacle& obstacle, const DetectOptions& options)
      : cloth_(cloth), obstacle_(obstacle), options_(options) {}

  /// One at most on a convex solid; in a groove, one with each side.
  std::vector<Contact> vertex_face(int vertex) const;
  /// `edge` is the obstacle's; `id` names it: kind Edge if it is sharp, None if it is blunt.
  std::optional<Contact> edge_edge(int halfedge, const PlacedEdge& edge, const FeatureId& id) const;
  std::optional<Contact> corner_face(int corner, int face) const;

 private:
  Vec3 relative_velocity(int vertex) const;
  double reach(const Vec3& velocity) const;
  bool is_guarded_by_end(int halfedge, double s) const;
  bool on_feature(int vertex, FeatureKind kind, int index) const;
  int side_of_sheet(std::span<const int> vertices) const;
  Vec3 rim_normal(int vertex, std::span<const Vec3> normals, const Vec3& mean) const;
  /// A pair that may be a contact: `points` are the corners of the cloth's edge or face, `on_cloth` and `on_feature`
  /// its closest points, `own` the normals of the obstacle's faces that meet in the feature.
  struct Pair {
    double distance, reach;
    std::span<const Vec3> points;
    Vec3 on_cloth, on_feature;
    std::span<const Vec3> own;
  };
  bool is_way_out(const Pair& pair) const;
  Contact make_contact(ContactType type, const Vec3& point, const Vec3& normal, double distance) const;

  const Cloth& cloth_;
  const PlacedObstacle& obstacle_;
  const DetectOptions& options_;
};

}  // namespace crease
