// SPDX-License-Identifier: MIT
#include "crease/geometry/closed_surface.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <numeric>

#include <Eigen/Geometry>

#include "crease/base/require.hpp"
#include "crease/geometry/distance.hpp"

namespace crease {
namespace {

// So many triangles in a leaf of the tree: below, a box test costs as much as the triangle.
constexpr int leaf_size = 4;

// Halves of a tree over as many triangles as an int can count: no branch is longer.
constexpr std::size_t most_levels = 32;

// Round-off of a length, as a share of those that it was computed from: sums of some tens of terms.
constexpr double length_round_off = 1e-14;

// An edge bends inwards if the triangle behind it rises above the plane before it by more than this sine: round-off of
// flat faces that were cut into triangles.
constexpr double flat_sine = 1e-9;

// Two feet nearer to each other than this [m], or to p by this, are one: the round-off of a common edge.
constexpr double same_place = 1e-9;

Vec3 area_vector(const TriangleSurface& mesh, std::size_t t) {
  const auto& [a, b, c] = mesh.triangles[t];
  return (mesh.vertices[b] - mesh.vertices[a]).cross(mesh.vertices[c] - mesh.vertices[a]);
}

std::vector<std::array<int, 3>> neighbours_of(const TriangleSurface& mesh) {
  std::map<std::array<int, 2>, int> owner;  // directed edge -> triangle
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t)
    for (std::size_t k = 0; k < 3; ++k)
      owner[{mesh.triangles[t][k], mesh.triangles[t][(k + 1) % 3]}] = static_cast<int>(t);
  std::vector<std::array<int, 3>> across(mesh.triangles.size());
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t)
    for (std::size_t k = 0; k < 3; ++k) across[t][k] = owner.at({mesh.triangles[t][(k + 1) % 3], mesh.triangles[t][k]});
  return across;
}

}  // namespace

ClosedSurface::ClosedSurface(TriangleSurface surface) : mesh_(std::move(surface)) {
  const auto problems = surface_problems(mesh_);
  require(problems.empty(), problems.empty() ? "" : "ClosedSurface: " + problems.front());
  across_ = neighbours_of(mesh_);
  at_vertex_.resize(mesh_.vertices.size());
  std::vector<Vec3> centres;
  for (std::size_t t = 0; t < mesh_.triangles.size(); ++t) {
    normals_.push_back(area_vector(mesh_, t).normalized());
    Vec3 centre = Vec3::Zero();
    for (const int i : mesh_.triangles[t]) {
      at_vertex_[i].push_back(static_cast<int>(t));
      centre += mesh_.vertices[i] / 3;
    }
    centres.push_back(centre);
  }
  set_edge_normals();
  set_vertex_normals();
  set_slabs();
  convex_ = convex_ && is_connected();
  order_.resize(mesh_.triangles.size());
  std::iota(order_.begin(), order_.end(), 0);
  build(0, static_cast<int>(order_.size()), centres);
}

void ClosedSurface::set_edge_normals() {
  edge_normals_.resize(normals_.size());
  for (std::size_t t = 0; t < normals_.size(); ++t) {
    const auto& corners = mesh_.triangles[t];
    for (std::size_t k = 0; k < 3; ++k) {
      const int other = across_[t][k];
      const Vec3 sum = normals_[t] + normals_[other];
      // Folded back onto itself: any direction across the edge would do, and none is better.
      edge_normals_[t][k] = sum.norm() > 0 ? Vec3(sum.normalized()) : normals_[t];
      const Vec3 along = (mesh_.vertices[corners[(k + 1) % 3]] - mesh_.vertices[corners[k]]).normalized();
      convex_ = convex_ && along.dot(normals_[t].cross(normals_[other])) >= -flat_sine;
    }
  }
}

void ClosedSurface::set_vertex_normals() {
  vertex_normals_.resize(mesh_.vertices.size(), Vec3::Zero());
  for (std::size_t t = 0; t < normals_.size(); ++t) {
    const auto& corners = mesh_.triangles[t];
    for (std::size_t k = 0; k < 3; ++k) {
      const Vec3 p = mesh_.vertices[corners[(k + 1) % 3]] - mesh_.vertices[corners[k]];
      const Vec3 q = mesh_.vertices[corners[(k + 2) % 3]] - mesh_.vertices[corners[k]];
      vertex_normals_[corners[k]] += std::atan2(p.cross(q).norm(), p.dot(q)) * normals_[t];
    }
  }
  for (Vec3& n : vertex_normals_)
    if (n.norm() > 0) n.normalize();
}

