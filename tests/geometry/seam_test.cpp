// SPDX-License-Identifier: MIT
#include <gtest/gtest.h>

#include <algorithm>
#include <array>

#include "crease/geometry/cloth.hpp"
#include "crease/geometry/dof_map.hpp"
#include "support/seams.hpp"

namespace crease {
namespace {

using support::border_length;
using support::sewn_meshes;

TEST(Seam, HasTwoSidesThatRunOppositeWaysBetweenTheSamePlaces) {
  for (const auto& [name, mesh] : sewn_meshes()) {
    SCOPED_TRACE(name);
    ASSERT_EQ(mesh.validate(), std::nullopt);
    int n = 0;
    for (int h = 0; h < 3 * mesh.face_slots(); ++h) {
      const int g = mesh.seam_twin(h);
      if (g == Mesh::none) continue;
      ++n;
      EXPECT_EQ(mesh.seam_twin(g), h);
      EXPECT_TRUE(mesh.is_border(h) && mesh.is_border(g));
      EXPECT_EQ(mesh.x[mesh.from(h)], mesh.x[mesh.to(g)]);
      EXPECT_EQ(mesh.x[mesh.to(h)], mesh.x[mesh.from(g)]);
      EXPECT_NEAR(mesh.material_length(h), mesh.material_length(g), 1e-14);  // panels were cut from one sheet
      EXPECT_TRUE(mesh.on_seam(mesh.from(h)) && mesh.on_seam(mesh.to(h)));
    }
    EXPECT_GT(n, 0);
  }
}

// The Euler characteristic of the sewn cloth, with tied vertices and seam edges counted once, is that of the surface.
TEST(Seam, MakesTheSurfaceThatItIsMeantToBe) {
  const auto euler = [](const Mesh& mesh) {
    const DofMap dofs = make_dof_map(make_cloth(mesh));
    int n_points = 0, n_sides = 0;
    for (int v = 0; v < mesh.n_vertices(); ++v) n_points += dofs.owner(v) == v ? 1 : 0;
    for (int h = 0; h < 3 * mesh.face_slots(); ++h) n_sides += mesh.seam_twin(h) != Mesh::none ? 1 : 0;
    return n_points - (static_cast<int>(mesh.edges().size()) - n_sides / 2) + mesh.n_faces();
  };
  EXPECT_EQ(euler(support::halves().mesh), 1);
  EXPECT_EQ(euler(support::patchwork().mesh), 1);
  EXPECT_EQ(euler(support::dart()), 1);
  EXPECT_EQ(euler(support::tube()), 0);
  EXPECT_EQ(euler(support::pillow()), 2);
}

TEST(Seam, IsSplitOnBothSidesAtOnePlace) {
  for (const auto& [name, start] : sewn_meshes()) {
    SCOPED_TRACE(name);
    for (int h = 0; h < 3 * start.face_slots(); ++h) {
      const int g = start.seam_twin(h);
      if (g == Mesh::none || !start.can_split(h, 0.3)) continue;
      Mesh mesh = start;
      const Mesh::Split made = mesh.split(h, 0.3);
      ASSERT_EQ(mesh.validate(), std::nullopt);
      ASSERT_EQ(made.tied, made.vertex + 1);
      EXPECT_EQ(mesh.n_vertices(), start.n_vertices() + 2);
      EXPECT_EQ(made.faces.size(), 4u);
      EXPECT_TRUE(mesh.are_tied(made.vertex, made.tied));
      EXPECT_EQ(mesh.x[made.vertex], mesh.x[made.tied]);
      const double length = start.material_length(g);
      EXPECT_NEAR((mesh.X[made.tied] - start.X[start.to(g)]).norm(), 0.3 * length, 1e-15);
      EXPECT_NEAR(border_length(mesh, true), border_length(start, true), 1e-13);
      EXPECT_NEAR(support::border_length(mesh, false), border_length(start, false), 1e-13);
    }
  }
}

// A split seam can be coarsened again, and is then what it was. Only an end that both sides share, as a dart has it,
// takes none of its neighbours in.
TEST(Seam, TakesItsSplitsBackOnBothSidesAtOnce) {
  for (const auto& [name, start] : sewn_meshes()) {
    SCOPED_TRACE(name);
    for (int h = 0; h < 3 * start.face_slots(); ++h) {
      const int g = start.seam_twin(h);
      if (g == Mesh::none || !start.can_split(h, 0.3)) continue;
      Mesh split = start;
      const int vertex = split.split(h, 0.3).vertex, tied = vertex + 1;
      const std::array<std::array<int, 2>, 2> ends{{{start.from(h), start.to(g)}, {start.to(h), start.from(g)}}};
      for (const auto& [into, into_there] : ends) {
        ASSERT_EQ(split.can_collapse_vertex(vertex, into), into != into_there);
        ASSERT_EQ(split.can_collapse_vertex(tied, into_there), into != into_there);
        if (into == into_there) continue;
        Mesh mesh = split;
        const Mesh::Collapse done = mesh.collapse_vertex(vertex, into);
        EXPECT_EQ(done.tied.vertex, tied);
        EXPECT_EQ(done.tied.into, into_there);
        ASSERT_EQ(mesh.validate(), std::nullopt);
        mesh.compact();
        ASSERT_EQ(mesh.X, start.X);
        EXPECT_EQ(mesh.n_faces(), start.n_faces());
        for (int v = 0; v < mesh.n_vertices(); ++v) EXPECT_EQ(mesh.tied(v), start.tied(v));
        EXPECT_NEAR(border_length(mesh, true), border_length(start, true), 1e-13);
        EXPECT_NEAR(border_length(mesh, false), border_length(start, false), 1e-13);
      }
    }
  }
}

// Nothing that would change a panel's shape, or what is sewn to what.
TEST(Seam, KeepsWhatHasAPartInItsShape) {
  const auto is_kept = [](const Mesh& mesh, int v) {
    const std::vector<int> around = mesh.neighbours(v);
    return std::none_of(around.begin(), around.end(), [&](int u) { return mesh.can_collapse_vertex(v, u); });
  };
  for (const auto& [name, mesh] : sewn_meshes()) {
    SCOPED_TRACE(name);
    for (int v = 0; v < mesh.n_vertices(); ++v) {
      if (!mesh.on_seam(v)) continue;
      const int h = mesh.halfedge(v), before = mesh.neighbours(v).back();
      const bool ends = mesh.across_seam(v, mesh.to(h)).vertex != mesh.across_seam(v, before).vertex;
      const bool is_crossing = mesh.tied(mesh.tied(v)) != v;
      EXPECT_TRUE(is_kept(mesh, v) || !(ends || is_crossing || !mesh.is_tied(v))) << v;
      // Along the seam, or not at all: no vertex leaves it.
      for (const int u : mesh.neighbours(v))
        EXPECT_FALSE(mesh.can_collapse_vertex(v, u) && mesh.across_seam(v, u).vertex == Mesh::none) << v << ' ' << u;
    }
  }
  const Mesh straight = support::halves().mesh;
  const auto is_inner = [&](int u) { return straight.is_tied(u) && !is_kept(straight, u); };
  int v = 0;
  while (v < straight.n_vertices() && !is_inner(v)) ++v;
  ASSERT_LT(v, straight.n_vertices());
  const Vec2 along = (straight.X[straight.neighbours(v).front()] - straight.X[v]).normalized();
  // One side bent, though both would still be as long as each other to 1e-8; one side gathered.
  for (const Vec2& aside : {Vec2(1e-5 * Vec2(-along.y(), along.x())), Vec2(1e-5 * along)}) {
    Mesh mesh = straight;
    mesh.X[v] += aside;
    ASSERT_EQ(mesh.validate(), std::nullopt);
    EXPECT_TRUE(is_kept(mesh, v));
    EXPECT_TRUE(is_kept(mesh, mesh.tied(v)));
  }
}

TEST(Seam, NoEdgeJoinsTiedVertices) {
  // A tube of two cells: nearly every flip or collapse would join the two sides of the seam.
  Mesh mesh = support::tube(3);
  for (const int h : mesh.edges())
    if (mesh.face_live(Mesh::face_of(h)) && mesh.can_flip(h)) mesh.flip(h);
  for (const int h : mesh.edges())
    if (mesh.face_live(Mesh::face_of(h)) && mesh.can_collapse(h)) mesh.collapse(h);
  EXPECT_EQ(mesh.validate(), std::nullopt);
}

// The open end of a tube is a ring of border edges; of the last two, each would be the other side of the other.
TEST(Seam, NoneComesToBeWhereATubeIsOpen) {
  for (const bool forth : {true, false}) {
    Mesh mesh = support::tube(4);
    const double open = support::border_length(mesh, false);
    for (bool changed = true; changed;) {
      changed = false;
      for (const int h : mesh.edges()) {
        if (!mesh.is_border(h)) continue;
        const int a = forth ? mesh.from(h) : mesh.to(h), b = forth ? mesh.to(h) : mesh.from(h);
        if (!mesh.can_collapse_vertex(a, b)) continue;
        mesh.collapse_vertex(a, b);
        changed = true;
        break;
      }
      ASSERT_NEAR(support::border_length(mesh, false), open, 1e-12);
      ASSERT_EQ(mesh.validate(), std::nullopt);
    }
    EXPECT_LT(mesh.n_vertices(), 25) << "something did collapse";
  }
}

TEST(Seam, SurvivesCompacting) {
  for (const auto& [name, start] : sewn_meshes()) {
    SCOPED_TRACE(name);
    Mesh mesh = start;
    for (const int h : mesh.edges())
      if (mesh.face_live(Mesh::face_of(h)) && mesh.can_collapse(h)) mesh.collapse(h);
    ASSERT_LT(mesh.n_vertices(), mesh.vertex_slots());
    const Mesh before = mesh;
    const std::vector<int> now = mesh.compact().vertex;
    ASSERT_EQ(mesh.validate(), std::nullopt);
    for (int v = 0; v < before.vertex_slots(); ++v) {
      if (!before.vertex_live(v)) continue;
      EXPECT_EQ(mesh.tied(now[v]), now[before.tied(v)]);
    }
  }
}

TEST(Seam, ValidateSaysWhatIsBroken) {
  const Mesh good = support::halves().mesh;
  int v = 0;
  while (!good.is_tied(v)) ++v;
  Mesh apart = good;
  apart.x[v].z() += 1e-300;
  EXPECT_NE(apart.validate().value_or("").find("stand apart"), std::string::npos);
  EXPECT_THROW(apart.tie(v, v + 1), std::invalid_argument);

  Cloth cloth = make_cloth(good);
  cloth.v[v] = Vec3(0, 0, 1);
  EXPECT_NE(validate(cloth).value_or("").find("moves or is held otherwise"), std::string::npos);
  cloth = make_cloth(good);
  cloth.pins[v] = 1;
  EXPECT_NE(validate(cloth).value_or("").find("moves or is held otherwise"), std::string::npos);
  cloth = make_cloth(good);
  cloth.feature[v] = {0, FeatureKind::Edge, 0};
  EXPECT_NE(validate(cloth), std::nullopt);

  // Three squares along one line are no surface; two of them run the same way there, whichever way they are turned.
  const Mesh one = support::grid(GridPattern::Right, 1, 1);
  std::vector<Vec2> X;
  std::vector<Vec3> x;
  std::vector<std::array<int, 3>> faces;
  for (int copy = 0; copy < 3; ++copy) {
    for (int f = 0; f < one.n_faces(); ++f) {
      faces.push_back(one.face(f));
      for (int& corner : faces.back()) corner += copy * one.n_vertices();
    }
    for (const Vec2& P : one.X) {
      X.push_back(P + Vec2(copy, 0));
      x.emplace_back(copy == 0 ? P.x() : -P.x(), P.y(), copy == 2 ? P.x() : 0);
    }
  }
  Mesh three(X, x, faces);
  support::sew(three);
  EXPECT_NE(three.validate().value_or("").find("runs beside"), std::string::npos);
}

TEST(DofMap, TiedVerticesShareTheirUnknowns) {
  const Mesh mesh = support::patchwork().mesh;
  Cloth cloth = make_cloth(mesh);
  const DofMap dofs = make_dof_map(cloth);
  int n_points = 0;
  for (int v = 0; v < mesh.n_vertices(); ++v) {
    EXPECT_EQ(dofs.x(v), dofs.x(mesh.tied(v)));
    EXPECT_LE(dofs.owner(v), v);
    n_points += dofs.owner(v) == v ? 1 : 0;
  }
  EXPECT_EQ(dofs.size(), 3 * n_points);
  const std::vector<int> blocks = dof_blocks(dofs);
  EXPECT_EQ(static_cast<int>(blocks.size()), n_points + 1);
  VecX q(dofs.size());
  for (int i = 0; i < q.size(); ++i) q[i] = i;
  scatter_velocity(q, dofs, cloth);
  EXPECT_EQ(validate(cloth), std::nullopt);
  EXPECT_EQ(gather_velocity(cloth, dofs), q);
}

}  // namespace
}  // namespace crease
