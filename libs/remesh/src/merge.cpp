// SPDX-License-Identifier: MIT
#include <algorithm>
#include <cmath>
#include <optional>
#include <tuple>

#include "conforming.hpp"
#include "crease/geometry/distance.hpp"
#include "crease/geometry/normal_cone.hpp"
#include "crease/geometry/triangle.hpp"
#include "guard.hpp"
#include "metric.hpp"
#include "shift.hpp"
#include "strain.hpp"

// Keeps the way of a chain through the material open. An EOL vertex may move per step by a share of its height over the
// triangles ahead, and they shrink as it moves: whatever comes near is absorbed.
//
// Per EOL vertex, until nothing is due:
//  - neighbours on the chain that are too near become one, and so do two vertices that ride on one corner;
//  - a free vertex r that is too near, or low over a chain edge, goes into the chain: into one of its vertices, or, if
//    that leaves poor triangles, into a new one at r's foot. A foot is at least sqrt(1 - thin^2) merges from both ends
//    of its edge, or r would be near one of them; so it is not merged away again, and each vertex is absorbed once;
//  - an obtuse triangle whose longest side faces the chain is flipped.
// Absorbing removes a vertex, merging too, a flip raises the smallest altitude by a fixed factor; a budget ends it in
// any case.
//
// What this may do to the surface. A vertex taken out at the distance d from the chain, where the facets meet at the
// angle a, moves the surface by about d sin a. So there are two distances: within `merge`, or what the chain would
// reach in the time ahead, a vertex goes if nobody will see it; only within the few steps that the chain needs to go on
// does it go at any price, and the way that moves the surface least is taken, mostly to its own foot on the chain.
namespace crease {

namespace {

// A flip must raise the smallest altitude of its two faces by this.
constexpr double flip_gain = 1.2;
// Absorbing into an existing vertex leaves at least this share of `merge` of altitude, or a foot is tried.
constexpr double good_altitude_share = 0.8;
// ... and moves the surface by no more than this share of `snap`.
constexpr double good_shift_share = 0.1;
// Within this shift, as a share of `snap`, a sliver in the chain's way may turn as it likes: a needle of 50 microns has
// any normal, and to refuse its flip for that holds the cloth there.
constexpr double sliver_shift_share = 0.5;
// A foot nearer to an end of its chain edge than this share of `merge` is that end.
constexpr double least_foot_share = 0.5;
// Nor may a new edge run deeper than this share of `snap` inside a feature, unless what is in the way is within
// last_share: vertices that hover over a gap in a chain are all that keeps the cloth from cutting through there.
constexpr double inside_share = 0.5;
// Operations per EOL vertex and call.
constexpr int budget_per_vertex = 10;
constexpr int least_budget = 50;

// How much the surface may change.
struct Permission {
  double turn;    // of a face normal, or across a flipped edge [rad]
  double shift;   // of the surface in the world [m]
  double angle;   // that a triangle may have, or it had less before [rad]
  double strain;  // that the patch may gain, see strain.hpp [1]
  bool cut;       // a feature may be cut
  double sliver;  // shift within which they may turn as they like: their normals mean nothing [m]
};

class Merger {
 public:
  explicit Merger(Conforming& conforming) : c_(conforming) {}
  void run();

 private:
  /// Where a vertex may be absorbed: into a chain vertex, or at t on a chain edge.
  struct Way {
    int into = Mesh::none, edge = Mesh::none;
    double t = 0;
    double altitude = 0;  // smallest that it leaves [m]
    double shift = 0;     // of the surface [m]
    double strain = 0;    // that the patch gains, if above needed_strain, else 0 [1]
    bool is_better_than(const Way& other) const {
      return altitude > 0 && (other.altitude == 0 ||
                              std::tie(strain, shift, other.altitude) < std::tie(other.strain, other.shift, altitude));
    }
  };
  const Cloth& cloth() const { return c_.cloth(); }
  const Mesh& mesh() const { return c_.mesh(); }
  double distance(int a, int b) const { return (mesh().X[b] - mesh().X[a]).norm(); }

