// SPDX-License-Identifier: MIT
//
// Every scene with Eulerian unknowns as it ships, whole: ten times with its obstacles shaken by a millimetre and
// everything turned at random.
#include <gtest/gtest.h>

#include "support/shaken_runs.hpp"

namespace crease {
namespace {

using testing::ShakenScene;

class ShakenScenesAsShipped : public ::testing::TestWithParam<ShakenScene> {};

TEST_P(ShakenScenesAsShipped, EndWithTheClothOutside) {
  testing::expect_all_end_outside(GetParam(), "shipped");
}

INSTANTIATE_TEST_SUITE_P(Whole, ShakenScenesAsShipped,
                         ::testing::Values(ShakenScene{"drape_corner"}, ShakenScene{"edge"}, ShakenScene{"jaws"},
                                           ShakenScene{"lo_res"}, ShakenScene{"nails"}, ShakenScene{"prism"},
                                           ShakenScene{"push"}, ShakenScene{"tablecloth"}, ShakenScene{"throw"},
                                           ShakenScene{"wire"}),
                         testing::name_of);

}  // namespace
}  // namespace crease
