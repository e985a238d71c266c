// SPDX-License-Identifier: MIT
#pragma once

#include <cmath>

namespace crease {

// The elements' formulas, once for a double and once for a register of doubles, each lane of which is an element of its
// own. There are no branches: what a formula cannot use is selected away. No sum is contracted to a fused one, so a
// lane has the bytes of a double, whatever the register. Everything is inlined without exception: a copy compiled with
// the instructions of one processor must never be the one that the linker keeps for all. No other header, and no Eigen.
//
// Real is double, or a vector of GCC's; Axes are plain arrays of them, one for each axis.
#define CREASE_ALWAYS_INLINE [[gnu::always_inline]] inline
#define CREASE_ALWAYS_INLINED __attribute__((always_inline))  // the same of a lambda

// Below this stretch the direction u_i is rounding noise and any orthogonal one serves.
constexpr double directionless_stretch = 1e-12;  // [1]
// The out-of-plane stiffness psi_i/s_i grows without bound as s_i -> 0 under a large cross stretch (above 1/nu); it is
// cut here, a thousand times the material's own stiffness, so that the system stays solvable.
constexpr double collapsed_stretch = 1e-3;  // [1]
// Products of stretches below which their squares are no numbers to rely on. What is smaller is orthogonal as it is,
// or has no direction anyhow.
constexpr double undirected = 1e-150;  // [1]

CREASE_ALWAYS_INLINE double root(double a) {
  return std::sqrt(a);
}

template <class Real>
CREASE_ALWAYS_INLINE Real root(Real a) {
  Real result;
  for (unsigned lane = 0; lane < sizeof(Real) / sizeof(double); ++lane) result[lane] = __builtin_sqrt(a[lane]);
  return result;
}

template <class Real>
CREASE_ALWAYS_INLINE Real larger(Real a, Real b) {
  return a > b ? a : b;
}

template <class Real>
struct Axes {
  Real c[3];

