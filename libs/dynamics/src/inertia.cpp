// SPDX-License-Identifier: MIT
#include "crease/dynamics/inertia.hpp"

#include "crease/base/require.hpp"
#include "crease/geometry/triangle.hpp"
#include "element.hpp"

namespace crease {

Mat15 eol_inertia(const std::array<Vec2, 3>& X, const std::array<Vec3, 3>& x, double density) {
  const Mat32 F = deformation_gradient(X, x);
  const Mat2 FtF = F.transpose() * F;
  const double unit = density * material_area(X) / 12;
  CREASE_ASSERT(unit > 0);
  Mat15 M;
  for (int i = 0; i < 3; ++i) {
    for (int j = 0; j < 3; ++j) {
      const double m = i == j ? 2 * unit : unit;
      M.block<3, 3>(3 * i, 3 * j) = m * Mat3::Identity();
      M.block<3, 2>(3 * i, 9 + 2 * j) = -m * F;
      M.block<2, 3>(9 + 2 * i, 3 * j) = -m * F.transpose();
      M.block<2, 2>(9 + 2 * i, 9 + 2 * j) = m * FtF;
    }
  }
  return M;
}

Vec15 eol_velocity_terms(const TriangleState& state, double density) {
  const Mat32 F = deformation_gradient(state.X, state.x);
  const Mat32 g = barycentric_gradients(state.X);
  const double mass = density * material_area(state.X);
  CREASE_ASSERT(mass > 0);
  std::array<Vec3, 3> w;
  for (int i = 0; i < 3; ++i) w[i] = state.v[i] - F * state.V[i];
  const TriangleMotion motion = triangle_motion(w, mass);

  // Fdot = sum_j w_j g_j^T: the identity (Dxdot - F DXdot) DX^-1 written by vertices.
  Mat32 F_dot = Mat32::Zero();
  double div = 0;
  Vec2 V_sum = Vec2::Zero();
  for (int j = 0; j < 3; ++j) {
    F_dot += w[j] * g.row(j);
    div += g.row(j).dot(state.V[j]);
    V_sum += state.V[j];
  }
  Vec15 C;
  for (int i = 0; i < 3; ++i) {
    Vec3 on_x = div * motion.p[i] - mass / 12 * (F_dot * (state.V[i] + V_sum));
    for (int j = 0; j < 3; ++j) on_x += g.row(i).dot(state.V[j]) * motion.p[j];
    C.segment<3>(3 * i) = on_x;
    C.segment<2>(9 + 2 * i) =
        -F.transpose() * on_x - F_dot.transpose() * motion.p[i] - motion.kinetic_energy * g.row(i).transpose();
  }
  return C;
}

Eigen::Matrix<double, 3, 15> eol_jacobian(const std::array<Vec2, 3>& X, const std::array<Vec3, 3>& x,
                                          const Vec3& alpha) {
  const Mat32 F = deformation_gradient(X, x);
  Eigen::Matrix<double, 3, 15> J;
  for (int i = 0; i < 3; ++i) {
    J.block<3, 3>(0, 3 * i) = alpha[i] * Mat3::Identity();
    J.block<3, 2>(0, 9 + 2 * i) = -alpha[i] * F;
  }
  return J;
}

}  // namespace crease
