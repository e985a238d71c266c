// SPDX-License-Identifier: MIT
#pragma once

// Runs one frictionless sheet over sharp edges through the shipped stages and shows an observer every step.

#include <functional>
#include <limits>
#include <vector>

#include "support/strip_run.hpp"

namespace crease::testing {

struct Slide {
  Cloth cloth;
  std::vector<Obstacle> obstacles;
  Material material;
  double element = 0.05;  ///< edges wanted: half of it to one and a half [m]
  double g = 9.81;
  std::vector<PinSpec> pins;
};

/// Called after every step; false ends the run.
using SlideObserver = std::function<bool(double time, const Cloth& cloth, const Reactions& reactions)>;

/// @return steps that were taken in halves
inline int run_slide(Slide slide, double h, double end, const SlideObserver& observe) {
  Scene scene;
  scene.obstacles = slide.obstacles;
  scene.time_step = h;
  ClothSpec spec;
  spec.material = slide.material;
  spec.remeshing = RemeshMethod::Conformal;
  spec.adapt.size = {0.5 * slide.element, 1.5 * slide.element};
  spec.adapt.velocity = 1e3;
  spec.adapt.angle = 1e3;
  spec.pins = slide.pins;
  SheetSettings settings;
  settings.material = slide.material;
  settings.dynamics.gravity = Vec3(0, 0, -slide.g);
  settings.threshold = scene.threshold;
  settings.pins = slide.pins;
  SheetStepper stepper(settings, make_stages(scene, spec));
  int cuts = 0;
  for (int n = 1; n * h < end + 1e-9; ++n) {
    const Reactions reactions = advance(stepper, slide.cloth, scene.obstacles, (n - 1) * h, h, cuts);
    if (!observe(n * h, slide.cloth, reactions)) break;
  }
  return cuts;
}

/// Makes vertices ride on an edge of an obstacle, and tags the mesh edges between them.
inline void put_on_edge(Cloth& cloth, const std::vector<int>& vertices, int obstacle, int edge) {
  for (const int v : vertices) cloth.feature[v] = {obstacle, FeatureKind::Edge, edge};
  for (const int h : cloth.mesh.edges())
    if (cloth.is_eol(cloth.mesh.from(h)) && cloth.is_eol(cloth.mesh.to(h)) &&
        cloth.feature[cloth.mesh.from(h)].obstacle == obstacle && cloth.feature[cloth.mesh.to(h)].obstacle == obstacle)
      cloth.mesh.set_tag(h, edge_tag(obstacle, edge));
}

}  // namespace crease::testing
