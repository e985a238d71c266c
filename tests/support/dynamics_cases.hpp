// SPDX-License-Identifier: MIT
#pragma once

// Small cloths in general position, and a dense linearly implicit step, for tests of the assembled system.

#include <cmath>
#include <functional>
#include <utility>
#include <vector>

#include <Eigen/Cholesky>

#include "crease/dynamics/assemble.hpp"
#include "crease/geometry/cloth.hpp"
#include "crease/geometry/dof_map.hpp"
#include "crease/geometry/grid.hpp"
#include "support/element_cases.hpp"

namespace crease::testing {

inline void make_eol(Cloth& cloth, int vertex) {
  cloth.feature[vertex] = {0, FeatureKind::Edge, 0};
}

inline void map_world(Cloth& cloth, const std::function<Vec3(const Vec2&)>& shape) {
  for (std::size_t v = 0; v < cloth.mesh.X.size(); ++v) cloth.mesh.x[v] = shape(cloth.mesh.X[v]);
}

/// An irregular sheet of size 1 x 0.8, stretched and bumpy, in random motion; every `eol_every`-th interior vertex is
/// Eulerian (0 = none). Bumps of `bump` m make all F differ, so that M is positive definite with Eulerian vertices too.
inline Cloth random_cloth(std::uint64_t seed, int cells, double bump, int eol_every) {
  Rng rng(seed);
  Cloth cloth = make_cloth(
      make_grid({.size = {1, 0.8}, .cells = {cells, cells}, .pattern = GridPattern::Irregular, .seed = seed}));
  const Mat32 F = rng.rotation().leftCols<2>() * Mat2{{1.1, 0.05}, {-0.02, 0.97}};
  int interior = 0;
  for (int v = 0; v < cloth.mesh.n_vertices(); ++v) {
    cloth.mesh.x[v] = F * cloth.mesh.X[v] + rng.vec3(bump);
    cloth.v[v] = rng.vec3();
    if (cloth.mesh.is_border_vertex(v) || eol_every == 0 || interior++ % eol_every != 0) continue;
    make_eol(cloth, v);
    cloth.V[v] = rng.vec2(0.5);
  }
  return cloth;
}

/// A sheet 1 x 1 of n x n jittered cells, n even, folded isometrically by `angle` about X = 0.5, which is a mesh line;
/// the vertices inside that line are Eulerian.
inline Cloth folded_cloth(int n, double angle, std::uint64_t seed) {
  Cloth cloth = make_cloth(make_grid({.size = {1, 1}, .cells = {n, n}, .pattern = GridPattern::Right}));
  Rng rng(seed);
  for (int v = 0; v < cloth.mesh.n_vertices(); ++v) {
    const bool on_fold = std::abs(cloth.mesh.X[v].x() - 0.5) < 1e-12;
    if (cloth.mesh.is_border_vertex(v)) continue;
    const Vec2 shift = rng.vec2(0.15 / n);
    cloth.mesh.X[v] += on_fold ? Vec2(0, shift.y()) : shift;
    if (on_fold) make_eol(cloth, v);
  }
  map_world(cloth, [angle](const Vec2& P) {
    const double s = P.x() - 0.5;
    return s <= 0 ? Vec3(s, P.y(), 0) : Vec3(s * std::cos(angle), P.y(), -s * std::sin(angle));
  });
  return cloth;
}

/// The motions that are left when the vertices chosen by `pinned` are held: columns of the identity.
inline MatX free_motions(const Cloth& cloth, const DofMap& dofs, const std::function<bool(const Vec2&)>& pinned) {
  std::vector<Eigen::Index> free;
  for (int v = 0; v < cloth.mesh.n_vertices(); ++v) {
    if (pinned(cloth.mesh.X[v])) continue;
    for (int k = dofs.start[v]; k < dofs.start[v + 1]; ++k) free.push_back(k);
  }
  MatX motions = MatX::Zero(dofs.size(), static_cast<Eigen::Index>(free.size()));
  for (std::size_t k = 0; k < free.size(); ++k) motions(free[k], static_cast<Eigen::Index>(k)) = 1;
  return motions;
}

inline MatX all_motions(const DofMap& dofs) {
  return MatX::Identity(dofs.size(), dofs.size());
}

/// qdot of H qdot = rhs among the combinations of the columns of `motions`.
inline VecX solve_step(const AssembledSystem& system, const MatX& motions) {
  const MatX H = motions.transpose() * (system.H * motions);
  return motions * Eigen::LDLT<MatX>(H).solve(motions.transpose() * system.rhs);
}

inline void advance(Cloth& cloth, const DofMap& dofs, const VecX& q_dot, double h) {
  scatter_velocity(q_dot, dofs, cloth);
  for (int v = 0; v < cloth.mesh.n_vertices(); ++v) {
    cloth.mesh.x[v] += h * cloth.v[v];
    cloth.mesh.X[v] += h * cloth.V[v];
  }
}

/// Repeats steps of length h, each from rest, until the force along `motions` is below `tolerance` [N].
/// Returns false if `max_steps` were not enough.
inline bool settle(Cloth& cloth, const Material& material, const MatX& motions, double h, double tolerance,
                   int max_steps) {
  const DofMap dofs = make_dof_map(cloth);
  Assembler assembler;
  for (int step = 0; step < max_steps; ++step) {
    for (Vec3& v : cloth.v) v.setZero();
    const AssembledSystem& system = assembler.assemble(cloth, dofs, material, {}, h, step > 0);
    if ((motions.transpose() * system.force).cwiseAbs().maxCoeff() < tolerance) return true;
    advance(cloth, dofs, solve_step(system, motions), h);
  }
  return false;
}

}  // namespace crease::testing
