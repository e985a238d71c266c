// SPDX-License-Identifier: MIT
#include <cmath>
#include <numbers>

#include <gtest/gtest.h>
#include <Eigen/Geometry>

#include "crease/geometry/grid.hpp"
#include "crease/geometry/triangle.hpp"
#include "crease/remesh/remesh.hpp"
#include "remesh/same_bits.hpp"
#include "support/meshes.hpp"

namespace crease {
namespace {

using support::Rng;
using support::uniform;

constexpr double degree = std::numbers::pi / 180;

AdaptOptions sizes(double shortest, double longest) {
  AdaptOptions options;
  options.size = {shortest, longest};
  return options;
}

// The same far from any contact: what a pass may move the surface by is a share of the shortest edge alone, so that a
// curved sheet coarsens.
AdaptOptions loose_sizes(double shortest, double longest) {
  AdaptOptions options = sizes(shortest, longest);
  options.threshold = shortest;
  return options;
}

Cloth flat_sheet(GridPattern pattern, int cells, Vec2 size = Vec2(1, 1)) {
  GridOptions grid;
  grid.size = size;
  grid.cells = {cells, cells};
  grid.pattern = pattern;
  return make_cloth(make_grid(grid));
}

double area(const Mesh& mesh) {
  return support::total_area(mesh);
}

struct Carried {
  Vec3 linear = Vec3::Zero(), angular = Vec3::Zero();  // the latter about the centre of mass
  double kinetic = 0;
};

// Three-point quadrature, exact for the product of two linear functions.
Carried carried(const Cloth& cloth) {
  const auto integrate = [&](auto&& quantity) {
    decltype(quantity(Vec3(), Vec3())) sum = quantity(Vec3(0, 0, 0), Vec3(0, 0, 0));
    for (int f = 0; f < cloth.mesh.n_faces(); ++f) {
      const auto x = world_corners(cloth.mesh, f);
      const auto& face = cloth.mesh.face(f);
      for (std::size_t k = 0; k < 3; ++k) {
        const std::size_t j = (k + 1) % 3;
        sum += cloth.mesh.material_area(f) / 3 *
               quantity(0.5 * (x[k] + x[j]), 0.5 * (cloth.v[face[k]] + cloth.v[face[j]]));
      }
    }
    return sum;
  };
  const Vec3 moment = integrate([](const Vec3& x, const Vec3&) { return x; });
  const Vec3 centre = moment / area(cloth.mesh);
  return {integrate([](const Vec3&, const Vec3& v) { return v; }),
          integrate([&](const Vec3& x, const Vec3& v) { return Vec3((x - centre).cross(v)); }),
          integrate([](const Vec3&, const Vec3& v) { return 0.5 * v.squaredNorm(); })};
}

void expect_valid(const Cloth& cloth, double expected_area) {
  EXPECT_EQ(validate(cloth), std::nullopt);
  EXPECT_TRUE(cloth.mesh.is_compact());
  // Areas are sums of thousands of products: rounding, no more.
  EXPECT_NEAR(area(cloth.mesh), expected_area, 1e-12 * expected_area);
}

TEST(Adapt, RefusesMissingSizes) {
  const Cloth sheet = flat_sheet(GridPattern::Cross, 4);
  EXPECT_THROW(adapt(sheet, AdaptOptions{}), std::invalid_argument);
  EXPECT_THROW(adapt(sheet, sizes(0.1, 0.05)), std::invalid_argument);
  EXPECT_THROW(sizing_field(sheet, AdaptOptions{}), std::invalid_argument);
  AdaptOptions no_aspect = sizes(0.05, 0.1);
  no_aspect.aspect = 0;
  EXPECT_THROW(adapt(sheet, no_aspect), std::invalid_argument);
}

// The aspect of the strip, 1 : 1e4, is what a loop "while an edge is too long" never ends on if a split is refused.
TEST(Adapt, EndsOnAThinStrip) {
  const Cloth strip = flat_sheet(GridPattern::Right, 1, Vec2(1, 1e-4));
  const RemeshResult result = adapt(strip, sizes(0.01, 0.1));
  expect_valid(result.cloth, 1e-4);
  EXPECT_GE(result.cloth.mesh.n_faces(), 20);
  for (const int h : result.cloth.mesh.edges()) EXPECT_LE(result.cloth.mesh.material_length(h), 0.1 * (1 + 1e-12));
}

// Share of the angles that lie between 30 and 120 degrees.
double good_angles(const Mesh& mesh) {
  int good = 0;
  for (int f = 0; f < mesh.n_faces(); ++f) {
    const auto X = material_corners(mesh, f);
    for (std::size_t k = 0; k < 3; ++k) {
      const Vec2 a = X[(k + 1) % 3] - X[k], b = X[(k + 2) % 3] - X[k];
      const double angle = std::acos(a.dot(b) / (a.norm() * b.norm()));
      good += angle >= 30 * degree - 1e-12 && angle <= 120 * degree + 1e-12 ? 1 : 0;
    }
  }
  return good / (3.0 * mesh.n_faces());
}

// From coarser, from much finer, and from what lies just outside the band: 13 and 17 cells, L = .45 to 1.3.
TEST(Adapt, FillsAUnitSquareWithTheWantedSize) {
  for (const GridPattern pattern :
       {GridPattern::Cross, GridPattern::Alternating, GridPattern::Right, GridPattern::Irregular}) {
    for (const int cells : {1, 7, 13, 17, 28, 40, 60}) {
      SCOPED_TRACE("pattern " + std::to_string(static_cast<int>(pattern)) + ", cells " + std::to_string(cells));
      const AdaptOptions options = sizes(0.06, 0.06);
      const RemeshResult result = adapt(flat_sheet(pattern, cells), options);
      const Mesh& mesh = result.cloth.mesh;
      expect_valid(result.cloth, 1);
      EXPECT_TRUE(result.report.refusals.empty());
      for (const int h : mesh.edges()) {
        const double L = mesh.material_length(h) / 0.06;
        EXPECT_LE(L, 1 + 1e-12);
        EXPECT_GE(L, 0.5 * (1 - 1e-9));  // halves of what has the longest length are long enough
      }
      EXPECT_GT(good_angles(mesh), 0.995);
      EXPECT_GT(result.report.smallest_angle, 15 * degree);
      EXPECT_FALSE(adapt(result.cloth, options).report.changed);
    }
  }
}

// A vertex that is held does not slide, nor does any in a cloth that a feature travels through.
TEST(Adapt, EvensOutLengthsOnlyWhereNothingHoldsOrRides) {
  const AdaptOptions options = sizes(0.1, 0.1);
  const auto moved = [&](const Cloth& sheet) {
    const RemeshResult result = adapt(sheet, options);
    int n = 0;
    for (int v = 0; v < sheet.mesh.n_vertices(); ++v) {
      const int now = result.report.vertex_map.empty() ? v : result.report.vertex_map[v];
      n += now != Mesh::none && result.cloth.mesh.X[now] != sheet.mesh.X[v] ? 1 : 0;
    }
    return n;
  };
  const Cloth flat = flat_sheet(GridPattern::Irregular, 20);
  EXPECT_GT(moved(flat), 20);
  Cloth held = flat, ridden = flat;
  held.pins.assign(held.pins.size(), 1);
  EXPECT_EQ(moved(held), 0);
  ridden.feature[210] = {0, FeatureKind::Corner, 0};
  EXPECT_EQ(moved(ridden), 0);
}

// A field of nail tips 0.2 mm under a wavy sheet, which a coarser mesh would cut through.
TEST(Adapt, CutsNoFeatureUnderneath) {
  Cloth sheet = flat_sheet(GridPattern::Irregular, 40);
  for (int v = 0; v < sheet.mesh.n_vertices(); ++v) {
    const Vec2& X = sheet.mesh.X[v];
    sheet.mesh.x[v].z() = 0.01 * std::sin(8 * X.x()) * std::cos(7 * X.y());
  }
  ObstacleShape nail;
  nail.kind = ObstacleShape::Kind::Point;
  nail.corners.push_back({Vec3::Zero(), {Vec3::UnitZ()}});
  std::vector<PosedObstacle> nails;
  for (int v = 7; v < sheet.mesh.n_vertices(); v += 7) {
    PosedObstacle posed{&nail, {}};
    posed.pose.position = sheet.mesh.x[v] - Vec3(0, 0, 2e-4);
    nails.push_back(posed);
  }
  // World and material agree in x and y, so the surface is a height there.
  const AdaptOptions options = loose_sizes(0.15, 0.3);
  const double touch = 1.01e-3 * options.threshold;  // a thousandth of it counts as touching; and rounding
  const auto pierced = [&](const Mesh& mesh) {
    int n = 0;
    for (const PosedObstacle& posed : nails) {
      const Vec3& tip = posed.pose.position;
      for (int f = 0; f < mesh.n_faces(); ++f) {
        const Vec3 b = barycentric(material_corners(mesh, f), tip.head<2>());
        if (b.minCoeff() < 1e-9) continue;
        const auto x = world_corners(mesh, f);
        n += b[0] * x[0].z() + b[1] * x[1].z() + b[2] * x[2].z() < tip.z() - touch ? 1 : 0;
      }
    }
    return n;
  };
  ASSERT_EQ(pierced(sheet.mesh), 0);
  EXPECT_GT(pierced(adapt(sheet, options).cloth.mesh), 5);
  const RemeshResult result = adapt(sheet, options, nails);
  EXPECT_EQ(pierced(result.cloth.mesh), 0);
  EXPECT_GT(result.report.kept_back[static_cast<std::size_t>(RefusalReason::NearObstacle)], 0);
  EXPECT_GT(result.report.collapses, 0);
  expect_valid(result.cloth, 1);
}

// Far from the sheet an obstacle changes nothing.
TEST(Adapt, LooksAtNoObstacleFarAway) {
  Cloth sheet = flat_sheet(GridPattern::Irregular, 30);
  for (int v = 0; v < sheet.mesh.n_vertices(); ++v) sheet.mesh.x[v].z() = 0.01 * std::sin(8 * sheet.mesh.X[v].x());
  const ObstacleShape box = make_box(Vec3(1, 1, 1));
  PosedObstacle posed{&box, {}};
  posed.pose.position = Vec3(0.5, 0.5, -1.5);
  const std::vector<PosedObstacle> obstacles{posed};
  testing::expect_same_bits(adapt(sheet, sizes(0.1, 0.3)).cloth, adapt(sheet, sizes(0.1, 0.3), obstacles).cloth);
}

TEST(Adapt, ASecondPassChangesNoBit) {
  for (std::uint64_t seed = 1; seed <= 6; ++seed) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    Rng rng(seed);
    Cloth sheet = flat_sheet(seed % 2 == 0 ? GridPattern::Cross : GridPattern::Irregular, 10);
    const Vec3 pull(uniform(rng, -1, 1), uniform(rng, -1, 1), 0);
    for (int v = 0; v < sheet.mesh.n_vertices(); ++v) sheet.v[v] = 3 * sheet.mesh.X[v].x() * pull;
    const RemeshResult once = adapt(sheet, sizes(0.02, 0.09));
    expect_valid(once.cloth, 1);
    EXPECT_TRUE(once.report.changed);
    const RemeshResult twice = adapt(once.cloth, sizes(0.02, 0.09));
    EXPECT_FALSE(twice.report.changed);
    EXPECT_TRUE(twice.report.vertex_map.empty());
    testing::expect_same_bits(once.cloth, twice.cloth);
  }
}

// The sizes depend on the mesh, so a curved sheet may need several passes; that they come to rest is the hysteresis.
TEST(Adapt, ComesToRestOnACurvedSheet) {
  for (const double frequency : {6.0, 12.0, 20.0}) {
    SCOPED_TRACE("frequency " + std::to_string(frequency));
    Cloth sheet = flat_sheet(GridPattern::Irregular, 10);
    bool changed = true;
    for (int pass = 0; pass < 12 && changed; ++pass) {
      for (int v = 0; v < sheet.mesh.n_vertices(); ++v) {
        const Vec2& X = sheet.mesh.X[v];
        sheet.mesh.x[v] = Vec3(X.x(), X.y(), 0.05 * std::sin(frequency * X.x() + X.y()));
      }
      RemeshResult result = adapt(sheet, sizes(0.02, 0.2));
      expect_valid(result.cloth, 1);
      changed = result.report.changed;
      sheet = std::move(result.cloth);
    }
    EXPECT_FALSE(changed);
  }
}

TEST(Adapt, LeavesARigidlyRotatingSheetAlone) {
  Cloth sheet = adapt(flat_sheet(GridPattern::Cross, 8), sizes(0.02, 0.2)).cloth;
  const Mat3 turn = Eigen::AngleAxisd(0.7, Vec3(1, 2, 3).normalized()).toRotationMatrix();
  const Vec3 spin(30, -20, 10);  // velocity differences of 10 m/s along an edge, 20 times what refines
  for (int v = 0; v < sheet.mesh.n_vertices(); ++v) {
    sheet.mesh.x[v] = turn * sheet.mesh.x[v];
    sheet.v[v] = spin.cross(sheet.mesh.x[v]) + Vec3(5, 5, 5);
  }
  EXPECT_FALSE(adapt(sheet, sizes(0.02, 0.2)).report.changed);
}

TEST(Adapt, RefinesStretchRateCompressionAndBending) {
  const AdaptOptions options = sizes(0.02, 0.2);
  const Cloth rest = adapt(flat_sheet(GridPattern::Cross, 8), options).cloth;
  const int n = rest.mesh.n_faces();
  Cloth torn = rest, pressed = rest, bent = rest;
  for (int v = 0; v < rest.mesh.n_vertices(); ++v) {
    const Vec2& X = rest.mesh.X[v];
    torn.v[v] = Vec3(10 * X.x(), 0, 0);
    pressed.mesh.x[v].x() *= 0.9;
    bent.mesh.x[v] = Vec3(0.2 * std::sin(X.x() / 0.2), X.y(), 0.2 * std::cos(X.x() / 0.2));
  }
  for (const Cloth& cloth : {torn, pressed, bent}) {
    const RemeshResult result = adapt(cloth, options);
    expect_valid(result.cloth, 1);
    EXPECT_GT(result.cloth.mesh.n_faces(), 2 * n);
  }
}

TEST(Adapt, CoarsensWhereABumpHasGone) {
  const AdaptOptions options = sizes(0.02, 0.2);
  Cloth sheet = adapt(flat_sheet(GridPattern::Cross, 8), options).cloth;
  const int n = sheet.mesh.n_faces();
  for (int pass = 0; pass < 6; ++pass) {
    for (int v = 0; v < sheet.mesh.n_vertices(); ++v) {
      const Vec2 d = sheet.mesh.X[v] - Vec2(0.5, 0.5);
      sheet.mesh.x[v].z() = 0.1 * std::exp(-40 * d.squaredNorm());
    }
    sheet = adapt(sheet, options).cloth;
  }
  EXPECT_GT(sheet.mesh.n_faces(), n + n / 2);
  for (int v = 0; v < sheet.mesh.n_vertices(); ++v) sheet.mesh.x[v].z() = 0;
  for (int pass = 0; pass < 3; ++pass) sheet = adapt(sheet, options).cloth;
  expect_valid(sheet, 1);
  EXPECT_NEAR(sheet.mesh.n_faces(), n, 0.1 * n);
}

TEST(Adapt, KeepsLinearAndAngularMomentum) {
  for (std::uint64_t seed = 1; seed <= 4; ++seed) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    Rng rng(seed);
    Cloth sheet = flat_sheet(GridPattern::Irregular, 12);
    double scale = 0;
    for (int v = 0; v < sheet.mesh.n_vertices(); ++v) {
      const Vec2& X = sheet.mesh.X[v];
      sheet.mesh.x[v].z() = 0.03 * std::sin(9 * X.x()) * std::cos(7 * X.y());
      sheet.v[v] = Vec3(std::sin(5 * X.y()), uniform(rng, -1, 1), uniform(rng, -1, 1));
      scale = std::max(scale, sheet.v[v].norm());
    }
    const RemeshResult result = adapt(sheet, sizes(0.03, 0.15));
    EXPECT_GT(result.report.splits, 0);
    EXPECT_GT(result.report.flips, 0);
    // Rounding of a few thousand operations on velocities of order `scale`, on one square metre.
    const Carried before = carried(sheet), after = carried(result.cloth);
    EXPECT_LE((after.linear - before.linear).norm(), 1e-12 * scale);
    EXPECT_LE((after.angular - before.angular).norm(), 1e-12 * scale);
    EXPECT_LE(after.kinetic, before.kinetic * (1 + 1e-12));
    EXPECT_NEAR(result.report.before.area, 1, 1e-12);
    EXPECT_NEAR(result.report.after.area, 1, 1e-12);
    for (const auto& [truth, told] : {std::pair{before, result.report.before}, std::pair{after, result.report.after}}) {
      EXPECT_LE((truth.linear - told.linear).norm(), 1e-13 * scale);
      EXPECT_LE((truth.angular - told.angular).norm(), 1e-13 * scale);
      EXPECT_NEAR(truth.kinetic, told.kinetic, 1e-13 * scale * scale);
    }
    EXPECT_EQ(result.report.momentum_change, result.report.after.linear - result.report.before.linear);
  }
}

