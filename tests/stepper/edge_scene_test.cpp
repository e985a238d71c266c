// SPDX-License-Identifier: MIT
//
// The shipped scene `edge`, run whole and judged from outside: on the frames it wrote, with its own box and pull.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

#include "support/scene_run.hpp"

namespace crease {
namespace {

using testing::Frame;

// The box of scenes/edge.json: size (1.2, 1.5, 1) about (.9175, .4425, -.549).
const Vec3 box_low{0.3175, -0.3075, -1.049}, box_high{1.5175, 1.1925, -0.049};
constexpr double edge_x = 0.3175, edge_z = -0.049;
constexpr double pull_speed = 0.1;
constexpr double settled = 0.6;  ///< the swing of the overhang after the fall has died down [s]

std::vector<Frame> run_edge(const std::vector<std::pair<std::string, std::string>>& changes, const std::string& label) {
  return testing::run_shipped("edge", changes, label);
}

/// Material overhang: how much cloth is left of the edge along its middle line.
double overhang(const Frame& frame) {
  double sum = 0;
  for (const int v : frame.eol) sum += frame.X[v].x();
  return frame.eol.empty() ? 0 : sum / static_cast<double>(frame.eol.size());
}

/// True once a part of the border that hung over the edge is up on the table. Below, it may touch the box's side.
bool border_has_passed(const Frame& frame) {
  for (std::size_t v = 0; v < frame.x.size(); ++v)
    if (frame.X[v].x() < 1e-9 && frame.x[v].x() >= edge_x && frame.x[v].z() >= edge_z - 1e-3) return true;
  return false;
}

/// Least-squares slope of the overhang over a span of time.
double slide_speed(const std::vector<Frame>& frames, double from, double to) {
  double n = 0, t = 0, y = 0, tt = 0, ty = 0;
  for (const Frame& frame : frames) {
    if (frame.time < from || frame.time > to) continue;
    const double left = overhang(frame);
    n += 1, t += frame.time, y += left, tt += frame.time * frame.time, ty += frame.time * left;
  }
  return -(n * ty - t * y) / (n * tt - t * t);
}

const Frame& frame_at(const std::vector<Frame>& frames, double time) {
  return *std::min_element(frames.begin(), frames.end(), [&](const Frame& a, const Frame& b) {
    return std::abs(a.time - time) < std::abs(b.time - time);
  });
}

/// What the sheet's way from the corners, held at height z = .049 m, down to the table costs of its length. Under the
/// tension rho g o of an overhang o it comes down along the parabola x^2 / (2 o), over d = sqrt(2 z o); the excess of
/// its length over d is the integral of (x / o)^2 / 2.
double sag_length(double overhang) {
  return std::pow(2 * 0.049 * overhang, 1.5) / (6 * overhang * overhang);
}

/// Largest jump of a vertex against its neighbours between frames, from settling to the passage of the border [m/s].
double largest_jump(const std::vector<Frame>& frames) {
  double jump = 0;
  for (std::size_t k = 1; k < frames.size(); ++k)
    if (frames[k].time >= settled && !border_has_passed(frames[k]))
      jump = std::max(jump, testing::largest_jump(frames[k - 1], frames[k]));
  return jump;
}

/// Along the edge; the whole edge is looked at where the chain is gone.
std::pair<double, double> chain_ends(const Frame& frame) {
  if (frame.eol.empty()) return {0.05, 0.95};
  const auto less = [&](int a, int b) { return frame.x[a].y() < frame.x[b].y(); };
  const auto [first, last] = std::minmax_element(frame.eol.begin(), frame.eol.end(), less);
  return {frame.x[*first].y(), frame.x[*last].y()};
}

/// What every resolution must show, from the settling of the overhang to the passage of the border.
void judge_contact(const std::vector<Frame>& frames) {
  ASSERT_GE(frames.size(), 240u);
  double farthest = 0, deepest = 0, off_feature = 0, shortest = 1, released = 0, released_before = -1;
  int judged = 0;
  std::size_t fewest = frames.size();
  for (const Frame& frame : frames) {
    deepest = std::max(deepest, testing::box_penetration(frame, box_low, box_high));
    if (frame.time < settled || border_has_passed(frame)) continue;
    ++judged;
    fewest = std::min(fewest, frame.time < 3 ? frame.eol.size() : fewest);
    for (const int v : frame.eol)
      off_feature = std::max(off_feature, std::hypot(frame.x[v].x() - edge_x, frame.x[v].z() - edge_z));
    const auto [first, last] = chain_ends(frame);
    if (frame.time < 3) shortest = std::min(shortest, last - first);
    for (int k = 0; k <= 20; ++k)
      farthest =
          std::max(farthest, testing::distance_to_surface(frame, {edge_x, first + (last - first) * k / 20, edge_z}));
    if (frame.time < 3) {
      released_before = released_before < 0 ? frame.released : released_before;
      released = frame.released - released_before;
    }
  }
  EXPECT_GE(judged, 150);
  EXPECT_LE(farthest, 5e-4) << "surface to edge line [m]";
  EXPECT_LE(largest_jump(frames), 0.2) << "vertex against its neighbours [m/s]";
  EXPECT_LE(deepest, 1e-3) << "penetration on the lattice [m]";
  // A vertex whose contact opens hovers, and is let go at 5e-4 m; none gets there (2.3e-4 m is the most seen).
  EXPECT_LE(off_feature, 4e-4) << "EOL vertex to edge line [m]";
  EXPECT_GE(fewest, 10u) << "vertices of the chain";
  EXPECT_EQ(released, 0) << "vertices that left it";
  EXPECT_GE(shortest, 0.99) << "from the chain's first vertex to its last, of a sheet 1 m wide";
}

TEST(EdgeScene, SlidesOverTheEdgeAtFiveHundredFaces) {
  judge_contact(
      run_edge({{"cloths.0.shape.grid.cells", "[11,11]"}, {"cloths.0.remeshing.size", "[0.05,0.12]"}}, "500"));
}

TEST(EdgeScene, OverhangShortensAtThePullSpeed) {
  // The shipped scene holds the corners 49 mm above the table: see sag_length(). Here they are held at the height of
  // the table: what is left is the stretch given back, rho g / E of the pull, 1e-3.
  const auto frames = run_edge({{"cloths.0.shape.grid.cells", "[11,11]"},
                                {"cloths.0.remeshing.size", "[0.05,0.12]"},
                                {"cloths.0.placement", R"({"origin": [0, 0, -0.0485]})"}},
                               "level");
  judge_contact(frames);
  EXPECT_NEAR(slide_speed(frames, settled, 3.2), pull_speed, 0.01 * pull_speed);
}

TEST(EdgeScene, SlidesOverTheEdgeAsShipped) {
  const auto frames = run_edge({}, "shipped");
  judge_contact(frames);
  // While the overhang is long the sag costs little: see sag_length(). Later it is counted.
  EXPECT_NEAR(slide_speed(frames, 0.8, 2.4), pull_speed, 0.03 * pull_speed);
  const Frame &first = frame_at(frames, settled), &last = frame_at(frames, 3.0);
  const double pulled = pull_speed * (last.time - first.time);
  EXPECT_NEAR(overhang(first) - overhang(last), pulled + sag_length(overhang(last)) - sag_length(overhang(first)),
              0.03 * pulled);
}

}  // namespace
}  // namespace crease
