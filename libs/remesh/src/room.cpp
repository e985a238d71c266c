// SPDX-License-Identifier: MIT
#include "room.hpp"

#include <algorithm>
#include <cmath>

namespace crease {

namespace {

// Room beside a chain, as a metric length: far enough that most of the fold's bend lies before it, near enough that the
// next vertices, at L = .5 to 1, are well behind it. What has the first length is left alone, the second is restored.
constexpr double least_room = .64, room = .65;
// Faces keep this many times the shift allowed as altitude: two rows of vertices that have come as near to each other
// as that become one unseen, unless the sheet bends by more than a third of a radian there.
constexpr double least_altitude = 3;
// A border vertex slides along the border, if that runs straight on and leads away from the chain at all.
constexpr double least_cosine = 0.3, straight = 1e-9;
constexpr int max_tries = 5;
constexpr double safety = 0.9;

Vec2 nearest_on_segment(const Vec2& P, const Vec2& a, const Vec2& b) {
  const Vec2 e = b - a;
  return a + std::clamp(e.dot(P - a) / e.squaredNorm(), 0.0, 1.0) * e;
}

// From the nearest point of the chains in its star to the vertex. A lone tip passes between vertices: those that flee
// it only crowd each other.
std::optional<Vec2> way_from_chain(const Cloth& cloth, int vertex) {
  const Mesh& mesh = cloth.mesh;
  const Vec2& P = mesh.X[vertex];
  std::optional<Vec2> nearest;
  const auto offer = [&](const Vec2& Q) {
    if (!nearest || (P - Q).squaredNorm() < nearest->squaredNorm()) nearest = P - Q;
  };
  mesh.all_outgoing(vertex, [&](int h) {
    const int a = mesh.to(h), b = mesh.opposite(h);
    if (mesh.tag(Mesh::next(h)) != 0) offer(nearest_on_segment(P, mesh.X[a], mesh.X[b]));
    for (const int v : {a, b})
      if (cloth.feature[v].kind == FeatureKind::Edge) offer(mesh.X[v]);
    return true;
  });
  return nearest;
}

// The same way along a straight border, where the chain's own vertex on the border comes after it.
std::optional<Vec2> along_border(const Cloth& cloth, int vertex, const Vec2& way) {
  const Mesh& mesh = cloth.mesh;
  if (mesh.border_turn(vertex) > straight) return std::nullopt;
  const std::vector<int> around = mesh.neighbours(vertex);
  for (const int end : {around.front(), around.back()}) {
    if (cloth.feature[end].kind != FeatureKind::Edge) continue;
    const Vec2 direction = (mesh.X[vertex] - mesh.X[end]).normalized();
    const double cosine = direction.dot(way.normalized());
    if (cosine >= least_cosine) return Vec2(way.norm() / cosine * direction);
  }
  return std::nullopt;
}

}  // namespace

std::vector<int> vertices_beside_chains(const Cloth& cloth) {
  std::vector<int> beside;
  for (int v = 0; v < cloth.mesh.vertex_slots(); ++v) {
    if (!cloth.mesh.vertex_live(v) || cloth.feature[v].kind != FeatureKind::Edge) continue;
    for (const int u : cloth.mesh.neighbours(v))
      if (!cloth.is_eol(u)) beside.push_back(u);
  }
  std::sort(beside.begin(), beside.end());
  beside.erase(std::unique(beside.begin(), beside.end()), beside.end());
  return beside;
}

std::optional<Slide> slide_from_chain(const Cloth& cloth, int vertex, const Tensor& size, const GuardLimits& limits) {
  const Mesh& mesh = cloth.mesh;
  if (cloth.pins[vertex] != 0 || mesh.on_seam(vertex)) return std::nullopt;
  const std::optional<Vec2> way = way_from_chain(cloth, vertex);
  if (!way) return std::nullopt;
  const double length = std::sqrt(std::max(0.0, size.along(*way)));
  if (!(length > 0 && length < least_room)) return std::nullopt;
  Vec2 step = (room / length - 1) * *way;
  if (mesh.is_border_vertex(vertex)) {
    const std::optional<Vec2> along = along_border(cloth, vertex, step);
    if (!along) return std::nullopt;
    step = *along;
  }
  const double floor = least_altitude * limits.shift;
  for (int attempt = 0; attempt < max_tries; ++attempt) {
    std::optional<Slide> slide = place_in_star(cloth, vertex, mesh.X[vertex] + step);
    double share = 0.5;
    if (slide) {
      const Verdict verdict = judge_slide(cloth, vertex, {slide->X, slide->x}, floor, limits);
      slide->shift = verdict.shift;
      if (!verdict.trouble) return slide;
      if (verdict.shift > limits.shift) share = safety * limits.shift / verdict.shift;
    }
    step *= share;
  }
  return std::nullopt;
}

}  // namespace crease