// Conservation must not depend on the frame: a sheet in free fall at 20 m/s is remeshed as one at rest.
TEST(Adapt, IsTheSameInFreeFall) {
  const Vec3 fall(3, -4, -20);
  Cloth sheet = flat_sheet(GridPattern::Irregular, 12), falling = sheet;
  for (int v = 0; v < sheet.mesh.n_vertices(); ++v) {
    const Vec2& X = sheet.mesh.X[v];
    sheet.mesh.x[v].z() = falling.mesh.x[v].z() = 0.015 * std::sin(9 * X.x()) * std::cos(7 * X.y());
    sheet.v[v] = 0.3 * Vec3(std::sin(5 * X.y()), std::cos(3 * X.x()), std::sin(4 * X.x()));
    falling.v[v] = sheet.v[v] + fall;
  }
  const RemeshResult at_rest = adapt(sheet, loose_sizes(0.03, 0.25)), in_fall = adapt(falling, loose_sizes(0.03, 0.25));
  EXPECT_GT(at_rest.report.collapses, 5);
  ASSERT_EQ(at_rest.cloth.mesh.X, in_fall.cloth.mesh.X);
  // The energy's share of rounding at 20 m/s enters under a root where a limit is reached.
  for (std::size_t v = 0; v < at_rest.cloth.v.size(); ++v)
    EXPECT_LE((in_fall.cloth.v[v] - fall - at_rest.cloth.v[v]).norm(), 1e-9);
}

