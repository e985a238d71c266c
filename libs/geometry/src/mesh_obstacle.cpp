// SPDX-License-Identifier: MIT
#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <numeric>

#include <Eigen/Dense>

#include "crease/base/require.hpp"
#include "crease/geometry/obstacle.hpp"

namespace crease {
namespace {

// Directions nearer to each other than this are one [rad]: coordinates written with six decimals turn the edges of a
// centimetre by as much.
constexpr double same_direction = 1e-4;

// Three normals of a corner span room if their determinant exceeds this: a bend of a rim by 0.06 degrees.
constexpr double least_room = 1e-3;

// A convex mesh of more faces than this counts as round: its planes are not listed.
constexpr std::size_t most_planes = 32;

// A vertex this share of the mesh's size above a face's plane makes the mesh not convex.
constexpr double plane_slack = 1e-9;

bool same(const Vec3& a, const Vec3& b) {
  return std::atan2(a.cross(b).norm(), a.dot(b)) <= same_direction;
}

void add_new(std::vector<Vec3>& directions, const Vec3& d) {
  if (std::none_of(directions.begin(), directions.end(), [&](const Vec3& known) { return same(known, d); }))
    directions.push_back(d);
}

void add_new(std::vector<int>& numbers, int n) {
  const auto at = std::lower_bound(numbers.begin(), numbers.end(), n);
  if (at == numbers.end() || *at != n) numbers.insert(at, n);
}

/// One mesh edge, seen along its direction a -> b with the outside up: triangle 0 is on its left.
struct Crease {
  int a, b;
  std::array<int, 2> triangles;
  Vec3 tangent;
  std::array<Vec3, 2> normals;
  std::array<int, 2> patches;
};

Crease reversed(const Crease& c) {
  return {c.b,
          c.a,
          {c.triangles[1], c.triangles[0]},
          -c.tangent,
          {c.normals[1], c.normals[0]},
          {c.patches[1], c.patches[0]}};
}

bool continues(const Crease& from, const Crease& to) {
  return same(from.tangent, to.tangent) && same(from.normals[0], to.normals[0]) && same(from.normals[1], to.normals[1]);
}

/// Finds the features of one mesh.
class FeatureFinder {
 public:
  FeatureFinder(const ClosedSurface& surface, double sharp_angle) : surface_(surface), sharp_angle_(sharp_angle) {}
  void fill(ObstacleShape& shape);

 private:
  double bend(int t, int k) const;
  bool bends_outwards(int t, int k) const;
  void number_patches();
  void collect_creases();
  void add_blunt_edges(ObstacleShape& shape) const;
  std::array<int, 2> run_through(int crease, ObstacleShape& shape) const;
  void mark(int crease, ObstacleShape& shape) const;
  int next_in_run(int crease, int vertex, const Crease& first) const;
  std::vector<Vec3> cone_at(int vertex) const;
  int corner_at(int vertex, ObstacleShape& shape);

