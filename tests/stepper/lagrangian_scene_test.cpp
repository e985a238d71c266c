// SPDX-License-Identifier: MIT
//
// The Lagrangian methods in the scene edge, coarse and pulled level with the table, judged from outside: on the frames
// they wrote. Each must end, and fail as the paper says it does.                            [WEIDNER18, Sec. 7, Fig. 4]
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

#include "support/scene_run.hpp"

namespace crease {
namespace {

using testing::Frame;

// The box of scenes/edge.json and its edge.
const Vec3 box_low{0.3175, -0.3075, -1.049}, box_high{1.5175, 1.1925, -0.049};
constexpr double edge_x = 0.3175, edge_z = -0.049;
constexpr double pull_speed = 0.1, from = 0.6, to = 1.2;

struct Outcome {
  double slid = 0;         ///< of the way that was pulled
  double lifted = 0;       ///< greatest height over the table within 5 cm of the edge [m]
  double penetration = 0;  ///< [m]
};

/// Material coordinate across the edge where the sheet passes over it, mean along the edge.
double material_at_edge(const Frame& frame) {
  double sum = 0;
  int n = 0;
  for (const auto& f : frame.faces)
    for (int k = 0; k < 3; ++k) {
      const int a = f[k], b = f[(k + 1) % 3];
      const double p = frame.x[a].x() - edge_x - 1e-6, q = frame.x[b].x() - edge_x - 1e-6;
      if (!(p * q < 0)) continue;
      const double t = p / (p - q);
      sum += (1 - t) * frame.X[a].x() + t * frame.X[b].x();
      ++n;
    }
  return sum / n;
}

double height_behind_edge(const Frame& frame) {
  double highest = 0;
  for (const Vec3& x : frame.x)
    if (x.x() > edge_x && x.x() < edge_x + 0.05) highest = std::max(highest, x.z() - edge_z);
  return highest;
}

Outcome run_variant(const std::string& name) {
  std::vector<std::pair<std::string, std::string>> changes{{"cloths.0.shape.grid.cells", "[8,8]"},
                                                           {"cloths.0.placement", R"({"origin": [0, 0, -0.0485]})"}};
  if (name != "edge_regular") changes.emplace_back("cloths.0.remeshing.size", "[0.07,0.15]");
  const auto frames = testing::run_shipped(name, changes, "coarse", to);
  Outcome outcome;
  double first = NAN, last = NAN, first_time = 0, last_time = 0;
  for (const Frame& frame : frames) {
    outcome.penetration = std::max(outcome.penetration, testing::box_penetration(frame, box_low, box_high));
    if (frame.time < from) continue;
    last = material_at_edge(frame), last_time = frame.time;
    if (std::isnan(first)) first = last, first_time = frame.time;
    outcome.lifted = std::max(outcome.lifted, height_behind_edge(frame));
  }
  outcome.slid = (first - last) / (pull_speed * (last_time - first_time));
  return outcome;
}

TEST(LagrangianScene, EolSlidesOnTheEdge) {
  const Outcome eol = run_variant("edge");
  EXPECT_NEAR(eol.slid, 1, 0.03);
  EXPECT_LE(eol.lifted, 5e-4);
  EXPECT_LE(eol.penetration, 1e-3);
}

TEST(LagrangianScene, ConeNormalsLockTheSheet) {
  EXPECT_LE(run_variant("edge_conformal_cone").slid, 0.1);
}

TEST(LagrangianScene, AveragedNormalsLiftTheSheetOff) {
  const Outcome averaged = run_variant("edge_conformal");
  EXPECT_GE(averaged.lifted, 1e-3) << "the contact threshold: no contact holds it up there";
  EXPECT_NEAR(averaged.slid, 1, 0.1);
}

TEST(LagrangianScene, AFixedMeshCutsTheEdge) {
  EXPECT_GE(run_variant("edge_regular").penetration, 2e-3);
}

}  // namespace
}  // namespace crease
