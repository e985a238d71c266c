// SPDX-License-Identifier: MIT
#pragma once

#include <array>
#include <string>
#include <vector>

#include "crease/base/types.hpp"

namespace crease {

/// Vertices [m] and triangles that run counter-clockwise seen from outside.
struct TriangleSurface {
  std::vector<Vec3> vertices;
  std::vector<std::array<int, 3>> triangles;
};

/// Everything that keeps a surface from being the boundary of a solid, in words, vertices and triangles counted from 1:
/// triangles of no area, edges with one side or with more than two, triangles that disagree about the outside, vertices
/// where two sheets touch, parts that are inside out. Empty if it is one. That it does not cut itself is not looked at.
std::vector<std::string> surface_problems(const TriangleSurface& surface);

/// Place on a surface where the distance to some point has a minimum.
struct SurfaceFoot {
  Vec3 point = Vec3::Zero();
  Vec3 normal = Vec3::Zero();  ///< unit, outward: the face's own, or at an edge or vertex the pseudonormal
  double distance = 0;         ///< negative inside [m]
  int triangle = -1;           ///< the one that was looked at, lowest among equals
  int edge = -1;               ///< 0, 1, 2 = from that corner of the triangle to the next, -1 = not on an edge
  int corner = -1;             ///< 0, 1, 2 = on that corner of the triangle, -1 = not on a vertex
};

/// The boundary of a solid, for queries of nearest points: a tree of boxes over its triangles, and normals at edges
/// (the two faces' sum) and vertices (the faces' sum, each by its angle there), which alone tell inside from outside
/// when the nearest point is an edge or a vertex.                                                        [BAERENTZEN05]
class ClosedSurface {
 public:
  /// Throws std::invalid_argument with the first of surface_problems().
  explicit ClosedSurface(TriangleSurface surface);

  const TriangleSurface& mesh() const { return mesh_; }
  const Vec3& normal(int triangle) const { return normals_[static_cast<std::size_t>(triangle)]; }
  /// Triangle on the other side of edge k of a triangle, which runs from its corner k to the next.
  int across(int triangle, int k) const {
    return across_[static_cast<std::size_t>(triangle)][static_cast<std::size_t>(k)];
  }
  /// Ascending.
  const std::vector<int>& triangles_at(int vertex) const { return at_vertex_[static_cast<std::size_t>(vertex)]; }
  /// In one part, and no edge bends inwards, up to round-off.
  bool is_convex() const { return convex_; }

  /// The nearest place on all triangles, on the lowest of those that are equally near. `start`, a triangle that may be
  /// near (-1 = none known), saves work and changes nothing.
  SurfaceFoot nearest(const Vec3& p, int start = -1) const;

  /// Seen from a point outside: every place within `reach` that is nearer than all places around it. One at most on a
  /// convex solid; in a groove, one on each side. From inside the nearest alone: it is the way out. By triangle.
  std::vector<SurfaceFoot> minima(const Vec3& p, double reach) const;

 private:
  struct Node {
    Vec3 low, high;
    int left = -1, right = -1;  // children, or
    int first = 0, last = 0;    // a range of order_ (a leaf)
  };
  /// What a triangle lies within: its plane n . x = offset, and side k's plane across it, outward.
  struct Slab {
    Vec3 normal;
    double offset;
    std::array<Vec3, 3> sides;
    std::array<double, 3> side_offsets;
    double round_off;  // of a distance to these planes, as a share of the lengths that go into it
  };
  int build(int first, int last, const std::vector<Vec3>& centres);
  void set_slabs();
  void set_edge_normals();
  void set_vertex_normals();
  bool is_connected() const;
  SurfaceFoot foot(int triangle, const Vec3& p) const;
  bool is_minimum(const SurfaceFoot& candidate, const Vec3& p) const;
  double distance2(const Node& node, const Vec3& p) const;
  double least_distance(const Slab& slab, const Vec3& p, double size) const;

  TriangleSurface mesh_;
  std::vector<Vec3> normals_;
  std::vector<std::array<int, 3>> across_;
  std::vector<std::array<Vec3, 3>> edge_normals_;
  std::vector<Vec3> vertex_normals_;
  std::vector<std::vector<int>> at_vertex_;
  std::vector<Slab> slabs_;
  double radius_ = 0;  // of all vertices about the origin [m]
  std::vector<Node> nodes_;
  std::vector<int> order_;
  bool convex_ = true;
};

}  // namespace crease
