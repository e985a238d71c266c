// SPDX-License-Identifier: MIT
#include "momentum.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>

#include <Eigen/Cholesky>
#include <Eigen/Geometry>
#include <Eigen/LU>

#include "metric.hpp"
#include "transfer.hpp"

namespace crease {

namespace {

using Vec6 = Eigen::Matrix<double, 6, 1>;
using Mat6 = Eigen::Matrix<double, 6, 6>;
using MatN3 = Eigen::Matrix<double, Eigen::Dynamic, 3>;

// Below this ratio of the smallest to the largest pivot, with lengths measured in patch radii, the vertices are as good
// as in one line: a rotation about it would have to be fast to carry anything.
constexpr double least_pivot_ratio = 1e-3;
// An energy is not above another if by less than this share: rounding of sums over a patch.
constexpr double energy_rounding = 1e-14;

void sort_unique(std::vector<int>& ids) {
  std::sort(ids.begin(), ids.end());
  ids.erase(std::unique(ids.begin(), ids.end()), ids.end());
}

std::vector<int> with_neighbours(const Mesh& mesh, const std::vector<int>& vertices) {
  std::vector<int> grown = vertices;
  for (const int v : vertices)
    for (const int u : mesh.neighbours(v)) grown.push_back(u);
  sort_unique(grown);
  return grown;
}

std::array<Vec3, 3> seen_velocities(const Cloth& cloth, int face, const Frame& frame) {
  std::array<Vec3, 3> w = corner_velocities(cloth, face);
  for (Vec3& at_corner : w) at_corner -= frame.velocity;
  return w;
}

// What is asked of a change of velocities: momenta, and how much energy it may add.
struct Debt {
  Vec3 linear, angular;
  double energy;
};

// Changes d_i of the velocities of n vertices. A field of them carries the momenta C d = (sum a_i d_i, sum y_i x d_i)
// and adds the energy d.M d / 2 + d.p; M is the mass matrix of their hat functions, p_i the momentum that each hat sees
// now, a_i and y_i the hats' area and first moment. Lengths in y are measured in patch radii R.
class Payers {
 public:
  /// @param vertices  sorted
  Payers(const Cloth& cloth, std::vector<int> vertices, const Frame& frame);

  /// Whether both momenta can be given: the vertices are not in one line.
  bool carry_spin() const { return n() > 0 && std::abs(lu_.matrixLU()(5, 5)) > least_pivot_ratio * lu_.maxPivot(); }
  int n() const { return static_cast<int>(vertices_.size()); }

  /// The least change that carries both momenta, if its energy is not above the debt's, or else as much of it as is;
  /// nothing if no change can do it.
  std::optional<MatN3> settle(const Debt& debt) const;
  /// Linear momentum, and as much of the angular one as the debt's energy allows; nothing if already the linear one
  /// asks for more, as it may next to vertices that are held.
  std::optional<MatN3> settle_linear(const Debt& debt) const;
  /// As much of the linear momentum as the debt's energy allows.
  MatN3 settle_in_part(const Debt& debt) const;
  void apply(const MatN3& change, Cloth& cloth) const {
    for (int i = 0; i < n(); ++i) cloth.v[vertices_[i]] += change.row(i).transpose();
  }

 private:
  double energy(const MatN3& d) const { return 0.5 * d.cwiseProduct(M_ * d).sum() + d.cwiseProduct(p_).sum(); }
  Vec6 carried(const MatN3& d) const;
  MatN3 push(const Vec6& multipliers) const;  // M^-1 C^T multipliers
  MatN3 push_linear(const Vec3& momentum) const { return Z_.col(0) * (momentum / a_.dot(Z_.col(0))).transpose(); }
  Vec6 in_radii(const Debt& debt) const { return (Vec6() << debt.linear, debt.angular / radius_).finished(); }
  // On the way from the least energy to `wanted`, as far as the energy allows. Both carry the same momenta, so that the
  // energy grows with the square of the way.
  MatN3 as_far_as_allowed(const MatN3& least, const MatN3& wanted, double allowed) const;

