// SPDX-License-Identifier: MIT
#pragma once

#include <algorithm>
#include <cmath>
#include <random>
#include <vector>

#include <Eigen/Geometry>

#include "crease/constraints/rows.hpp"
#include "crease/geometry/cloth.hpp"
#include "crease/geometry/dof_map.hpp"
#include "crease/geometry/grid.hpp"
#include "crease/geometry/obstacle.hpp"

namespace crease::testing {

/// A sheet with a chain of EOL vertices along one edge of a box.
///
/// Unless transformed: the sheet lies in z = 0 over [0, 0.6] x [0, 0.4]; the box is under its half x < 0.3, so the edge
/// runs along y with the outward normals +x and +z; the other half hangs at `bend` below the horizontal.
struct EolSheet {
  Cloth cloth;
  ObstacleShape shape;
  Pose pose;
  FeatureId feature;                                ///< the box edge
  std::vector<int> chain;                           ///< EOL vertices, ascending in y
  Vec3 up{0, 0, 1}, side{1, 0, 0}, along{0, 1, 0};  ///< of the edge, in world

  std::vector<PosedObstacle> obstacles() const { return {{&shape, pose}}; }
  ConstraintRows rows(const std::vector<Contact>& contacts = {}, const std::vector<PinState>& pins = {},
                      double h = 1e-2) const {
    ConstraintOptions options;
    options.h = h;
    return build_constraints(cloth, make_dof_map(cloth), contacts, obstacles(), pins, options);
  }
};

inline constexpr double sheet_length = 0.6, sheet_width = 0.4;

/// Index of the edge of `shape` whose two normals are n0 and n1 in either order, -1 if there is none.
inline int find_feature_edge(const ObstacleShape& shape, const Vec3& n0, const Vec3& n1) {
  for (std::size_t e = 0; e < shape.edges.size(); ++e) {
    const auto& n = shape.edges[e].normals;
    if ((n[0].isApprox(n0) && n[1].isApprox(n1)) || (n[0].isApprox(n1) && n[1].isApprox(n0))) {
      return static_cast<int>(e);
    }
  }
  return -1;
}

inline EolSheet make_eol_sheet(double bend = 0, GridPattern pattern = GridPattern::Right) {
  EolSheet sheet;
  sheet.cloth = make_cloth(make_grid({.size = {sheet_length, sheet_width}, .cells = {4, 4}, .pattern = pattern}));
  sheet.shape = make_box({1.0, 2.0, 0.5});
  sheet.pose.position = {0.5 * sheet_length - 0.5, 0.5 * sheet_width, -0.25};
  sheet.feature = {0, FeatureKind::Edge, find_feature_edge(sheet.shape, Vec3::UnitX(), Vec3::UnitZ())};

  Mesh& mesh = sheet.cloth.mesh;
  for (int v = 0; v < mesh.vertex_slots(); ++v) {
    const double overhang = mesh.X[v].x() - 0.5 * sheet_length;
    if (overhang > 0) mesh.x[v] += overhang * Vec3(std::cos(bend) - 1, 0, -std::sin(bend));
    if (std::abs(overhang) < 1e-9) sheet.chain.push_back(v);
  }
  std::sort(sheet.chain.begin(), sheet.chain.end(), [&](int a, int b) { return mesh.X[a].y() < mesh.X[b].y(); });
  for (const int v : sheet.chain) sheet.cloth.feature[v] = sheet.feature;
  for (std::size_t i = 1; i < sheet.chain.size(); ++i) {
    mesh.set_tag(mesh.find_edge(sheet.chain[i - 1], sheet.chain[i]), edge_tag(0, sheet.feature.index));
  }
  return sheet;
}

/// Moves cloth and obstacle together.
inline void place(EolSheet& sheet, const Mat3& Q, const Vec3& shift) {
  for (Vec3& x : sheet.cloth.mesh.x) x = Q * x + shift;
  sheet.pose.position = Q * sheet.pose.position + shift;
  sheet.pose.rotation = Q * sheet.pose.rotation;
  sheet.pose.velocity = Q * sheet.pose.velocity;
  sheet.pose.spin = Q * sheet.pose.spin * Q.transpose();
  sheet.up = Q * sheet.up;
  sheet.side = Q * sheet.side;
  sheet.along = Q * sheet.along;
}

/// Changes the material coordinates alone: another choice of texture, the same cloth.
inline void place_material(EolSheet& sheet, double angle, const Vec2& shift) {
  for (Vec2& X : sheet.cloth.mesh.X) X = Eigen::Rotation2Dd(angle) * X + shift;
}

inline double uniform(std::mt19937_64& rng, double low, double high) {
  return std::uniform_real_distribution<double>(low, high)(rng);
}

inline Mat3 random_rotation(std::mt19937_64& rng) {
  std::normal_distribution<double> normal;
  return Eigen::Quaterniond(normal(rng), normal(rng), normal(rng), normal(rng)).normalized().toRotationMatrix();
}

inline Vec3 random_vector(std::mt19937_64& rng, double size) {
  return {uniform(rng, -size, size), uniform(rng, -size, size), uniform(rng, -size, size)};
}

/// Numbers of the rows of one kind at a vertex (any vertex if -1), ascending.
inline std::vector<int> rows_of(const std::vector<RowInfo>& info, RowKind kind, int vertex = -1) {
  std::vector<int> found;
  for (std::size_t r = 0; r < info.size(); ++r) {
    if (info[r].kind == kind && (vertex < 0 || info[r].vertex == vertex)) found.push_back(static_cast<int>(r));
  }
  return found;
}

/// The coefficients of row r on xdot of a vertex.
inline Vec3 world_part(const SparseRows& A, int r, const DofMap& dofs, int vertex) {
  return {A.coeff(r, dofs.x(vertex)), A.coeff(r, dofs.x(vertex) + 1), A.coeff(r, dofs.x(vertex) + 2)};
}
/// ... and on Xdot.
inline Vec2 material_part(const SparseRows& A, int r, const DofMap& dofs, int vertex) {
  return {A.coeff(r, dofs.X(vertex)), A.coeff(r, dofs.X(vertex) + 1)};
}

}  // namespace crease::testing
