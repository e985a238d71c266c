// SPDX-License-Identifier: MIT
#include <gtest/gtest.h>

#include "support/mesh_edits.hpp"

namespace crease {
namespace {

TEST(Edits, KeepEveryInvariantAMillionTimes) {
  EXPECT_EQ(support::run_random_edits(1'000'000), std::nullopt);
}

}  // namespace
}  // namespace crease
