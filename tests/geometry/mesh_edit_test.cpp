// SPDX-License-Identifier: MIT
#include <gtest/gtest.h>

#include "support/meshes.hpp"

namespace crease {
namespace {

using support::all_meshes;

TEST(SplitEdge, WorksOnEveryEdge) {
  for (const auto& [name, mesh] : all_meshes()) {
    SCOPED_TRACE(name);
    for (const int h : mesh.edges()) {
      Mesh m = mesh;
      m.set_tag(h, 3);
      ASSERT_TRUE(m.can_split(h, 0.25));
      const int a = m.from(h), b = m.to(h);
      const auto made = m.split(h, 0.25);
      ASSERT_EQ(m.validate(), std::nullopt);
      // Rounding of one position in a sum of about 100 areas of 0.02.
      EXPECT_NEAR(support::total_area(m), support::total_area(mesh), 1e-14);
      EXPECT_EQ(m.from(h), a);
      EXPECT_EQ(m.to(h), made.vertex);
      EXPECT_EQ(m.tag(h), 3);
      EXPECT_EQ(m.tag(m.find_edge(made.vertex, b)), 3);
      int tagged = 0;
      for (const int e : m.edges()) tagged += m.tag(e) != 0 ? 1 : 0;
      EXPECT_EQ(tagged, 2);
      EXPECT_EQ(m.n_vertices(), mesh.n_vertices() + 1);
      EXPECT_EQ(m.n_faces(), mesh.n_faces() + (mesh.is_border(h) ? 1 : 2));
      EXPECT_EQ(support::euler_characteristic(m), support::euler_characteristic(mesh));
    }
  }
}

TEST(FlipEdge, TwiceGivesTheSameEdgeBack) {
  for (const auto& [name, mesh] : all_meshes()) {
    SCOPED_TRACE(name);
    for (const int h : mesh.edges()) {
      if (!mesh.can_flip(h)) continue;
      Mesh m = mesh;
      const int a = m.from(h), b = m.opposite(h), c = m.to(h), d = m.opposite(m.twin(h));
      m.flip(h);
      ASSERT_EQ(m.validate(), std::nullopt);
      EXPECT_EQ(m.find_edge(a, c), Mesh::none);
      EXPECT_NE(m.find_edge(b, d), Mesh::none);
      ASSERT_TRUE(m.can_flip(h));
      m.flip(h);
      ASSERT_EQ(m.validate(), std::nullopt);
      EXPECT_NE(m.find_edge(a, c), Mesh::none);
      EXPECT_NEAR(support::total_area(m), support::total_area(mesh), 1e-14);
    }
  }
}

TEST(CollapseEdge, UndoesASplit) {
  for (const auto& [name, mesh] : all_meshes()) {
    SCOPED_TRACE(name);
    for (const int h : mesh.edges()) {
      Mesh m = mesh;
      const int a = m.from(h), v = m.split(h, 0.5).vertex;
      ASSERT_TRUE(m.can_collapse_vertex(v, a));
      const auto gone = m.collapse_vertex(v, a);
      EXPECT_EQ(gone.vertex, v);
      EXPECT_EQ(gone.into, a);
      ASSERT_EQ(m.validate(), std::nullopt);
      EXPECT_EQ(m.n_faces(), mesh.n_faces());
      EXPECT_EQ(m.edges().size(), mesh.edges().size());
      EXPECT_NEAR(support::total_area(m), support::total_area(mesh), 1e-14);
    }
  }
}

}  // namespace
}  // namespace crease
