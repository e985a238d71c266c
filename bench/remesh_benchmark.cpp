// SPDX-License-Identifier: MIT
#include <array>
#include <cmath>
#include <vector>

#include <benchmark/benchmark.h>

#include "crease/collision/detect.hpp"
#include "crease/geometry/grid.hpp"
#include "crease/remesh/remesh.hpp"

// What one pass of the adaptive remesher costs on about 3000 faces, at rest and at work.
namespace crease {
namespace {

AdaptOptions options() {
  AdaptOptions options;
  options.size = {0.02, 0.1};
  return options;
}

// A ridge across the sheet, which `place` moves along it; behind it a swell that nowhere goes flat.
void ripple(Cloth& cloth, double place) {
  for (int v = 0; v < cloth.mesh.n_vertices(); ++v) {
    const Vec2& X = cloth.mesh.X[v];
    const double s = X.x() + 0.3 * X.y() - place;
    cloth.mesh.x[v] =
        Vec3(X.x(), X.y(), 0.06 * std::exp(-90 * s * s) + 0.03 * std::sin(7 * X.x()) * std::cos(5 * X.y()));
    cloth.v[v] = Vec3(0, std::sin(6 * X.x()), std::cos(4 * X.y()));
  }
}

Cloth sheet(double place) {
  GridOptions grid;
  grid.size = Vec2(2, 2);
  grid.cells = {20, 20};
  grid.pattern = GridPattern::Irregular;
  Cloth cloth = make_cloth(make_grid(grid));
  for (int pass = 0; pass < 20; ++pass) {
    ripple(cloth, place);
    RemeshResult result = adapt(cloth, options());
    cloth = std::move(result.cloth);
    if (!result.report.changed) break;
  }
  return cloth;
}

void count(benchmark::State& state, const RemeshResult& result) {
  state.counters["faces"] = result.cloth.mesh.n_faces();
  state.counters["splits"] = result.report.splits;
  state.counters["flips"] = result.report.flips;
  state.counters["collapses"] = result.report.collapses;
}

void pass_with_nothing_due(benchmark::State& state) {
  Cloth cloth = sheet(0.5);
  RemeshResult result = adapt(cloth, options());
  for (auto _ : state) benchmark::DoNotOptimize(result = adapt(cloth, options()));
  count(state, result);
}
BENCHMARK(pass_with_nothing_due)->Unit(benchmark::kMillisecond);

void pass_on_a_flat_sheet(benchmark::State& state) {
  GridOptions grid;
  grid.cells = {27, 27};
  grid.pattern = GridPattern::Cross;
  Cloth cloth = make_cloth(make_grid(grid));
  RemeshResult result;
  for (auto _ : state) benchmark::DoNotOptimize(result = adapt(cloth, options()));
  count(state, result);
}
BENCHMARK(pass_on_a_flat_sheet)->Unit(benchmark::kMillisecond);

void pass_after_a_small_motion(benchmark::State& state) {
  Cloth cloth = sheet(0.5);
  ripple(cloth, 0.5 + 1e-4 * static_cast<double>(state.range(0)));
  RemeshResult result;
  for (auto _ : state) benchmark::DoNotOptimize(result = adapt(cloth, options()));
  count(state, result);
}
BENCHMARK(pass_after_a_small_motion)->Arg(5)->Arg(20)->Arg(80)->Arg(160)->Arg(240)->Unit(benchmark::kMillisecond);

// A sheet bent over the edge of a box, with a chain of Eulerian vertices along it.
void conform_with_nothing_due(benchmark::State& state) {
  GridOptions grid;
  grid.size = Vec2(2.1, 2.1);
  grid.cells = {28, 28};
  Cloth cloth = make_cloth(make_grid(grid));
  const ObstacleShape box = make_box(Vec3(2, 4, 1));
  Pose pose;
  pose.position = Vec3(1.031, 1.05, -0.5);
  const std::array<PosedObstacle, 1> obstacles{{{&box, pose}}};
  for (Vec3& x : cloth.mesh.x)
    if (const double over = x.x() - 2.031; over > 0) x = Vec3(2.031 + 0.1 * over, x.y(), -0.99 * over);
  ConformOptions options;
  options.snap = 2e-3;
  Detector detector;
  for (int pass = 0; pass < 5; ++pass)
    cloth = conform(cloth, detector.detect(cloth, obstacles, {options.snap, 0, 0}), obstacles, options).cloth;
  const std::vector<Contact> contacts = detector.detect(cloth, obstacles, {options.snap, 0, 0});
  RemeshResult result;
  for (auto _ : state) benchmark::DoNotOptimize(result = conform(cloth, contacts, obstacles, options));
  count(state, result);
  state.counters["eol"] = result.cloth.n_eol();
  state.counters["contacts"] = static_cast<double>(contacts.size());
}
BENCHMARK(conform_with_nothing_due)->Unit(benchmark::kMillisecond);

void sizes_of_every_vertex(benchmark::State& state) {
  const Cloth cloth = sheet(0.5);
  for (auto _ : state) benchmark::DoNotOptimize(sizing_field(cloth, options()));
}
BENCHMARK(sizes_of_every_vertex)->Unit(benchmark::kMillisecond);

}  // namespace
}  // namespace crease

BENCHMARK_MAIN();
