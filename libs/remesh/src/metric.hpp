// SPDX-License-Identifier: MIT
#pragma once

#include <algorithm>
#include <cmath>
#include <span>

#include "crease/base/types.hpp"

// Symmetric positive semidefinite 2x2 tensors as metrics of the material plane: e^T M e <= 1 says that the edge e is
// short enough; eigenvalues are 1/length^2.
namespace crease {

/// M = [radius + centre.x, centre.y; centre.y, radius - centre.x]: a disk in the plane of trace-free tensors. The
/// eigenvalues are radius +- |centre|, and M is not below N (Loewner order) exactly when its disk encloses that of N,
/// so everything that is asked of a metric has a closed form without eigenvectors.
struct Tensor {
  Vec2 centre = Vec2::Zero();
  double radius = 0;

  double large() const { return radius + centre.norm(); }
  double small() const { return radius - centre.norm(); }
  double determinant() const { return radius * radius - centre.squaredNorm(); }
  /// e^T M e
  double along(const Vec2& e) const {
    return radius * e.squaredNorm() + centre.x() * (e.x() * e.x() - e.y() * e.y()) + 2 * centre.y() * e.x() * e.y();
  }
  /// p^T M q
  double product(const Vec2& p, const Vec2& q) const {
    return radius * p.dot(q) + centre.x() * (p.x() * q.x() - p.y() * q.y()) +
           centre.y() * (p.x() * q.y() + p.y() * q.x());
  }
  Mat2 matrix() const { return Mat2{{radius + centre.x(), centre.y()}, {centre.y(), radius - centre.x()}}; }

  static Tensor isotropic(double value) { return {Vec2::Zero(), value}; }
  /// a a^T + ... over the rows of [first second]: G^T G of a 3x2 matrix.
  static Tensor gram(const Mat32& G) {
    const double xx = G.col(0).squaredNorm(), yy = G.col(1).squaredNorm();
    return {{0.5 * (xx - yy), G.col(0).dot(G.col(1))}, 0.5 * (xx + yy)};
  }
};

inline Tensor operator+(const Tensor& a, const Tensor& b) {
  return {a.centre + b.centre, a.radius + b.radius};
}
inline Tensor operator-(const Tensor& a, const Tensor& b) {
  return {a.centre - b.centre, a.radius - b.radius};
}
inline Tensor operator*(double s, const Tensor& a) {
  return {s * a.centre, s * a.radius};
}
inline Tensor square(const Tensor& a) {
  return {2 * a.radius * a.centre, a.radius * a.radius + a.centre.squaredNorm()};
}

/// The tensor with the eigenvectors of `M` and the given eigenvalues, `large` to the larger one.
inline Tensor with_eigenvalues(const Tensor& M, double large, double small) {
  const double length = M.centre.norm();
  return {length > 0 ? Vec2(M.centre * (0.5 * (large - small) / length)) : Vec2::Zero(), 0.5 * (large + small)};
}

/// f applied to the eigenvalues.
template <typename Function>
Tensor map_eigenvalues(const Tensor& M, Function f) {
  return with_eigenvalues(M, f(M.large()), f(M.small()));
}

/// Whether M is not below N.
inline bool encloses(const Tensor& M, const Tensor& N) {
  const double slack = M.radius - N.radius;
  return slack >= 0 && (M.centre - N.centre).squaredNorm() <= slack * slack;
}

/// The tensor of least trace that is not below any of the given ones: the smallest disk that encloses the disks. Where
/// rounding leaves no candidate that encloses all, their sum.
/// @pre at most 8 tensors, positive semidefinite
Tensor tensor_max(std::span<const Tensor> tensors);
Tensor tensor_max(const Tensor& a, const Tensor& b);

inline double cross2(const Vec2& a, const Vec2& b) {
  return a.x() * b.y() - a.y() * b.x();
}

/// Squared length of the material vector e in the mean of two metrics.
inline double squared_metric_length(const Vec2& e, const Tensor& a, const Tensor& b) {
  return std::max(0.0, 0.5 * (a + b).along(e));
}

/// Of two angles, one of which is obtuse: see opposite_angle_sine.
double obtuse_angle_sine(const Vec2& ba, const Vec2& bc, const Vec2& da, const Vec2& dc, double cosine_b,
                         double cosine_d, const Tensor& M);

/// Sine of the sum of the two angles that face the edge ac in the quadrilateral abcd (b right, d left of a -> c or the
/// other way), measured in M. Negative: the edge is not Delaunay, and bd is the better diagonal. Positive values are
/// exact only where an angle is obtuse: with neither the sum is below 180 degrees, which is all that is asked.
///                                                                                                [BOSSEN-HECKBERT96]
inline double opposite_angle_sine(const Vec2& a, const Vec2& b, const Vec2& c, const Vec2& d, const Tensor& M) {
  const Vec2 ba = a - b, bc = c - b, da = a - d, dc = c - d;
  const double cosine_b = M.product(ba, bc), cosine_d = M.product(da, dc);  // times the two lengths
  return cosine_b >= 0 && cosine_d >= 0 ? 1 : obtuse_angle_sine(ba, bc, da, dc, cosine_b, cosine_d, M);
}

}  // namespace crease
