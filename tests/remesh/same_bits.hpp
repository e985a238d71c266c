// SPDX-License-Identifier: MIT
#pragma once

#include <gtest/gtest.h>

#include "crease/geometry/cloth.hpp"

namespace crease::testing {

inline void expect_same_bits(const Cloth& a, const Cloth& b) {
  ASSERT_EQ(a.mesh.vertex_slots(), b.mesh.vertex_slots());
  ASSERT_EQ(a.mesh.face_slots(), b.mesh.face_slots());
  for (int f = 0; f < a.mesh.face_slots(); ++f) EXPECT_EQ(a.mesh.face(f), b.mesh.face(f));
  EXPECT_EQ(a.mesh.X, b.mesh.X);
  EXPECT_EQ(a.mesh.x, b.mesh.x);
  EXPECT_EQ(a.v, b.v);
  EXPECT_EQ(a.V, b.V);
  EXPECT_EQ(a.feature, b.feature);
}

}  // namespace crease::testing
