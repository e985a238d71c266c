// SPDX-License-Identifier: MIT
//
// An inextensible sheet that crosses a sharp edge at an angle, and turns as it does.
//
// Folded along a straight line it is isometric to the plane y = (along the edge, across it; y2 > 0 hangs). While both
// parts stay plane it moves there as a rigid lamina that is pulled where it hangs:
//   m c2" = rho g A,   I psi" = rho g (S1 - c1 A),   A, S1 = area and first moment of what has y2 > 0,
// and the crease runs where y2 = 0 through the material coordinates X = R(-psi) (y - c). (Newton and Euler; the
// stresses are not determined by that, so it ends where the mean tension falls below the momentum flux, about .4 s.)
#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <numbers>
#include <vector>

#include "support/slide_run.hpp"

namespace crease {
namespace {

using namespace crease::testing;

constexpr double g = 9.81, rho = 0.1;

struct Lamina {
  Vec2 size;       ///< [m]
  double psi = 0;  ///< of the material's first axis from the edge [rad]
  Vec2 c = Vec2::Zero(), v = Vec2::Zero();
  double omega = 0;

  Vec2 to_plane(const Vec2& X) const { return c + Eigen::Rotation2Dd(psi) * X; }
  std::array<Vec2, 4> corners() const {
    const Vec2 s = size / 2;
    return {to_plane({-s.x(), -s.y()}), to_plane({s.x(), -s.y()}), to_plane(s), to_plane({-s.x(), s.y()})};
  }
  /// Where the border crosses the edge: coordinates along it, the smaller first.
  std::array<double, 2> crossings() const {
    std::array<double, 2> found{1e9, -1e9};
    const auto p = corners();
    for (int i = 0; i < 4; ++i) {
      const Vec2 a = p[i], b = p[(i + 1) % 4];
      if ((a.y() > 0) == (b.y() > 0)) continue;
      const double y1 = a.x() + a.y() / (a.y() - b.y()) * (b.x() - a.x());
      found = {std::min(found[0], y1), std::max(found[1], y1)};
    }
    return found;
  }
  /// c2", psi".
  Vec2 acceleration() const {
    double area = 0, moment = 0;  // of the hanging part, in triangles around its first corner
    std::vector<Vec2> hanging;
    const auto p = corners();
    for (int i = 0; i < 4; ++i) {
      const Vec2 a = p[i], b = p[(i + 1) % 4];
      if (a.y() > 0) hanging.push_back(a);
      if ((a.y() > 0) != (b.y() > 0)) hanging.push_back(a + a.y() / (a.y() - b.y()) * (b - a));
    }
    for (std::size_t i = 2; i < hanging.size(); ++i) {
      const Vec2 a = hanging[i - 1] - hanging[0], b = hanging[i] - hanging[0];
      const double part = (a.x() * b.y() - a.y() * b.x()) / 2;
      area += part;
      moment += part * (hanging[0].x() + hanging[i - 1].x() + hanging[i].x()) / 3;
    }
    const double mass = size.x() * size.y();
    return {g * area / mass, g * (moment - c.x() * area) / (mass * size.squaredNorm() / 12)};
  }
  void advance(double seconds) {  // leapfrog
    const Vec2 before = acceleration();
    v.y() += seconds / 2 * before.x(), omega += seconds / 2 * before.y();
    c += seconds * v, psi += seconds * omega;
    const Vec2 after = acceleration();
    v.y() += seconds / 2 * after.x(), omega += seconds / 2 * after.y();
  }
};

Vec2 to_material(const Lamina& lamina, double along) {
  return lamina.size / 2 + Eigen::Rotation2Dd(-lamina.psi) * (Vec2(along, 0) - lamina.c);
}

/// The crease's ends in material coordinates.
std::array<Vec2, 2> fold_ends(const Lamina& lamina) {
  const auto [from, to] = lamina.crossings();
  return {to_material(lamina, from), to_material(lamina, to)};
}

/// The lamina as a sheet on a table's edge. Of its grid, of triangles with legs of `element`, a line across the given
/// axis is moved onto the crease, what lies between with it.
Slide folded_sheet(const Lamina& lamina, double element, int axis) {
  GridOptions grid;
  grid.size = {lamina.size.x(), lamina.size.y()};
  grid.cells = {static_cast<int>(std::lround(lamina.size.x() / element)),
                static_cast<int>(std::lround(lamina.size.y() / element))};
  Slide slide;
  slide.cloth = make_cloth(make_grid(grid));
  slide.material = {.density = rho, .youngs = 1e4, .poisson = 0, .bending = 0, .damping = 0};
  slide.element = element;
  slide.g = g;
  slide.obstacles = {strip_table()};
  Mesh& mesh = slide.cloth.mesh;
  const auto [first, last] = fold_ends(lamina);
  const double line = std::round((first + last)[axis] / 2 / element) * element, length = lamina.size[axis];
  std::vector<int> folded;
  for (int i = 0; i < mesh.n_vertices(); ++i) {
    Vec2& X = mesh.X[i];
    const double share = (X[1 - axis] - first[1 - axis]) / (last - first)[1 - axis];
    const double fold = first[axis] + share * (last - first)[axis], s = X[axis];
    if (std::abs(s - line) < 1e-9) folded.push_back(i);
    X[axis] = s < line ? s / line * fold : length - (length - s) / (length - line) * (length - fold);
    const Vec2 y = lamina.to_plane(X - lamina.size / 2);
    mesh.x[i] = Vec3(std::min(y.y(), 0.0), y.x(), -std::max(y.y(), 0.0));
  }
  for (const int v : folded) mesh.x[v] = Vec3(0, mesh.x[v].y(), 0);
  put_on_edge(slide.cloth, folded, 0, strip_edge(strip_table()));
  return slide;
}

struct Errors {
  double ends = 0;   ///< of the crease's ends, in the material [m]
  double turn = 0;   ///< of its direction there [rad]
  double bends = 0;  ///< of EOL vertices from the line [m]
};

void compare(const Cloth& cloth, const std::array<Vec2, 2>& exact, Errors& errors) {
  const Vec2 along = (exact[1] - exact[0]).normalized();
  Vec2 first = exact[1], last = exact[0];
  for (int i = 0; i < cloth.mesh.n_vertices(); ++i) {
    if (!cloth.is_eol(i)) continue;
    const Vec2 X = cloth.mesh.X[i];
    if (X.dot(along) < first.dot(along)) first = X;
    if (X.dot(along) > last.dot(along)) last = X;
    errors.bends = std::max(errors.bends, std::abs(along.x() * (X - exact[0]).y() - along.y() * (X - exact[0]).x()));
  }
  const Vec2 found = last - first;
  errors.ends = std::max({errors.ends, (first - exact[0]).norm(), (last - exact[1]).norm()});
  errors.turn =
      std::max(errors.turn, std::abs(std::atan2(along.x() * found.y() - along.y() * found.x(), along.dot(found))));
}

TEST(SlidingLaws, ObliqueCrossingTurnsAsALaminaInTheUnfoldedPlane) {
  const double h = 1e-3, degree = std::numbers::pi / 180;
  struct Crossing {
    Vec2 size;
    double psi, over;  ///< the lowest corner hangs by `over`
    int axis;
    double turns;  ///< to come, from an integration of the same equations of order 8 [rad]
  };
  for (const Crossing& crossing : {Crossing{{1, 1}, 20 * degree, 0.45, 1, .323489 - 20 * degree},
                                   Crossing{{1, 0.3}, 60 * degree, 0.35, 0, 1.359913 - 60 * degree}}) {
    SCOPED_TRACE(crossing.over);
    Lamina lamina{crossing.size, crossing.psi};
    double deepest = 0;
    for (const Vec2& corner : lamina.corners()) deepest = std::max(deepest, corner.y());
    lamina.c.y() = crossing.over - deepest;
    const Slide slide = folded_sheet(lamina, 0.05, crossing.axis);
    Errors errors;
    double clock = 0;
    run_slide(slide, h, 0.35 - h / 2, [&](double t, const Cloth& cloth, const Reactions&) {
      const double step = h / 32;
      // The scheme's clock is half a step ahead.
      for (; clock < t + h / 2 - step / 2; clock += step) lamina.advance(step);
      compare(cloth, fold_ends(lamina), errors);
      return true;
    });
    lamina.advance(h / 2);
    EXPECT_NEAR(lamina.psi - crossing.psi, crossing.turns, 1e-6);
    // The sheet starts unstretched: rho g L/E = 1e-4, twice.
    EXPECT_LE(errors.ends, 2e-4);
    EXPECT_LE(errors.bends, 2e-4);
    EXPECT_LE(errors.turn, 1e-3);
  }
}

}  // namespace
}  // namespace crease
