// SPDX-License-Identifier: MIT
#include "shift.hpp"

#include <algorithm>

#include "metric.hpp"

namespace crease {

namespace {

// A segment in both spaces.
struct Segment {
  Vec2 X0, X1;
  Vec3 x0, x1;
};

// Distance in the world between the points where two segments cross in the material; 0 if they do not.
double gap_at_crossing(const Segment& p, const Segment& q) {
  const Vec2 u = p.X1 - p.X0, w = q.X1 - q.X0, d = q.X0 - p.X0;
  const double area = cross2(u, w);
  if (area == 0) return 0;
  const double s = cross2(d, w) / area, t = cross2(d, u) / area;
  if (!(s > 0 && s < 1 && t > 0 && t < 1)) return 0;
  return ((1 - s) * p.x0 + s * p.x1 - (1 - t) * q.x0 - t * q.x1).norm();
}

}  // namespace

double shift_after(const Cloth& cloth, int vertex, const Target& target, const Ring& ring) {
  const Mesh& mesh = cloth.mesh;
  const std::vector<int> around = mesh.neighbours(vertex);
  double largest = ring.shift;
  for (const int to : around) {
    if (to == target.a || to == target.b) continue;
    const Segment made{target.X, mesh.X[to], target.x, mesh.x[to]};
    for (const int old : around)
      if (old != to && old != target.a)
        largest = std::max(largest, gap_at_crossing(made, {mesh.X[vertex], mesh.X[old], mesh.x[vertex], mesh.x[old]}));
  }
  return largest;
}

double flip_shift(const Mesh& mesh, int h) {
  const int a = mesh.from(h), b = mesh.opposite(h), c = mesh.to(h), d = mesh.opposite(mesh.twin(h));
  return gap_at_crossing({mesh.X[a], mesh.X[c], mesh.x[a], mesh.x[c]}, {mesh.X[b], mesh.X[d], mesh.x[b], mesh.x[d]});
}

}  // namespace crease
