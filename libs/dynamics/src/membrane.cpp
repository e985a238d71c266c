// SPDX-License-Identifier: MIT
#include "crease/dynamics/membrane.hpp"

#include <algorithm>
#include <cmath>

#include <Eigen/Geometry>

#include "crease/base/require.hpp"
#include "crease/geometry/triangle.hpp"
#include "element.hpp"

namespace crease {

namespace {

// Below this stretch the direction u_i is rounding noise and any orthogonal one serves.
constexpr double directionless_stretch = 1e-12;  // [1]
// The out-of-plane stiffness psi_i/s_i grows without bound as s_i -> 0 under a large cross stretch (above 1/nu); it is
// cut here, a thousand times the material's own stiffness, so that the system stays solvable.
constexpr double collapsed_stretch = 1e-3;  // [1]
// Products of stretches below which their squares are no numbers to rely on. What is smaller is orthogonal as it is,
// or has no direction anyhow.
constexpr double undirected = 1e-150;  // [1]

// F = s_1 u_1 v_1^T + s_2 u_2 v_2^T, s_1 >= s_2 >= 0, n = u_1 x u_2.
struct Svd32 {
  double s1, s2;
  Vec3 u1, u2, n;
  Vec2 v1, v2;
};

// Any unit vector orthogonal to the unit vector a.
Vec3 orthogonal_unit(const Vec3& a) {
  Eigen::Index smallest = 0;
  a.cwiseAbs().minCoeff(&smallest);
  return a.cross(Vec3::Unit(smallest)).normalized();
}

// Cosine and sine of half the angle of (q, p), taken in [-pi/2, pi/2]; of 0 where rounding decides the angle.
std::array<double, 2> half_angle(double p, double q) {
  const double r = std::sqrt(p * p + q * q);
  if (!(r > undirected)) return {1, 0};
  if (q >= 0) {
    const double c = std::sqrt(0.5 * (1 + q / r));
    return {c, 0.5 * p / (r * c)};
  }
  const double s = std::copysign(std::sqrt(0.5 * (1 - q / r)), p);
  return {0.5 * p / (r * s), s};
}

// One Jacobi rotation from the right makes the columns orthogonal; unlike the eigenvalues of F^T F it keeps the full
// relative accuracy of the smaller stretch.
Svd32 singular_values(const Mat32& F) {
  const Vec3 a = F.col(0), b = F.col(1);
  const auto [c, s] = half_angle(2 * a.dot(b), a.squaredNorm() - b.squaredNorm());
  Svd32 svd;
  svd.v1 = Vec2(c, s);
  svd.v2 = Vec2(-s, c);
  const Vec3 long_axis = c * a + s * b;
  svd.s1 = long_axis.norm();
  svd.u1 = svd.s1 > directionless_stretch ? Vec3(long_axis * (1 / svd.s1)) : Vec3::UnitX();
  Vec3 short_axis = c * b - s * a;
  short_axis -= svd.u1.dot(short_axis) * svd.u1;
  svd.s2 = short_axis.norm();
  svd.u2 = svd.s2 > directionless_stretch ? Vec3(short_axis * (1 / svd.s2)) : orthogonal_unit(svd.u1);
  svd.n = svd.u1.cross(svd.u2);
  return svd;
}

// The eigenvalues of d^2 psi/dF^2 outside the stretch block, negative ones set to zero. The stretch block
// [psi_ij] = 2 mu I + lambda 1 1^T is positive definite for every F and needs no care.
struct ModeStiffness {
  double twist;       // u_1 v_2^T - u_2 v_1^T:  (psi_1 + psi_2)/(s_1 + s_2)
  double flip;        // u_1 v_2^T + u_2 v_1^T:  (psi_1 - psi_2)/(s_1 - s_2) = 2 mu
  double out1, out2;  // n v_i^T:               psi_i/s_i
};

ModeStiffness mode_stiffness(const Svd32& svd, double mu, double psi1, double psi2) {
  const auto ratio = [](double stress, double stretch) {
    return std::max(0.0, stress) / std::max(stretch, collapsed_stretch);
  };
  return {ratio(psi1 + psi2, svd.s1 + svd.s2), 2 * mu, ratio(psi1, svd.s1), ratio(psi2, svd.s2)};
}

// K_ij = A Q L_ij Q^T: L_ij is the sum of the modes in the frame Q = (u_1, u_2, n), for which
// dF = u v^T moves F along mode (u, v) and vertex i enters by g_i . v. A translation meets no force, so the blocks of
// vertices 1 and 2 decide those of vertex 0.
void fill_stiffness(const Svd32& svd, const ModeStiffness& k, double mu, double lambda, double area,
                    const Mat32& gradients, Mat9& stiffness) {
  const Vec3 a = gradients * svd.v1, b = gradients * svd.v2;
  const double stretch = 2 * mu + lambda;
  const double shear = 0.5 * (k.flip + k.twist), swap = 0.5 * (k.flip - k.twist);
  Mat3 along = svd.u1 * svd.u1.transpose(), across = svd.u2 * svd.u2.transpose();
  Mat3 out = svd.n * svd.n.transpose(), mixed = svd.u1 * svd.u2.transpose();
  for (Mat3* mode : {&along, &across, &out, &mixed}) *mode *= area;  // afterwards: what is symmetric is so to the bit
  const auto straight = [&](int i, int j) -> Mat3 {                  // symmetric
    return (stretch * a[i] * a[j] + shear * b[i] * b[j]) * along +
           (stretch * b[i] * b[j] + shear * a[i] * a[j]) * across + (k.out1 * a[i] * a[j] + k.out2 * b[i] * b[j]) * out;
  };
  const auto own = [&](int i) -> Mat3 {
    const Mat3 both = mixed + mixed.transpose();
    return straight(i, i) + ((lambda + swap) * a[i] * b[i]) * both;
  };
  const Mat3 K11 = own(1), K22 = own(2);
  const Mat3 K12 = straight(1, 2) + (lambda * a[1] * b[2] + swap * b[1] * a[2]) * mixed +
                   (lambda * b[1] * a[2] + swap * a[1] * b[2]) * mixed.transpose();
  const Mat3 K21 = K12.transpose();
  const Mat3 K01 = -(K11 + K21), K02 = -(K12 + K22), K00 = (K11 + K22) + (K12 + K21);
  stiffness.block<3, 3>(0, 0) = K00;
  stiffness.block<3, 3>(0, 3) = K01;
  stiffness.block<3, 3>(0, 6) = K02;
  stiffness.block<3, 3>(3, 0) = K01.transpose();
  stiffness.block<3, 3>(3, 3) = K11;
  stiffness.block<3, 3>(3, 6) = K12;
  stiffness.block<3, 3>(6, 0) = K02.transpose();
  stiffness.block<3, 3>(6, 3) = K21;
  stiffness.block<3, 3>(6, 6) = K22;
}

struct Moduli {
  double mu, lambda;  // [N/m]
  explicit Moduli(const Material& material)
      : mu(material.youngs / (2 * (1 + material.poisson))),
        lambda(material.youngs * material.poisson / (1 - material.poisson * material.poisson)) {}

