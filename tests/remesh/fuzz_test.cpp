// SPDX-License-Identifier: MIT
#include <cmath>

#include <gtest/gtest.h>
#include <Eigen/Geometry>

#include "crease/geometry/grid.hpp"
#include "crease/geometry/triangle.hpp"
#include "crease/remesh/remesh.hpp"
#include "remesh/same_bits.hpp"
#include "support/contacts.hpp"
#include "support/meshes.hpp"
#include "support/seams.hpp"

// Sheets with noise in everything, boxes anywhere in them, options that do not fit each other: nothing here is
// physical, and every pass must still end with a valid cloth.
namespace crease {
namespace {

using support::pick;
using support::Rng;
using support::uniform;

Vec3 random_vector(Rng& rng, double size) {
  return size * Vec3(uniform(rng, -1, 1), uniform(rng, -1, 1), uniform(rng, -1, 1));
}

struct Chaos {
  explicit Chaos(std::uint64_t seed) : rng(seed) {
    GridOptions grid;
    grid.cells = {6 + pick(rng, 12), 6 + pick(rng, 12)};
    grid.pattern = static_cast<GridPattern>(pick(rng, 4));
    grid.seed = seed;
    grid.size = Vec2(uniform(rng, 0.3, 1), uniform(rng, 0.3, 1));
    area = grid.size.prod();
    Mesh mesh = make_grid(grid);
    // Every third sheet is two that are sewn together, along whatever jagged line.
    if (seed % 3 == 0)
      mesh = support::cut_and_sew(mesh, [&](const Vec2& c) {
               return c.x() + 0.3 * c.y() < 0.5 * grid.size.x() ? 0 : 1;
             }).mesh;
    cloth = make_cloth(std::move(mesh));
    const double bump = pick(rng, 2) * uniform(rng, 0, 0.2);
    for (int v = 0; v < cloth.mesh.n_vertices(); ++v) {
      const Vec2& X = cloth.mesh.X[v];
      cloth.mesh.x[v].z() = bump * std::sin(9 * X.x()) * std::cos(7 * X.y());
      cloth.v[v] = random_vector(rng, 1);
      if (pick(rng, 60) == 0) cloth.pins[v] = 1u << pick(rng, 3);
    }
    match_tied();
    add_boxes();
    conforming.merge = uniform(rng, 0.004, 0.03);
    conforming.snap = uniform(rng, 0.0005, 0.02);
    sizes.size[0] = uniform(rng, 0.02, 0.06);
    sizes.size[1] = sizes.size[0] * uniform(rng, 1, 6);
  }

  // What is tied is one point.
  void match_tied() {
    for (int i = 0; i < cloth.mesh.n_vertices(); ++i)
      for (int v = cloth.mesh.tied(i); v != i; v = cloth.mesh.tied(v)) {
        cloth.mesh.x[v] = cloth.mesh.x[i];
        cloth.v[v] = cloth.v[i];
        cloth.pins[v] = cloth.pins[i];
      }
  }

  void add_boxes() {
    const int n = 1 + pick(rng, 3);
    for (int i = 0; i < n; ++i) {
      const double thickness = uniform(rng, 0.05, 0.4);
      boxes.push_back(make_box(Vec3(uniform(rng, 0.02, 0.6), uniform(rng, 0.02, 0.6), thickness)));
      const bool flat = pick(rng, 2) == 0;
      Pose pose;
      pose.rotation =
          Eigen::AngleAxisd(uniform(rng, 0, 6), flat ? Vec3(Vec3::UnitZ()) : random_vector(rng, 1).normalized());
      pose.position = Vec3(uniform(rng, 0, 1), uniform(rng, 0, 1), flat ? -0.5 * thickness : uniform(rng, -0.2, 0.2));
      pose.velocity = random_vector(rng, 1);
      poses.push_back(pose);
    }
  }

  std::vector<PosedObstacle> obstacles() const {
    std::vector<PosedObstacle> posed;
    for (std::size_t i = 0; i < boxes.size(); ++i) posed.push_back({&boxes[i], poses[i]});
    return posed;
  }

