// SPDX-License-Identifier: MIT
#pragma once

#include <algorithm>
#include <cmath>
#include <span>

#include "crease/base/types.hpp"

// Symmetric positive semidefinite 2x2 tensors as metrics of the material plane: e^T M e <= 1 says that the edge e is
// short enough; eigenvalues are 1/length^2.
namespace crease {

/// Eigenvalues of a symmetric 2x2 tensor and the unit eigenvector of the larger one, in closed form.
struct Spectrum {
  double large, small;
  Vec2 axis;
};
Spectrum spectrum(const Mat2& M);

/// The tensor with the eigenvectors of `s` and the given eigenvalues.
Mat2 with_eigenvalues(const Spectrum& s, double large, double small);

/// f applied to the eigenvalues of a symmetric tensor.
template <typename Function>
Mat2 map_eigenvalues(const Mat2& M, Function f) {
  const Spectrum s = spectrum(M);
  return with_eigenvalues(s, f(s.large), f(s.small));
}

/// The tensor of least trace that is not below any of the given ones (Loewner order). A tensor is a disk of centre
/// ((M11 - M22)/2, M12) and radius trace/2, and "not below" is "encloses", so this is the smallest enclosing disk of
/// disks; where rounding leaves no candidate that encloses all, their sum.
/// @pre at most 8 tensors, positive semidefinite
Mat2 tensor_max(std::span<const Mat2> tensors);

inline double cross2(const Vec2& a, const Vec2& b) {
  return a.x() * b.y() - a.y() * b.x();
}

/// Length of the material vector e in the mean of two metrics.
inline double metric_length(const Vec2& e, const Mat2& Ma, const Mat2& Mb) {
  return std::sqrt(std::max(0.0, 0.5 * (e.dot(Ma * e) + e.dot(Mb * e))));
}

/// Sine of the sum of the two angles that face the edge ac in the quadrilateral abcd (b right, d left of a -> c or the
/// other way), measured in M. Negative: the edge is not Delaunay, and bd is the better diagonal. Positive values are
/// exact only where an angle is obtuse.                                                         [BOSSEN-HECKBERT96]
double opposite_angle_sine(const Vec2& a, const Vec2& b, const Vec2& c, const Vec2& d, const Mat2& M);

}  // namespace crease
