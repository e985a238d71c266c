// SPDX-License-Identifier: MIT
#pragma once

// Which places of sharp edges have a chain of the cloth on them, and how often that changes back and forth.

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <map>
#include <memory>
#include <set>
#include <span>
#include <tuple>
#include <vector>

#include "crease/geometry/chain.hpp"
#include "crease/stepper/run.hpp"

namespace crease::testing {

class ChainCover {
 public:
  /// The shipped stages, watched.
  static auto watched(std::shared_ptr<ChainCover> cover) {
    return [cover](const Scene& scene, const ClothSpec& spec) {
      Stages stages = make_stages(scene, spec);
      stages.remesh = [cover, remesh = stages.remesh](const Cloth& cloth, std::span<const Contact> contacts,
                                                      std::span<const PosedObstacle> obstacles, double h) {
        ++cover->step_;
        cover->look(cloth, obstacles);
        RemeshResult result = remesh(cloth, contacts, obstacles, h);
        cover->look(result.cloth, obstacles);
        return result;
      };
      return stages;
    };
  }

  /// Changes, over all places.
  int changes() const {
    int n = 0;
    for (const auto& [place, steps] : changes_) n += static_cast<int>(steps.size());
    return n;
  }
  /// Those that take back another one of the same step or the one before.
  int taken_back() const {
    int n = 0;
    for (const auto& [place, steps] : changes_)
      for (std::size_t i = 1; i < steps.size(); ++i) n += steps[i] - steps[i - 1] <= 1 ? 1 : 0;
    return n;
  }

 private:
  using Place = std::tuple<int, FeatureKind, int, int>;  // obstacle, kind, index, multiple of `spacing` along an edge
  static constexpr double spacing = 5e-3;                // [m], a quarter of the shortest mesh edges

  void look(const Cloth& cloth, std::span<const PosedObstacle> obstacles) {
    std::set<Place> now;
    for (int v = 0; v < cloth.mesh.n_vertices(); ++v)
      if (cloth.rides(v) && cloth.feature[v].kind == FeatureKind::Corner)
        now.insert({cloth.feature[v].obstacle, FeatureKind::Corner, cloth.feature[v].index, 0});
    for (const int h : cloth.mesh.edges()) {
      if (cloth.mesh.tag(h) == 0) continue;
      const FeatureId feature = tag_feature(cloth.mesh.tag(h));
      const PosedObstacle& obstacle = obstacles[feature.obstacle];
      const SharpEdge& edge = obstacle.shape->edges[feature.index];
      const Vec3 tangent = obstacle.pose.rotation * (edge.b - edge.a).normalized(), a = obstacle.pose.to_world(edge.a);
      const auto [from, to] = std::minmax(
          {tangent.dot(cloth.mesh.x[cloth.mesh.from(h)] - a), tangent.dot(cloth.mesh.x[cloth.mesh.to(h)] - a)});
      for (int k = static_cast<int>(std::ceil(from / spacing)); k * spacing <= to; ++k)
        now.insert({feature.obstacle, FeatureKind::Edge, feature.index, k});
    }
    for (const Place& place : now)
      if (!covered_.contains(place)) changes_[place].push_back(step_);
    for (const Place& place : covered_)
      if (!now.contains(place)) changes_[place].push_back(step_);
    covered_ = std::move(now);
  }

  int step_ = 0;
  std::set<Place> covered_;
  std::map<Place, std::vector<int>> changes_;
};

}  // namespace crease::testing
