// SPDX-License-Identifier: MIT
#include <cmath>

#include <gtest/gtest.h>

#include "crease/geometry/triangle.hpp"
#include "crease/remesh/remesh.hpp"
#include "support/seams.hpp"

// The adaptive remesher on panels that are sewn together.
namespace crease {
namespace {

AdaptOptions sizes(double shortest, double longest) {
  AdaptOptions options;
  options.size = {shortest, longest};
  options.threshold = shortest;  // far from any contact
  return options;
}

int n_tied(const Mesh& mesh) {
  int n = 0;
  for (int v = 0; v < mesh.n_vertices(); ++v) n += mesh.is_tied(v) ? 1 : 0;
  return n;
}

Vec2 middle(const Mesh& mesh) {
  Vec2 sum = Vec2::Zero();
  for (const Vec3& x : mesh.x) sum += x.head<2>();
  return sum / mesh.n_vertices();
}

// A bump in the world, the same for what is tied since it stands at one place.
void raise(Cloth& cloth, const Vec2& centre, double height) {
  for (int v = 0; v < cloth.mesh.n_vertices(); ++v) {
    Vec3& x = cloth.mesh.x[v];
    x.z() = height * std::exp(-40 * (Vec2(x.head<2>()) - centre).squaredNorm());
    cloth.v[v] = 0.1 * Vec3(std::sin(5 * x.y()), std::cos(4 * x.x()), 0.3 * x.x());
  }
}

TEST(AdaptSewn, CoarsensTheSeamWhereABumpHasGone) {
  const AdaptOptions options = sizes(0.03, 0.25);
  for (const auto& [name, start] : {support::NamedMesh{"halves", support::halves().mesh},
                                    support::NamedMesh{"patchwork", support::patchwork().mesh}}) {
    SCOPED_TRACE(name);
    Cloth sheet = adapt(make_cloth(start), options).cloth;
    const Vec2 centre = middle(start);
    const int n_rest = n_tied(sheet.mesh), n_faces = sheet.mesh.n_faces();
    const double area = support::total_area(start);
    const std::array<double, 2> length{support::border_length(start, false), support::border_length(start, true)};
    const auto pass = [&] {
      RemeshResult result = adapt(sheet, options);
      ASSERT_EQ(validate(result.cloth), std::nullopt);
      EXPECT_NEAR(support::total_area(result.cloth.mesh), area, 1e-12 * area);
      for (const bool sewn : {false, true})
        EXPECT_NEAR(support::border_length(result.cloth.mesh, sewn), length[sewn], 1e-12);
      const Motion &before = result.report.before, &after = result.report.after;
      // Rounding of a few hundred operations on speeds of 1 m/s; what is tied pays nothing.
      EXPECT_LE((after.linear - before.linear).norm(), 1e-12);
      EXPECT_LE(after.kinetic, before.kinetic * (1 + 1e-12));
      sheet = std::move(result.cloth);
    };
    for (int n = 0; n < 6; ++n) raise(sheet, centre, 0.1), pass();
    const int n_bump = n_tied(sheet.mesh);
    EXPECT_GT(n_bump, 1.5 * n_rest);
    for (int n = 0; n < 4; ++n) raise(sheet, centre, 0), pass();
    EXPECT_LE(n_tied(sheet.mesh), n_rest + 0.2 * (n_bump - n_rest));
    EXPECT_NEAR(sheet.mesh.n_faces(), n_faces, 0.1 * n_faces);
  }
}

// What is sewn together unevenly, or along a line that is no line, keeps the vertices that say so.
TEST(AdaptSewn, KeepsTheVerticesOfAJaggedSeam) {
  const Mesh jagged = support::cut_and_sew(support::grid(GridPattern::Irregular, 16, 16, 5), [](const Vec2& c) {
                        return c.x() + 0.3 * c.y() < 1.6 ? 0 : 1;
                      }).mesh;
  const int n = n_tied(jagged);
  const RemeshResult result = adapt(make_cloth(jagged), sizes(0.3, 0.9));
  EXPECT_EQ(validate(result.cloth), std::nullopt);
  EXPECT_GT(result.report.collapses, 0);
  EXPECT_EQ(n_tied(result.cloth.mesh), n);
  EXPECT_NEAR(support::border_length(result.cloth.mesh, true), support::border_length(jagged, true), 1e-12);
}

}  // namespace
}  // namespace crease
