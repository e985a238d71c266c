// SPDX-License-Identifier: MIT
//
// What a checkpoint keeps, and that none is believed that was damaged or that no run could have written. A run begins
// with a checkpoint of its start, and goes on from what it reads there: so a start stands for any state.
#include <algorithm>
#include <cmath>
#include <csignal>
#include <functional>
#include <memory>
#include <stdexcept>
#include <utility>

#include <gtest/gtest.h>

#include "support/meshes.hpp"
#include "support/run_control.hpp"
#include "support/scene_text.hpp"

namespace crease {
namespace {

using namespace testing;
using support::Rng;
using support::uniform;

/// Some vertices ride, some linger and some are lifted off the table's edges and corners; a chain; places just left.
LoadedScene lingering_scene() {
  LoadedScene loaded = table_scene();
  Cloth& cloth = loaded.cloths[0];
  Rng rng(5);
  int n_tagged = 0;
  for (const int h : cloth.mesh.edges()) {
    const int a = cloth.mesh.from(h), b = cloth.mesh.to(h);
    if (cloth.mesh.is_border_vertex(a) || cloth.mesh.is_border_vertex(b) || cloth.is_eol(a) || cloth.is_eol(b))
      continue;
    const int edge = n_tagged++ % 12;
    const bool lingers = n_tagged % 2 == 0;
    for (const int v : {a, b})
      cloth.feature[v] = {0,         FeatureKind::Edge,     edge,
                          v % 3 - 1, lingers || v % 3 == 0, lingers ? uniform(rng, 1e-4, 0.01) : 0.0};
    cloth.mesh.set_tag(h, edge_tag(0, edge));
  }
  for (int v = 0; v < cloth.mesh.n_vertices(); ++v) {
    if (!cloth.mesh.is_border_vertex(v) && !cloth.is_eol(v))
      cloth.feature[v] = {0, FeatureKind::Corner, v % 8, 0, true, uniform(rng, 1e-4, 0.01)};
    cloth.v[v] = {uniform(rng, -1, 1), uniform(rng, -1, 1), uniform(rng, -1, 1)};
    if (cloth.is_eol(v)) cloth.V[v] = {uniform(rng, -1, 1), uniform(rng, -1, 1)};
  }
  cloth.left = {{.feature = {0, FeatureKind::Edge, 7}, .from = 0.1, .to = 1 / 3.0, .age = 0.0025},
                {.feature = {0, FeatureKind::Corner, 5}, .age = 0.01},
                {.feature = {0, FeatureKind::Edge, 0}, .from = -1e-3, .to = 0.7}};
  return loaded;
}

/// The sheet as the run's first step sees it; the step fails then.
RunResult begin(const LoadedScene& loaded, const fs::path& directory, Cloth& seen) {
  RunOptions options{.directory = directory};
  options.stages = [&seen](const Scene& scene, const ClothSpec& spec) {
    Stages stages = make_stages(scene, spec);
    stages.detect = [&seen](const Cloth& cloth, std::span<const PosedObstacle>, double) -> std::vector<Contact> {
      seen = cloth;
      throw std::runtime_error("seen");
    };
    return stages;
  };
  return run_scene(loaded, options);
}

TEST(Checkpoint, KeepsAllOfACloth) {
  const TestFolder folder;
  const LoadedScene loaded = lingering_scene();
  const Cloth& cloth = loaded.cloths[0];
  ASSERT_EQ(validate(cloth), std::nullopt);
  int n_away = 0, n_lifted = 0;
  for (const FeatureId& id : cloth.feature) n_away += id.away > 0, n_lifted += id.lifted && id.away == 0;
  ASSERT_GT(n_away, 3);
  ASSERT_GT(n_lifted, 0);
  Cloth seen;
  EXPECT_NE(begin(loaded, folder.path() / "run", seen).message.find("seen"), std::string::npos);
  EXPECT_EQ(seen.mesh.X, cloth.mesh.X);
  EXPECT_EQ(seen.mesh.x, cloth.mesh.x);
  EXPECT_EQ(seen.v, cloth.v);
  EXPECT_EQ(seen.V, cloth.V);
  EXPECT_EQ(seen.pins, cloth.pins);
  ASSERT_EQ(seen.mesh.n_faces(), cloth.mesh.n_faces());
  for (int h = 0; h < 3 * cloth.mesh.n_faces(); ++h) {
    EXPECT_EQ(seen.mesh.from(h), cloth.mesh.from(h));
    EXPECT_EQ(seen.mesh.tag(h), cloth.mesh.tag(h));
  }
  for (int v = 0; v < cloth.mesh.n_vertices(); ++v) {
    const FeatureId &a = seen.feature[v], &b = cloth.feature[v];
    EXPECT_EQ(a, b) << v;
    EXPECT_EQ(a.side, b.side) << v;
    EXPECT_EQ(a.lifted, b.lifted) << v;
    EXPECT_EQ(a.away, b.away) << v;
  }
  ASSERT_EQ(seen.left.size(), cloth.left.size());
  for (std::size_t i = 0; i < cloth.left.size(); ++i) {
    EXPECT_EQ(seen.left[i].feature, cloth.left[i].feature);
    EXPECT_EQ(seen.left[i].from, cloth.left[i].from);
    EXPECT_EQ(seen.left[i].to, cloth.left[i].to);
    EXPECT_EQ(seen.left[i].age, cloth.left[i].age);
  }
}

// The hash is right in all of these: it is the content that no run of the scene could have left.
TEST(Checkpoint, IsRefusedIfNoRunCouldHaveWrittenIt) {
  const auto rider = [](Cloth& cloth) -> FeatureId& {  // in no chain
    return *std::find_if(cloth.feature.begin(), cloth.feature.end(),
                         [](const FeatureId& id) { return id.away > 0 && id.kind == FeatureKind::Corner; });
  };
  const std::vector<std::pair<std::string, std::function<void(Cloth&)>>> cases = {
      {"lingered for too long", [&](Cloth& cloth) { rider(cloth).away = 0.02; }},
      {"lingered for no time", [&](Cloth& cloth) { rider(cloth).away = -1e-3; }},
      {"lingers but is not lifted", [&](Cloth& cloth) { rider(cloth).lifted = false; }},
      {"no obstacle has", [&](Cloth& cloth) { rider(cloth).obstacle = 1; }},
      {"a feature that no obstacle has", [&](Cloth& cloth) { cloth.left[0].feature.index = 12; }},
      {"a feature that no obstacle has", [&](Cloth& cloth) { cloth.left[1].feature.index = 8; }},
      {"left is no feature", [&](Cloth& cloth) { cloth.left[0].feature.kind = FeatureKind::None; }},
      {"left was so too long ago", [&](Cloth& cloth) { cloth.left[1].age = 0.02; }},
      {"left was so at no time", [&](Cloth& cloth) { cloth.left[1].age = std::nan(""); }},
      {"left is no stretch", [&](Cloth& cloth) { std::swap(cloth.left[0].from, cloth.left[0].to); }},
      {"velocity that is not finite", [&](Cloth& cloth) { cloth.v[3].x() = std::nan(""); }}};
  for (const auto& [says, spoil] : cases) {
    SCOPED_TRACE(says);
    const TestFolder folder;
    LoadedScene loaded = lingering_scene();
    spoil(loaded.cloths[0]);
    Cloth seen;
    const RunResult result = begin(loaded, folder.path() / "run", seen);
    EXPECT_EQ(result.status, RunStatus::FileTrouble);
    EXPECT_NE(result.message.find("checkpoint.bin: "), std::string::npos) << result.message;
    EXPECT_NE(result.message.find(says), std::string::npos) << result.message;
    EXPECT_EQ(seen.mesh.n_vertices(), 0) << "no step is taken";
  }
}

// Cut off anywhere, or with any bit turned over: told in words, and the run is left as it was.
TEST(Checkpoint, IsRefusedIfDamagedAnywhere) {
  const TestFolder folder;
  const LoadedScene loaded = lingering_scene();
  const fs::path run = folder.path() / "run", file = run / "checkpoint.bin";
  Cloth seen;
  begin(loaded, run, seen);
  const std::string good = bytes_of(file);
  ASSERT_GT(good.size(), 1000u);
  const auto expect_trouble = [&](const std::string& bytes, const std::string& says) {
    std::ofstream(file, std::ios::binary) << bytes;
    const RunResult result = run_scene(loaded, {.directory = run, .resume = true});
    EXPECT_EQ(result.status, RunStatus::FileTrouble);
    EXPECT_NE(result.message.find(says), std::string::npos) << result.message;
    EXPECT_EQ(bytes_of(file), bytes);
  };
  Rng rng(6);
  for (std::size_t at = 0; at < good.size(); at += 37) {
    SCOPED_TRACE("byte " + std::to_string(at));
    std::string flipped = good;
    flipped[at] = static_cast<char>(flipped[at] ^ (1 << support::pick(rng, 8)));
    expect_trouble(flipped, "checkpoint");
    expect_trouble(good.substr(0, at), "checkpoint");
  }
  const std::size_t version = good.find('\n') - 1;
  for (const char other : {'1', static_cast<char>(good[version] - 1), static_cast<char>(good[version] + 1)})
    expect_trouble(std::string(good).replace(version, 1, 1, other), "not a checkpoint of this version");
}

// A sheet that rattles over the edges of a box that spins: at the checkpoints of steps 40, 60 and 80 vertices linger
// and places are remembered, which none of the smaller scenes has. Killed in the middle of a step, as if by the power.
TEST(CheckpointDeathTest, KilledWhileChainsLingerAndResumedWritesTheSameBytes) {
  const TestFolder folder;
  LoadedScene loaded = load_scene(fs::path(CREASE_SCENES) / "throw.json", {});
  loaded.scene.formats = {FrameFormat::Obj};
  loaded.scene.duration = 0.45;
  const fs::path whole = folder.path() / "whole", parts = folder.path() / "parts";
  ASSERT_EQ(run_scene(loaded, {.directory = whole}).status, RunStatus::Done);
  int n_lingering = 0, n_left = 0;
  const auto watched = [&](const Scene& scene, const ClothSpec& spec) {
    Stages stages = make_stages(scene, spec);
    stages.detect = [&, first = true, detect = stages.detect](
                        const Cloth& cloth, std::span<const PosedObstacle> obstacles, double h) mutable {
      if (std::exchange(first, false)) {
        for (const FeatureId& id : cloth.feature) n_lingering += id.away > 0;
        n_left += static_cast<int>(cloth.left.size());
      }
      return detect(cloth, obstacles, h);
    };
    return stages;
  };
  const auto kill_in_detection = [&](int call) {
    RunOptions options{.directory = parts, .resume = fs::exists(parts)};
    options.stages = [call, calls = std::make_shared<int>(0)](const Scene& scene, const ClothSpec& spec) {
      Stages stages = make_stages(scene, spec);
      stages.detect = [=, detect = stages.detect](const Cloth& cloth, std::span<const PosedObstacle> obstacles,
                                                  double h) {
        if (++*calls == call) raise(SIGKILL);
        return detect(cloth, obstacles, h);
      };
      return stages;
    };
    run_scene(loaded, options);
  };
  // Detection runs once or twice a step, and again in what is retried.
  for (const int call : {80, 30, 45}) EXPECT_EXIT(kill_in_detection(call), ::testing::KilledBySignal(SIGKILL), "");
  RunOptions last{.directory = parts, .resume = true, .stages = watched};
  EXPECT_EQ(run_scene(loaded, last).status, RunStatus::Done);
  EXPECT_EQ(differences(repeatable_bytes(whole), repeatable_bytes(parts)), Names());
  EXPECT_GT(n_lingering, 0);
  EXPECT_GT(n_left, 0);
}

}  // namespace
}  // namespace crease
