// SPDX-License-Identifier: MIT
#include <gtest/gtest.h>

#include <algorithm>
#include <limits>

#include <Eigen/Geometry>

#include "support/mesh_oracle.hpp"

namespace crease {
namespace {

using support::all_meshes;
using support::canonical;
using support::euler_characteristic;
using support::live_faces;
using support::ragged_meshes;
using support::rebuild;
using support::Rng;
using support::total_area;

double world_area(const Mesh& mesh) {
  double sum = 0;
  for (int f = 0; f < mesh.face_slots(); ++f) {
    if (!mesh.face_live(f)) continue;
    const auto x = world_corners(mesh, f);
    sum += 0.5 * (x[1] - x[0]).cross(x[2] - x[0]).norm();
  }
  return sum;
}

int count_tagged(const Mesh& mesh) {
  int n = 0;
  for (const int h : mesh.edges()) n += mesh.tag(h) != 0 ? 1 : 0;
  return n;
}

// -- split -----------------------------------------------------------------------------------------------------------

TEST(SplitEdge, KeepsSurfaceTagsAndSlots) {
  for (const auto& [name, flat] : ragged_meshes()) {
    SCOPED_TRACE(name);
    Mesh mesh = flat;
    Rng rng(1);
    support::crumple(mesh, rng);
    for (const int h : mesh.edges()) {
      Mesh m = mesh;
      m.set_tag(h, 3);
      ASSERT_TRUE(m.can_split(h, 0.25));
      const int a = m.from(h), b = m.to(h), twin = m.twin(h);
      const auto made = m.split(h, 0.25);
      ASSERT_EQ(m.validate(), std::nullopt);
      // Rounding of one position in a sum of about 100 areas of 0.02.
      EXPECT_NEAR(total_area(m), total_area(mesh), 1e-14);
      EXPECT_NEAR(world_area(m), world_area(mesh), 1e-13);
      EXPECT_EQ(m.x[made.vertex], mesh.x[a] + 0.25 * (mesh.x[b] - mesh.x[a]));
      EXPECT_EQ(m.from(h), a);
      EXPECT_EQ(m.to(h), made.vertex);
      EXPECT_EQ(m.twin(h), twin);
      EXPECT_EQ(m.tag(h), 3);
      EXPECT_EQ(m.tag(m.find_edge(made.vertex, b)), 3);
      EXPECT_EQ(count_tagged(m), 2);
      EXPECT_EQ(m.n_vertices(), mesh.n_vertices() + 1);
      EXPECT_EQ(m.n_faces(), mesh.n_faces() + (mesh.is_border(h) ? 1 : 2));
      EXPECT_EQ(made.faces.size(), mesh.is_border(h) ? 2u : 4u);
      EXPECT_EQ(euler_characteristic(m), euler_characteristic(mesh));
    }
  }
}

TEST(SplitEdge, HandsTheOtherTagsOn) {
  for (const auto& [name, mesh] : all_meshes()) {
    SCOPED_TRACE(name);
    for (const int h : mesh.edges()) {
      Mesh m = mesh;
      for (const int e : m.edges()) m.set_tag(e, 1 + e);
      m.split(h, 0.5);
      for (const int e : mesh.edges()) {
        if (e != h) {
          EXPECT_EQ(m.tag(m.find_edge(mesh.from(e), mesh.to(e))), 1 + e);
        }
      }
      EXPECT_EQ(m.validate(), std::nullopt);
    }
  }
}

TEST(SplitEdge, RefusesParametersOutsideTheEdgeAndChildrenWithoutArea) {
  const Mesh mesh = support::grid(GridPattern::Right);
  for (const double t : {0.0, 1.0, -0.5, 1.5, std::numeric_limits<double>::quiet_NaN(), 1e-12, 1 - 1e-12}) {
    EXPECT_FALSE(mesh.can_split(0, t)) << t;
  }
  EXPECT_TRUE(mesh.can_split(0, 1e-6));
}

TEST(SplitFace, WorksOnEveryFace) {
  for (const auto& [name, flat] : ragged_meshes()) {
    SCOPED_TRACE(name);
    Mesh mesh = flat;
    Rng rng(1);
    support::crumple(mesh, rng);
    for (int f = 0; f < mesh.face_slots(); ++f) {
      Mesh m = mesh;
      for (const int e : m.edges()) m.set_tag(e, 1 + e);
      ASSERT_TRUE(m.can_split_face(f, Vec3(0.2, 0.3, 0.5)));
      const auto made = m.split_face(f, Vec3(0.2, 0.3, 0.5));
      ASSERT_EQ(m.validate(), std::nullopt);
      EXPECT_EQ(made.faces.size(), 3u);
      EXPECT_EQ(m.neighbours(made.vertex).size(), 3u);
      EXPECT_NEAR(total_area(m), total_area(mesh), 1e-14);
      EXPECT_NEAR(world_area(m), world_area(mesh), 1e-13);
      EXPECT_LT((barycentric(material_corners(mesh, f), m.X[made.vertex]) - Vec3(0.2, 0.3, 0.5)).norm(), 1e-13);
      for (const int e : mesh.edges()) EXPECT_EQ(m.tag(m.find_edge(mesh.from(e), mesh.to(e))), 1 + e);
      EXPECT_EQ(count_tagged(m), static_cast<int>(mesh.edges().size()));
    }
    EXPECT_FALSE(mesh.can_split_face(0, Vec3(0, 0.5, 0.5)));
    EXPECT_FALSE(mesh.can_split_face(0, Vec3(-0.1, 0.6, 0.5)));
  }
}

// -- flip ------------------------------------------------------------------------------------------------------------

TEST(FlipEdge, IsPossibleExactlyWhereAMeshRemains) {
  for (const auto& [name, mesh] : ragged_meshes()) {
    SCOPED_TRACE(name);
    for (const int h : mesh.edges()) {
      if (mesh.is_border(h)) {
        EXPECT_FALSE(mesh.can_flip(h));
        continue;
      }
      const int g = mesh.twin(h), a = mesh.from(h), b = mesh.opposite(h), c = mesh.to(h), d = mesh.opposite(g);
      auto faces = live_faces(mesh);
      faces[h / 3] = {d, b, a};
      faces[g / 3] = {b, d, c};
      const bool possible = rebuild(mesh, faces).has_value();
      ASSERT_EQ(mesh.can_flip(h), possible) << "edge " << a << "-" << c;
      if (!possible) continue;
      Mesh m = mesh;
      m.flip(h);
      ASSERT_EQ(m.validate(), std::nullopt);
      EXPECT_EQ(canonical(live_faces(m)), canonical(faces));
    }
  }
}

TEST(FlipEdge, TwiceGivesTheSameMeshAndTagsBack) {
  for (const auto& [name, mesh] : all_meshes()) {
    SCOPED_TRACE(name);
    for (const int h : mesh.edges()) {
      Mesh m = mesh;
      for (const int e : m.edges()) m.set_tag(e, e == h ? 0 : 1 + e);
      if (!m.can_flip(h)) continue;
      m.flip(h);
      ASSERT_EQ(m.validate(), std::nullopt);
      EXPECT_NEAR(total_area(m), total_area(mesh), 1e-14);
      ASSERT_TRUE(m.can_flip(h));
      m.flip(h);
      ASSERT_EQ(m.validate(), std::nullopt);
      EXPECT_EQ(canonical(live_faces(m)), canonical(live_faces(mesh)));
      for (const int e : mesh.edges()) {
        EXPECT_EQ(m.tag(m.find_edge(mesh.from(e), mesh.to(e))), e == h ? 0 : 1 + e);
      }
    }
  }
}

TEST(FlipEdge, RefusesTaggedEdges) {
  Mesh mesh = support::grid(GridPattern::Right);
  for (const int h : mesh.edges()) {
    if (!mesh.can_flip(h)) continue;
    mesh.set_tag(h, 1);
    EXPECT_FALSE(mesh.can_flip(h));
    mesh.set_tag(h, 0);
  }
}

// -- collapse --------------------------------------------------------------------------------------------------------

/// Faces after `vertex` has moved into `into`.
std::vector<std::array<int, 3>> merged_faces(const Mesh& mesh, int vertex, int into) {
  std::vector<std::array<int, 3>> faces;
  for (auto face : live_faces(mesh)) {
    std::replace(face.begin(), face.end(), vertex, into);
    if (std::count(face.begin(), face.end(), into) < 2) faces.push_back(face);
  }
  return faces;
}

TEST(CollapseEdge, IsPossibleExactlyWhereTheSameBorderRemains) {
  int possible = 0, impossible = 0;
  for (const auto& [name, mesh] : ragged_meshes()) {
    SCOPED_TRACE(name);
    for (int a = 0; a < mesh.n_vertices(); ++a) {
      for (const int b : mesh.neighbours(a)) {
        const auto faces = merged_faces(mesh, a, b);
        const auto rebuilt = rebuild(mesh, faces, a);
        const bool stays =
            !mesh.is_border_vertex(a) || (mesh.is_border(mesh.find_edge(a, b)) && !mesh.is_material_corner(a));
        const bool expected = stays && rebuilt && euler_characteristic(*rebuilt) == euler_characteristic(mesh);
        ASSERT_EQ(mesh.can_collapse_vertex(a, b), expected) << a << " into " << b;
        ++(expected ? possible : impossible);
        if (!expected) continue;
        Mesh m = mesh;
        const auto gone = m.collapse_vertex(a, b);
        ASSERT_EQ(m.validate(), std::nullopt);
        EXPECT_EQ(canonical(live_faces(m)), canonical(faces));
        EXPECT_EQ(gone.removed_faces.size(), mesh.is_border(mesh.find_edge(a, b)) ? 1u : 2u);
        for (const int f : gone.removed_faces) EXPECT_FALSE(m.face_live(f));
        for (const int f : gone.faces) EXPECT_TRUE(m.face_live(f));
        EXPECT_FALSE(m.vertex_live(a));
      }
    }
  }
  EXPECT_GT(possible, 500);
  EXPECT_GT(impossible, 500);
}

TEST(CollapseEdge, UndoesASplit) {
  for (const auto& [name, mesh] : ragged_meshes()) {
    SCOPED_TRACE(name);
    for (const int h : mesh.edges()) {
      for (const int end : {mesh.from(h), mesh.to(h)}) {
        Mesh m = mesh;
        for (const int e : m.edges()) m.set_tag(e, 1 + e);
        const int v = m.split(h, 0.5).vertex;
        ASSERT_TRUE(m.can_collapse_vertex(v, end));
        const auto gone = m.collapse_vertex(v, end);
        EXPECT_EQ(gone.vertex, v);
        EXPECT_EQ(gone.into, end);
        ASSERT_EQ(m.validate(), std::nullopt);
        EXPECT_EQ(canonical(live_faces(m)), canonical(live_faces(mesh)));
        for (const int e : mesh.edges()) EXPECT_EQ(m.tag(m.find_edge(mesh.from(e), mesh.to(e))), 1 + e);
      }
    }
  }
}

TEST(CollapseEdge, RefusesToRemoveTheLastFace) {
  // A border vertex on the flat side of its triangle: nothing but the face count forbids it.
  const std::vector<Vec2> X = {{0, 0}, {1, -0.05}, {2, 0}};
  const Mesh mesh(X, std::vector<Vec3>(3, Vec3::Zero()), {{0, 1, 2}});
  ASSERT_FALSE(mesh.is_material_corner(1));
  EXPECT_FALSE(mesh.can_collapse_vertex(1, 0));
  EXPECT_FALSE(mesh.can_collapse_vertex(1, 2));
}

TEST(CollapseEdge, RefusesFacesSmallerThanAsked) {
  const Mesh mesh = support::grid(GridPattern::Right, 4, 4);
  const int v = 12;  // centre of the sheet, cells of 0.2: the faces that stay grow or keep 0.02
  ASSERT_TRUE(mesh.can_collapse_vertex(v, 13));
  EXPECT_TRUE(mesh.can_collapse_vertex(v, 13, 0.0199));
  EXPECT_FALSE(mesh.can_collapse_vertex(v, 13, 0.0201));
}

TEST(CollapseEdge, ShortensATaggedLineOnlyAlongItself) {
  Mesh mesh = support::grid(GridPattern::Alternating, 6, 6);
  const int row = 3 * 7;
  for (int i = 0; i < 6; ++i) mesh.set_tag(mesh.find_edge(row + i, row + i + 1), 5);
  const int v = row + 3;
  EXPECT_TRUE(mesh.can_collapse_vertex(v, v + 1));
  EXPECT_TRUE(mesh.can_collapse_vertex(v, v - 1));
  EXPECT_FALSE(mesh.can_collapse_vertex(v, v + 7));
  EXPECT_TRUE(mesh.can_collapse_vertex(v + 7, v)) << "an untagged vertex may go into the line";
  EXPECT_FALSE(mesh.can_collapse_vertex(row, row + 1)) << "the end of the line would leave the border";
  mesh.set_tag(mesh.find_edge(v, v + 7), 6);
  EXPECT_FALSE(mesh.can_collapse_vertex(v, v + 1)) << "a junction of two lines would move";
  mesh.set_tag(mesh.find_edge(v, v + 7), 5);
  EXPECT_FALSE(mesh.can_collapse_vertex(v, v + 1)) << "three edges of one line do not tell which way it runs";
}

}  // namespace
}  // namespace crease
