// SPDX-License-Identifier: MIT
#pragma once

// A scene turned as a whole and its obstacles shaken, and a watch that no tip and no wire comes through the cloth.

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <limits>
#include <memory>
#include <optional>
#include <random>
#include <span>
#include <stdexcept>
#include <utility>
#include <vector>

#include <Eigen/Geometry>

#include "crease/geometry/distance.hpp"
#include "crease/stepper/run.hpp"
#include "crease/stepper/scene_io.hpp"

namespace crease::testing {

/// Turns cloths, pins, obstacles, their motions and gravity about the origin: the same scene, seen from elsewhere.
/// @pre  pins hold all axes or none, as an axis of the world has no name in a turned one
inline void turn_scene(LoadedScene& loaded, const Mat3& R) {
  Scene& scene = loaded.scene;
  scene.gravity = R * scene.gravity;
  for (Cloth& cloth : loaded.cloths) {
    for (Vec3& x : cloth.mesh.x) x = R * x;
    for (Vec3& v : cloth.v) v = R * v;
  }
  const auto turn = [&R](std::vector<MotionKey>& motion) {
    for (MotionKey& key : motion) key.velocity = R * key.velocity, key.angular_velocity = R * key.angular_velocity;
  };
  for (ClothSpec& spec : scene.cloths)
    for (PinSpec& pin : spec.pins) {
      if (pin.axes != std::array{true, true, true}) throw std::logic_error("turn_scene: a pin that holds some axes");
      turn(pin.motion);
    }
  for (Obstacle& obstacle : scene.obstacles) {
    obstacle.start.position = R * obstacle.start.position;
    obstacle.start.rotation = R * obstacle.start.rotation;
    turn(obstacle.motion);
  }
}

/// Moves every obstacle by its own random vector of up to `by` along each axis [m], and turns the whole at random.
inline void shake_scene(LoadedScene& loaded, double by, std::uint64_t seed) {
  std::mt19937_64 random{seed};
  std::uniform_real_distribution<double> shift(-by, by);
  std::normal_distribution<double> normal;
  for (Obstacle& obstacle : loaded.scene.obstacles)
    for (double& p : obstacle.start.position) p += shift(random);
  Eigen::Quaterniond turn;
  for (double& q : turn.coeffs()) q = normal(random);
  turn_scene(loaded, turn.normalized().toRotationMatrix());
}

/// The motion of a face, even from s = 0 to 1 in the frame of a point at the origin, may take it over that point: the
/// cosine between n and the face's normal as it passes, the one that points away from where the point was before.
/// Looked for at sixteen moments: a face that comes back between two of them has not passed.
inline std::optional<double> passing_cosine(const std::array<Vec3, 3>& start, const std::array<Vec3, 3>& end,
                                            const Vec3& n) {
  constexpr int moments = 16;
  const auto at = [&](double s) {
    std::array<Vec3, 3> x;
    for (std::size_t k = 0; k < 3; ++k) x[k] = start[k] + s * (end[k] - start[k]);
    return x;
  };
  const auto side = [&](double s) {
    const auto [a, b, c] = at(s);
    return a.dot(b.cross(c));
  };
  for (int i = 0; i < moments; ++i) {
    double low = i / double(moments), high = (i + 1) / double(moments);
    const double before = side(low);
    if (before * side(high) >= 0) continue;
    for (int halving = 0; halving < 40; ++halving) {
      const double middle = 0.5 * (low + high);
      (before * side(middle) > 0 ? low : high) = middle;
    }
    const auto [a, b, c] = at(high);
    const Vec3 m = (b - a).cross(c - a);
    const std::array<double, 3> weights{m.dot(b.cross(c)), m.dot(c.cross(a)), m.dot(a.cross(b))};
    const bool inside = *std::min_element(weights.begin(), weights.end()) >= -1e-9 * m.squaredNorm();
    if (inside) return std::copysign(1.0, before) * n.dot(m) / m.norm();  // before > 0: the origin is behind m
  }
  return std::nullopt;
}

/// Where a point stands at a cloth: on which side of the face that is nearest to it, and how that is turned.
struct SheetSide {
  double sign;  ///< 1: where the face's normal points
  Vec3 normal;
};

/// None where nothing is within `reach`, or the border is nearest. Of faces that are equally near the steepest is
/// asked: it alone tells the sides apart where their common vertex or edge is nearest.
inline std::optional<SheetSide> side_of(const Mesh& mesh, const Vec3& p, double reach) {
  constexpr double same = 1e-9;  // [m]
  double nearest = reach, steepest = 0;
  std::optional<SheetSide> side;
  for (int f = 0; f < mesh.n_faces(); ++f) {
    const auto [i, j, k] = mesh.face(f);
    const std::array<Vec3, 3> x{mesh.x[i], mesh.x[j], mesh.x[k]};
    const Vec3 low = x[0].cwiseMin(x[1]).cwiseMin(x[2]), high = x[0].cwiseMax(x[1]).cwiseMax(x[2]);
    if ((low - p).maxCoeff() > reach || (p - high).maxCoeff() > reach) continue;
    const Vec3 b = closest_on_triangle(p, x);
    const Vec3 way = p - b[0] * x[0] - b[1] * x[1] - b[2] * x[2];
    const Vec3 normal = (x[1] - x[0]).cross(x[2] - x[0]).normalized();
    const double distance = way.norm(), steep = std::abs(normal.dot(way));
    if (distance > nearest + same || (distance > nearest - same && steep <= steepest)) continue;
    nearest = std::min(nearest, distance);
    steepest = steep;
    side = SheetSide{std::copysign(1.0, normal.dot(way)), normal};
    for (int e = 0; e < 3; ++e)
      if (b[(e + 2) % 3] == 0 && mesh.is_border(3 * f + e)) side.reset();
  }
  return side;
}

/// Counts what comes through tips, and tells how far the cloth gets from the wires that it has come to hang on; neither
/// has an inside in which a penetration could be measured.
///
/// A tip keeps the cloth on the side of its normal, and that is all it does (it has no shaft): the cloth has been
/// pierced if its motion in a step carries it over the point `allowed` behind the tip, against the normal. Cloth that
/// slips off over its border, or that has come to lean over by a right angle, has not; after that a tip is not judged.
/// Remeshing moves the surface as well, where a vertex is taken out of a tip's way: what changes sides by that is
/// judged as what passes.
class Piercing {
 public:
  explicit Piercing(double allowed) : allowed_(allowed) {}