void ClosedSurface::set_slabs() {
  for (const Vec3& x : mesh_.vertices) radius_ = std::max(radius_, x.norm());
  for (std::size_t t = 0; t < normals_.size(); ++t) {
    Slab slab{normals_[t], normals_[t].dot(mesh_.vertices[mesh_.triangles[t][0]]), {}, {}, 0};
    double longest = 0;
    for (std::size_t k = 0; k < 3; ++k) {
      const Vec3& a = mesh_.vertices[mesh_.triangles[t][k]];
      const Vec3 along = mesh_.vertices[mesh_.triangles[t][(k + 1) % 3]] - a;
      longest = std::max(longest, along.norm());
      slab.sides[k] = along.cross(normals_[t]).normalized();
      slab.side_offsets[k] = slab.sides[k].dot(a);
    }
    // A needle's normal is as uncertain as the needle is thin.
    slab.round_off = length_round_off * (1 + longest * longest / area_vector(mesh_, t).norm());
    slabs_.push_back(slab);
  }
}

bool ClosedSurface::is_connected() const {
  std::vector<char> seen(across_.size(), 0);
  std::vector<int> stack{0};
  seen[0] = 1;
  std::size_t n = 1;
  while (!stack.empty()) {
    const int t = stack.back();
    stack.pop_back();
    for (const int other : across_[t]) {
      if (seen[other]) continue;
      seen[other] = 1;
      ++n;
      stack.push_back(other);
    }
  }
  return n == across_.size();
}

// Halves by the median along the longest side of the centres' box; ends since both halves are smaller.
int ClosedSurface::build(int first, int last, const std::vector<Vec3>& centres) {
  const auto id = static_cast<int>(nodes_.size());
  nodes_.emplace_back();
  Vec3 low = Vec3::Constant(std::numeric_limits<double>::infinity()), high = -low, from = low, to = high;
  for (int i = first; i < last; ++i) {
    for (const int v : mesh_.triangles[order_[i]]) {
      low = low.cwiseMin(mesh_.vertices[v]);
      high = high.cwiseMax(mesh_.vertices[v]);
    }
    from = from.cwiseMin(centres[order_[i]]);
    to = to.cwiseMax(centres[order_[i]]);
  }
  Node node{low, high, -1, -1, first, last};
  if (last - first > leaf_size) {
    int axis = 0;
    (to - from).maxCoeff(&axis);
    const int middle = (first + last) / 2;
    std::nth_element(order_.begin() + first, order_.begin() + middle, order_.begin() + last, [&](int a, int b) {
      return centres[a][axis] != centres[b][axis] ? centres[a][axis] < centres[b][axis] : a < b;
    });
    node.left = build(first, middle, centres);
    node.right = build(middle, last, centres);
  }
  nodes_[id] = node;
  return id;
}

double ClosedSurface::distance2(const Node& node, const Vec3& p) const {
  return (node.low - p).cwiseMax(p - node.high).cwiseMax(0.0).squaredNorm();
}

SurfaceFoot ClosedSurface::foot(int triangle, const Vec3& p) const {
  const auto t = static_cast<std::size_t>(triangle);
  const auto& corners = mesh_.triangles[t];
  const std::array<Vec3, 3> x{mesh_.vertices[corners[0]], mesh_.vertices[corners[1]], mesh_.vertices[corners[2]]};
  const Vec3 w = closest_on_triangle(p, x);
  SurfaceFoot foot{w[0] * x[0] + w[1] * x[1] + w[2] * x[2], normals_[t], 0, triangle};
  for (int k = 0; k < 3; ++k) {
    const int next = (k + 1) % 3, last = (k + 2) % 3;
    if (w[last] == 0 && w[k] != 0 && w[next] != 0) {
      foot.edge = k;
      foot.normal = edge_normals_[t][static_cast<std::size_t>(k)];
    }
    if (w[next] == 0 && w[last] == 0) {
      foot.corner = k;
      foot.normal = vertex_normals_[corners[static_cast<std::size_t>(k)]];
    }
  }
  const double length = (p - foot.point).norm();
  foot.distance = (p - foot.point).dot(foot.normal) < 0 ? -length : length;
  return foot;
}