  CREASE_ALWAYS_INLINE Real operator[](int i) const { return c[i]; }
};

template <class Real>
CREASE_ALWAYS_INLINE Axes<Real> operator+(const Axes<Real>& a, const Axes<Real>& b) {
  return {{a[0] + b[0], a[1] + b[1], a[2] + b[2]}};
}

template <class Real>
CREASE_ALWAYS_INLINE Axes<Real> operator-(const Axes<Real>& a, const Axes<Real>& b) {
  return {{a[0] - b[0], a[1] - b[1], a[2] - b[2]}};
}

template <class Real>
CREASE_ALWAYS_INLINE Axes<Real> operator*(Real s, const Axes<Real>& a) {
  return {{s * a[0], s * a[1], s * a[2]}};
}

template <class Real>
CREASE_ALWAYS_INLINE Real dot(const Axes<Real>& a, const Axes<Real>& b) {
  return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

template <class Real>
CREASE_ALWAYS_INLINE Axes<Real> cross(const Axes<Real>& a, const Axes<Real>& b) {
  return {{a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]}};
}

template <class Condition, class Real>
CREASE_ALWAYS_INLINE Axes<Real> select(Condition condition, const Axes<Real>& a, const Axes<Real>& b) {
  return {{condition ? a[0] : b[0], condition ? a[1] : b[1], condition ? a[2] : b[2]}};
}

// Any unit vector orthogonal to the unit vector a: across its smallest component.
template <class Real>
CREASE_ALWAYS_INLINE Axes<Real> orthogonal_unit(const Axes<Real>& a) {
  const Real zero{}, x = a[0] * a[0], y = a[1] * a[1], z = a[2] * a[2];
  const Axes<Real> across_x{{zero, a[2], -a[1]}}, across_y{{-a[2], zero, a[0]}}, across_z{{a[1], -a[0], zero}};
  const Real smaller = x <= y ? x : y;
  const Axes<Real> other = select(z < smaller, across_z, across_y);
  const Axes<Real> across = select(z < smaller, other, select(x <= y, across_x, across_y));
  return (1 / root(dot(across, across))) * across;
}

/// F = s_1 u_1 v_1^T + s_2 u_2 v_2^T, s_1 >= s_2 >= 0, n = u_1 x u_2.
template <class Real>
struct Stretches {
  Real s1, s2;
  Axes<Real> u1, u2, n;
  Real c, s;  ///< v_1 = (c, s), v_2 = (-s, c)
};

// One Jacobi rotation from the right makes the columns a, b of F orthogonal; unlike the eigenvalues of F^T F it keeps
// the full relative accuracy of the smaller stretch. Its angle, taken in [-pi/2, pi/2], is half that of (q, p), and 0
// where rounding decides it.
template <class Real>
CREASE_ALWAYS_INLINE Stretches<Real> singular_values(const Axes<Real>& a, const Axes<Real>& b) {
  const Real zero{}, one = zero + 1;
  const Real p = 2 * dot(a, b), q = dot(a, a) - dot(b, b), r = root(p * p + q * q);
  const auto directed = r > undirected;
  const Real length = directed ? r : one, acute = q < 0 ? -q : q;
  const Real larger_leg = root(0.5 * (1 + acute / length));
  const Real smaller_leg = 0.5 * p / (length * larger_leg);  // of the sign of p
  const Real c = q < 0 ? (smaller_leg < 0 ? -smaller_leg : smaller_leg) : larger_leg;
  const Real s = q < 0 ? (p < 0 ? -larger_leg : larger_leg) : smaller_leg;
  Stretches<Real> result;
  result.c = directed ? c : one;
  result.s = directed ? s : zero;
  const Axes<Real> long_axis = result.c * a + result.s * b;
  result.s1 = root(dot(long_axis, long_axis));
  const auto has_long = result.s1 > directionless_stretch;
  result.u1 = select(has_long, (1 / (has_long ? result.s1 : one)) * long_axis, Axes<Real>{{one, zero, zero}});
  const Axes<Real> leaning = result.c * b - result.s * a;
  const Axes<Real> short_axis = leaning - dot(result.u1, leaning) * result.u1;
  result.s2 = root(dot(short_axis, short_axis));
  const auto has_short = result.s2 > directionless_stretch;
  result.u2 = select(has_short, (1 / (has_short ? result.s2 : one)) * short_axis, orthogonal_unit(result.u1));
  result.n = cross(result.u1, result.u2);
  return result;
}

struct Moduli {
  double mu, lambda;  ///< [N/m]
};

/// A triangle's membrane; blocks of its stiffness column by column.
template <class Real>
struct MembraneTerms {
  Real density;                 ///< psi [J/m^2]
  Axes<Real> force[3];          ///< [N]
  Real K11[9], K12[9], K22[9];  ///< [N/m]; a translation meets no force, so these decide the rest
};

// K_ij = A Q L_ij Q^T: L_ij is the sum of the modes in the frame Q = (u_1, u_2, n), for which dF = u v^T moves F along
// mode (u, v) and vertex i enters by g_i . v. The eigenvalues of d^2 psi/dF^2 outside the stretch block, negative ones
// set to zero, are
//   twist       u_1 v_2^T - u_2 v_1^T:  (psi_1 + psi_2)/(s_1 + s_2)
//   flip        u_1 v_2^T + u_2 v_1^T:  (psi_1 - psi_2)/(s_1 - s_2) = 2 mu
//   out1, out2  n v_i^T:                psi_i/s_i
// The stretch block [psi_ij] = 2 mu I + lambda 1 1^T is positive definite for every F and needs no care.
//
// g1, g2: gradients of the barycentric coordinates of corners 1 and 2 [1/m]
template <class Real>
CREASE_ALWAYS_INLINE MembraneTerms<Real> membrane_terms(const Moduli& moduli, Real area, const Stretches<Real>& svd,
                                                        const Real (&g1)[2], const Real (&g2)[2]) {
  const double mu = moduli.mu, lambda = moduli.lambda;
  const Real zero{};
  const Real e1 = svd.s1 - 1, e2 = svd.s2 - 1, trace = e1 + e2;
  const Real psi1 = 2 * mu * e1 + lambda * trace, psi2 = 2 * mu * e2 + lambda * trace;
  const Real a[2] = {g1[0] * svd.c + g1[1] * svd.s, g2[0] * svd.c + g2[1] * svd.s};
  const Real b[2] = {g1[1] * svd.c - g1[0] * svd.s, g2[1] * svd.c - g2[0] * svd.s};

  MembraneTerms<Real> result;
  result.density = mu * (e1 * e1 + e2 * e2) + 0.5 * lambda * (trace * trace);
  for (int i = 0; i < 2; ++i) result.force[i + 1] = (-area * psi1 * a[i]) * svd.u1 + (-area * psi2 * b[i]) * svd.u2;
  result.force[0] = Axes<Real>{{zero, zero, zero}} - (result.force[1] + result.force[2]);

  const Real cut1 = larger(svd.s1, zero + collapsed_stretch), cut2 = larger(svd.s2, zero + collapsed_stretch);
  const Real cut12 = larger(svd.s1 + svd.s2, zero + collapsed_stretch);
  const Real twist = larger(psi1 + psi2, zero) / cut12;
  const Real out1 = larger(psi1, zero) / cut1, out2 = larger(psi2, zero) / cut2;
  const double flip = 2 * mu, stretch = 2 * mu + lambda;
  const Real shear = 0.5 * (flip + twist), swap = 0.5 * (flip - twist);
  const auto straight = [&](int i, int j, Real& along, Real& across, Real& out) CREASE_ALWAYS_INLINED {
    const Real aa = area * (a[i] * a[j]), bb = area * (b[i] * b[j]);
    along = stretch * aa + shear * bb;
    across = stretch * bb + shear * aa;
    out = out1 * aa + out2 * bb;
  };
  // u_1 u_1^T and so on, entry (row, col) of each.
  const auto own = [&](int i, Real(&K)[9]) CREASE_ALWAYS_INLINED {
    Real along, across, out;
    straight(i, i, along, across, out);
    const Real mixed = area * ((lambda + swap) * (a[i] * b[i]));
    const Axes<Real> left = along * svd.u1 + mixed * svd.u2, middle = mixed * svd.u1 + across * svd.u2,
                     right = out * svd.n;
    for (int col = 0; col < 3; ++col)
      for (int row = col; row < 3; ++row)
        K[3 * col + row] = K[3 * row + col] =
            svd.u1[row] * left[col] + svd.u2[row] * middle[col] + svd.n[row] * right[col];
  };
  own(0, result.K11);
  own(1, result.K22);
  Real along, across, out;
  straight(0, 1, along, across, out);
  const Real mixed = area * (lambda * (a[0] * b[1]) + swap * (b[0] * a[1]));
  const Real mixed_back = area * (lambda * (b[0] * a[1]) + swap * (a[0] * b[1]));
  const Axes<Real> left = along * svd.u1 + mixed * svd.u2, middle = mixed_back * svd.u1 + across * svd.u2,
                   right = out * svd.n;
  for (int col = 0; col < 3; ++col)
    for (int row = 0; row < 3; ++row)
      result.K12[3 * col + row] = svd.u1[row] * left[col] + svd.u2[row] * middle[col] + svd.n[row] * right[col];
  return result;
}

/// Half of a hinge's curvature: see BendingElement.
template <class Real>
struct HingeTerms {
  Real k[4], c;
};

// Cotangent of the angle between two sides of a triangle of twice the area `double_area`.
template <class Real>
CREASE_ALWAYS_INLINE Real cotangent(const Real (&p)[2], const Real (&q)[2], const Real (&r)[2], Real double_area) {
  return ((q[0] - p[0]) * (r[0] - p[0]) + (q[1] - p[1]) * (r[1] - p[1])) / double_area;
}

template <class Real>
CREASE_ALWAYS_INLINE Real double_area(const Real (&p)[2], const Real (&q)[2], const Real (&r)[2]) {
  return (q[0] - p[0]) * (r[1] - p[1]) - (q[1] - p[1]) * (r[0] - p[0]);
}

/// @param scaled  3 s B, see BendingElement [J]
template <class Real>
CREASE_ALWAYS_INLINE HingeTerms<Real> hinge_terms(double scaled, const Real (&from)[2], const Real (&to)[2],
                                                  const Real (&left)[2], const Real (&right)[2]) {
  const Real double_left = double_area(from, to, left), double_right = double_area(to, from, right);
  const Real from_left = cotangent(from, to, left, double_left), to_left = cotangent(to, left, from, double_left);
  const Real from_right = cotangent(from, right, to, double_right), to_right = cotangent(to, from, right, double_right);
  return {{to_left + to_right, from_left + from_right, -(from_left + to_left), -(from_right + to_right)},
          scaled / (0.5 * (double_left + double_right))};
}

}  // namespace crease
