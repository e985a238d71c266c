// SPDX-License-Identifier: MIT
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <compare>
#include <map>
#include <span>

#include <Eigen/Geometry>

#include "crease/collision/detect.hpp"
#include "crease/geometry/distance.hpp"
#include "crease/geometry/triangle.hpp"

/// Contacts of cloths with boxes by brute force: every pair, no bounds, no tree, in the box's own frame with the
/// closest points of whole segments and triangles, where the detector works in the world with planes and common
/// normals.
namespace crease::support {

/// What tells one contact from another. The order is the one the detector promises.
struct ContactKey {
  int obstacle, type, feature, cloth;
  auto operator<=>(const ContactKey&) const = default;
};

inline ContactKey key_of(const Contact& c) {
  const int cloth = c.type == ContactType::VertexFace ? c.vertices[0]
                    : c.type == ContactType::EdgeEdge ? c.halfedge
                                                      : c.face;
  return {c.obstacle, static_cast<int>(c.type), c.feature.index, cloth};
}

class BoxOracle {
 public:
  BoxOracle(const Cloth& cloth, const PosedObstacle& box, int index, const DetectOptions& options)
      : cloth_(cloth), box_(box), index_(index), options_(options) {
    for (const Vec3& x : cloth.mesh.x) local_.push_back(box.pose.to_local(x));
  }

  /// Signed distances of all contacts.
  std::map<ContactKey, double> contacts() const {
    std::map<ContactKey, double> found;
    const Mesh& mesh = cloth_.mesh;
    for (int i = 0; i < mesh.vertex_slots(); ++i) vertex(i, found);
    for (const int h : mesh.edges()) {
      for (int e = 0; e < 12; ++e) edge(h, e, found);
    }
    for (int f = 0; f < mesh.face_slots(); ++f) {
      for (int c = 0; c < 8; ++c) corner(f, c, found);
    }
    return found;
  }

 private:
  static constexpr double degrees = M_PI / 180;

  Vec3 relative(int i) const { return cloth_.v[i] - box_.pose.velocity_at(cloth_.mesh.x[i]); }
  double reach(const Vec3& velocity) const { return options_.threshold + options_.look_ahead * velocity.norm(); }
  bool is_on(int i, FeatureKind kind, int index) const { return cloth_.feature[i] == FeatureId{index_, kind, index}; }

  void vertex(int i, std::map<ContactKey, double>& found) const {
    if (cloth_.feature[i].kind != FeatureKind::None && cloth_.feature[i].obstacle == index_) return;
    const double distance = *signed_distance(*box_.shape, box_.pose, cloth_.mesh.x[i]);
    if (distance <= reach(relative(i))) found[{index_, static_cast<int>(ContactType::VertexFace), -1, i}] = distance;
  }

  // +1 or -1 if `offset` (from the feature to the cloth) or its opposite lies within 2 degrees of the cone spanned by
  // three orthogonal normals (signs), else 0. `free` masks the axes that span the cone.
  static int side(const Vec3& offset, const Vec3& signs, const Vec3& free) {
    for (const int s : {1, -1}) {
      const Vec3 d = s * offset.cwiseProduct(signs);
      const Vec3 nearest = d.cwiseMax(0.0).cwiseProduct(free);
      if (nearest.norm() > 0 && std::acos(std::min(1.0, nearest.normalized().dot(d.normalized()))) < 2 * degrees)
        return s;
    }
    return 0;
  }

  // Penetrations: must not be deeper than the cloth's corner points lie below any face, with a little room for the
  // feature's own faces (those on the side of `signs`).
  bool way_out(double depth, std::span<const Vec3> points, const Vec3& signs) const {
    for (int axis = 0; axis < 3; ++axis) {
      for (const int s : {1, -1}) {
        double deepest = 0;
        for (const Vec3& p : points) deepest = std::max(deepest, box_.shape->half_size[axis] - s * p[axis]);
        const double slack = s * signs[axis] > 0 ? 0.1 * options_.threshold : 0.0;
        if (depth > 1.001 * deepest + slack + 1e-9) return false;
      }
    }
    return true;
  }

  void edge(int h, int e, std::map<ContactKey, double>& found) const {
    const SharpEdge& sharp = box_.shape->edges[e];
    const std::array<int, 2> ends{cloth_.mesh.from(h), cloth_.mesh.to(h)};
    for (const int i : ends) {
      if (is_on(i, FeatureKind::Edge, e)) return;
      if (is_on(i, FeatureKind::Corner, sharp.corners[0]) || is_on(i, FeatureKind::Corner, sharp.corners[1])) return;
    }
    const std::array<Vec3, 2> x{local_[ends[0]], local_[ends[1]]};
    const SegmentPair pair = closest_segments(x[0], x[1], sharp.a, sharp.b);
    const Vec3 direction = (x[1] - x[0]).normalized(), tangent = (sharp.b - sharp.a).normalized();
    if (direction.cross(tangent).norm() < std::sin(2 * degrees)) return;
    if (std::min({pair.s, pair.t, 1 - pair.s, 1 - pair.t}) <= 1e-12) return;
    const Vec3 offset = x[0] + pair.s * (x[1] - x[0]) - sharp.a - pair.t * (sharp.b - sharp.a);
    const Vec3 own = sharp.normals[0] + sharp.normals[1];
    const int s = side(offset, own + tangent, Vec3::Ones() - tangent);
    const double limit = reach((1 - pair.s) * relative(ends[0]) + pair.s * relative(ends[1]));
    if (s == 0 || (s > 0 && pair.distance > limit)) return;
    if (s < 0 && !way_out(pair.distance, x, own)) return;
    found[{index_, static_cast<int>(ContactType::EdgeEdge), e, h}] = s * pair.distance;
  }

  void corner(int f, int c, std::map<ContactKey, double>& found) const {
    const auto& face = cloth_.mesh.face(f);
    std::array<Vec3, 3> x;
    for (int k = 0; k < 3; ++k) {
      if (is_on(face[k], FeatureKind::Corner, c)) return;
      x[k] = local_[face[k]];
    }
    const SharpCorner& sharp = box_.shape->corners[c];
    const Vec3 w = closest_on_triangle(sharp.position, x);
    if (w.minCoeff() <= 1e-12) return;
    const Vec3 offset = w[0] * x[0] + w[1] * x[1] + w[2] * x[2] - sharp.position;
    const Vec3 own = sharp.normals[0] + sharp.normals[1] + sharp.normals[2];
    const int s = side(offset, own, Vec3::Ones());
    const double limit = reach(w[0] * relative(face[0]) + w[1] * relative(face[1]) + w[2] * relative(face[2]));
    if (s == 0 || (s > 0 && offset.norm() > limit)) return;
    if (s < 0 && !way_out(offset.norm(), x, own)) return;
    found[{index_, static_cast<int>(ContactType::CornerFace), c, f}] = s * offset.norm();
  }

  const Cloth& cloth_;
  const PosedObstacle& box_;
  int index_;
  const DetectOptions& options_;
  std::vector<Vec3> local_;
};

}  // namespace crease::support
