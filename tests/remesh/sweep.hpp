// SPDX-License-Identifier: MIT
#pragma once

#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include <Eigen/Geometry>

#include "crease/collision/detect.hpp"
#include "crease/geometry/feature_place.hpp"
#include "crease/geometry/grid.hpp"
#include "crease/geometry/triangle.hpp"
#include "crease/remesh/remesh.hpp"
#include "support/surface_change.hpp"

/// A sheet at rest, with sharp features that are moved along under it and everything that a step does but the solver:
/// contacts by the real detector, conform(), adapt(), and EOL vertices that follow their features through the material,
/// as far as a step may go. The sheet is the unit square at z = 0; where it is folded it rises from a crease, so that
/// chains end inside the cloth.
namespace crease::support {

class Sweep {
 public:
  struct Setup {
    GridPattern pattern = GridPattern::Irregular;
    int cells = 14;
    std::optional<double> crease;  ///< the sheet rises where X.x + 0.3 X.y is greater
  };
  struct Tally {
    int positions = 0, complete = 0, by_rule = 0, refused = 0, silent = 0, jams = 0, calls = 0, thin = 0;
    double smallest_angle = 10;  ///< [rad]
    std::map<std::string, int> reasons;
    std::string first_silent, first_jam, broken;
  };
  using Poses = std::vector<Pose>;

  Sweep(const Setup& setup, std::vector<ObstacleShape> shapes) : setup_(setup), shapes_(std::move(shapes)) {
    GridOptions grid;
    grid.cells = {setup.cells, setup.cells};
    grid.pattern = setup.pattern;
    cloth_ = make_cloth(make_grid(grid));
    for (int v = 0; v < cloth_.mesh.n_vertices(); ++v) cloth_.mesh.x[v] = world(cloth_.mesh.X[v]);
    conforming_.look_ahead = 7;  // velocities are displacements per step
    conforming_.clearance = 0.35 / setup.cells;
    sizes_.size = {0.5 / setup.cells, 1.3 / setup.cells};
    sizes_.velocity = 1e9;
  }

  /// Moves the features to the poses, in as many steps as the room asks for, and judges what is there then.
  void go_to(const Poses& next) {
    if (poses_.empty()) poses_ = next;
    const Poses start = poses_;
    double done = 0, part = 1;
    while (done < 1) {
      part = std::min(part, 1 - done);
      const Poses target = between(start, next, done + part);
      if (!advance(target)) {
        part /= 2;
        if (part > 1e-4) continue;
        ++tally.jams;
        if (tally.jams == 1) tally.first_jam = place(target);
        let_go();
        poses_ = next;
        break;
      }
      poses_ = target;
      done += part;
      part *= 2;
      if (!remesh()) return;
    }
    if (!remesh()) return;
    judge();
  }

  /// Takes the features away; the next go_to() puts them in place at once.
  void lift() {
    let_go();
    poses_.clear();
  }

  Tally tally;
  const Cloth& cloth() const { return cloth_; }

 private:
  Vec3 world(const Vec2& X) const {
    const Vec2 normal = Vec2(1, 0.3).normalized();
    const double beyond = setup_.crease ? std::max(0.0, normal.dot(X) - *setup_.crease) : 0.0;
    const Vec2 flat = X - beyond * (1 - std::cos(0.6)) * normal;
    return {flat.x(), flat.y(), beyond * std::sin(0.6)};
  }

  std::vector<PosedObstacle> obstacles(const Poses& poses) const {
    std::vector<PosedObstacle> posed;
    for (std::size_t i = 0; i < shapes_.size(); ++i) posed.push_back({&shapes_[i], poses[i]});
    return posed;
  }

  static Poses between(const Poses& a, const Poses& b, double t) {
    Poses poses = b;
    for (std::size_t i = 0; i < a.size(); ++i) {
      poses[i].position = (1 - t) * a[i].position + t * b[i].position;
      const Eigen::AngleAxisd turn(Mat3(a[i].rotation.transpose() * b[i].rotation));
      poses[i].rotation = a[i].rotation * Eigen::AngleAxisd(t * turn.angle(), turn.axis()).toRotationMatrix();
    }
    return poses;
  }

