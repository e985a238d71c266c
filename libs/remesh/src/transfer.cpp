// SPDX-License-Identifier: MIT
#include "transfer.hpp"

#include <Eigen/Geometry>
#include <Eigen/LU>

#include "crease/geometry/triangle.hpp"
#include "crease/remesh/remesh.hpp"

namespace crease {

namespace {

// A direction whose image under F is shorter than this, relative to F, is not seen in the world: no motion along it can
// take up any world velocity.
constexpr double degenerate = 1e-9;

}  // namespace

std::array<Vec3, 3> corner_velocities(const Cloth& cloth, int face) {
  const std::array<int, 3>& corners = cloth.mesh.face(face);
  std::array<Vec3, 3> w;
  bool eulerian = false;
  for (std::size_t k = 0; k < 3; ++k) {
    w[k] = cloth.v[corners[k]];
    eulerian = eulerian || cloth.is_eol(corners[k]);
  }
  if (!eulerian) return w;
  const Mat32 F = deformation_gradient(cloth.mesh, face);
  for (std::size_t k = 0; k < 3; ++k) w[k] -= F * cloth.V[corners[k]];
  return w;
}

Vec3 edge_velocity(const Cloth& cloth, int h, double t) {
  const Mesh& mesh = cloth.mesh;
  Vec3 sum = Vec3::Zero();
  double area = 0;
  for (const int side : {h, mesh.twin(h)}) {
    if (side == Mesh::none) continue;
    const std::array<Vec3, 3> w = corner_velocities(cloth, Mesh::face_of(side));
    const std::size_t from = static_cast<std::size_t>(side % 3), to = (from + 1) % 3;
    const double along = side == h ? t : 1 - t;
    const double weight = mesh.material_area(Mesh::face_of(side));
    sum += weight * ((1 - along) * w[from] + along * w[to]);
    area += weight;
  }
  return sum / area;
}

// One row leaves one direction t free, where the minimum of |w + s F t|^2 is at s = -(F t).w / |F t|^2; no row leaves
// the plane, with the normal equations of the paper's Eq. 13.
Vec2 eulerian_share(const Vec3& world_velocity, const Mat32& F, std::span<const Vec2> rows) {
  const double scale2 = F.squaredNorm();
  const auto along = [&](const Vec2& t) -> Vec2 {
    const Vec3 image = F * t;
    if (!(image.squaredNorm() > degenerate * degenerate * scale2)) return Vec2::Zero();
    return -image.dot(world_velocity) / image.squaredNorm() * t;
  };
  if (rows.empty()) {
    const Mat2 C = F.transpose() * F;
    if (C.determinant() > degenerate * scale2 * scale2) return -C.inverse() * (F.transpose() * world_velocity);
    const Vec2 longest = C(0, 0) >= C(1, 1) ? C.col(0) : C.col(1);
    return longest.norm() > 0 ? along(longest.normalized()) : Vec2::Zero();
  }
  const Vec2 first = rows.front().normalized();
  for (const Vec2& row : rows.subspan(1))
    if (std::abs(first.x() * row.y() - first.y() * row.x()) > degenerate * row.norm()) return Vec2::Zero();
  return along({-first.y(), first.x()});
}

}  // namespace crease