// A rigid spin has the least energy of all motions with its angular momentum, and a sheet that loses a bulge has less
// inertia: it cannot keep both. The energy is what is kept, and as much of the angular momentum as goes with it.
TEST(Adapt, LosesNoMoreSpinThanItsShapeDoes) {
  Cloth sheet = flat_sheet(GridPattern::Irregular, 30);
  const Vec3 spin(4, -3, 9);
  for (int v = 0; v < sheet.mesh.n_vertices(); ++v) {
    const Vec2& X = sheet.mesh.X[v];
    sheet.mesh.x[v] = Vec3(X.x(), X.y(), 0.1 * std::sin(4 * X.x()) * std::cos(3 * X.y()));
    sheet.v[v] = spin.cross(sheet.mesh.x[v]);
  }
  const RemeshResult result = adapt(sheet, loose_sizes(0.05, 0.3));
  EXPECT_GT(result.report.collapses, 200);
  const Motion &before = result.report.before, &after = result.report.after;
  EXPECT_LE((after.linear - before.linear).norm(), 1e-12 * before.linear.norm());
  EXPECT_LE(after.kinetic, before.kinetic * (1 + 1e-12));
  EXPECT_LE((after.angular - before.angular).norm(), 2e-3 * before.angular.norm());
  EXPECT_GE(after.kinetic, before.kinetic * (1 - 4e-3));
}