  // EOL vertices follow: a corner's goes with it, an edge's crosswise, on the border along the border. False where a
  // triangle would lose more than a step may take.
  bool advance(const Poses& target) {
    Cloth moved = cloth_;
    const testing::Surface surface(cloth_.mesh);
    std::vector<int> leaving;
    for (int v = 0; v < cloth_.mesh.n_vertices(); ++v) {
      if (!cloth_.is_eol(v)) continue;
      const FeatureId& f = cloth_.feature[v];
      const ObstacleShape& shape = shapes_[f.obstacle];
      const Pose& pose = target[f.obstacle];
      Vec2 X = cloth_.mesh.X[v];
      if (f.kind == FeatureKind::Corner) {
        X = pose.to_world(shape.corners[f.index].position).head<2>();
      } else {
        const SharpEdge& edge = shape.edges[f.index];
        const Vec2 a = pose.to_world(edge.a).head<2>(), b = pose.to_world(edge.b).head<2>();
        const Vec2 t = (b - a).normalized(), n(-t.y(), t.x());
        Vec2 way = n;
        if (cloth_.mesh.is_border_vertex(v)) {
          way = std::min(X.x(), 1 - X.x()) < 1e-9 ? Vec2(0, 1) : Vec2(1, 0);
          if (std::abs(way.dot(n)) < 0.2) leaving.push_back(v);
        }
        if (leaving.empty() || leaving.back() != v) X -= n.dot(X - a) / way.dot(n) * way;
        if (const double s = t.dot(X - a); s < 0 || s > (b - a).norm()) leaving.push_back(v);
      }
      if (X.minCoeff() < 0 || X.maxCoeff() > 1) {
        leaving.push_back(v);
        X = cloth_.mesh.X[v];
      }
      moved.mesh.X[v] = X;
      moved.V[v] = X - cloth_.mesh.X[v];
      moved.mesh.x[v] = surface.at(X);
      if (moved.mesh.x[v].z() > 0.5e-3) leaving.push_back(v);
    }
    for (int f = 0; f < cloth_.mesh.n_faces(); ++f)
      if (!(moved.mesh.material_area(f) >= 0.7 * cloth_.mesh.material_area(f))) return false;
    std::sort(leaving.begin(), leaving.end());
    leaving.erase(std::unique(leaving.begin(), leaving.end()), leaving.end());
    for (const int v : leaving) make_lagrangian(moved, v);
    cloth_ = std::move(moved);
    stop();
    return true;
  }

  // The material is at rest, whatever slides through it: what remeshing makes of velocities is tested elsewhere.
  void stop() {
    for (int v = 0; v < cloth_.mesh.n_vertices(); ++v) cloth_.v[v] -= cloth_.world_velocity(v);
  }

  void rest() {
    for (int v = 0; v < cloth_.mesh.n_vertices(); ++v) {
      cloth_.V[v].setZero();
      cloth_.v[v].setZero();
    }
  }

  void let_go() {
    for (int v = 0; v < cloth_.mesh.n_vertices(); ++v)
      if (cloth_.is_eol(v)) make_lagrangian(cloth_, v);
    stop();
  }

  bool remesh() {
    const std::vector<PosedObstacle> posed = obstacles(poses_);
    ++tally.calls;
    cloth_.left.clear();  // each place is looked at by itself, not a moment after another
    RemeshResult conformed = conform(cloth_, detector_.detect(cloth_, posed, {}), posed, conforming_);
    last_ = std::move(conformed.report);
    if (!is_sound(conformed.cloth, "conform")) return false;
    RemeshResult adapted = adapt(conformed.cloth, sizes_, posed);
    if (!is_sound(adapted.cloth, "adapt")) return false;
    cloth_ = std::move(adapted.cloth);
    tally.smallest_angle = std::min(tally.smallest_angle, adapted.report.smallest_angle);
    stop();
    return true;
  }

