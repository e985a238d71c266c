// SPDX-License-Identifier: MIT
//
// Sharp features of every kind, moved along under a flat and under a folded sheet. How often: CREASE_SWEEP_POSITIONS,
// CREASE_SWEEP_NAME.
#include <gtest/gtest.h>

#include <iostream>

#include "sweep_cases.hpp"

namespace crease {
namespace {

using support::Sweep;
using support::SweepCase;

class FeatureSweep : public ::testing::TestWithParam<std::tuple<int, bool>> {};

// Whatever lies under the sheet: a valid mesh always; a step of some length possible, and each feature either conformed
// to from end to end or a reason given why not.
TEST_P(FeatureSweep, IsConformedToOrRefusedWithAReason) {
  const SweepCase features = support::sweep_cases()[static_cast<std::size_t>(std::get<0>(GetParam()))];
  const bool folded = std::get<1>(GetParam());
  Sweep::Setup setup;
  if (folded) setup.crease = 0.62;
  if (CREASE_SWEEP_POSITIONS < 100) setup.cells = 12;  // for the sake of time
  setup.pattern = folded ? GridPattern::Irregular : GridPattern::Cross;
  Sweep sweep(setup, features.shapes);
  support::run(sweep, features, CREASE_SWEEP_POSITIONS);
  const Sweep::Tally& tally = sweep.tally;
  std::cout << features.name << (folded ? ", folded: " : ", flat: ") << support::describe(tally) << '\n';
  EXPECT_EQ(tally.broken, "");
  EXPECT_EQ(tally.jams, 0) << tally.first_jam;
  EXPECT_EQ(tally.silent, 0) << tally.first_silent;
  if (features.shapes.size() == 1) {                         // else two chains cross, where one of them stops
    EXPECT_LE(tally.refused, CREASE_SWEEP_POSITIONS / 500);  // for a reason; measured: 1 in 1000, WouldInvert
  }
}

INSTANTIATE_TEST_SUITE_P(CREASE_SWEEP_NAME, FeatureSweep, ::testing::Combine(::testing::Range(0, 5), ::testing::Bool()),
                         [](const auto& test) {
                           const auto index = static_cast<std::size_t>(std::get<0>(test.param));
                           return support::sweep_cases()[index].name + (std::get<1>(test.param) ? "Folded" : "Flat");
                         });

}  // namespace
}  // namespace crease