  double density(double e1, double e2) const { return mu * (e1 * e1 + e2 * e2) + 0.5 * lambda * (e1 + e2) * (e1 + e2); }
};

}  // namespace

MembraneElement membrane_element(const std::array<Vec2, 3>& X, const std::array<Vec3, 3>& x, const Material& material) {
  const double area = material_area(X);
  CREASE_ASSERT(area > 0);
  const Moduli moduli(material);
  const double mu = moduli.mu, lambda = moduli.lambda;
  const Mat32 gradients = barycentric_gradients(X);
  const Svd32 svd = singular_values(deformation_gradient(X, x));

  const double e1 = svd.s1 - 1, e2 = svd.s2 - 1, trace = e1 + e2;
  const double psi1 = 2 * mu * e1 + lambda * trace, psi2 = 2 * mu * e2 + lambda * trace;
  MembraneElement element;
  element.density = moduli.density(e1, e2);
  element.energy = area * element.density;
  const Mat32 P = psi1 * svd.u1 * svd.v1.transpose() + psi2 * svd.u2 * svd.v2.transpose();
  for (int i = 0; i < 3; ++i) element.force.segment<3>(3 * i) = -area * P * gradients.row(i).transpose();
  fill_stiffness(svd, mode_stiffness(svd, mu, psi1, psi2), mu, lambda, area, gradients, element.stiffness);
  return element;
}

double membrane_energy(const std::array<Vec2, 3>& X, const std::array<Vec3, 3>& x, const Material& material) {
  const Svd32 svd = singular_values(deformation_gradient(X, x));
  return material_area(X) * Moduli(material).density(svd.s1 - 1, svd.s2 - 1);
}

}  // namespace crease