  bool is_sound(const Cloth& cloth, const std::string& who) {
    const auto trouble = validate(cloth);
    if (trouble && tally.broken.empty()) tally.broken = who + " at " + place(poses_) + ": " + *trouble;
    return !trouble;
  }

  std::string place(const Poses& poses) const {
    std::string text = "position " + std::to_string(tally.positions);
    for (const Pose& p : poses) {
      const double angle = std::atan2(p.rotation(1, 0), p.rotation(0, 0)) * 180 / std::numbers::pi;
      text += ", (" + std::to_string(p.position.x()) + " " + std::to_string(p.position.y()) + ") at " +
              std::to_string(angle) + " degrees";
    }
    return text;
  }

  // Where the feature still crosses edges or faces without a vertex, or lacks a link.
  std::vector<Vec2> open_places() {
    const std::vector<PosedObstacle> posed = obstacles(poses_);
    std::vector<Vec2> open;
    for (const Contact& contact : detector_.detect(cloth_, posed, {})) {
      if (contact.type == ContactType::VertexFace || std::abs(contact.distance) > 0.25e-3) continue;
      Vec2 X = Vec2::Zero();
      for (int k = 0; k < contact.n_vertices; ++k) X += contact.weights[k] * cloth_.mesh.X[contact.vertices[k]];
      if (!is_taken(contact.feature, X)) open.push_back(X);
    }
    add_gaps(posed, open);
    return open;
  }

  static bool is_of(const FeatureId& f, const FeatureId& feature, const std::vector<PosedObstacle>& posed) {
    return feature.kind == FeatureKind::Edge ? lies_on(f, feature, posed) : f == feature;
  }

  // Vertices of a chain nearer than 0.75 of merge become one, so such a vertex stands for the crossing.
  bool is_taken(const FeatureId& feature, const Vec2& X) const {
    const std::vector<PosedObstacle> posed = obstacles(poses_);
    for (int v = 0; v < cloth_.mesh.n_vertices(); ++v)
      if (cloth_.is_eol(v) && is_of(cloth_.feature[v], feature, posed) &&
          (cloth_.mesh.X[v] - X).norm() < 0.75 * conforming_.merge)
        return true;
    return false;
  }

  void judge() {
    ++tally.positions;
    std::vector<Vec2> open = open_places();
    // adapt() may lay new edges across the feature where a chain ends inside the cloth: the next pass sees them. And
    // where a vertex slides through a fold the facets beside it rise: what is refused for that is not at rest.
    if (!open.empty()) {
      rest();
      if (remesh()) open = open_places();
    }
    bool thin = false;
    for (const Refusal& refusal : last_.refusals) {
      ++tally.reasons[to_string(refusal.reason)];
      thin = thin || refusal.reason == RefusalReason::TooThin;
    }
    tally.thin += thin ? 1 : 0;
    if (open.empty()) {
      ++tally.complete;
    } else if (std::all_of(open.begin(), open.end(), [&](const Vec2& X) { return near_border(X); })) {
      ++tally.by_rule;
    } else if (std::all_of(open.begin(), open.end(), [&](const Vec2& X) { return near_border(X) || is_refused(X); })) {
      ++tally.refused;
    } else {
      ++tally.silent;
      if (tally.silent == 1) {
        tally.first_silent = place(poses_) + ", open at";
        for (const Vec2& X : open)
          tally.first_silent += " (" + std::to_string(X.x()) + " " + std::to_string(X.y()) + ")";
      }
    }
  }

  // Whether a reason other than the rules for borders stands near, from one end of a link to its middle.
  bool is_refused(const Vec2& X) const {
    return std::any_of(last_.refusals.begin(), last_.refusals.end(), [&](const Refusal& refusal) {
      return refusal.reason != RefusalReason::TooThin && refusal.reason != RefusalReason::NearBorder &&
             refusal.reason != RefusalReason::AtCorner && (refusal.X - X).norm() < 2.0 / setup_.cells;
    });
  }

