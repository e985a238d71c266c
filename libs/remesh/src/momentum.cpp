// SPDX-License-Identifier: MIT
#include "momentum.hpp"

#include <algorithm>
#include <cmath>

#include <Eigen/Geometry>
#include <Eigen/LU>

#include "transfer.hpp"

namespace crease {

namespace {

using Vec6 = Eigen::Matrix<double, 6, 1>;
using Mat6 = Eigen::Matrix<double, 6, 6>;

// Below this ratio of the smallest to the largest pivot, with lengths measured in patch radii, the vertices are as good
// as in one line: a rotation about it would have to be fast to carry anything.
constexpr double least_pivot_ratio = 1e-3;

Mat3 cross_matrix(const Vec3& a) {
  return Mat3{{0, -a.z(), a.y()}, {a.z(), 0, -a.x()}, {-a.y(), a.x(), 0}};
}

bool is_held(const Cloth& cloth, int v) {
  return cloth.is_eol(v) || cloth.pins[v] != 0;
}

std::vector<int> free_among(const Cloth& cloth, std::vector<int> vertices) {
  const auto held = [&](int v) { return is_held(cloth, v); };
  if (std::all_of(vertices.begin(), vertices.end(), held)) {
    std::vector<int> around;
    for (const int v : vertices)
      for (const int u : cloth.mesh.neighbours(v)) around.push_back(u);
    std::sort(around.begin(), around.end());
    around.erase(std::unique(around.begin(), around.end()), around.end());
    vertices = std::move(around);
  }
  vertices.erase(std::remove_if(vertices.begin(), vertices.end(), held), vertices.end());
  return vertices;
}

// What a unit velocity of one vertex carries: its lumped area, and the first moment of its hat function about a point.
struct Inertia {
  double area = 0;
  Vec3 moment = Vec3::Zero();
};

Inertia inertia(const Mesh& mesh, int v, const Vec3& about) {
  Inertia sum;
  for (const int h : mesh.outgoing(v)) {
    const double area = mesh.material_area(Mesh::face_of(h));
    sum.area += area / 3;
    sum.moment += area / 12 * (2 * mesh.x[v] + mesh.x[mesh.to(h)] + mesh.x[mesh.opposite(h)] - 4 * about);
  }
  return sum;
}

}  // namespace

Momentum momentum(const Cloth& cloth, std::span<const int> faces, const Vec3& about) {
  Momentum sum;
  for (const int f : faces) {
    const std::array<Vec3, 3> w = corner_velocities(cloth, f);
    const std::array<int, 3>& corners = cloth.mesh.face(f);
    const double area = cloth.mesh.material_area(f);
    const Vec3 total = w[0] + w[1] + w[2];
    sum.linear += area / 3 * total;
    for (std::size_t i = 0; i < 3; ++i)
      sum.angular += area / 12 * (cloth.mesh.x[corners[i]] - about).cross(total + w[i]);
  }
  return sum;
}

Vec3 total_linear_momentum(const Cloth& cloth) {
  Vec3 sum = Vec3::Zero();
  for (int f = 0; f < cloth.mesh.face_slots(); ++f) {
    if (!cloth.mesh.face_live(f)) continue;
    const std::array<Vec3, 3> w = corner_velocities(cloth, f);
    sum += cloth.mesh.material_area(f) / 3 * (w[0] + w[1] + w[2]);
  }
  return sum;
}

// Unknowns: the velocity a at `about` and the spin times the patch radius R; v_i += a + spin x r_i. The rows are the
// change of linear momentum and of angular momentum over R, so that the matrix has the one unit m^2.
void repay(Cloth& cloth, const Momentum& debt, const Vec3& about, std::vector<int> vertices) {
  if (debt.linear.isZero(0) && debt.angular.isZero(0)) return;
  const std::vector<int> free = free_among(cloth, std::move(vertices));
  double radius = 0;
  for (const int v : free) radius = std::max(radius, (cloth.mesh.x[v] - about).norm());
  if (free.empty() || !(radius > 0)) return;
  Mat6 A = Mat6::Zero();
  double area = 0;
  for (const int v : free) {
    const Inertia carried = inertia(cloth.mesh, v, about);
    const Mat3 r = cross_matrix((cloth.mesh.x[v] - about) / radius), y = cross_matrix(carried.moment / radius);
    area += carried.area;
    A.topLeftCorner<3, 3>() += carried.area * Mat3::Identity();
    A.topRightCorner<3, 3>() -= carried.area * r;
    A.bottomLeftCorner<3, 3>() += y;
    A.bottomRightCorner<3, 3>() -= y * r;
  }
  const Eigen::FullPivLU<Mat6> lu(A);
  const double smallest = std::abs(lu.matrixLU()(5, 5));
  Vec6 motion = Vec6::Zero();
  if (smallest > least_pivot_ratio * lu.maxPivot()) {
    Vec6 wanted;
    wanted << debt.linear, debt.angular / radius;
    motion = lu.solve(wanted);
  } else {
    motion.head<3>() = debt.linear / area;
  }
  const Vec3 a = motion.head<3>(), spin = motion.tail<3>() / radius;
  for (const int v : free) cloth.v[v] += a + spin.cross(cloth.mesh.x[v] - about);
}

}  // namespace crease
