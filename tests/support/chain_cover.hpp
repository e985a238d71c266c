// SPDX-License-Identifier: MIT
#pragma once

// Which places of sharp edges have a chain of the cloth on them, and how often that changes back and forth.

#include <algorithm>
#include <cmath>
#include <map>
#include <memory>
#include <set>
#include <span>
#include <tuple>
#include <utility>
#include <vector>

#include "crease/geometry/feature_place.hpp"
#include "crease/stepper/run.hpp"

namespace crease::testing {

/// A place changes when a chain begins or ends there; a chain that moves along the edge with its cloth changes nothing.
/// Steps that failed and were taken in parts count by the parts.
class ChainCover {
 public:
  /// The shipped stages, watched.
  static auto watched(std::shared_ptr<ChainCover> cover) {
    return [cover](const Scene& scene, const ClothSpec& spec) {
      Stages stages = make_stages(scene, spec);
      stages.remesh = [cover, remesh = stages.remesh](const Cloth& cloth, std::span<const Contact> contacts,
                                                      std::span<const PosedObstacle> obstacles, double h) {
        cover->look_before(cloth, obstacles);
        RemeshResult result = remesh(cloth, contacts, obstacles, h);
        cover->look_after(result.cloth, obstacles);
        return result;
      };
      return stages;
    };
  }

  /// Changes, over all places.
  int changes() const {
    int n = 0;
    for (const auto& [place, all] : now_.changes) n += static_cast<int>(all.size());
    return n;
  }
  /// Those that take back another one of the same step or the one before.
  int taken_back() const {
    int n = 0;
    for (const auto& [place, all] : now_.changes)
      for (std::size_t i = 1; i < all.size(); ++i)
        n += all[i].begins != all[i - 1].begins && all[i].step - all[i - 1].step <= 1 ? 1 : 0;
    return n;
  }

 private:
  using Place = std::tuple<int, FeatureKind, int, int>;  // obstacle, kind, index, multiple of `spacing` along an edge
  static constexpr double spacing = 5e-3;                // [m], a quarter of the shortest mesh edges
  struct Change {
    int step;
    bool begins;
  };
  struct State {
    int step = 0;
    std::set<Place> covered;
    std::map<Place, std::vector<Change>> changes;
    Cloth remeshed;  // as the step began to move it
  };

  /// The cloth as a step left it, or again as the last call had it, if that step failed.
  void look_before(const Cloth& cloth, std::span<const PosedObstacle> obstacles) {
    if (given_ == cloth.mesh.x)
      now_ = before_;
    else
      before_ = now_;
    given_ = cloth.mesh.x;
    Cloth& moved = now_.remeshed;
    if (moved.mesh.n_vertices() == cloth.mesh.n_vertices()) {
      moved.mesh.x = cloth.mesh.x;
      now_.covered = covered_by(moved, obstacles);
    }
    note(covered_by(cloth, obstacles));
    ++now_.step;
  }

  void look_after(const Cloth& cloth, std::span<const PosedObstacle> obstacles) {
    note(covered_by(cloth, obstacles));
    now_.remeshed = cloth;
  }

  void note(std::set<Place> covered) {
    for (const Place& place : covered)
      if (!now_.covered.contains(place)) now_.changes[place].push_back({now_.step, true});
    for (const Place& place : now_.covered)
      if (!covered.contains(place)) now_.changes[place].push_back({now_.step, false});
    now_.covered = std::move(covered);
  }

  static std::set<Place> covered_by(const Cloth& cloth, std::span<const PosedObstacle> obstacles) {
    std::set<Place> covered;
    for (int v = 0; v < cloth.mesh.n_vertices(); ++v)
      if (cloth.feature[v].kind == FeatureKind::Corner)
        covered.insert({cloth.feature[v].obstacle, FeatureKind::Corner, cloth.feature[v].index, 0});
    for (const int h : cloth.mesh.edges()) {
      if (cloth.mesh.tag(h) == 0) continue;
      const FeatureId feature = tag_feature(cloth.mesh.tag(h));
      const WorldEdge edge = world_edge(feature, obstacles);
      const auto [from, to] = std::minmax(
          {edge.parameter(cloth.mesh.x[cloth.mesh.from(h)]), edge.parameter(cloth.mesh.x[cloth.mesh.to(h)])});
      for (int k = static_cast<int>(std::ceil(from / spacing)); k * spacing <= to; ++k)
        covered.insert({feature.obstacle, FeatureKind::Edge, feature.index, k});
    }
    return covered;
  }

  State now_, before_;
  std::vector<Vec3> given_;
};

}  // namespace crease::testing
