// SPDX-License-Identifier: MIT
#include "strain.hpp"

#include <algorithm>
#include <cmath>

#include <Eigen/Geometry>

#include "crease/geometry/triangle.hpp"

namespace crease {

namespace {

struct Sum {
  double area = 0, strain = 0;

  // |S - I|^2 of the stretches s1, s2, by their sum and product; no strain leads to a face that is turned over.
  void add(const std::array<Vec2, 3>& X, const std::array<Vec3, 3>& x) {
    const double A = 0.5 * orient2d(X[0], X[1], X[2]);
    if (!(A > 0)) {
      strain = HUGE_VAL;
      return;
    }
    const Mat32 F = deformation_gradient(X, x);
    const double squares = F.squaredNorm(), product = F.col(0).cross(F.col(1)).norm();
    area += A;
    strain += A * (squares - 2 * std::sqrt(squares + 2 * product) + 2);
  }
};

double gained(const Sum& before, const Sum& after) {
  return std::sqrt(std::max(0.0, after.strain - before.strain) / before.area);
}

}  // namespace

double strain_gained(const Mesh& mesh, int vertex, const Target& target) {
  Sum before, after;
  for (const int h : mesh.outgoing(vertex)) {
    const int f = Mesh::face_of(h), s = mesh.to(h), t = mesh.opposite(h);
    before.add(material_corners(mesh, f), world_corners(mesh, f));
    const bool has_a = s == target.a || t == target.a;
    const bool has_b = target.b == Mesh::none || s == target.b || t == target.b;
    if (!has_a || !has_b) after.add({target.X, mesh.X[s], mesh.X[t]}, {target.x, mesh.x[s], mesh.x[t]});
  }
  return gained(before, after);
}

double strain_gained_by_split(const Mesh& mesh, int h, const Target& target) {
  const int g = mesh.twin(h);
  Sum before, after;
  for (const int side : {h, g}) {
    const int a = mesh.from(side), b = mesh.to(side), c = mesh.opposite(side);
    before.add({mesh.X[a], mesh.X[b], mesh.X[c]}, {mesh.x[a], mesh.x[b], mesh.x[c]});
    after.add({mesh.X[a], target.X, mesh.X[c]}, {mesh.x[a], target.x, mesh.x[c]});
    after.add({target.X, mesh.X[b], mesh.X[c]}, {target.x, mesh.x[b], mesh.x[c]});
  }
  return gained(before, after);
}

double strain_gained_by_flip(const Mesh& mesh, int h) {
  const int g = mesh.twin(h);
  const int a = mesh.from(h), b = mesh.opposite(h), c = mesh.to(h), d = mesh.opposite(g);
  const auto& X = mesh.X;
  const auto& x = mesh.x;
  Sum before, after;
  for (const int f : {Mesh::face_of(h), Mesh::face_of(g)})
    before.add(material_corners(mesh, f), world_corners(mesh, f));
  after.add({X[d], X[b], X[a]}, {x[d], x[b], x[a]});
  after.add({X[b], X[d], X[c]}, {x[b], x[d], x[c]});
  return gained(before, after);
}

}  // namespace crease