  // The band along the border in which chains are neither begun nor kept.
  bool near_border(const Vec2& X) const { return std::min({X.x(), X.y(), 1 - X.x(), 1 - X.y()}) < conforming_.merge; }

  // Whether the sheet between two vertices is at the edge all the way: it may stand off it, which is no gap. A wire has
  // no side, so there the way counts in every direction. Chains are linked up to 0.45 of the threshold, judged where
  // the way crosses edges and at vertices a little beside it: next to that bound either answer is right.
  bool touches(const testing::Surface& surface, int p, int q, const Vec3& a, const Vec3& t, bool is_wire) const {
    constexpr int samples = 64;
    for (int k = 1; k < samples; ++k) {
      const double s = static_cast<double>(k) / samples;
      const Vec3 away = surface.at((1 - s) * cloth_.mesh.X[p] + s * cloth_.mesh.X[q]) - a;
      if ((is_wire ? (away - t.dot(away) * t).norm() : away.z()) > 0.4e-3) return false;
    }
    return true;
  }

  // Whether a vertex that a link from p to q would take in stands off the feature: what is beside the way by less than
  // a tenth of `merge` is met, and stands off by that too, on either side of the edge; from a wire in any direction.
  bool passes_what_stands_off(int p, int q, const PosedObstacle& obstacle, const SharpEdge& edge) const {
    const Vec2 P = cloth_.mesh.X[p], d = cloth_.mesh.X[q] - P;
    for (int v = 0; v < cloth_.mesh.n_vertices(); ++v) {
      const Vec2 e = cloth_.mesh.X[v] - P;
      const double along = e.dot(d) / d.squaredNorm();
      if (along <= 0 || along >= 1 || std::abs(e.x() * d.y() - e.y() * d.x()) > 0.1 * conforming_.merge * d.norm())
        continue;
      const Vec3 a = obstacle.pose.to_world(edge.a), t = (obstacle.pose.to_world(edge.b) - a).normalized();
      const Vec3 away = cloth_.mesh.x[v] - a;
      if (edge.free_cone && (away - t.dot(away) * t).norm() > 0.4e-3) return true;
      for (const Vec3& n : edge.normals)
        if ((obstacle.pose.rotation * n).dot(away) > 0.4e-3) return true;
    }
    return false;
  }

  void add_gaps(const std::vector<PosedObstacle>& posed, std::vector<Vec2>& open) const {
    const testing::Surface surface(cloth_.mesh);
    for (int o = 0; o < static_cast<int>(posed.size()); ++o) {
      const ObstacleShape& shape = *posed[o].shape;
      for (int e = 0; e < static_cast<int>(shape.edges.size()); ++e) {
        const Vec3 a = posed[o].pose.to_world(shape.edges[e].a);
        const Vec3 t = (posed[o].pose.to_world(shape.edges[e].b) - a).normalized();
        std::vector<std::pair<double, int>> order;
        for (int v = 0; v < cloth_.mesh.n_vertices(); ++v) {
          const FeatureId& f = cloth_.feature[v];
          if (lies_on(f, {o, FeatureKind::Edge, e}, posed)) order.emplace_back(t.dot(cloth_.mesh.x[v] - a), v);
        }
        std::sort(order.begin(), order.end());
        for (std::size_t i = 0; i + 1 < order.size(); ++i) {
          const int p = order[i].second, q = order[i + 1].second, h = cloth_.mesh.find_edge(p, q);
          if ((h == Mesh::none || cloth_.mesh.tag(h) != edge_tag(o, e)) &&
              touches(surface, p, q, a, t, shape.edges[e].free_cone) &&
              !passes_what_stands_off(p, q, posed[o], shape.edges[e]))
            open.push_back(0.5 * (cloth_.mesh.X[p] + cloth_.mesh.X[q]));
        }
      }
    }
  }

  Setup setup_;
  std::vector<ObstacleShape> shapes_;
  Cloth cloth_;
  Poses poses_;
  Detector detector_;
  ConformOptions conforming_;
  AdaptOptions sizes_;
  RemeshReport last_;
};

}  // namespace crease::support
