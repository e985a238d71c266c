// SPDX-License-Identifier: MIT
//
// What inextensible sheets do on frictionless sharp edges, by Newton's law along the path: exact unless said.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <vector>

#include "support/slide_run.hpp"
#include "support/surfaces.hpp"

namespace crease {
namespace {

using namespace crease::testing;

constexpr double h = 1e-3;

/// The strip of strip.hpp, folded over its table, as a slide.
Slide strip_slide(const Strip& strip, std::array<int, 2> cells = {20, 4}) {
  Slide slide;
  slide.cloth = make_strip(strip, cells, GridPattern::Alternating, true);
  slide.obstacles = {strip_table()};
  slide.material = strip.material();
  slide.element = strip.L / cells[0];
  return slide;
}

/// The same over the table as a triangle mesh.
Slide over_a_mesh(Slide slide) {
  Obstacle table;
  table.name = "table";
  table.shape = make_mesh(support::quartered(support::box_surface({4, 4, 4})), 0.5);
  table.start.position = {-2, 0, -2};
  const int edge = strip_edge(table);
  for (FeatureId& feature : slide.cloth.feature)
    if (feature.kind == FeatureKind::Edge) feature.index = edge;
  slide.obstacles = {table};
  return slide;
}

/// Everything slides over the edge at the speed v.
void set_sliding(Cloth& cloth, const Strip& strip, double v) {
  for (int i = 0; i < cloth.mesh.n_vertices(); ++i) {
    if (cloth.is_eol(i))
      cloth.V[i] = Vec2(-v, 0);
    else
      cloth.v[i] = cloth.mesh.X[i].x() < strip.L - strip.x0 ? Vec3(v, 0, 0) : Vec3(0, 0, -v);
  }
}

double overhang(const Cloth& cloth, const Strip& strip) {
  return measure_fold(cloth, strip.L).overhang;
}

// x = x0 cosh(k t) + v0/k sinh(k t); the fold leaves the edge at x = (L + sqrt(L^2 + 8 x0^2 - 8 L v0^2/g))/4.
TEST(SlidingLaws, StripStartsWithASpeed) {
  Strip strip;
  strip.x0 = 0.2;
  for (const double v0 : {0.25, 0.5, 1.0}) {
    SCOPED_TRACE(v0);
    Slide slide = strip_slide(strip);
    set_sliding(slide.cloth, strip, v0);
    const double L = strip.L, k = strip.k();
    const double leaves = (L + std::sqrt(L * L + 8 * strip.x0 * strip.x0 - 8 * L * v0 * v0 / strip.g)) / 4;
    // The scheme's clock runs half a step ahead, so that is when its start is: x(h/2) = x0.
    const double at_rest = (strip.x0 - v0 / k * std::sinh(k * h / 2)) / std::cosh(k * h / 2);
    const auto exact = [&](double t) { return at_rest * std::cosh(k * t) + v0 / k * std::sinh(k * t); };
    double error = 0, left_at = 0, before = strip.x0;
    run_slide(slide, h, 0.6, [&](double t, const Cloth& cloth, const Reactions& reactions) {
      if (t > 2 * h && reactions.edge.x() <= 1e-12) {
        left_at = before;
        return false;
      }
      before = overhang(cloth, strip);
      if (before < 0.995 * leaves) error = std::max(error, std::abs(before - exact(t + h / 2)));
      return true;
    });
    EXPECT_LE(error, 3e-5 + 0.05 * strip.rho * strip.g * L / strip.E);
    EXPECT_NEAR(left_at, leaves, 4 * h);
  }
}

// No closed form. Chains of up to 1600 beads over edges rounded by .04 to .005 m, extrapolated to a sharp one: +-4e-4
// m, the bow +-1e-3. The fold does not jump up: as a wave that stands still on a string it goes on through the
// material, out at the height of the table, and the sheet beyond it bows out.
TEST(SlidingLaws, AfterLiftOffTheFoldTravelsOutAtTheHeightOfTheTable) {
  struct Seen {
    double time, tail, tip, bow;
  };
  const std::vector<Seen> chains{{.44, -.3668, -.6325, .0006}, {.46, -.3295, -.6680, .0025},
                                 {.48, -.2882, -.7054, .0064}, {.50, -.2419, -.7447, .0134},
                                 {.52, -.1893, -.7857, .0250}, {.54, -.1282, -.8284, .0429},
                                 {.56, -.0551, -.8726, .0696}};
  const Strip strip;
  const auto measure = [&](double t, const Mesh& mesh) {
    Seen seen{t, 0, 0, 0};
    int n_tail = 0, n_tip = 0;
    for (int i = 0; i < mesh.n_vertices(); ++i) {
      if (mesh.X[i].x() < 1e-9) seen.tail += mesh.x[i].x(), ++n_tail;
      if (mesh.X[i].x() > strip.L - 1e-9) seen.tip += mesh.x[i].z(), ++n_tip;
      seen.bow = std::max(seen.bow, mesh.x[i].x());
    }
    seen.tail /= n_tail, seen.tip /= n_tip;
    return seen;
  };
  std::vector<Seen> found;
  Seen before{};
  double push = 0;
  run_slide(strip_slide(strip, {40, 4}), h, 0.57, [&](double t, const Cloth& cloth, const Reactions& reactions) {
    const Seen now = measure(t + h / 2, cloth.mesh);  // the scheme's clock runs half a step ahead
    if (found.size() < chains.size() && now.time >= chains[found.size()].time) {
      const double time = chains[found.size()].time, share = (time - before.time) / (now.time - before.time);
      const auto at = [&](double Seen::*value) { return before.*value + share * (now.*value - before.*value); };
      found.push_back({time, at(&Seen::tail), at(&Seen::tip), at(&Seen::bow)});
    }
    if (t > strip.lift_time() + 4 * h) push = std::max(push, reactions.edge.norm());
    before = now;
    return true;
  });
  ASSERT_EQ(found.size(), chains.size());
  for (std::size_t i = 0; i < chains.size(); ++i) {
    SCOPED_TRACE(chains[i].time);
    // The chains' own uncertainty, and as much again for 40 elements and 1 ms.
    EXPECT_NEAR(found[i].tail, chains[i].tail, 1e-3);
    EXPECT_NEAR(found[i].tip, chains[i].tip, 1e-3);
    EXPECT_NEAR(found[i].bow, chains[i].bow, 2e-3);
  }
  // A vertex of a chain carries its share of the elements on its two sides to the table: here at lift-off, and when a
  // chain has been found again on the flat sheet behind the fold.
  EXPECT_LE(push, 2 * 1.5 / 40 * strip.rho * strip.g * strip.L * strip.W);
}

// Longitudinal waves rho r_tt = E r_ss + rho g H(r), r_s = 1 at both ends: overhang and lift-off by spectral modes,
// checked by finite differences with Richardson extrapolation to 1e-8.
void expect_elastic_slide(const Slide& slide, const Strip& strip) {
  const std::vector<std::pair<double, double>> elastic{
      {0.1, 0.314662896}, {0.2, 0.360156547}, {0.3, 0.440561714}, {0.4, 0.563680956}};
  double before = 0, before_time = 0, left_at = 0;
  std::size_t next = 0;
  std::vector<double> seen;
  run_slide(slide, h, 0.5, [&](double t, const Cloth& cloth, const Reactions& reactions) {
    if (t > 2 * h && reactions.edge.x() <= 1e-12) {
      left_at = before;
      return false;
    }
    const double now = overhang(cloth, strip);
    // x(t + h/2) of the exact solution is reached at t: interpolate what stands for `time`.
    if (next < elastic.size() && t + h / 2 >= elastic[next].first) {
      const double share = (elastic[next].first - before_time) / (t + h / 2 - before_time);
      seen.push_back(before + share * (now - before));
      ++next;
    }
    before = now, before_time = t + h / 2;
    return true;
  });
  ASSERT_EQ(seen.size(), elastic.size());
  for (std::size_t i = 0; i < elastic.size(); ++i) EXPECT_NEAR(seen[i], elastic[i].second, 3e-4) << elastic[i].first;
  EXPECT_NEAR(left_at, 0.58205, 4 * h);
}

TEST(SlidingLaws, StretchedStripFollowsTheElasticSolution) {
  Strip strip;
  strip.E = 10;
  const Slide slide = strip_slide(strip, {40, 4});
  {
    SCOPED_TRACE("box");
    expect_elastic_slide(slide, strip);
  }
  SCOPED_TRACE("mesh");
  expect_elastic_slide(over_a_mesh(slide), strip);
}

// The tail is drawn back by s(t): x = x0 - s, edge reaction W rho (g x - s'^2) in x and z, pull W (T + rho (L - x) s'')
// with T = rho x (g + s''); at a constant speed V the fold leaves the edge at x = V^2/g.
TEST(SlidingLaws, PulledBackTheFoldLeavesAtTheSquareOfTheSpeed) {
  Strip strip;
  strip.x0 = 0.75;
  strip.E = 1e5;
  const double settling = 0.02;           // of the waves that the ramp's ends excite [s]
  const double start = 0.01, ramp = 0.1;  // s = V (t - start - ramp/2) from start + ramp on
  for (const double V : {0.5, 1.0, 2.0}) {
    SCOPED_TRACE(V);
    Slide slide = strip_slide(strip, {20, 4});
    PinSpec pull;
    pull.motion = {{.time = start, .velocity = {-V, 0, 0}}};
    pull.ramp = ramp;
    slide.pins = {pull};
    for (int i = 0; i < slide.cloth.mesh.n_vertices(); ++i)
      if (slide.cloth.mesh.X[i].x() < 1e-9) slide.cloth.pins[i] = 1;
    const double leaves = V * V / strip.g, end = start + ramp / 2 + (strip.x0 - leaves) / V + 0.02;
    double before = strip.x0, left_at = -1, squares = 0, force_error = 0;
    int judged = 0;
    run_slide(slide, h, end, [&](double t, const Cloth& cloth, const Reactions& reactions) {
      const double x = overhang(cloth, strip);
      if (t > start + ramp + settling) {
        if (reactions.edge.x() <= 1e-12) {
          left_at = before;
          return false;
        }
        const double exact = strip.x0 - V * (t - h - start - ramp / 2);  // the step's forces are those at its start
        if (exact > leaves + 0.03) {
          squares += std::pow(reactions.edge.x() - strip.W * strip.rho * (strip.g * exact - V * V), 2);
          const double pulled = strip.W * strip.rho * strip.g * exact;
          force_error = std::max(force_error, std::abs(-reactions.pin.x() / pulled - 1));
          ++judged;
        }
      }
      before = x;
      return true;
    });
    EXPECT_GT(judged, 60);
    // The motion is uniform, so what is left is rounding, strain (rho g L/E = 1e-5) and what the ramp left swinging.
    EXPECT_LE(std::sqrt(squares / judged) / (strip.rho * strip.g * strip.L * strip.W), 1e-5);
    EXPECT_LE(force_error, 1e-4);
    EXPECT_NEAR(left_at, leaves, 2 * h * V);
  }
}

TEST(SlidingLaws, TheSameOverAMeshedTable) {
  const Strip strip;
  double error = 0;
  run_slide(over_a_mesh(strip_slide(strip)), h, 0.99 * strip.lift_time(),
            [&](double t, const Cloth& cloth, const Reactions&) {
              error = std::max(error, std::abs(overhang(cloth, strip) - strip.overhang(t + h / 2)));
              return true;
            });
  EXPECT_LE(error, 3e-5 + 0.05 * strip.rho * strip.g * strip.L / strip.E);
}

// A drift along the edge is decoupled: the material carries the EOL vertices along (t . Xdot = 0).
TEST(SlidingLaws, DriftAlongTheEdgeStaysUniform) {
  const Strip strip;
  const double drift = 0.25;
  Slide slide = strip_slide(strip);
  for (Vec3& v : slide.cloth.v) v.y() += drift;
  double error = 0, sideways = 0;
  run_slide(slide, h, 0.99 * strip.lift_time(), [&](double t, const Cloth& cloth, const Reactions&) {
    error = std::max(error, std::abs(overhang(cloth, strip) - strip.overhang(t + h / 2)));
    for (int i = 0; i < cloth.mesh.n_vertices(); ++i)
      sideways = std::max(sideways, std::abs(cloth.mesh.x[i].y() - (cloth.mesh.X[i].y() - strip.W / 2) - drift * t));
    return true;
  });
  EXPECT_LE(error, 3e-5 + 0.05 * strip.rho * strip.g * strip.L / strip.E);
  EXPECT_LE(sideways, 1e-6);
}

// A square, the corner of which hangs over the edge along its diagonal by d: the hanging part has the area d^2, so
// d'' = g d^2 while d < sqrt(1/2), v^2 = 2 g (d^3 - d0^3)/3. The fold runs at 45 degrees to the borders, and grows.
TEST(SlidingLaws, DiamondSlidesOverTheEdge) {
  const int cells = 20;
  const double d0 = 14 / (cells * std::numbers::sqrt2), g = 9.81, across = 2 / std::numbers::sqrt2 - d0;
  GridOptions grid;
  grid.cells = {cells, cells};
  Slide slide;
  slide.cloth = make_cloth(make_grid(grid));
  slide.material = {.density = 0.1, .youngs = 1e4, .poisson = 0, .bending = 0, .damping = 0};
  slide.element = 0.05;
  slide.g = g;
  slide.obstacles = {strip_table()};
  Mesh& mesh = slide.cloth.mesh;
  std::vector<int> folded;
  for (int i = 0; i < mesh.n_vertices(); ++i) {
    const double beyond = (mesh.X[i].x() + mesh.X[i].y()) / std::numbers::sqrt2 - across;
    const double along = (mesh.X[i].y() - mesh.X[i].x()) / std::numbers::sqrt2;
    mesh.x[i] = Vec3(std::min(beyond, 0.0), along, -std::max(beyond, 0.0));
    if (std::abs(beyond) < 1e-9) folded.push_back(i), mesh.x[i] = Vec3(0, along, 0);
  }
  put_on_edge(slide.cloth, folded, 0, strip_edge(strip_table()));
  double d = d0, speed = 0, clock = 0, error = 0, crooked = 0;
  run_slide(slide, h, 0.3, [&](double t, const Cloth& cloth, const Reactions&) {
    for (const double step = h / 64; clock < t + h / 2 - step / 2; clock += step) {  // the exact law, by leapfrog
      speed += step / 2 * g * d * d, d += step * speed, speed += step / 2 * g * d * d;
    }
    double low = 1e9, high = -1e9, mean = 0;
    for (int i = 0; i < cloth.mesh.n_vertices(); ++i) {
      if (!cloth.is_eol(i)) continue;
      const double here = std::numbers::sqrt2 - (cloth.mesh.X[i].x() + cloth.mesh.X[i].y()) / std::numbers::sqrt2;
      low = std::min(low, here), high = std::max(high, here), mean += here / cloth.n_eol();
    }
    error = std::max(error, std::abs(mean - d));
    crooked = std::max(crooked, high - low);
    return d < 0.7;
  });
  // Strain: rho g L/E = 1e-4, of which a twentieth counts as for the strip, and as much again across.
  EXPECT_LE(error, 1e-5);
  EXPECT_LE(crooked, 2e-5);
}

}  // namespace
}  // namespace crease
