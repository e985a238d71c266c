// SPDX-License-Identifier: MIT
#include <gtest/gtest.h>

#include <sstream>

#include "crease/geometry/obj_io.hpp"
#include "crease/stepper/scene_io.hpp"
#include "crease/stepper/step.hpp"
#include "support/runs.hpp"
#include "support/scene_text.hpp"
#include "support/seams.hpp"

// Panels that are sewn together, from the file to the end of a run.
namespace crease {
namespace {

std::string obj_text(const Mesh& mesh) {
  const Cloth cloth = make_cloth(mesh);
  const NamedCloth named{"sheet", &cloth};
  std::ostringstream out;
  write_obj(out, std::span(&named, 1), 0);
  return out.str();
}

// A square metre cut along x = .5, which reaches .4 m over a table. The seam crosses the table's edge.
constexpr char scene_text[] = R"({
  "format": 1, "name": "sewn", "duration": 0.2, "time_step": 0.005,
  "cloths": [{
    "name": "sheet", "shape": {"mesh": "sheet.obj"}, "material": {"density": 0.05, "youngs": 50, "bending": 1e-5},
    "remeshing": {"method": "conformal", "size": [0.05, 0.25]},
    "pins": [{"where": {"vertices": [0]}, "axes": "z"}]
  }],
  "obstacles": [{"name": "table", "box": {"size": [2, 2, 1]}, "position": [0.5, 1.4, -0.5005]}],
  "output": {"fps": 60, "formats": ["obj"]}
})";

LoadedScene sewn_scene(const TestFolder& folder) {
  GridOptions grid;
  grid.cells = {8, 8};
  const auto side = [](const Vec2& c) { return c.x() < 0.5 ? 0 : 1; };
  folder.write("sheet.obj", obj_text(support::cut_and_sew(make_grid(grid), side).mesh));
  return load_scene(folder.write("scene.json", scene_text));
}

TEST(SewnCloth, StaysClosedWhileItIsRemeshedOverAnEdge) {
  const TestFolder folder;
  const LoadedScene loaded = sewn_scene(folder);
  const Scene& scene = loaded.scene;
  SheetSettings settings;
  settings.material = scene.cloths[0].material;
  settings.dynamics.gravity = scene.gravity;
  settings.threshold = scene.threshold;
  settings.pins = scene.cloths[0].pins;
  SheetStepper stepper(settings, make_stages(scene, scene.cloths[0]));
  Cloth cloth = loaded.cloths[0];
  const auto n_tied = [&] {
    int n = 0;
    for (int v = 0; v < cloth.mesh.n_vertices(); ++v) n += cloth.mesh.is_tied(v) ? 1 : 0;
    return n;
  };
  const int n_before = n_tied();
  const double seam = support::border_length(cloth.mesh, true), open = support::border_length(cloth.mesh, false);
  int eol = 0;
  for (int n = 0; n < 40; ++n) {
    StepResult result = stepper.step(cloth, scene.obstacles, n * scene.time_step, scene.time_step);
    ASSERT_EQ(result.report.status, StepStatus::Done) << "step " << n << ": " << result.report.message;
    cloth = std::move(result.cloth);
    // Tied vertices share position and velocity to the last bit.
    ASSERT_EQ(validate(cloth), std::nullopt) << "step " << n;
    EXPECT_NEAR(support::border_length(cloth.mesh, true), seam, 1e-12);
    EXPECT_NEAR(support::border_length(cloth.mesh, false), open, 1e-12);
    eol = std::max(eol, cloth.n_eol());
  }
  EXPECT_GT(n_tied(), n_before);  // the fold at the table's edge is fine enough to split the seam
  EXPECT_GT(eol, 5);              // chains on both panels
}

TEST(SewnCloth, RunIsResumedToTheSameBytes) {
  const TestFolder folder;
  const LoadedScene loaded = sewn_scene(folder);
  const auto whole = folder.path() / "whole", parts = folder.path() / "parts";
  ASSERT_EQ(run_scene(loaded, {.directory = whole}).status, RunStatus::Done);
  ASSERT_EQ(run_scene(loaded, {.directory = parts, .until = 0.12}).status, RunStatus::Done);
  ASSERT_EQ(run_scene(loaded, {.directory = parts, .resume = true}).status, RunStatus::Done);
  EXPECT_EQ(testing::differences(testing::repeatable_bytes(whole), testing::repeatable_bytes(parts)),
            std::vector<std::string>());
  // The frames are sewn cloths again.
  const Mesh last = read_obj(whole / "frames" / "000012.obj");
  EXPECT_EQ(last.validate(), std::nullopt);
  EXPECT_TRUE(last.has_seams());
}

TEST(SewnCloth, HangsAsOneSheetDoes) {
  GridOptions grid;
  grid.cells = {6, 6};
  grid.pattern = GridPattern::Irregular;
  const Mesh sheet = make_grid(grid);
  const support::CutSheet cut = support::cut_and_sew(sheet, [](const Vec2& c) { return c.x() + c.y() < 1 ? 0 : 1; });
  Cloth whole = make_cloth(sheet), sewn = make_cloth(cut.mesh);
  PinSpec pin;
  SheetSettings settings;
  settings.material.bending = 1e-4;
  settings.pins = {pin};
  Scene scene;
  ClothSpec spec;
  spec.pins = {pin};
  // The ends of the seam, in whose vertices both panels take part.
  for (int v = 0; v < sheet.n_vertices(); ++v)
    if (sheet.X[v] == Vec2(1, 0) || sheet.X[v] == Vec2(0, 1)) whole.pins[v] = 1;
  for (int v = 0; v < cut.mesh.n_vertices(); ++v) sewn.pins[v] = whole.pins[cut.whole[v]];
  SheetStepper one(settings, make_stages(scene, spec)), other(settings, make_stages(scene, spec));
  const double h = 5e-3;
  for (int n = 0; n < 40; ++n) {
    const StepResult a = one.step(whole, {}, n * h, h), b = other.step(sewn, {}, n * h, h);
    ASSERT_EQ(a.report.status, StepStatus::Done) << a.report.message;
    ASSERT_EQ(b.report.status, StepStatus::Done) << b.report.message;
    whole = a.cloth;
    sewn = b.cloth;
  }
  ASSERT_EQ(validate(sewn), std::nullopt);
  double moved = 0;
  for (int v = 0; v < sewn.mesh.n_vertices(); ++v) {
    // The solver's tolerance, summed up over 40 steps.
    EXPECT_LT((sewn.mesh.x[v] - whole.mesh.x[cut.whole[v]]).norm(), 1e-7);
    moved = std::max(moved, (sewn.mesh.x[v] - cut.mesh.x[v]).norm());
  }
  EXPECT_GT(moved, 0.05);
}

}  // namespace
}  // namespace crease