  std::vector<int> vertices_;
  double radius_ = 0, rounding_ = 0;
  MatX M_;
  VecX a_;
  MatN3 y_, p_;
  Eigen::Matrix<double, Eigen::Dynamic, 7> Z_;  // M^-1 [a y p]
  Eigen::FullPivLU<Mat6> lu_;                   // of C M^-1 C^T
};

Payers::Payers(const Cloth& cloth, std::vector<int> vertices, const Frame& frame)
    : vertices_(std::move(vertices)), M_(MatX::Zero(n(), n())), a_(VecX::Zero(n())), y_(MatN3::Zero(n(), 3)), p_(y_) {
  if (n() == 0) return;
  const Mesh& mesh = cloth.mesh;
  std::vector<int> faces;
  for (const int v : vertices_) {
    radius_ = std::max(radius_, (mesh.x[v] - frame.origin).norm());
    for (const int h : mesh.outgoing(v)) faces.push_back(Mesh::face_of(h));
  }
  sort_unique(faces);
  if (!(radius_ > 0)) radius_ = 1;
  for (const int f : faces) {
    const std::array<Vec3, 3> w = seen_velocities(cloth, f, frame);
    const std::array<int, 3>& corners = mesh.face(f);
    const double share = mesh.material_area(f) / 12;
    const Vec3 x_sum = mesh.x[corners[0]] + mesh.x[corners[1]] + mesh.x[corners[2]] - 4 * frame.origin;
    const Vec3 w_sum = w[0] + w[1] + w[2];
    std::array<int, 3> place;
    for (std::size_t k = 0; k < 3; ++k) {
      const auto found = std::lower_bound(vertices_.begin(), vertices_.end(), corners[k]);
      place[k] = found != vertices_.end() && *found == corners[k] ? static_cast<int>(found - vertices_.begin()) : -1;
    }
    for (std::size_t k = 0; k < 3; ++k) {
      if (place[k] < 0) continue;
      a_[place[k]] += 4 * share;
      y_.row(place[k]) += share / radius_ * (x_sum + mesh.x[corners[k]]);
      p_.row(place[k]) += share * (w_sum + w[k]);
      for (std::size_t j = 0; j < 3; ++j)
        if (place[j] >= 0) M_(place[k], place[j]) += j == k ? 2 * share : share;
    }
    rounding_ += energy_rounding * share * (w_sum.squaredNorm() + w[0].squaredNorm() + w[1].squaredNorm());
  }
  MatX right(n(), 7);
  right << a_, y_, p_;
  Z_ = M_.llt().solve(right);
  const Vec3 ay = y_.transpose() * Z_.col(0);
  const Mat3 yy = y_.transpose() * Z_.middleCols<3>(1);
  Mat6 S;
  S << a_.dot(Z_.col(0)) * Mat3::Identity(), -cross_matrix(ay), cross_matrix(ay), yy.trace() * Mat3::Identity() - yy;
  lu_.compute(S);
}

Vec6 Payers::carried(const MatN3& d) const {
  Vec6 sum;
  sum << d.transpose() * a_, Vec3::Zero();
  for (int i = 0; i < n(); ++i) sum.tail<3>() += Vec3(y_.row(i)).cross(Vec3(d.row(i)));
  return sum;
}

MatN3 Payers::push(const Vec6& multipliers) const {
  return Z_.col(0) * multipliers.head<3>().transpose() +
         Z_.middleCols<3>(1) * cross_matrix(multipliers.tail<3>()).transpose();
}

MatN3 Payers::as_far_as_allowed(const MatN3& least, const MatN3& wanted, double allowed) const {
  const double floor = energy(least), ceiling = energy(wanted);
  allowed += rounding_;  // so that the result does not jump where rounding decides whether there is anything to do
  if (ceiling <= allowed) return wanted;
  const double way = std::sqrt(std::max(0.0, allowed - floor) / (ceiling - floor));
  return least + std::min(1.0, way) * (wanted - least);
}

std::optional<MatN3> Payers::settle(const Debt& debt) const {
  const Vec6 owed = in_radii(debt);
  const MatN3 wanted = push(lu_.solve(owed));
  if (energy(wanted) <= debt.energy + rounding_) return wanted;
  const MatN3 rest = Z_.rightCols<3>();
  const MatN3 least = push(lu_.solve(owed + carried(rest))) - rest;
  if (energy(least) > debt.energy + rounding_) return std::nullopt;
  return as_far_as_allowed(least, wanted, debt.energy);
}

std::optional<MatN3> Payers::settle_linear(const Debt& debt) const {
  const MatN3 rest = Z_.rightCols<3>();
  const MatN3 least = push_linear(debt.linear + rest.transpose() * a_) - rest;
  if (energy(least) > debt.energy + rounding_) return std::nullopt;
  MatN3 wanted = push_linear(debt.linear);
  if (carry_spin()) wanted = push(lu_.solve(in_radii(debt) + carried(rest))) - rest;
  return as_far_as_allowed(least, wanted, debt.energy);
}

MatN3 Payers::settle_in_part(const Debt& debt) const {
  const MatN3 rest = Z_.rightCols<3>();
  return as_far_as_allowed(-rest, push_linear(debt.linear + rest.transpose() * a_) - rest, debt.energy);
}

// With X = sum x_i and W = sum w_i over the corners, a face adds the integrals A W / 3, A (X x W + sum x_i x w_i) / 12
// and A (|W|^2 + sum |w_i|^2) / 24.
template <typename FaceAt>
Account sum_over(int n, FaceAt face_at, const Cloth& cloth, const Frame& frame) {
  const Mesh& mesh = cloth.mesh;
  Account sum;
  for (int place = 0; place < n; ++place) {
    const int f = face_at(place);
    if (!mesh.face_live(f)) continue;
    const auto& [i, j, k] = mesh.face(f);
    const double area = 0.5 * cross2(mesh.X[j] - mesh.X[i], mesh.X[k] - mesh.X[i]), twelfth = area / 12;
    Vec3 w0 = cloth.v[i], w1 = cloth.v[j], w2 = cloth.v[k];
    if (cloth.is_eol(i) || cloth.is_eol(j) || cloth.is_eol(k)) {
      const std::array<Vec3, 3> w = corner_velocities(cloth, f);
      w0 = w[0], w1 = w[1], w2 = w[2];
    }
    w0 -= frame.velocity, w1 -= frame.velocity, w2 -= frame.velocity;
    const Vec3 x0 = mesh.x[i] - frame.origin, x1 = mesh.x[j] - frame.origin, x2 = mesh.x[k] - frame.origin;
    const Vec3 x = x0 + x1 + x2, w = w0 + w1 + w2;
    sum.area += area;
    sum.moment += 4 * twelfth * x;
    sum.linear += 4 * twelfth * w;
    sum.angular += twelfth * (x.cross(w) + x0.cross(w0) + x1.cross(w1) + x2.cross(w2));
    sum.kinetic += 0.5 * twelfth * (w.squaredNorm() + w0.squaredNorm() + w1.squaredNorm() + w2.squaredNorm());
  }
  return sum;
}

Debt debt_of(const Account& before, const Account& after) {
  return {before.linear - after.linear, before.angular - after.angular, before.kinetic - after.kinetic};
}

/// Those whose velocity may be changed.
std::vector<int> free_ones(const Cloth& cloth, std::vector<int> vertices) {
  std::erase_if(vertices, [&](int v) { return cloth.is_eol(v) || cloth.pins[v] != 0 || cloth.mesh.is_tied(v); });
  return vertices;
}

}  // namespace

Account& Account::operator+=(const Account& more) {
  area += more.area;
  moment += more.moment;
  linear += more.linear;
  angular += more.angular;
  kinetic += more.kinetic;
  return *this;
}

Account account(const Cloth& cloth, std::span<const int> faces, const Frame& frame) {
  const auto face_at = [&](int i) { return faces[static_cast<std::size_t>(i)]; };
  return sum_over(static_cast<int>(faces.size()), face_at, cloth, frame);
}

// Seen from a vertex, so that a cloth far away or in fast flight loses no digits; then from the centre of mass.
Motion motion(const Cloth& cloth) {
  const int n = cloth.mesh.face_slots();
  int first = 0;
  while (first < n && !cloth.mesh.face_live(first)) ++first;
  if (first == n) return {};
  const int some = cloth.mesh.face(first)[0];
  const Frame frame{cloth.mesh.x[some], cloth.v[some]};
  const Account seen = sum_over(
      n, [](int f) { return f; }, cloth, frame);
  Motion result;
  result.area = seen.area;
  result.centre = frame.origin + seen.moment / seen.area;
  result.linear = seen.linear + seen.area * frame.velocity;
  result.angular = seen.angular - seen.moment.cross(seen.linear) / seen.area;
  result.kinetic = seen.kinetic + frame.velocity.dot(seen.linear) + 0.5 * seen.area * frame.velocity.squaredNorm();
  return result;
}

bool settle(Cloth& cloth, const Account& before, const Account& after, const Frame& frame, std::vector<int> patch,
            int rings) {
  const Debt debt = debt_of(before, after);
  // What is only rounding is left alone: paying it back would only add to it.
  const double linear_rounding = 64 * std::numeric_limits<double>::epsilon() *
                                 std::sqrt(2 * std::max(before.kinetic, after.kinetic) * before.area);
  if (debt.linear.norm() <= linear_rounding && debt.angular.norm() <= linear_rounding * std::sqrt(before.area) &&
      -debt.energy <= energy_rounding * before.kinetic)
    return true;
  sort_unique(patch);
  for (int ring = 0; ring <= rings; ++ring) {
    if (ring > 0) patch = with_neighbours(cloth.mesh, patch);
    const Payers payers(cloth, free_ones(cloth, patch), frame);
    if (!payers.carry_spin()) continue;
    const std::optional<MatN3> change = payers.settle(debt);
    if (!change) continue;
    payers.apply(*change, cloth);
    return true;
  }
  return false;
}

void settle_in_part(Cloth& cloth, const Account& before, const Account& after, const Frame& frame,
                    std::vector<int> patch) {
  sort_unique(patch);
  for (int ring = 0; ring < paying_rings; ++ring) patch = with_neighbours(cloth.mesh, patch);
  const Payers payers(cloth, free_ones(cloth, std::move(patch)), frame);
  if (payers.n() == 0) return;
  const Debt debt = debt_of(before, after);
  const std::optional<MatN3> change = payers.settle_linear(debt);
  payers.apply(change ? *change : payers.settle_in_part(debt), cloth);
}

}  // namespace crease