// Without giving back, a pass loses the momentum of the vertices it removes: the reason why settling is there.
TEST(Adapt, InterpolatesOnlyOnDemand) {
  Cloth sheet = flat_sheet(GridPattern::Irregular, 30);
  for (int v = 0; v < sheet.mesh.n_vertices(); ++v) {
    const Vec2& X = sheet.mesh.X[v];
    sheet.v[v] = Vec3(1 + std::sin(9 * X.y()), 0, std::cos(8 * X.x()));
  }
  AdaptOptions options = sizes(0.2, 0.3);
  const RemeshReport settled = adapt(sheet, options).report;
  options.conserve = false;
  const RemeshReport plain = adapt(sheet, options).report;
  EXPECT_LE(settled.momentum_change.norm(), 1e-12 * settled.before.linear.norm());
  EXPECT_GT(plain.momentum_change.norm(), 1e-4 * plain.before.linear.norm());
}

TEST(Adapt, KeepsPinsAndMaterialCorners) {
  Cloth sheet = flat_sheet(GridPattern::Cross, 20);
  const int pinned = 200;
  sheet.pins[pinned] = 1;
  const Vec2 place = sheet.mesh.X[pinned];
  const RemeshResult result = adapt(sheet, sizes(0.1, 0.5));
  ASSERT_FALSE(result.report.vertex_map.empty());
  const int now = result.report.vertex_map[pinned];
  ASSERT_NE(now, Mesh::none);
  EXPECT_EQ(result.cloth.mesh.X[now], place);
  EXPECT_EQ(result.cloth.pins[now], 1u);
  EXPECT_LT(result.cloth.mesh.n_faces(), sheet.mesh.n_faces() / 4);
  expect_valid(result.cloth, 1);
}

