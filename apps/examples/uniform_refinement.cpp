// SPDX-License-Identifier: MIT
//
// How to put a remesher of your own into the stepper: a function of (cloth, contacts, obstacles, h) that returns the
// new cloth and a report, assigned to one field of Stages. This one halves every edge that is longer than it may be,
// longest first; the scene's own choice is left aside.
//
//   uniform_refinement SCENE LONGEST_EDGE [STEPS]
#include <algorithm>
#include <cstdlib>
#include <exception>
#include <iostream>
#include <numeric>
#include <vector>

#include "crease/base/require.hpp"
#include "crease/stepper/scene_io.hpp"
#include "crease/stepper/step.hpp"

namespace crease {
namespace {

/// A split leaves surface and velocity field as they are, so nothing has to be given back. Ends: each split removes
/// length from the sum of what edges have too much.
RemeshResult refine_uniformly(Cloth cloth, double longest) {
  RemeshResult result;
  result.report.before = motion(cloth);
  result.report.vertex_map.resize(cloth.v.size());
  std::iota(result.report.vertex_map.begin(), result.report.vertex_map.end(), 0);  // splits renumber nothing
  Mesh& mesh = cloth.mesh;
  for (bool changed = true; changed;) {
    changed = false;
    std::vector<int> edges = mesh.edges();
    std::stable_sort(edges.begin(), edges.end(),
                     [&](int g, int h) { return mesh.material_length(g) > mesh.material_length(h); });
    for (const int h : edges) {
      if (mesh.tag(h) != 0 || mesh.material_length(h) <= longest || !mesh.can_split(h, 0.5)) continue;
      const int a = mesh.from(h), b = mesh.to(h);
      mesh.split(h, 0.5);
      cloth.v.push_back(0.5 * (cloth.v[a] + cloth.v[b]));
      cloth.V.push_back(Vec2::Zero());
      cloth.feature.push_back({});
      cloth.pins.push_back(cloth.pins[a] & cloth.pins[b]);
      ++result.report.splits;
      changed = result.report.changed = true;
    }
  }
  result.report.after = motion(cloth);
  result.cloth = std::move(cloth);
  return result;
}

int run(const std::string& file, double longest, int steps) {
  require(longest > 0, "uniform_refinement: expected a longest edge above 0");
  const LoadedScene loaded = load_scene(file);
  const Scene& scene = loaded.scene;
  const ClothSpec& spec = scene.cloths.front();
  Stages stages = make_stages(scene, spec);
  stages.remesh = [longest](const Cloth& cloth, std::span<const Contact>, std::span<const PosedObstacle>, double) {
    return refine_uniformly(cloth, longest);
  };
  SheetSettings settings;
  settings.material = spec.material;
  settings.dynamics = {scene.gravity, scene.velocity_terms};
  settings.pins = spec.pins;
  SheetStepper stepper(settings, stages);
  Cloth cloth = loaded.cloths.front();
  std::cout << "faces given " << cloth.mesh.n_faces() << '\n';
  for (int n = 0; n < steps; ++n) {
    StepResult result = stepper.step(cloth, scene.obstacles, n * scene.time_step, scene.time_step);
    if (result.report.status != StepStatus::Done) {
      std::cerr << to_string(result.report.status) << ": " << result.report.message << '\n';
      return 1;
    }
    cloth = std::move(result.cloth);
    std::cout << "step " << n + 1 << ": faces " << cloth.mesh.n_faces() << ", splits " << result.report.splits
              << ", membrane energy " << result.report.energies.membrane << " J\n";
  }
  return 0;
}

}  // namespace
}  // namespace crease

int main(int argc, char** argv) {
  if (argc < 3) {
    std::cerr << "uniform_refinement SCENE LONGEST_EDGE [STEPS]\n";
    return 2;
  }
  try {
    return crease::run(argv[1], std::atof(argv[2]), argc > 3 ? std::atoi(argv[3]) : 5);
  } catch (const std::exception& trouble) {
    std::cerr << trouble.what() << '\n';
    return 2;
  }
}
