// SPDX-License-Identifier: MIT
//
// The shipped scenes `wire` and `nails`, somewhat coarser, judged from outside: on the frames they wrote.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

#include "support/scene_run.hpp"

namespace crease {
namespace {

using testing::Frame;

constexpr double threshold = 1e-3;

std::vector<Frame> run_coarse(const std::string& name, double until, const std::string& size) {
  return testing::run_shipped(name, {{"cloths.0.remeshing.size", size}, {"cloths.0.shape.grid.cells", "[10,10]"}},
                              "coarse", until);
}

/// Mean material place of the fold, across it.
double fold_place(const Frame& frame) {
  double sum = 0;
  for (const int v : frame.eol) sum += frame.X[v].y();
  return sum / static_cast<double>(frame.eol.size());
}

// scenes/wire.json: the wire is at y = .51 and ends at z = .49; the borders come to y = .4 and .6, at z = 0; one goes
// up by .15 until 1 s, the other down, and back until 1.3 s.
TEST(WireScene, FoldsOverTheWireAndSlidesToAndFro) {
  const std::vector<Frame> frames = run_coarse("wire", 1.4, "[0.05,0.1]");
  ASSERT_GE(frames.size(), 80u);
  double at_rest = 0, farthest = 0, back = 0;
  for (const Frame& frame : frames) {
    if (frame.time < 0.1) continue;
    ASSERT_GT(frame.eol.size(), 8u) << "at " << frame.time << " s";
    const double wire_z = -0.01 + std::min(frame.time, 0.5);
    for (const int v : frame.eol)
      EXPECT_LT(std::hypot(frame.x[v].y() - 0.51, frame.x[v].z() - wire_z), 0.5 * threshold) << "at " << frame.time;
    // It hangs and does not stand: nothing is higher than the wire by more than a bulge of a centimetre.
    for (const Vec3& x : frame.x) EXPECT_LT(x.z(), wire_z + 0.01) << "at " << frame.time;
    if (frame.time < 0.7) at_rest = fold_place(frame);
    if (frame.time < 1.01) farthest = fold_place(frame);
    back = fold_place(frame);
  }
  // The borders move by .15 m: the sheet is hardly longer than the way over the wire, so it has to follow. With y on
  // the rising side, the fold's material place goes down or up by nearly as much, and comes back within the slack.
  EXPECT_GT(std::abs(farthest - at_rest), 0.12);
  EXPECT_LT(std::abs(farthest - at_rest), 0.18);
  EXPECT_LT(std::abs(back - at_rest), 0.03);
}

// scenes/nails.json: until the border comes to the first row of tips, each of the 16 carries its own vertex, but for
// moments where the swinging sheet jumps off one by more than the hover (its vertex lingers above it for two steps, and
// is let go); and material slides over them after the held corners, which go .08 m from .5 s on.
TEST(NailsScene, SlidesOverEveryTipWithoutASnag) {
  const std::vector<Frame> frames = run_coarse("nails", 0.75, "[0.04,0.08]");
  ASSERT_GE(frames.size(), 45u);
  double first = 0, last = 0;
  int judged = 0, complete = 0;
  for (const Frame& frame : frames) {
    if (frame.time < 0.1) continue;
    double sum = 0;
    int on_tips = 0;
    for (const int v : frame.eol) {
      EXPECT_GT(frame.x[v].z(), -1e-3 - 0.5 * threshold) << "at " << frame.time;
      on_tips += frame.x[v].z() < -1e-3 + 0.5 * threshold ? 1 : 0;
      sum += frame.X[v].x();
    }
    ASSERT_GE(on_tips, 14) << "at " << frame.time << " s";
    ++judged;
    if (on_tips != 16 || frame.eol.size() != 16) continue;
    ++complete;
    if (frame.time < 0.5) first = sum / 16;
    last = sum / 16;
  }
  EXPECT_GE(complete, 0.9 * judged);
  EXPECT_LT(last, first - 0.05);
}

}  // namespace
}  // namespace crease