  int pierced() const { return pierced_; }
  double farthest_from_wire() const { return farthest_; }  ///< [m]

  /// The state before the solution of a step or of a part of one, which may be refused.
  void begin(const Cloth& cloth, std::span<const PosedObstacle> obstacles) {
    start_ = cloth.mesh;
    poses_.clear();
    for (const PosedObstacle& obstacle : obstacles) poses_.push_back(obstacle.pose);
  }
  void solved(const DofMap& dofs, const VecX& q, double h) {
    end_ = start_.x;
    for (int v = 0; v < start_.n_vertices(); ++v) end_[v] += h * q.segment<3>(dofs.x(v));
    pending_ = true;
  }
  /// A state that a step begins with: if it is the one that was waited for, that was accepted.
  void look(const Cloth& cloth, std::span<const PosedObstacle> obstacles) {
    if (pending_ && arrived(cloth)) {
      for (std::size_t o = 0; o < obstacles.size(); ++o) look_at_tip(o, obstacles[o]);
      pending_ = false;
      before_ = cloth.mesh;
    }
    if (before_.n_faces() == 0) before_ = cloth.mesh;
    for (std::size_t o = 0; o < obstacles.size(); ++o)
      if (obstacles[o].shape->kind == ObstacleShape::Kind::Wire) look_at_wire(cloth, obstacles[o]);
  }

 private:
  bool arrived(const Cloth& cloth) const {
    if (cloth.mesh.n_vertices() != start_.n_vertices()) return false;
    constexpr double settled = 1e-5;  // what the stepper puts back onto a feature at the end of a step [m]
    for (int v = 0; v < cloth.mesh.n_vertices(); ++v)
      if ((cloth.mesh.x[v] - end_[v]).norm() > settled) return false;
    return true;
  }

