// SPDX-License-Identifier: MIT
#include "crease/geometry/triangle.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include <Eigen/Geometry>

#include "crease/base/require.hpp"

namespace crease {
namespace {

/// A number held as an unevaluated sum of non-overlapping doubles, smallest first (Shewchuk's expansion).
class Expansion {
 public:
  void add_product(double a, double b) {
    const double product = a * b;
    add(std::fma(a, b, -product));
    add(product);
  }
  /// The nearest-but-a-few-ulps double; its sign is that of the exact value.
  double value() const {
    double sum = 0;
    for (int i = 0; i < size_; ++i) sum += terms_[i];
    return sum;
  }

 private:
  void add(double b) {
    double carry = b;
    int kept = 0;
    for (int i = 0; i < size_; ++i) {
      const double sum = carry + terms_[i];
      const double part = sum - carry;
      const double error = (carry - (sum - part)) + (terms_[i] - part);
      if (error != 0) terms_[kept++] = error;
      carry = sum;
    }
    if (carry != 0) terms_[kept++] = carry;
    size_ = kept;
  }

  std::array<double, 12> terms_{};
  int size_ = 0;
};

/// a x b + b x c + c x a, without a rounding error as long as no product underflows.
double exact_orient2d(const Vec2& a, const Vec2& b, const Vec2& c) {
  Expansion sum;
  sum.add_product(a.x(), b.y());
  sum.add_product(-a.y(), b.x());
  sum.add_product(b.x(), c.y());
  sum.add_product(-b.y(), c.x());
  sum.add_product(c.x(), a.y());
  sum.add_product(-c.y(), a.x());
  return sum.value();
}

/// Edge opposite to each corner, counter-clockwise.
std::array<Vec2, 3> sides(const std::array<Vec2, 3>& X) {
  return {X[2] - X[1], X[0] - X[2], X[1] - X[0]};
}

}  // namespace

double orient2d(const Vec2& a, const Vec2& b, const Vec2& c) {
  const double left = (a.x() - c.x()) * (b.y() - c.y());
  const double right = (a.y() - c.y()) * (b.x() - c.x());
  const double determinant = left - right;
  constexpr double unit = std::numeric_limits<double>::epsilon() / 2;
  constexpr double bound = (3 + 16 * unit) * unit;  // Shewchuk's "A" bound on the rounded determinant
  if (std::abs(determinant) > bound * (std::abs(left) + std::abs(right))) return determinant;
  if (!a.allFinite() || !b.allFinite() || !c.allFinite()) return std::numeric_limits<double>::quiet_NaN();
  return exact_orient2d(a, b, c);
}

Mat32 deformation_gradient(const std::array<Vec2, 3>& X, const std::array<Vec3, 3>& x) {
  // Differences with respect to corner 0: a translation of the world then drops out before the division by the area.
  const Mat32 g = barycentric_gradients(X);
  return (x[1] - x[0]) * g.row(1) + (x[2] - x[0]) * g.row(2);
}

Mat32 deformation_gradient(const Mesh& mesh, int face) {
  return deformation_gradient(material_corners(mesh, face), world_corners(mesh, face));
}

Mat32 barycentric_gradients(const std::array<Vec2, 3>& X) {
  const double doubled_area = orient2d(X[0], X[1], X[2]);
  CREASE_ASSERT(doubled_area > 0);
  Mat32 g;
  const auto side = sides(X);
  for (int i = 0; i < 3; ++i) g.row(i) << -side[i].y() / doubled_area, side[i].x() / doubled_area;
  return g;
}

Vec3 barycentric(const std::array<Vec2, 3>& X, const Vec2& P) {
  const Vec3 parts(orient2d(P, X[1], X[2]), orient2d(X[0], P, X[2]), orient2d(X[0], X[1], P));
  return parts / orient2d(X[0], X[1], X[2]);
}

Mat32 vertex_deformation_gradient(const Mesh& mesh, int v) {
  Mat32 sum = Mat32::Zero();
  double total = 0;
  for (const int h : mesh.outgoing(v)) {
    const int f = Mesh::face_of(h);
    const double area = mesh.material_area(f);
    sum += area * deformation_gradient(mesh, f);
    total += area;
  }
  return sum / total;
}

std::array<Vec2, 3> material_corners(const Mesh& mesh, int face) {
  const auto& f = mesh.face(face);
  return {mesh.X[f[0]], mesh.X[f[1]], mesh.X[f[2]]};
}

std::array<Vec3, 3> world_corners(const Mesh& mesh, int face) {
  const auto& f = mesh.face(face);
  return {mesh.x[f[0]], mesh.x[f[1]], mesh.x[f[2]]};
}

Vec3 face_normal(const Mesh& mesh, int face) {
  const auto x = world_corners(mesh, face);
  const Vec3 a = x[1] - x[0], b = x[2] - x[0];
  const Vec3 n = a.cross(b);
  // Below this ratio of altitude to edge the direction of n is rounding noise.
  constexpr double degenerate = 1e-13;
  const double length = n.norm();
  if (!(length > degenerate * std::max(a.squaredNorm(), b.squaredNorm()))) return Vec3::Zero();
  return n / length;
}

double smallest_altitude(const std::array<Vec2, 3>& X) {
  double longest = 0;
  for (const Vec2& side : sides(X)) longest = std::max(longest, side.norm());
  return longest > 0 ? std::abs(orient2d(X[0], X[1], X[2])) / longest : 0.0;
}

double smallest_angle(const std::array<Vec2, 3>& X) {
  const auto side = sides(X);
  const double doubled_area = std::abs(orient2d(X[0], X[1], X[2]));
  double smallest = std::numeric_limits<double>::infinity();
  for (int i = 0; i < 3; ++i) {
    // atan2 keeps its precision for needles, where acos of a dot product loses half of it.
    smallest = std::min(smallest, std::atan2(doubled_area, -side[(i + 1) % 3].dot(side[(i + 2) % 3])));
  }
  return smallest;
}

}  // namespace crease