// A border that bends by 0.02 rad at each vertex keeps them all: without one the sheet would lose area, and with it
// mass. What is split off between them goes again.
TEST(Adapt, KeepsTheAreaOfASheetWithARoundBorder) {
  Cloth sheet = flat_sheet(GridPattern::Alternating, 20);
  for (int v = 0; v < sheet.mesh.n_vertices(); ++v) {
    Vec2& X = sheet.mesh.X[v];
    X.x() *= 1 + 0.4 * X.y() * (1 - X.y());
    sheet.mesh.x[v].head<2>() = X;
  }
  const auto n_border = [](const Mesh& mesh) {
    int n = 0;
    for (int v = 0; v < mesh.n_vertices(); ++v) n += mesh.is_border_vertex(v) && mesh.X[v].x() > 0.999 ? 1 : 0;
    return n;
  };
  const double before = area(sheet.mesh);
  const RemeshResult coarse = adapt(sheet, loose_sizes(0.2, 0.4));
  expect_valid(coarse.cloth, before);
  EXPECT_LT(coarse.cloth.mesh.n_faces(), sheet.mesh.n_faces() / 2);
  EXPECT_EQ(n_border(coarse.cloth.mesh), 21);
  const RemeshResult fine = adapt(sheet, sizes(0.02, 0.02)), back = adapt(fine.cloth, loose_sizes(0.2, 0.4));
  EXPECT_GT(n_border(fine.cloth.mesh), 40);
  expect_valid(back.cloth, before);
  EXPECT_EQ(n_border(back.cloth.mesh), 21);
}

// A border held by one pin stays held where it is refined.
TEST(Adapt, HoldsNewVerticesBetweenVerticesOfOnePin) {
  Cloth sheet = flat_sheet(GridPattern::Cross, 4);
  for (int v = 0; v < sheet.mesh.n_vertices(); ++v)
    if (sheet.mesh.X[v].x() == 0) sheet.pins[v] = 4;
  const RemeshResult result = adapt(sheet, sizes(0.05, 0.05));
  for (int v = 0; v < result.cloth.mesh.n_vertices(); ++v)
    EXPECT_EQ(result.cloth.pins[v], result.cloth.mesh.X[v].x() == 0 ? 4u : 0u);
}

}  // namespace
}  // namespace crease