  // A quarter of the room it has, along the border for border vertices.
  void move_eol(int v) {
    const Mesh& mesh = cloth.mesh;
    double room = 1;
    for (const int h : mesh.outgoing(v))
      room = std::min(room, 2 * mesh.material_area(Mesh::face_of(h)) / mesh.material_length(Mesh::next(h)));
    Vec2 way(uniform(rng, -1, 1), uniform(rng, -1, 1));
    if (mesh.is_border_vertex(v)) {
      const std::vector<int> around = mesh.neighbours(v);
      const Vec2 tangent = (mesh.X[around.front()] - mesh.X[around.back()]).normalized();
      way = way.dot(tangent) * tangent;
    }
    const Vec2 before = mesh.X[v];
    cloth.mesh.X[v] += 0.25 * room * way;
    for (const int h : mesh.outgoing(v))
      if (mesh.material_area(Mesh::face_of(h)) < 1e-12) cloth.mesh.X[v] = before;
    cloth.V[v] = Vec2(uniform(rng, -1, 1), uniform(rng, -1, 1));
  }

  void move() {
    for (Pose& pose : poses) pose.position += random_vector(rng, 0.004);
    for (int v = 0; v < cloth.mesh.n_vertices(); ++v) {
      if (cloth.is_eol(v))
        move_eol(v);
      else
        cloth.mesh.x[v] += random_vector(rng, 0.0005);
    }
    match_tied();
  }

  Rng rng;
  Cloth cloth;
  double area = 0;
  std::vector<ObstacleShape> boxes;
  std::vector<Pose> poses;
  ConformOptions conforming;
  AdaptOptions sizes;
};

TEST(Remesh, KeepsItsInvariantsWhateverHappens) {
  for (std::uint64_t seed = 1; seed <= 30; ++seed) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    Chaos chaos(seed);
    for (int step = 0; step < 12; ++step) {
      const std::vector<PosedObstacle> obstacles = chaos.obstacles();
      const auto contacts = support::feature_contacts(chaos.cloth, obstacles, 1.5 * chaos.conforming.snap);
      const RemeshResult conformed = conform(chaos.cloth, contacts, obstacles, chaos.conforming);
      ASSERT_EQ(validate(conformed.cloth), std::nullopt) << "conform, step " << step;
      const RemeshResult adapted = adapt(conformed.cloth, chaos.sizes);
      ASSERT_EQ(validate(adapted.cloth), std::nullopt) << "adapt, step " << step;
      ASSERT_TRUE(conformed.cloth.mesh.is_compact() && adapted.cloth.mesh.is_compact());
      ASSERT_NEAR(support::total_area(adapted.cloth.mesh), chaos.area, 1e-11 * chaos.area);
      for (const Refusal& refusal : adapted.report.refusals)
        ASSERT_NE(refusal.reason, RefusalReason::BudgetSpent) << "step " << step;
      // Pinned vertices are never removed.
      const auto n_pinned = [](const Cloth& c) {
        return std::count_if(c.pins.begin(), c.pins.end(), [](std::uint64_t bits) { return bits != 0; });
      };
      ASSERT_GE(n_pinned(adapted.cloth), n_pinned(chaos.cloth));
      chaos.cloth = adapted.cloth;
      chaos.move();
      ASSERT_EQ(chaos.cloth.mesh.validate(), std::nullopt) << "the motion, step " << step;
    }
  }
}

TEST(Remesh, GivesTheSameBitsOnEveryRun) {
  const auto run = [] {
    Chaos chaos(77);
    for (int step = 0; step < 8; ++step) {
      const std::vector<PosedObstacle> obstacles = chaos.obstacles();
      const auto contacts = support::feature_contacts(chaos.cloth, obstacles, chaos.conforming.snap);
      chaos.cloth = adapt(conform(chaos.cloth, contacts, obstacles, chaos.conforming).cloth, chaos.sizes).cloth;
      chaos.move();
    }
    return chaos.cloth;
  };
  testing::expect_same_bits(run(), run());
}

}  // namespace
}  // namespace crease
