// SPDX-License-Identifier: MIT
//
// Operations shorten what is bent, and that is energy which nobody gave. Stiff sheets over the edges of boxes got
// twenty times their kinetic energy in one pass: vertices of steep kinks were slid or absorbed from millimetres away.
#include <algorithm>
#include <cmath>
#include <numbers>

#include <gtest/gtest.h>

#include "crease/geometry/triangle.hpp"
#include "sliding_sheet.hpp"
#include "support/meshes.hpp"

namespace crease {
namespace {

using support::SlidingSheet;
using support::uniform;

// Integral of |S - I|^2: the membrane's energy for E = 2 and nu = 0. The stretches by the eigenvalues of F^T F.
double strain(const Mesh& mesh) {
  double sum = 0;
  for (int f = 0; f < mesh.n_faces(); ++f) {
    const Mat32 F = deformation_gradient(mesh, f);
    const Mat2 C = F.transpose() * F;
    const double mean = 0.5 * C.trace(), spread = std::hypot(0.5 * (C(0, 0) - C(1, 1)), C(0, 1));
    const double s = std::sqrt(mean + spread) - 1, t = std::sqrt(std::max(0.0, mean - spread)) - 1;
    sum += mesh.material_area(f) * (s * s + t * t);
  }
  return sum;
}

// Area of the faces around a vertex.
double largest_patch(const Mesh& mesh) {
  double largest = 0;
  for (int v = 0; v < mesh.n_vertices(); ++v) {
    double area = 0;
    for (const int h : mesh.outgoing(v)) area += mesh.material_area(Mesh::face_of(h));
    largest = std::max(largest, area);
  }
  return largest;
}

int operations(const RemeshReport& report) {
  return report.flips + report.collapses + report.inserted;
}

// A sheet rolled up without strain, each row of cells turned by `turn` against the one before: a collapse across the
// rows shortens by turn^2 / 8. Each operation may add 2e-3^2 times its patch.
TEST(Strain, IsNotPutIntoARolledSheet) {
  for (const double turn : {0.05, 0.1, 0.15, 0.19}) {
    SCOPED_TRACE("turn " + std::to_string(turn));
    Cloth cloth = make_cloth(make_grid({.cells = {20, 20}}));
    const double radius = 0.5 * 0.05 / std::sin(0.5 * turn);
    for (int v = 0; v < cloth.mesh.n_vertices(); ++v) {
      const double row = cloth.mesh.X[v].x() / 0.05, low = std::floor(row + 1e-9), rest = row - low;
      const auto at = [&](double k) { return Vec2(radius * std::sin(k * turn), radius * std::cos(k * turn)); };
      const Vec2 p = at(low), q = at(low + 1);
      cloth.mesh.x[v] = {(1 - rest) * p.x() + rest * q.x(), cloth.mesh.X[v].y(), (1 - rest) * p.y() + rest * q.y()};
    }
    AdaptOptions options;
    options.size = {0.2, 0.4};
    options.angle = options.velocity = options.compression = 1e9;
    options.threshold = 0.1;
    const RemeshResult result = adapt(cloth, options);
    const double patch = std::max(largest_patch(cloth.mesh), largest_patch(result.cloth.mesh));
    const double bound = 2e-3 * 2e-3 * patch * operations(result.report);
    EXPECT_LE(strain(cloth.mesh), 1e-20);
    // At .15 each would give a patch more than that: the rows stay.
    EXPECT_LE(strain(result.cloth.mesh), turn < 0.15 ? bound : 1e-20);
  }
}

// A chain travels into sheets that hang down in steep facets, anyhow turned and bent. What it takes up may strain a
// patch by .03, and by more only within .15 `merge`: from 1.5 mm, facets of 50 mm that meet at 1.2 rad, where all
// operations end, are shortened by 1.5 (1 - cos 1.2) / 50 = .02.
TEST(Strain, IsNotPutIntoASheetInTheChainsWay) {
  support::Rng rng{7};
  for (int sheets = 0; sheets < 12; ++sheets) {
    SCOPED_TRACE("sheet " + std::to_string(sheets));
    SlidingSheet sheet({.pattern = GridPattern::Irregular, .angle = uniform(rng, -0.6, 0.6), .place = 0.4});
    const double stride = 0.002;
    ConformOptions options;
    options.look_ahead = 7 * stride / SlidingSheet::speed;
    options.clearance = 0.02;
    sheet.cloth = sheet.conform(options).cloth;
    sheet.bend(uniform(rng, -1.0, -0.2), uniform(rng, 5.0, 22.0));
    for (int step = 0; step < 60; ++step) {
      sheet.slide(std::min(stride, 0.3 * sheet.room()));
      const RemeshResult result = sheet.conform(options);
      const double patch = std::max(largest_patch(sheet.cloth.mesh), largest_patch(result.cloth.mesh));
      const double gained = strain(result.cloth.mesh) - strain(sheet.cloth.mesh);
      EXPECT_LE(gained, 0.03 * 0.03 * patch * operations(result.report) + 1e-15) << "step " << step;
      sheet.cloth = result.cloth;
    }
  }
}

// Two vertices on a wire with a fold between them that doubles back, shorter than `merge`: their link by a flip would
// press the fold flat, from 9.9 mm to .1 mm. By a new vertex on the fold it changes nothing; as the end of a chain that
// is too near to another one it is let go, and to take it out would press the fold flat, too.
TEST(Strain, IsNotPutIntoAFoldByLinkingOverIt) {
  const double fold = 0.0049;
  const std::vector<Vec2> X{{-0.0001, 0}, {2 * fold, 0}, {fold, -0.05}, {fold, 0.05}, {-0.05, 0}, {0.06, 0}};
  std::vector<Vec3> x;
  for (const Vec2& P : X) x.emplace_back(P.x() > fold ? 2 * fold - P.x() : P.x(), P.y(), 0);
  Cloth cloth = make_cloth(Mesh(X, x, {{0, 2, 3}, {2, 1, 3}, {4, 2, 0}, {4, 0, 3}, {2, 5, 1}, {1, 5, 3}}));
  const ObstacleShape wire = make_wire({Vec3(-1, 0, 0), Vec3(1, 0, 0)});
  const PosedObstacle posed{&wire, Pose()};
  for (const int v : {0, 1}) cloth.feature[v] = {.obstacle = 0, .kind = FeatureKind::Edge, .index = 0};
  const RemeshResult result = conform(cloth, {}, {&posed, 1}, {});
  EXPECT_LE(strain(result.cloth.mesh), 1e-20);
  const std::vector<Vec2>& left = result.cloth.mesh.X;
  EXPECT_NE(std::find(left.begin(), left.end(), Vec2(fold, 0)), left.end());
}

}  // namespace
}  // namespace crease