  double clearance(int v) const;
  double way(double share) const { return share * clear_; }
  Permission permission(double room) const;
  double turn_allowed(const Permission& allowed, double shift) const;
  bool settle(int v);
  bool shorten_chain(int v);
  bool drop_dangling(int v, int q);
  bool absorb_neighbours(int v);
  bool cuts_feature(const Vec3& a, const Vec3& b) const;
  bool cuts_corner(const std::array<Vec3, 3>& x) const;
  bool cuts_feature(int r, const Target& target) const;
  void judge(Way& way, int r, const Target& target, const Permission& allowed) const;
  Way best_vertex(int r, const Permission& allowed) const;
  Way best_foot(int r, const Permission& allowed) const;
  bool absorb(int r, double room);
  bool open_faces(int v);
  double height(int face, int v) const;
  std::optional<double> foot(int h, int r) const;
  void report_thin(int v);

  Conforming& c_;
  int budget_ = 0;
  double clear_ = 0;  // clearance() of the vertex that is being settled [m]
  double need_ = 0;   // what it needs to go on [m]
};

// What the vertex would reach in the time ahead, between `merge` and the limit given for it.
double Merger::clearance(int v) const {
  const double ahead = c_.options.look_ahead * cloth().V[v].norm();
  return std::max(c_.options.merge, std::min(ahead, c_.options.clearance));
}

Permission Merger::permission(double room) const {
  const double snap = c_.options.snap;
  if (room < c_.merge(last_share)) return {1.2, c_.merge(0.5), 0, HUGE_VAL, true, sliver_shift_share * snap};
  if (room < need_) return {1.2, c_.merge(0.5), 0, needed_strain, false, good_shift_share * snap};
  return {0.35, good_shift_share * snap, least_angle, needed_strain, false, 0};
}

double Merger::turn_allowed(const Permission& allowed, double shift) const {
  return shift < allowed.sliver ? HUGE_VAL : allowed.turn;
}

// Height of corner v over the opposite side of a face.
double Merger::height(int face, int v) const {
  const std::array<int, 3>& f = mesh().face(face);
  const int k = f[0] == v ? 0 : f[1] == v ? 1 : 2;
  const double side = mesh().material_length(Mesh::next(3 * face + k));
  return 2 * mesh().material_area(face) / side;
}

// Parameter of r's foot on edge h if it is well inside.
std::optional<double> Merger::foot(int h, int r) const {
  const Vec2 a = mesh().X[mesh().from(h)], e = mesh().X[mesh().to(h)] - a;
  const double length = e.norm(), along = e.dot(mesh().X[r] - a) / length, margin = way(least_foot_share);
  if (along < margin || along > length - margin) return std::nullopt;
  return along / length;
}

bool Merger::shorten_chain(int v) {
  struct Merge {
    int gone, into;
    double altitude;
  };
  std::optional<Merge> best;
  const auto offer = [&](int gone, int into) {
    if (cloth().feature[gone].kind != FeatureKind::Edge || cloth().pins[gone] != 0) return;
    if (mesh().is_border_vertex(gone) || !mesh().can_collapse_vertex(gone, into)) return;
    const Ring ring = ring_after(cloth(), gone, at_vertex(mesh(), into));
    const Permission allowed = permission(c_.merge(forced_share));
    if (!ring.sound || ring.turn > allowed.turn) return;
    if (shift_after(cloth(), gone, at_vertex(mesh(), into), ring) > allowed.shift) return;
    if (strain_gained(mesh(), gone, at_vertex(mesh(), into)) > needed_strain) return;
    if (!best || ring.altitude > best->altitude) best = Merge{gone, into, ring.altitude};
  };
  for (const int q : mesh().neighbours(v)) {
    if (mesh().tag(mesh().find_edge(v, q)) == 0 || distance(v, q) >= c_.merge(chain_merge_share)) continue;
    if (drop_dangling(v, q) || drop_dangling(q, v)) return true;
    offer(v, q);
    offer(q, v);
  }
  if (!best) return false;
  c_.editor.collapse(best->gone, best->into);
  return true;
}

// A chain that ends inside the cloth has one link at its last vertex, which the mesh does not collapse: it is let go.
// One that has just begun, a little earlier, or it would end in the next step.
bool Merger::drop_dangling(int v, int q) {
  if (cloth().feature[v].kind != FeatureKind::Edge || cloth().pins[v] != 0 || mesh().is_border_vertex(v)) return false;
  const bool is_new = std::find(c_.newcomers.begin(), c_.newcomers.end(), v) != c_.newcomers.end();
  if (distance(v, q) >= c_.merge(is_new ? chain_merge_share : thin_share)) return false;
  int links = 0;
  for (const int u : mesh().neighbours(v)) links += mesh().tag(mesh().find_edge(v, u)) != 0 ? 1 : 0;
  if (links != 1) return false;
  const Ring ring = ring_after(cloth(), v, at_vertex(mesh(), q));
  if (!ring.sound || ring.turn > permission(0).turn) return false;
  const bool is_felt = strain_gained(mesh(), v, at_vertex(mesh(), q)) > needed_strain;
  let_go(c_, v);
  if (!is_felt && mesh().can_collapse_vertex(v, q)) c_.editor.collapse(v, q);
  return true;
}

bool Merger::absorb_neighbours(int v) {
  std::vector<std::pair<double, int>> near;
  for (const int h : mesh().outgoing(v)) {
    for (const int r : {mesh().to(h), mesh().opposite(h)}) {
      if (cloth().is_eol(r)) continue;
      if (const double d = distance(v, r); d < clear_) near.emplace_back(d, r);
    }
    // The two faces of a chain edge, each seen from one of its ends.
    for (const int side : {h, mesh().twin(h)}) {
      if (side == Mesh::none || mesh().tag(side) == 0) continue;
      const int r = mesh().opposite(side);
      const double d = height(Mesh::face_of(side), r);
      if (!cloth().is_eol(r) && d < way(thin_share)) near.emplace_back(d, r);
    }
  }
  std::sort(near.begin(), near.end());
  for (const auto& [room, r] : near)
    if (absorb(r, room)) return true;
  return false;
}

// Whether a straight mesh edge would pass a sharp edge of a solid on the inside.
bool Merger::cuts_feature(const Vec3& a, const Vec3& b) const {
  for (int o = 0; o < static_cast<int>(c_.obstacles.size()); ++o) {
    const ObstacleShape& shape = *c_.obstacles[o].shape;
    if (shape.triangles.empty()) continue;
    // A mesh may have thousands of sharp edges, few of them near: those whose box, in the obstacle's frame, is not are
    // passed by.
    const Vec3 p = c_.obstacles[o].pose.to_local(a), q = c_.obstacles[o].pose.to_local(b);
    const Vec3 low = p.cwiseMin(q).array() - 2 * c_.merge(1), high = p.cwiseMax(q).array() + 2 * c_.merge(1);
    for (int e = 0; e < static_cast<int>(shape.edges.size()); ++e) {
      const SharpEdge& sharp = shape.edges[e];
      if ((sharp.a.cwiseMax(sharp.b).array() < low.array()).any()) continue;
      if ((sharp.a.cwiseMin(sharp.b).array() > high.array()).any()) continue;
      const FeatureId feature{o, FeatureKind::Edge, e};
      const WorldEdge edge = world_edge(feature, c_.obstacles);
      const SegmentPair near = closest_segments(a, b, edge.a, edge.a + edge.length * edge.tangent);
      if (near.distance > c_.merge(1) || near.distance < inside_share * c_.options.snap) continue;
      if (stand_off(feature, c_.obstacles, (1 - near.s) * a + near.s * b) < 0) return true;
    }
  }
  return false;
}

// Whether a sharp corner of a solid would stick out of a face of the mesh.
bool Merger::cuts_corner(const std::array<Vec3, 3>& x) const {
  const Vec3 across = (x[1] - x[0]).cross(x[2] - x[0]);
  return std::any_of(c_.obstacles.begin(), c_.obstacles.end(), [&](const PosedObstacle& obstacle) {
    const auto& corners = obstacle.shape->corners;
    return !obstacle.shape->triangles.empty() && std::any_of(corners.begin(), corners.end(), [&](const SharpCorner& c) {
      const Vec3 tip = obstacle.pose.to_world(c.position);
      const double side = across.dot(obstacle.pose.rotation * mean_normal(c.normals));
      const Vec3 normal = std::copysign(1.0, side) * across.normalized();
      for (std::size_t k = 0; k < 3; ++k)
        if (across.dot((x[(k + 1) % 3] - x[k]).cross(tip - x[k])) < 0) return false;
      return normal.dot(x[0] - tip) < -inside_share * c_.options.snap &&
             in_cone(c.normals, obstacle.pose.rotation.transpose() * normal);
    });
  });
}

bool Merger::cuts_feature(int r, const Target& target) const {
  for (const int h : mesh().outgoing(r)) {
    const std::array<int, 2> side{mesh().to(h), mesh().opposite(h)};
    const auto has = [&](int v) { return side[0] == v || side[1] == v; };
    const bool vanishes = has(target.a) && (target.b == Mesh::none || has(target.b));
    if (!vanishes && cuts_corner({target.x, mesh().x[side[0]], mesh().x[side[1]]})) return true;
  }
  const std::vector<int> around = mesh().neighbours(r);
  return std::any_of(around.begin(), around.end(), [&](int s) {
    return s != target.a && s != target.b && mesh().find_edge(target.a, s) == Mesh::none &&
           cuts_feature(target.x, mesh().x[s]);
  });
}

// Triangles may stay as thin as they were: another vertex may be the cause, and its turn comes.
void Merger::judge(Way& way, int r, const Target& target, const Permission& allowed) const {
  const Ring ring = ring_after(cloth(), r, target);
  if (!ring.sound || ring.angle < std::min(allowed.angle, ring.angle_before)) return;
  if (ring.altitude < std::min(clear_ * thin_share, ring.altitude_before)) return;
  way.shift = shift_after(cloth(), r, target, ring);
  if (ring.turn > turn_allowed(allowed, way.shift)) return;
  if (!allowed.cut && way.shift > good_shift_share * c_.options.snap && cuts_feature(r, target)) return;
  if (way.shift > allowed.shift) return;
  const double strain = strain_gained(mesh(), r, target);
  if (strain > allowed.strain) return;
  if (strain > needed_strain) way.strain = strain;
  way.altitude = ring.altitude;
}

Merger::Way Merger::best_vertex(int r, const Permission& allowed) const {
  Way best;
  for (const int p : mesh().neighbours(r)) {
    if (!cloth().is_eol(p) || !mesh().can_collapse_vertex(r, p)) continue;
    Way way{.into = p};
    judge(way, r, at_vertex(mesh(), p), allowed);
    if (way.is_better_than(best)) best = way;
  }
  return best;
}

Merger::Way Merger::best_foot(int r, const Permission& allowed) const {
  Way best;
  if (mesh().is_border_vertex(r)) return best;
  for (const int out : mesh().outgoing(r)) {
    const int h = Mesh::next(out), g = mesh().twin(h);
    const std::optional<double> t = foot(h, r);
    if (mesh().tag(h) == 0 || !t || !mesh().can_split(h, *t)) continue;
    // After the split the new vertex sees r and the vertex across; were those two joined, the collapse could not be.
    if (g != Mesh::none && mesh().find_edge(r, mesh().opposite(g)) != Mesh::none) continue;
    Way way{.edge = h, .t = *t};
    judge(way, r, on_edge(mesh(), mesh().from(h), mesh().to(h), *t), allowed);
    if (way.is_better_than(best)) best = way;
  }
  return best;
}

bool Merger::absorb(int r, double room) {
  if (cloth().pins[r] != 0 || mesh().on_seam(r) || (mesh().is_border_vertex(r) && mesh().is_material_corner(r)))
    return false;
  const Permission allowed = permission(room);
  const Way vertex = best_vertex(r, allowed), foot = best_foot(r, allowed);
  const bool good = vertex.altitude >= way(good_altitude_share) && vertex.shift <= good_shift_share * c_.options.snap;
  if (vertex.altitude > 0 && (good || !foot.is_better_than(vertex))) {
    c_.editor.collapse(r, vertex.into);
    return true;
  }
  if (foot.altitude == 0) return false;
  const int m = c_.editor.split(foot.edge, foot.t).vertex;
  if (mesh().can_collapse_vertex(r, m)) c_.editor.collapse(r, m);
  return true;
}

bool Merger::open_faces(int v) {
  for (const int out : mesh().outgoing(v)) {
    const double room = height(Mesh::face_of(out), v);
    if (room >= way(thin_share)) continue;
    int longest = out;
    for (const int h : {Mesh::next(out), Mesh::prev(out)})
      if (mesh().material_length(h) > mesh().material_length(longest)) longest = h;
    const FlipCheck check = flip_check(cloth(), longest);
    const Permission allowed = permission(room);
    if (!check.sound || check.altitude < flip_gain * check.altitude_before) continue;
    const double shift = flip_shift(mesh(), longest);
    if (shift > allowed.shift || check.dihedral > turn_allowed(allowed, shift)) continue;
    if (strain_gained_by_flip(mesh(), longest) > allowed.strain) continue;
    if (!allowed.cut &&
        cuts_feature(mesh().x[mesh().opposite(longest)], mesh().x[mesh().opposite(mesh().twin(longest))]))
      continue;
    if (room >= way(forced_share)) {
      // What adapt() would flip back is left alone.
      const auto& X = mesh().X;
      const int other = mesh().opposite(mesh().twin(longest));
      if (opposite_angle_sine(X[mesh().from(longest)], X[mesh().opposite(longest)], X[mesh().to(longest)], X[other],
                              Tensor::isotropic(1)) >= 0)
        continue;
    }
    c_.editor.flip(longest);
    return true;
  }
  return false;
}

bool Merger::settle(int v) {
  bool changed = false;
  clear_ = clearance(v);
  need_ = std::max(c_.merge(last_share), need_share * c_.options.look_ahead * cloth().V[v].norm());
  while (mesh().vertex_live(v) && cloth().is_eol(v) && budget_ > 0) {
    if (!shorten_chain(v) && !drop_second_rider(c_, v) && !absorb_neighbours(v) && !open_faces(v)) break;
    changed = true;
    --budget_;
  }
  return changed;
}

void Merger::report_thin(int v) {
  for (const int h : mesh().outgoing(v)) {
    if (height(Mesh::face_of(h), v) >= c_.merge(report_share)) continue;
    c_.editor.refuse(RefusalReason::TooThin, v, mesh().X[v]);
    return;
  }
}

void Merger::run() {
  const auto is_eol = [&](int v) { return mesh().vertex_live(v) && cloth().is_eol(v); };
  int n = 0;
  for (int v = 0; v < mesh().vertex_slots(); ++v) n += is_eol(v) ? 1 : 0;
  budget_ = least_budget + budget_per_vertex * n;
  for (bool changed = true; changed && budget_ > 0;) {
    changed = false;
    for (int v = 0; v < mesh().vertex_slots(); ++v)
      if (is_eol(v)) changed |= settle(v);
  }
  if (budget_ == 0) c_.editor.refuse(RefusalReason::BudgetSpent, Mesh::none, Vec2::Zero());
  for (int v = 0; v < mesh().vertex_slots(); ++v)
    if (is_eol(v)) report_thin(v);
}

}  // namespace

void merge_near_chains(Conforming& c) {
  Merger(c).run();
}

}  // namespace crease