// No point of the triangle is nearer. @param size  of the coordinates that go into it [m]
double ClosedSurface::least_distance(const Slab& slab, const Vec3& p, double size) const {
  const double off = slab.normal.dot(p) - slab.offset;
  double beside = 0;
  for (std::size_t k = 0; k < 3; ++k) beside = std::max(beside, slab.sides[k].dot(p) - slab.side_offsets[k]);
  return std::sqrt(off * off + beside * beside) - slab.round_off * size;
}

// Passes over only what is farther than the best by more than round-off: so it is the best of all triangles, in
// whichever order they are looked at.
SurfaceFoot ClosedSurface::nearest(const Vec3& p, int start) const {
  const double size = p.norm() + radius_;
  SurfaceFoot best;
  double best2 = std::numeric_limits<double>::infinity(), limit = best2, limit2 = best2;
  const auto offer = [&](int triangle) {
    const SurfaceFoot found = foot(triangle, p);
    const double d2 = found.distance * found.distance;
    if (!(d2 < best2 || (d2 == best2 && triangle < best.triangle))) return;
    best = found;
    best2 = d2;
    limit = std::abs(found.distance) + length_round_off * size;
    limit2 = limit * limit;
  };
  if (start >= 0) offer(start);
  struct Waiting {
    int node;
    double d2;
  };
  std::array<Waiting, most_levels + 1> stack{Waiting{0, 0}};
  std::size_t n = 1;
  while (n > 0) {
    const auto [id, d2] = stack[--n];
    if (d2 > limit2) continue;
    const Node& node = nodes_[id];
    if (node.left < 0) {
      for (int i = node.first; i < node.last; ++i)
        if (order_[i] != start && least_distance(slabs_[order_[i]], p, size) <= limit) offer(order_[i]);
      continue;
    }
    Waiting near{node.left, distance2(nodes_[node.left], p)}, far{node.right, distance2(nodes_[node.right], p)};
    if (far.d2 <= near.d2) std::swap(near, far);
    stack[n++] = far;
    stack[n++] = near;
  }
  return best;
}

// The triangles that share the place must not come nearer to p.
bool ClosedSurface::is_minimum(const SurfaceFoot& candidate, const Vec3& p) const {
  const auto t = static_cast<std::size_t>(candidate.triangle);
  const auto not_nearer = [&](int other) {
    return std::abs(foot(other, p).distance) >= std::abs(candidate.distance) - same_place;
  };
  if (candidate.edge >= 0) return not_nearer(across_[t][static_cast<std::size_t>(candidate.edge)]);
  if (candidate.corner < 0) return true;
  const auto& around = triangles_at(mesh_.triangles[t][static_cast<std::size_t>(candidate.corner)]);
  return std::all_of(around.begin(), around.end(), not_nearer);
}

std::vector<SurfaceFoot> ClosedSurface::minima(const Vec3& p, double reach) const {
  const SurfaceFoot closest = nearest(p);
  if (closest.distance > reach) return {};
  if (convex_ || closest.distance <= same_place) return {closest};
  std::vector<SurfaceFoot> found;
  std::vector<int> stack{0};
  while (!stack.empty()) {
    const Node& node = nodes_[stack.back()];
    stack.pop_back();
    if (distance2(node, p) > reach * reach) continue;
    if (node.left >= 0) {
      stack.insert(stack.end(), {node.left, node.right});
      continue;
    }
    for (int i = node.first; i < node.last; ++i) {
      const SurfaceFoot candidate = foot(order_[i], p);
      // What turns its back to p is behind the solid.
      if (candidate.distance >= 0 && candidate.distance <= reach && is_minimum(candidate, p))
        found.push_back(candidate);
    }
  }
  std::sort(found.begin(), found.end(),
            [](const SurfaceFoot& a, const SurfaceFoot& b) { return a.triangle < b.triangle; });
  std::vector<SurfaceFoot> distinct;
  for (const SurfaceFoot& f : found)
    if (std::none_of(distinct.begin(), distinct.end(),
                     [&](const SurfaceFoot& g) { return (f.point - g.point).norm() <= same_place; }))
      distinct.push_back(f);
  return distinct;
}

}  // namespace crease
