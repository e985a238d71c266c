// SPDX-License-Identifier: MIT
#include <algorithm>
#include <memory>

#include "crease/base/require.hpp"
#include "crease/constraints/lagrangian.hpp"
#include "crease/geometry/wire.hpp"
#include "crease/stepper/step.hpp"
#include "resolution.hpp"

namespace crease {
namespace {

/// What a fold would reach in this many steps is cleared out of its way, so that a step, which may cross 0.3 of a
/// triangle, need not be cut; up to this share of the longest edge wanted, beyond which it is cut.
constexpr double steps_ahead = 7;
constexpr double clearance_share_of_longest = 0.35;

/// A step may end with the cloth this deep inside an obstacle, as a share of the contact threshold, without being
/// solved again: a tenth of what is promised, and far above what a solver leaves.
constexpr double foreseen_depth = 0.1;

using RemeshStage = decltype(Stages::remesh);

/// Conformal remeshing of a method without Eulerian unknowns: the mesh follows features as ever, but its vertices are
/// Lagrangian. Those that still stand on a feature in the next step are its chain again, what has moved off is made
/// conformal anew.
RemeshStage without_eulerian(RemeshStage conforming, double threshold) {
  return [threshold, remesh = std::move(conforming)](const Cloth& cloth, std::span<const Contact> contacts,
                                                     std::span<const PosedObstacle> obstacles, double h) {
    Cloth marked = cloth;
    mark_standing(marked, obstacles, threshold);
    spread_wire_sides(marked, obstacles);
    RemeshResult result = remesh(marked, contacts, obstacles, h);
    for (int v = 0; v < result.cloth.mesh.vertex_slots(); ++v)
      if (result.cloth.is_eol(v)) make_lagrangian(result.cloth, v);
    result.report.inserted = result.report.released = 0;  // no vertex changed its kind
    return result;
  };
}

decltype(Stages::constrain) lagrangian_rows(const Scene& scene) {
  const auto normals =
      scene.contact == ContactMethod::LagrangianCone ? LagrangianNormals::Cone : LagrangianNormals::Averaged;
  return
      [normals, threshold = scene.threshold](const Cloth& cloth, const DofMap& dofs, std::span<const Contact> contacts,
                                             std::span<const PosedObstacle> obstacles, std::span<const PinState> pins,
                                             const ConstraintOptions& options) {
        return build_constraints(cloth, dofs, lagrangian_contacts(cloth, contacts, obstacles, normals, threshold),
                                 obstacles, pins, options);
      };
}

}  // namespace

RemeshResult chain_passes(RemeshResult first, RemeshResult second) {
  if (!second.report.changed) {
    first.report.smallest_angle = second.report.smallest_angle;
    first.report.refusals.insert(first.report.refusals.end(), second.report.refusals.begin(),
                                 second.report.refusals.end());
    return first;
  }
  RemeshReport& a = first.report;
  RemeshReport& b = second.report;
  const auto renumbered = [&b](int between) { return between == Mesh::none ? Mesh::none : b.vertex_map[between]; };
  for (Refusal& r : a.refusals) r.vertex = renumbered(r.vertex);
  if (a.changed) {
    for (int& v : a.vertex_map) v = renumbered(v);
    b.vertex_map = std::move(a.vertex_map);
  }
  b.inserted += a.inserted;
  b.released += a.released;
  b.splits += a.splits;
  b.flips += a.flips;
  b.collapses += a.collapses;
  b.before = a.before;
  b.momentum_change += a.momentum_change;
  b.refusals.insert(b.refusals.begin(), a.refusals.begin(), a.refusals.end());
  return second;
}

Stages make_stages(const Scene& scene, const ClothSpec& spec, int threads) {
  Stages stages;
  if (!scene.obstacles.empty()) {
    auto detector = std::make_shared<Detector>();
    stages.detect = [detector, threshold = scene.threshold, g = scene.gravity.norm()](
                        const Cloth& cloth, std::span<const PosedObstacle> obstacles, double h) {
      return detector->detect(cloth, obstacles, {threshold, h, g * h * h});
    };
    // A Lagrangian method has other normals than the contacts, and stays what it is compared as.
    if (scene.contact == ContactMethod::Eol)
      stages.foresee = [detector, depth = foreseen_depth * scene.threshold](
                           const Cloth& cloth, std::span<const PosedObstacle> obstacles, double h) {
        return detector->foresee(cloth, obstacles, h, depth);
      };
  }
  AdaptOptions adapt_options = spec.adapt;
  adapt_options.threshold = scene.threshold;
  if (spec.remeshing == RemeshMethod::Adaptive)
    stages.remesh = [options = adapt_options](const Cloth& cloth, std::span<const Contact>,
                                              std::span<const PosedObstacle> obstacles,
                                              double) { return adapt(cloth, options, obstacles); };
  const bool is_lagrangian = scene.contact != ContactMethod::Eol && !scene.obstacles.empty();
  if (spec.remeshing == RemeshMethod::Conformal)
    // The way ahead is that of whole steps, also in the parts of one that is retried: less room would defeat the retry.
    stages.remesh = [options = adapt_options, look_ahead = steps_ahead * scene.time_step, is_lagrangian](
                        const Cloth& cloth, std::span<const Contact> contacts, std::span<const PosedObstacle> obstacles,
                        double) {
      ConformOptions conform_options;
      conform_options.snap = options.threshold;
      conform_options.merge = merge_distance(cloth, options);
      conform_options.look_ahead = look_ahead;
      conform_options.eulerian = !is_lagrangian;
      conform_options.clearance = clearance_share_of_longest * options.size[1];
      RemeshResult conformed = conform(cloth, contacts, obstacles, conform_options);
      RemeshResult adapted = adapt(conformed.cloth, options, obstacles);
      return chain_passes(std::move(conformed), std::move(adapted));
    };
  if (is_lagrangian && spec.remeshing == RemeshMethod::Conformal)
    stages.remesh = without_eulerian(std::move(stages.remesh), scene.threshold);
  if (scene.obstacles.empty() && spec.pins.empty()) return stages;
  stages.constrain = build_constraints;
  if (is_lagrangian) stages.constrain = lagrangian_rows(scene);
  auto solver = std::shared_ptr<QpSolver>(make_qp_solver(scene.qp, threads));
  stages.solve = [solver, tolerance = scene.tolerance](const QpProblem& problem, std::span<const char> guess) {
    QpOptions options;
    options.tolerance = tolerance;
    return solver->solve(problem, options, guess);
  };
  return stages;
}

}  // namespace crease