  void look_at_tip(std::size_t o, const PosedObstacle& obstacle) {
    if (obstacle.shape->kind != ObstacleShape::Kind::Point) return;
    constexpr double facing = 0.1;  // cosine of 84 degrees
    slipped_.resize(poses_.size());
    for (const double cosine : passings(o, obstacle, 0.05 * allowed_))
      if (cosine <= facing) slipped_[o] = true;
    for (const double cosine : passings(o, obstacle, allowed_))
      if (cosine > facing && !slipped_[o]) ++pierced_;
  }

  /// The cosines with which cloth passes the point `sunk` behind the tip: by remeshing, and in the step.
  std::vector<double> passings(std::size_t o, const PosedObstacle& obstacle, double sunk) const {
    const SharpCorner& tip = obstacle.shape->corners.front();
    const Vec3 place = tip.position - sunk * tip.normals.front();
    const Vec3 from = poses_[o].to_world(place), to = obstacle.pose.to_world(place);
    const Vec3 n = obstacle.pose.rotation * tip.normals.front();
    std::vector<double> cosines;
    const auto was = side_of(before_, from, allowed_), is = side_of(start_, from, allowed_);
    if (was && is && was->sign != is->sign) cosines.push_back(is->sign * n.dot(is->normal));
    for (int f = 0; f < start_.n_faces(); ++f) {
      std::array<Vec3, 3> start, end;
      for (std::size_t k = 0; k < 3; ++k) {
        start[k] = start_.x[start_.face(f)[k]] - from;
        end[k] = end_[start_.face(f)[k]] - to;
      }
      if (const auto cosine = passing_cosine(start, end, n)) cosines.push_back(*cosine);
    }
    return cosines;
  }

  // In the middle, so that the places stay under the cloth while it slips to and fro.
  void look_at_wire(const Cloth& cloth, const PosedObstacle& obstacle) {
    const SharpEdge& edge = obstacle.shape->edges.front();
    for (const double s : {0.4, 0.5, 0.6}) {
      const Vec3 p = obstacle.pose.to_world(edge.a + s * (edge.b - edge.a));
      double nearest = std::numeric_limits<double>::infinity();
      for (int f = 0; f < cloth.mesh.n_faces(); ++f) {
        const auto [i, j, k] = cloth.mesh.face(f);
        const std::array<Vec3, 3> x{cloth.mesh.x[i], cloth.mesh.x[j], cloth.mesh.x[k]};
        const Vec3 b = closest_on_triangle(p, x);
        nearest = std::min(nearest, (p - b[0] * x[0] - b[1] * x[1] - b[2] * x[2]).norm());
      }
      touched_ = touched_ || nearest < allowed_;
      if (touched_) farthest_ = std::max(farthest_, nearest);
    }
  }

  double allowed_;
  Mesh before_, start_;  // of a step: before it was remeshed, and after
  std::vector<Pose> poses_;
  std::vector<Vec3> end_;
  std::vector<char> slipped_;  // by obstacle
  bool pending_ = false, touched_ = false;
  int pierced_ = 0;
  double farthest_ = 0;
};

/// The shipped stages, watched.
inline auto watched_stages(std::shared_ptr<Piercing> piercing) {
  return [piercing](const Scene& scene, const ClothSpec& spec) {
    Stages stages = make_stages(scene, spec);
    auto work = std::make_shared<std::pair<DofMap, double>>();
    stages.detect = [piercing, detect = stages.detect](const Cloth& cloth, std::span<const PosedObstacle> obstacles,
                                                       double h) {
      piercing->look(cloth, obstacles);
      return detect(cloth, obstacles, h);
    };
    stages.constrain = [piercing, work, constrain = stages.constrain](
                           const Cloth& cloth, const DofMap& dofs, std::span<const Contact> contacts,
                           std::span<const PosedObstacle> obstacles, std::span<const PinState> pins,
                           const ConstraintOptions& options) {
      piercing->begin(cloth, obstacles);
      *work = {dofs, options.h};
      return constrain(cloth, dofs, contacts, obstacles, pins, options);
    };
    stages.solve = [piercing, work, solve = stages.solve](const QpProblem& problem, std::span<const char> guess) {
      QpResult result = solve(problem, guess);
      if (result.status == QpStatus::Solved) piercing->solved(work->first, result.q, work->second);
      return result;
    };
    return stages;
  };
}

}  // namespace crease::testing
