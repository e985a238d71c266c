// SPDX-License-Identifier: MIT
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "support/mesh_oracle.hpp"

namespace crease {
namespace {

using support::euler_characteristic;
using support::live_faces;
using support::pick;
using support::rebuild;
using support::Rng;
using support::total_area;
using support::uniform;

TEST(Compact, RenamesAndKeepsEverythingElse) {
  for (const auto& [name, mesh] : support::ragged_meshes()) {
    SCOPED_TRACE(name);
    Mesh m = mesh;
    for (const int e : m.edges()) {
      if (m.face_live(e / 3) && m.can_collapse(e)) m.collapse(e);
    }
    int tag = 0;
    for (const int e : m.edges()) m.set_tag(e, ++tag % 3);
    const Mesh before = m;
    const auto ids = m.compact();
    EXPECT_TRUE(m.is_compact());
    ASSERT_EQ(m.validate(), std::nullopt);
    EXPECT_EQ(m.n_vertices(), before.n_vertices());
    EXPECT_EQ(m.n_faces(), before.n_faces());
    int next = 0;
    for (int v = 0; v < before.vertex_slots(); ++v) {
      EXPECT_EQ(ids.vertex[v], before.vertex_live(v) ? next++ : Mesh::none);
      if (!before.vertex_live(v)) continue;
      EXPECT_EQ(m.X[ids.vertex[v]], before.X[v]);
      EXPECT_EQ(m.x[ids.vertex[v]], before.x[v]);
    }
    next = 0;
    for (int f = 0; f < before.face_slots(); ++f) {
      EXPECT_EQ(ids.face[f], before.face_live(f) ? next++ : Mesh::none);
      if (!before.face_live(f)) continue;
      for (int k = 0; k < 3; ++k) {
        EXPECT_EQ(m.face(ids.face[f])[k], ids.vertex[before.face(f)[k]]);
        EXPECT_EQ(m.tag(3 * ids.face[f] + k), before.tag(3 * f + k));
      }
    }
  }
}

/// Tags the lowest border and, where the mesh has one, the row of edges at `height`.
void tag_lines(Mesh& mesh, double height) {
  for (const int h : mesh.edges()) {
    const double ya = mesh.X[mesh.from(h)].y(), yb = mesh.X[mesh.to(h)].y();
    if (ya == 0 && yb == 0) mesh.set_tag(h, 1);
    if (std::abs(ya - height) < 1e-12 && std::abs(yb - height) < 1e-12) mesh.set_tag(h, 2);
  }
}

double tagged_length(const Mesh& mesh, int tag) {
  double sum = 0;
  for (const int h : mesh.edges()) sum += mesh.tag(h) == tag ? mesh.material_length(h) : 0.0;
  return sum;
}

/// One random operation, if the mesh allows it; keeps the face count about `target`.
bool random_operation(Mesh& mesh, Rng& rng, int target) {
  const int h = pick(rng, 3 * mesh.face_slots());
  if (!mesh.face_live(h / 3)) return false;
  const int kind = pick(rng, 8);
  if (kind < 4) {
    if (!mesh.can_flip(h)) return false;
    mesh.flip(h);
  } else if (mesh.n_faces() < target && kind == 4) {
    const Vec3 b(uniform(rng, 0.1, 1), uniform(rng, 0.1, 1), uniform(rng, 0.1, 1));
    if (!mesh.can_split_face(h / 3, b)) return false;
    mesh.split_face(h / 3, b);
  } else if (mesh.n_faces() < target) {
    const double t = uniform(rng, 0.2, 0.8);
    if (!mesh.can_split(h, t)) return false;
    mesh.split(h, t);
  } else {
    const bool forwards = pick(rng, 2) == 0;
    const int vertex = forwards ? mesh.from(h) : mesh.to(h), into = forwards ? mesh.to(h) : mesh.from(h);
    if (!mesh.can_collapse_vertex(vertex, into, 1e-6)) return false;
    mesh.collapse_vertex(vertex, into);
  }
  return true;
}

/// Where every tagged vertex must stand.
void expect_tagged_vertices_on_their_lines(const Mesh& mesh, double height) {
  for (const int h : mesh.edges()) {
    if (mesh.tag(h) == 0) continue;
    const double y = mesh.tag(h) == 1 ? 0 : height;
    EXPECT_NEAR(mesh.X[mesh.from(h)].y(), y, 1e-12);  // rounding of a few hundred nested splits
    EXPECT_NEAR(mesh.X[mesh.to(h)].y(), y, 1e-12);
  }
}

TEST(MeshEdit, KeepsItsInvariantsThroughRandomSequences) {
  const auto meshes = support::all_meshes();
  const int n_operations = 100'000 / static_cast<int>(meshes.size());
  for (const auto& [name, start] : meshes) {
    SCOPED_TRACE(name);
    Mesh mesh = start;
    Rng rng(42);
    support::crumple(mesh, rng);
    const double height = 0.4;  // the second row of cells of 0.2
    tag_lines(mesh, height);
    const double area = total_area(mesh), line_1 = tagged_length(mesh, 1), line_2 = tagged_length(mesh, 2);
    const int euler = euler_characteristic(mesh), target = std::max(40, start.n_faces());
    int done = 0;
    for (int attempt = 0; attempt < 100 * n_operations && done < n_operations; ++attempt) {
      if (!random_operation(mesh, rng, target + 20 * ((attempt / 512) % 2))) continue;
      ++done;
      if (done % 1000 == 0) mesh.compact();
      if (done > 400 && done % 50 != 0) continue;
      ASSERT_EQ(mesh.validate(), std::nullopt) << "after operation " << done;
      ASSERT_EQ(euler_characteristic(mesh), euler);
      ASSERT_NEAR(total_area(mesh), area, 1e-12 * area) << "after operation " << done;
      ASSERT_NEAR(tagged_length(mesh, 1), line_1, 1e-12);
      ASSERT_NEAR(tagged_length(mesh, 2), line_2, 1e-12);
    }
    EXPECT_EQ(done, n_operations);
    expect_tagged_vertices_on_their_lines(mesh, height);
    mesh.compact();
    // The adjacency that 12500 operations maintained is the one that the face list implies.
    const auto fresh = rebuild(mesh, live_faces(mesh));
    ASSERT_TRUE(fresh.has_value());
    for (int h = 0; h < 3 * mesh.face_slots(); ++h) EXPECT_EQ(mesh.twin(h), fresh->twin(h));
    for (int v = 0; v < mesh.n_vertices(); ++v) EXPECT_EQ(mesh.is_border_vertex(v), fresh->is_border_vertex(v));
  }
}

}  // namespace
}  // namespace crease