  const ClosedSurface& surface_;
  double sharp_angle_;
  std::vector<int> patch_;
  std::vector<Crease> creases_;                // sharp, outwards; by the triangle that is found first
  std::map<int, std::vector<int>> at_vertex_;  // their numbers
};

double FeatureFinder::bend(int t, int k) const {
  const Vec3 &m = surface_.normal(t), &n = surface_.normal(surface_.across(t, k));
  return std::atan2(m.cross(n).norm(), m.dot(n));
}

bool FeatureFinder::bends_outwards(int t, int k) const {
  const auto& mesh = surface_.mesh();
  const auto& corners = mesh.triangles[t];
  const Vec3 along = mesh.vertices[corners[(k + 1) % 3]] - mesh.vertices[corners[k]];
  return along.dot(surface_.normal(t).cross(surface_.normal(surface_.across(t, k)))) > 0;
}

// Flood from every triangle that has no number yet, across all edges that are not sharp.
void FeatureFinder::number_patches() {
  const int n = static_cast<int>(surface_.mesh().triangles.size());
  patch_.assign(n, -1);
  int count = 0;
  for (int start = 0; start < n; ++start) {
    if (patch_[start] >= 0) continue;
    std::vector<int> stack{start};
    patch_[start] = count;
    while (!stack.empty()) {
      const int t = stack.back();
      stack.pop_back();
      for (int k = 0; k < 3; ++k) {
        const int other = surface_.across(t, k);
        if (patch_[other] >= 0 || bend(t, k) > sharp_angle_) continue;
        patch_[other] = count;
        stack.push_back(other);
      }
    }
    ++count;
  }
}

void FeatureFinder::collect_creases() {
  const auto& mesh = surface_.mesh();
  for (int t = 0; t < static_cast<int>(mesh.triangles.size()); ++t) {
    for (int k = 0; k < 3; ++k) {
      const int other = surface_.across(t, k);
      if (other < t || !(bend(t, k) > sharp_angle_) || !bends_outwards(t, k)) continue;
      const int a = mesh.triangles[t][k], b = mesh.triangles[t][(k + 1) % 3];
      for (const int end : {a, b}) at_vertex_[end].push_back(static_cast<int>(creases_.size()));
      creases_.push_back({a,
                          b,
                          {t, other},
                          (mesh.vertices[b] - mesh.vertices[a]).normalized(),
                          {surface_.normal(t), surface_.normal(other)},
                          {patch_[t], patch_[other]}});
    }
  }
}

void FeatureFinder::add_blunt_edges(ObstacleShape& shape) const {
  const auto& mesh = surface_.mesh();
  for (int t = 0; t < static_cast<int>(mesh.triangles.size()); ++t) {
    for (int k = 0; k < 3; ++k) {
      const int other = surface_.across(t, k);
      if (other < t || bend(t, k) > sharp_angle_ || bend(t, k) <= same_direction || !bends_outwards(t, k)) continue;
      SharpEdge edge{mesh.vertices[mesh.triangles[t][k]], mesh.vertices[mesh.triangles[t][(k + 1) % 3]]};
      edge.normals = {surface_.normal(t), surface_.normal(other)};
      shape.blunt_edges.push_back(std::move(edge));
    }
  }
}

// The crease on which the run `first` goes on beyond `vertex`, an end of `crease`; -1 = it ends there.
int FeatureFinder::next_in_run(int crease, int vertex, const Crease& first) const {
  const auto& around = at_vertex_.at(vertex);
  if (around.size() != 2) return -1;
  const int other = around[0] == crease ? around[1] : around[0];
  const Crease onward = creases_[other].a == vertex ? creases_[other] : reversed(creases_[other]);
  return continues(first, onward) ? other : -1;
}

// Both sides of a crease belong to the edge that is being made.
void FeatureFinder::mark(int crease, ObstacleShape& shape) const {
  for (const int t : creases_[crease].triangles) {
    const auto& corners = surface_.mesh().triangles[t];
    for (std::size_t k = 0; k < 3; ++k) {
      const int from = corners[k], to = corners[(k + 1) % 3], a = creases_[crease].a, b = creases_[crease].b;
      if ((from == a && to == b) || (from == b && to == a)) shape.edge_at[t][k] = static_cast<int>(shape.edges.size());
    }
  }
}

// The two ends of the straight run that holds a crease, in its direction. Compared with that one crease, not from piece
// to piece, so that a run cannot drift into a curve.
std::array<int, 2> FeatureFinder::run_through(int crease, ObstacleShape& shape) const {
  std::array<int, 2> ends{creases_[crease].a, creases_[crease].b};
  mark(crease, shape);
  for (const int side : {0, 1}) {
    const Crease first = side == 1 ? creases_[crease] : reversed(creases_[crease]);
    for (int next = crease; (next = next_in_run(next, ends[side], first)) >= 0;) {
      mark(next, shape);
      ends[side] = creases_[next].a == ends[side] ? creases_[next].b : creases_[next].a;
    }
  }
  return ends;
}

// Generators of all normals with which a plane can rest on the vertex: n . e <= 0 for every mesh edge e that leaves it.
// On a convex corner these are its faces' normals; else the cone is bounded by planes through two of the edges each.
std::vector<Vec3> FeatureFinder::cone_at(int vertex) const {
  const auto& mesh = surface_.mesh();
  std::vector<Vec3> edges, faces;
  for (const int t : surface_.triangles_at(vertex)) {
    const auto& corners = mesh.triangles[t];
    const auto k = static_cast<std::size_t>(std::find(corners.begin(), corners.end(), vertex) - corners.begin());
    add_new(edges, (mesh.vertices[corners[(k + 1) % 3]] - mesh.vertices[vertex]).normalized());
    add_new(faces, surface_.normal(t));
  }
  const auto supports = [&](const Vec3& n) {
    return std::all_of(edges.begin(), edges.end(), [&](const Vec3& e) { return n.dot(e) <= same_direction; });
  };
  if (std::all_of(faces.begin(), faces.end(), supports)) return faces;
  std::vector<Vec3> cone;
  for (std::size_t i = 0; i < edges.size(); ++i)
    for (std::size_t j = i + 1; j < edges.size(); ++j)
      for (const double sign : {1.0, -1.0})
        if (const Vec3 n = sign * edges[i].cross(edges[j]).normalized(); n.norm() > 0 && supports(n)) add_new(cone, n);
  return cone;
}

bool has_room(const std::vector<Vec3>& cone) {
  for (std::size_t i = 0; i < cone.size(); ++i)
    for (std::size_t j = i + 1; j < cone.size(); ++j)
      for (std::size_t k = j + 1; k < cone.size(); ++k)
        if (std::abs(cone[i].dot(cone[j].cross(cone[k]))) > least_room) return true;
  return false;
}

// Made when it is first asked for.
int FeatureFinder::corner_at(int vertex, ObstacleShape& shape) {
  if (shape.corner_at[vertex] >= 0) return shape.corner_at[vertex];
  SharpCorner corner{surface_.mesh().vertices[vertex], cone_at(vertex)};
  if (!has_room(corner.normals)) return -1;
  for (const int t : surface_.triangles_at(vertex)) add_new(corner.patches, patch_[t]);
  shape.corner_at[vertex] = static_cast<int>(shape.corners.size());
  shape.corners.push_back(std::move(corner));
  return shape.corner_at[vertex];
}

void FeatureFinder::fill(ObstacleShape& shape) {
  number_patches();
  collect_creases();
  add_blunt_edges(shape);
  shape.patch = patch_;
  shape.edge_at.assign(patch_.size(), {-1, -1, -1});
  shape.corner_at.assign(surface_.mesh().vertices.size(), -1);
  for (const Crease& crease : creases_) {
    const auto& corners = surface_.mesh().triangles[crease.triangles[0]];
    const auto k = static_cast<std::size_t>(std::find(corners.begin(), corners.end(), crease.a) - corners.begin());
    if (shape.edge_at[crease.triangles[0]][k] >= 0) continue;  // in an earlier one's run
    const std::array<int, 2> ends = run_through(static_cast<int>(&crease - creases_.data()), shape);
    SharpEdge edge;
    edge.a = surface_.mesh().vertices[ends[0]];
    edge.b = surface_.mesh().vertices[ends[1]];
    edge.normals = crease.normals;
    edge.corners = {corner_at(ends[0], shape), corner_at(ends[1], shape)};
    for (const int patch : crease.patches) add_new(edge.patches, patch);
    shape.edges.push_back(std::move(edge));
  }
}

// One plane for all triangles that lie in it; none if some vertex is above one, if there are too many, or if an edge is
// sharper than a box's: below such an edge, and straight across from it, one is soon out of the solid again.
std::vector<FacePlane> convex_planes(const ClosedSurface& surface) {
  if (!surface.is_convex()) return {};
  const auto& mesh = surface.mesh();
  for (int t = 0; t < static_cast<int>(mesh.triangles.size()); ++t)
    for (int k = 0; k < 3; ++k)
      if (surface.normal(t).dot(surface.normal(surface.across(t, k))) < -same_direction) return {};
  Vec3 low = mesh.vertices.front(), high = low;
  for (const Vec3& p : mesh.vertices) low = low.cwiseMin(p), high = high.cwiseMax(p);
  const double slack = plane_slack * (high - low).norm();
  std::vector<FacePlane> planes;
  for (int t = 0; t < static_cast<int>(mesh.triangles.size()); ++t) {
    const auto& corners = mesh.triangles[t];
    const auto holds = [&](const FacePlane& plane) {
      return surface.normal(t).dot(plane.normal) > 0 && std::all_of(corners.begin(), corners.end(), [&](int i) {
               return std::abs(plane.normal.dot(mesh.vertices[i]) - plane.offset) <= slack;
             });
    };
    if (std::any_of(planes.begin(), planes.end(), holds)) continue;
    const FacePlane plane{surface.normal(t), surface.normal(t).dot(mesh.vertices[corners[0]])};
    const bool supports = std::all_of(mesh.vertices.begin(), mesh.vertices.end(),
                                      [&](const Vec3& p) { return plane.normal.dot(p) <= plane.offset + slack; });
    if (!supports || planes.size() == most_planes) return {};
    planes.push_back(plane);
  }
  return planes;
}

TriangleSurface without_loose_vertices(const TriangleSurface& surface) {
  std::vector<int> id(surface.vertices.size(), -1);
  for (const auto& t : surface.triangles)
    for (const int i : t) id[i] = 0;
  TriangleSurface clean;
  for (std::size_t i = 0; i < id.size(); ++i) {
    if (id[i] < 0) continue;
    id[i] = static_cast<int>(clean.vertices.size());
    clean.vertices.push_back(surface.vertices[i]);
  }
  for (const auto& t : surface.triangles) clean.triangles.push_back({id[t[0]], id[t[1]], id[t[2]]});
  return clean;
}

}  // namespace

ObstacleShape make_mesh(const TriangleSurface& surface, double sharp_angle) {
  require(sharp_angle > 0, "make_mesh: expected a sharp angle > 0");
  const auto problems = surface_problems(surface);
  require(problems.empty(), problems.empty() ? "" : "make_mesh: " + problems.front());
  ObstacleShape shape;
  shape.kind = ObstacleShape::Kind::Mesh;
  const auto solid = std::make_shared<const ClosedSurface>(without_loose_vertices(surface));
  shape.vertices = solid->mesh().vertices;
  shape.triangles = solid->mesh().triangles;
  shape.surface = solid;
  shape.planes = convex_planes(*solid);
  FeatureFinder(*solid, sharp_angle).fill(shape);
  return shape;
}

}  // namespace crease
