// SPDX-License-Identifier: MIT
#include "metric.hpp"

#include <array>
#include <numeric>
#include <optional>

#include <Eigen/LU>

#include "crease/base/require.hpp"

namespace crease {

namespace {

// Disks may stick out by this much of the larger radius: rounding of the closed forms below.
constexpr double enclosing_tolerance = 1e-9;
constexpr std::size_t max_disks = 8;

using Disk = Tensor;
using DiskSpan = std::span<const Disk>;

bool encloses_all(const Disk& outer, DiskSpan disks) {
  const Disk grown{outer.centre, outer.radius * (1 + enclosing_tolerance)};
  return std::all_of(disks.begin(), disks.end(), [&](const Disk& d) { return encloses(grown, d); });
}

// Smallest disk around two, neither of which holds the other.
std::optional<Disk> around(const Disk& a, const Disk& b) {
  const Vec2 ab = b.centre - a.centre;
  const double distance = ab.norm();
  if (distance <= std::abs(a.radius - b.radius)) return std::nullopt;
  const double radius = 0.5 * (distance + a.radius + b.radius);
  return Disk{a.centre + ab * ((radius - a.radius) / distance), radius};
}

// The disk that three touch from inside (Apollonius). With the origin in a's centre and rho = R - a.radius the
// conditions are |y| = rho and y . d_i = rho s_i + (|d_i|^2 - s_i^2) / 2: y is linear in rho, rho solves a quadratic.
std::optional<Disk> around(const Disk& a, const Disk& b, const Disk& c) {
  const Vec2 d1 = b.centre - a.centre, d2 = c.centre - a.centre;
  const double s1 = b.radius - a.radius, s2 = c.radius - a.radius;
  const double det = cross2(d1, d2);
  // Centres in line: two of the three decide.
  if (std::abs(det) <= 1e-12 * d1.norm() * d2.norm()) return std::nullopt;
  const auto solve = [&](double r1, double r2) {
    return Vec2((r1 * d2.y() - r2 * d1.y()) / det, (r2 * d1.x() - r1 * d2.x()) / det);
  };
  const Vec2 u = solve(s1, s2);
  const Vec2 w = solve(0.5 * (d1.squaredNorm() - s1 * s1), 0.5 * (d2.squaredNorm() - s2 * s2));
  const double qa = u.squaredNorm() - 1, qb = u.dot(w), qc = w.squaredNorm();
  const double discriminant = qb * qb - qa * qc;
  if (discriminant < 0) return std::nullopt;
  const double q = -(qb + std::copysign(std::sqrt(discriminant), qb));
  const std::array<double, 2> roots{qa != 0 ? q / qa : -1, q != 0 ? qc / q : -1};
  std::optional<Disk> best;
  for (const double rho : roots) {
    if (rho < std::max({0.0, s1, s2}) || (best && rho + a.radius >= best->radius)) continue;
    best = Disk{a.centre + u * rho + w, a.radius + rho};
  }
  return best;
}

void keep_smaller(std::optional<Disk>& best, const std::optional<Disk>& candidate, DiskSpan disks) {
  if (!candidate || (best && candidate->radius >= best->radius)) return;
  if (encloses_all(*candidate, disks)) best = candidate;
}

// Tries all of at most 8 + 28 + 56 candidates: no branching on nearly equal numbers, so nothing to go wrong.
std::optional<Disk> smallest_enclosing(DiskSpan disks) {
  std::optional<Disk> best;
  const std::size_t n = disks.size();
  for (std::size_t i = 0; i < n; ++i) keep_smaller(best, disks[i], disks);
  if (best) return best;
  for (std::size_t i = 0; i < n; ++i)
    for (std::size_t j = i + 1; j < n; ++j) keep_smaller(best, around(disks[i], disks[j]), disks);
  if (best) return best;
  for (std::size_t i = 0; i < n; ++i)
    for (std::size_t j = i + 1; j < n; ++j)
      for (std::size_t k = j + 1; k < n; ++k) keep_smaller(best, around(disks[i], disks[j], disks[k]), disks);
  return best;
}

}  // namespace

Tensor tensor_max(std::span<const Tensor> tensors) {
  CREASE_ASSERT(tensors.size() <= max_disks);
  std::array<Disk, max_disks> storage{};
  std::size_t n = 0;
  for (const Tensor& M : tensors)
    if (M.radius > 0) storage[n++] = M;
  if (n == 0) return {};
  if (n == 1) return storage[0];
  if (n == 2) return tensor_max(storage[0], storage[1]);
  const DiskSpan disks(storage.data(), n);
  if (const std::optional<Disk> disk = smallest_enclosing(disks)) return *disk;
  return std::accumulate(disks.begin(), disks.end(), Tensor{});
}

Tensor tensor_max(const Tensor& a, const Tensor& b) {
  if (encloses(a, b)) return a;
  if (encloses(b, a)) return b;
  const Vec2 ab = b.centre - a.centre;
  const double distance = ab.norm(), radius = 0.5 * (distance + a.radius + b.radius);
  return {a.centre + ab * ((radius - a.radius) / distance), radius};
}

double obtuse_angle_sine(const Vec2& ba, const Vec2& bc, const Vec2& da, const Vec2& dc, double cosine_b,
                         double cosine_d, const Tensor& M) {
  const double stretch = std::sqrt(std::max(0.0, M.determinant()));
  const double sine_b = stretch * std::abs(cross2(ba, bc)), sine_d = stretch * std::abs(cross2(da, dc));
  const double scale2 = (cosine_b * cosine_b + sine_b * sine_b) * (cosine_d * cosine_d + sine_d * sine_d);
  return scale2 > 0 ? (sine_b * cosine_d + cosine_b * sine_d) / std::sqrt(scale2) : 0;
}

}  // namespace crease
