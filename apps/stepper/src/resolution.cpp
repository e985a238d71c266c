// SPDX-License-Identifier: MIT
#include "resolution.hpp"

#include <algorithm>
#include <charconv>
#include <limits>

#include "crease/geometry/distance.hpp"

namespace crease {
namespace {

/// As a share of the cloth's length.                                                               [WEIDNER18,
/// Sec. 6.1]
constexpr double merge_share_of_length = 0.01;
/// ... but never more than this share of the shortest edge wanted, else every fine triangle would be merged away.
constexpr double merge_share_of_size = 0.5;
/// Corners nearer than this share of the merge distance are in one place, as where boxes stand flush.
constexpr double same_place_share = 1e-6;

/// A corner or tip, or a segment of a wire.
struct Place {
  Vec3 a, b;
  int obstacle;
  double low() const { return std::min(a.x(), b.x()); }
  double high() const { return std::max(a.x(), b.x()); }
  bool is_point() const { return a == b; }
};

std::vector<Place> places_at_start(const std::vector<Obstacle>& obstacles) {
  std::vector<Place> places;
  for (std::size_t o = 0; o < obstacles.size(); ++o) {
    const Pose pose = pose_at(obstacles[o], 0);
    for (const SharpCorner& corner : obstacles[o].shape.corners) {
      const Vec3 x = pose.to_world(corner.position);
      places.push_back({x, x, static_cast<int>(o)});
    }
    for (const SharpEdge& edge : obstacles[o].shape.edges)
      if (edge.free_cone) places.push_back({pose.to_world(edge.a), pose.to_world(edge.b), static_cast<int>(o)});
  }
  std::stable_sort(places.begin(), places.end(), [](const Place& p, const Place& q) { return p.low() < q.low(); });
  return places;
}

struct Nearest {
  double distance = std::numeric_limits<double>::infinity();
  int first = -1, second = -1, pairs = 0;
};

// A wire's own joints are on its segments; only what belongs to different obstacles is told apart there.
Nearest nearest_pair(const std::vector<Place>& places, double reach) {
  Nearest nearest;
  for (auto p = places.begin(); p != places.end(); ++p)
    for (auto q = p + 1; q != places.end(); ++q) {
      if (p->is_point() && q->low() - p->high() > reach) break;
      if (p->obstacle == q->obstacle && !(p->is_point() && q->is_point())) continue;
      const double distance =
          p->is_point() && q->is_point() ? (p->a - q->a).norm() : closest_segments(p->a, p->b, q->a, q->b).distance;
      if (distance >= reach || distance < same_place_share * reach) continue;
      ++nearest.pairs;
      if (distance < nearest.distance) nearest = {distance, p->obstacle, q->obstacle, nearest.pairs};
    }
  return nearest;
}

std::string millimetres(double metres) {
  char text[32];
  return {text, std::to_chars(text, text + sizeof text, 1e3 * metres, std::chars_format::general, 3).ptr};
}

double material_length(const Cloth& cloth) {
  Vec2 low = cloth.mesh.X.front(), high = low;
  for (const Vec2& X : cloth.mesh.X) low = low.cwiseMin(X), high = high.cwiseMax(X);
  return (high - low).maxCoeff();
}

}  // namespace

double merge_distance(const Cloth& cloth, const AdaptOptions& options) {
  return std::min(merge_share_of_length * material_length(cloth), merge_share_of_size * options.size[0]);
}

std::vector<std::string> unresolved_features(const LoadedScene& loaded) {
  std::vector<std::string> warnings;
  const std::vector<Obstacle>& obstacles = loaded.scene.obstacles;
  const std::vector<Place> places = places_at_start(obstacles);
  for (std::size_t c = 0; c < loaded.cloths.size(); ++c) {
    const ClothSpec& spec = loaded.scene.cloths[c];
    if (spec.remeshing != RemeshMethod::Conformal) continue;
    const double reach = merge_distance(loaded.cloths[c], spec.adapt);
    const Nearest nearest = nearest_pair(places, reach);
    if (nearest.pairs == 0) continue;
    const std::string &first = obstacles[nearest.first].name, &second = obstacles[nearest.second].name;
    warnings.push_back("cloth '" + spec.name + "' cannot resolve all features of the obstacles: " +
                       (first == second ? "two of '" + first + "'" : "those of '" + first + "' and '" + second + "'") +
                       " are " + millimetres(nearest.distance) + " mm apart, and its mesh merges what is nearer than " +
                       millimetres(reach) + " mm; of " + std::to_string(nearest.pairs) +
                       " such pairs only one of each can hold the cloth by a vertex of its own. A smaller "
                       "remeshing.size resolves more, down to 1 % of the cloth's length");
  }
  return warnings;
}

}  // namespace crease
