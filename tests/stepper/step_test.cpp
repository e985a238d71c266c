// SPDX-License-Identifier: MIT
#include "crease/stepper/step.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <utility>
#include <vector>

#include "constraints/eol_sheet.hpp"
#include "crease/geometry/chain.hpp"
#include "crease/geometry/feature_place.hpp"
#include "crease/geometry/grid.hpp"

namespace crease {
namespace {

PinSpec pulled_pin() {
  PinSpec pin;
  pin.motion = {{.time = 0.35, .velocity = {0.1, 0, 0}}};
  return pin;
}

double travelled(const PinSpec& pin, double from, double to, int steps) {
  const double h = (to - from) / steps;
  double x = 0;
  for (int n = 0; n < steps; ++n) x += h * pin_state(pin, 0, from + n * h, h).velocity.x();
  return x;
}

TEST(PinMotion, CoversTheScriptedDistanceAtAnyStep) {
  PinSpec pin = pulled_pin();
  for (const int steps : {7, 100, 801}) EXPECT_NEAR(travelled(pin, 0, 1, steps), 0.1 * 0.65, 1e-15);
  pin.ramp = 0.1;  // the blend is symmetric: it costs half its length
  for (const int steps : {7, 100, 801}) EXPECT_NEAR(travelled(pin, 0, 1, steps), 0.1 * (0.65 - 0.05), 1e-15);
}

TEST(PinMotion, RampHasNoJump) {
  PinSpec pin = pulled_pin();
  pin.ramp = 0.1;
  double last = 0;
  for (double t = 0.3; t < 0.5; t += 1e-3) {
    const double v = pin_state(pin, 0, t, 1e-3).velocity.x();
    // The quintic's steepest slope is 15/8 of the mean one.
    EXPECT_LE(std::abs(v - last), 0.1 * 15 / 8 * 1e-3 / 0.1 + 1e-12);
    last = v;
  }
  EXPECT_NEAR(last, 0.1, 1e-13);  // a difference of two distances, over a millisecond
}

TEST(PinMotion, HoldsFromTheStartAndLetsGo) {
  PinSpec pin;
  pin.motion = {{.time = 0, .velocity = {1, 0, 0}}};
  pin.ramp = 0.5;
  pin.release = 2.0;
  EXPECT_NEAR(pin_state(pin, 0, 0, 0.01).velocity.x(), 1, 1e-15);
  EXPECT_FALSE(pin_state(pin, 0, 1.995, 0.005).released);
  EXPECT_TRUE(pin_state(pin, 0, 2.0, 0.005).released);
}

SheetStepper free_stepper(const Vec3& gravity) {
  Scene scene;
  ClothSpec spec;
  SheetSettings settings;
  settings.dynamics.gravity = gravity;
  return {settings, make_stages(scene, spec)};
}

TEST(Step, FallsFreelyAsTheSchemeDoes) {
  const Vec3 g{0.3, -0.2, -9.81}, v0{1, 2, 3};
  for (const GridPattern pattern : {GridPattern::Cross, GridPattern::Irregular}) {
    GridOptions grid;
    grid.pattern = pattern;
    Cloth cloth = make_cloth(make_grid(grid));
    const auto start = cloth.mesh.x;
    for (Vec3& v : cloth.v) v = v0;
    SheetStepper stepper = free_stepper(g);
    const double h = 5e-3;
    const int steps = 40;
    for (int n = 0; n < steps; ++n) {
      const StepResult result = stepper.step(cloth, {}, n * h, h);
      ASSERT_EQ(result.report.status, StepStatus::Done);
      cloth = result.cloth;
    }
    const double t = steps * h;  // x_n = x_0 + v_0 t + g t (t + h)/2: implicit Euler, exactly
    for (std::size_t i = 0; i < start.size(); ++i)
      EXPECT_LE((cloth.mesh.x[i] - start[i] - v0 * t - g * t * (t + h) / 2).norm(), 1e-12);
  }
}

// No obstacle, no pin, no remeshing: nothing of it is called.
TEST(Step, GetsTheStagesThatTheSceneNeeds) {
  Scene scene;
  ClothSpec spec;
  const Stages none = make_stages(scene, spec);
  EXPECT_FALSE(none.detect || none.remesh || none.constrain || none.solve);
  spec.pins.push_back(pulled_pin());
  const Stages pinned = make_stages(scene, spec);
  EXPECT_FALSE(pinned.detect || pinned.remesh);
  EXPECT_TRUE(pinned.constrain && pinned.solve);
}

TEST(Step, NeedsAWayToSolveWhatItConstrains) {
  Scene scene;
  ClothSpec spec;
  spec.pins.push_back(pulled_pin());
  Stages stages = make_stages(scene, spec);
  stages.solve = nullptr;
  try {
    const SheetStepper stepper({}, stages);
    FAIL() << "an empty solve stage was taken";
  } catch (const std::invalid_argument& error) {
    EXPECT_NE(std::string(error.what()).find("solve stage"), std::string::npos) << error.what();
  }
  stages.constrain = nullptr;
  EXPECT_NO_THROW(SheetStepper({}, stages));
}

// At rest the sheet is farther from the box than the contact threshold, but in one step it falls through 16 mm.
TEST(Step, CatchesASheetThatFallsFromRestWithinOneStep) {
  const double h = 0.04, gap = 2e-3;
  Scene scene;
  scene.gravity = {0, 0, -9.81};
  scene.obstacles.push_back({.name = "box", .shape = make_box({2, 2, 0.02}), .start = {}, .motion = {}});
  scene.obstacles[0].start.position = {0.5, 0.5, -0.01 - gap};
  ClothSpec spec;
  SheetSettings settings;
  settings.dynamics.gravity = scene.gravity;
  SheetStepper stepper(settings, make_stages(scene, spec));
  const StepResult result = stepper.step(make_cloth(make_grid({})), scene.obstacles, 0, h);
  ASSERT_EQ(result.report.status, StepStatus::Done);
  for (const Vec3& x : result.cloth.mesh.x) EXPECT_NEAR(x.z(), -gap, 1e-9);
}

// Rows begin to be known before they are met. Were they taken to stay as they were, every landing would cost exchanges
// of the working set: the motion that the sheet has says which are met within the step.
TEST(Step, LandsWithoutAnExchange) {
  const double h = 2e-3, gap = 2.3e-3;
  Scene scene;
  scene.gravity = {0, 0, -9.81};
  scene.obstacles.push_back({.name = "box", .shape = make_box({2, 2, 0.02}), .start = {}, .motion = {}});
  scene.obstacles[0].start.position = {0.5, 0.5, -0.01 - gap};
  SheetSettings settings;
  settings.dynamics.gravity = scene.gravity;
  SheetStepper stepper(settings, make_stages(scene, {}));
  Cloth cloth = make_cloth(make_grid({}));
  int before = 0, met = 0;
  for (int n = 0; n < 20; ++n) {
    const StepResult result = stepper.step(cloth, scene.obstacles, n * h, h);
    ASSERT_EQ(result.report.status, StepStatus::Done) << result.report.message;
    cloth = result.cloth;
    before += result.report.contacts > 0 && result.report.active_constraints == 0;
    met += result.report.active_constraints > 0;
    EXPECT_LE(result.report.qp_iterations, 1) << "step " << n;
  }
  EXPECT_GT(before, 0);
  EXPECT_GT(met, 0);
  for (const Vec3& x : cloth.mesh.x) EXPECT_NEAR(x.z(), -gap, 1e-9);
}

// Detection asks where the cloth gets to at its velocity. At rest that is nowhere, but what pulls at it within the step
// throws it a metre down: it is asked again at that velocity, and the floor that is found then holds.
TEST(Step, DetectsAgainWhatTheSolutionRunsInto) {
  const double h = 0.01, floor = -0.02;
  SheetSettings settings;
  settings.dynamics.gravity = {0, 0, -1e4};
  Scene scene;
  scene.obstacles.push_back({.name = "floor", .shape = make_box({2, 2, 2}), .start = {}, .motion = {}});
  Stages stages = make_stages(scene, {});
  stages.foresee = nullptr;  // detection alone
  int calls = 0;
  stages.detect = [&](const Cloth& cloth, std::span<const PosedObstacle>, double step) {
    ++calls;
    std::vector<Contact> contacts;
    for (int v = 0; v < cloth.mesh.n_vertices(); ++v) {
      if (cloth.mesh.x[v].z() + step * cloth.v[v].z() >= floor) continue;
      Contact contact;
      contact.obstacle = 0;
      contact.n_vertices = 1;
      contact.vertices = {v, -1, -1};
      contact.weights = {1, 0, 0};
      contact.normal = Vec3::UnitZ();
      contact.distance = cloth.mesh.x[v].z() - floor;
      contacts.push_back(contact);
    }
    return contacts;
  };
  SheetStepper stepper(settings, stages);
  const StepResult result = stepper.step(make_cloth(make_grid({})), scene.obstacles, 0, h);
  ASSERT_EQ(result.report.status, StepStatus::Done) << result.report.message;
  EXPECT_EQ(calls, 2);  // with the floor it is slower than that, so nothing is asked a third time
  EXPECT_EQ(result.report.contacts, result.cloth.mesh.n_vertices());
  for (const Vec3& x : result.cloth.mesh.x) EXPECT_NEAR(x.z(), floor, 1e-12);
}

// A sheet runs over the edge so fast that the chain would cross a whole triangle.
TEST(Step, HoldsWhatRunsAwayOnlyIfAskedTo) {
  const double h = 0.01, speed = 15;  // [m/s]: a triangle's .15 m in a step
  testing::EolSheet sheet = testing::make_eol_sheet(0);
  for (int v = 0; v < sheet.cloth.mesh.n_vertices(); ++v) {
    if (sheet.cloth.is_eol(v))
      sheet.cloth.V[v] = {-speed, 0};
    else
      sheet.cloth.v[v] = {speed, 0, 0};
  }
  Scene scene;
  scene.obstacles.push_back({.name = "box", .shape = sheet.shape, .start = sheet.pose, .motion = {}});
  ClothSpec spec;
  SheetSettings settings;
  SheetStepper stepper(settings, make_stages(scene, spec));
  EXPECT_EQ(stepper.step(sheet.cloth, scene.obstacles, 0, h).report.status, StepStatus::EulerianStepTooLong);
  const StepResult result = stepper.step(sheet.cloth, scene.obstacles, 0, h, {.hold_runaways = true});
  ASSERT_EQ(result.report.status, StepStatus::Done) << result.report.message;
  EXPECT_EQ(result.report.held, static_cast<int>(sheet.chain.size()));
  for (const int v : sheet.chain) {
    EXPECT_EQ(result.cloth.mesh.X[v], sheet.cloth.mesh.X[v]);
    EXPECT_LT((result.cloth.mesh.x[v] - sheet.cloth.mesh.x[v]).cwiseProduct(Vec3(1, 0, 1)).norm(), 1e-12);
  }
  const StepResult slow = stepper.step(sheet.cloth, scene.obstacles, 0, h / 10, {.hold_runaways = true});
  ASSERT_EQ(slow.report.status, StepStatus::Done) << slow.report.message;
  EXPECT_EQ(slow.report.held, 0) << "a tenth of a triangle";
}

// Flat cloth that leaves its edge for a step or two moves as Lagrangian cloth does and comes back to the chain that it
// had; after that the chain is gone, and where it was is remembered. Also in the parts of a step.
TEST(Step, LetsAChainLingerForTwoSteps) {
  const double h = 0.005, speed = 0.5;  // 2.5 mm a step
  for (const int parts : {1, 2}) {
    testing::EolSheet sheet = testing::make_eol_sheet(0);
    for (Vec3& v : sheet.cloth.v) v.z() = speed;
    Scene scene;
    scene.obstacles.push_back({.name = "box", .shape = sheet.shape, .start = sheet.pose, .motion = {}});
    Stages stages = make_stages(scene, {});
    stages.remesh = {};
    SheetSettings settings;
    settings.dynamics.gravity.setZero();
    settings.linger = linger_steps * h;
    SheetStepper stepper(settings, stages);
    Cloth cloth = sheet.cloth, off_once;
    const auto step = [&] {
      int released = 0;
      for (int part = 0; part < parts; ++part) {
        StepResult result = stepper.step(cloth, scene.obstacles, 0, h / parts);
        EXPECT_EQ(result.report.status, StepStatus::Done) << result.report.message;
        released += result.report.released;
        cloth = std::move(result.cloth);
      }
      EXPECT_EQ(validate(cloth), std::nullopt);
      return released;
    };
    const int n = sheet.cloth.n_eol(), middle = sheet.chain[sheet.chain.size() / 2];
    for (int i = 1; i <= 2; ++i) {
      EXPECT_EQ(step(), 0);
      EXPECT_EQ(cloth.n_eol(), n);
      EXPECT_FALSE(cloth.rides(middle));
      EXPECT_NEAR(cloth.feature[middle].away, i * h, 1e-15);
      EXPECT_EQ(cloth.V[middle].norm(), 0);
      EXPECT_NEAR(cloth.mesh.x[middle].z(), i * h * speed, 1e-12);
      if (i == 1) off_once = cloth;
    }
    const Cloth off = cloth;
    cloth = off_once;
    for (Vec3& v : cloth.v) v.z() = -speed;
    EXPECT_EQ(step(), 0);
    EXPECT_TRUE(cloth.rides(middle));
    EXPECT_EQ(cloth.feature[middle].away, 0);
    EXPECT_TRUE(cloth.left.empty());

    cloth = off;
    EXPECT_EQ(step(), n);
    EXPECT_EQ(cloth.n_eol(), 0);
    const double at = world_edge(sheet.feature, sheet.obstacles()).parameter(cloth.mesh.x[middle]);
    EXPECT_TRUE(was_left(cloth, sheet.feature, at));
    step();
    EXPECT_TRUE(was_left(cloth, sheet.feature, at));
    step();
    EXPECT_FALSE(was_left(cloth, sheet.feature, at));
  }
}

// The next mesh line is 40 um ahead of the chain, over 5 cm long; the chain goes there slowly: no quarter of the way.
TEST(Step, MakesNoNeedleThinner) {
  testing::EolSheet sheet = testing::make_eol_sheet(0);
  Mesh& mesh = sheet.cloth.mesh;
  const double ahead = 0.5 * testing::sheet_length + 4e-5;
  for (int v = 0; v < mesh.n_vertices(); ++v)
    if (mesh.X[v].x() > ahead && mesh.X[v].x() < testing::sheet_length - 1e-9) mesh.X[v].x() = mesh.x[v].x() = ahead;
  for (const int v : sheet.chain) sheet.cloth.V[v] = {0.01, 0};
  for (int v = 0; v < mesh.n_vertices(); ++v)
    if (!sheet.cloth.is_eol(v)) sheet.cloth.v[v] = {-0.01, 0, 0};
  Scene scene;
  scene.obstacles.push_back({.name = "box", .shape = sheet.shape, .start = sheet.pose, .motion = {}});
  SheetStepper stepper({}, make_stages(scene, {}));
  const StepResult result = stepper.step(sheet.cloth, scene.obstacles, 0, 1e-3);
  ASSERT_EQ(result.report.status, StepStatus::Done) << result.report.message;
  EXPECT_EQ(result.report.held, static_cast<int>(sheet.chain.size()));
  for (const int v : sheet.chain) EXPECT_LT((result.cloth.mesh.X[v] - mesh.X[v]).norm(), 1e-15);
}

// A vertex in the middle of a thin plate, which both faces push out, each its way.
TEST(Step, LeavesClothCaughtWhereItIs) {
  const double h = 0.01;
  Scene scene;
  scene.obstacles.push_back({.name = "plate", .shape = make_box({2, 2, 1e-3}), .start = {}, .motion = {}});
  Stages stages = make_stages(scene, {});
  stages.foresee = nullptr;
  stages.detect = [](const Cloth&, std::span<const PosedObstacle>, double) {
    std::vector<Contact> contacts;
    for (const double side : {1.0, -1.0}) {
      Contact contact;
      contact.obstacle = 0;
      contact.n_vertices = 1;
      contact.vertices = {0, -1, -1};
      contact.weights = {1, 0, 0};
      contact.normal = side * Vec3::UnitZ();
      contact.distance = -5e-4;
      contacts.push_back(contact);
    }
    return contacts;
  };
  SheetSettings settings;
  settings.dynamics.gravity.setZero();
  SheetStepper stepper(settings, stages);
  const Cloth cloth = make_cloth(make_grid({}));
  const StepResult result = stepper.step(cloth, scene.obstacles, 0, h);
  ASSERT_EQ(result.report.status, StepStatus::Done) << result.report.message;
  EXPECT_EQ(result.report.caught, 1);
  for (int v = 0; v < cloth.mesh.n_vertices(); ++v) EXPECT_LT((result.cloth.mesh.x[v] - cloth.mesh.x[v]).norm(), 1e-12);
}

TEST(Step, LeavesTheGivenClothAloneAndRefusesWhatIsNotFinite) {
  Cloth cloth = make_cloth(make_grid({}));
  const auto before = cloth.mesh.x;
  SheetStepper stepper = free_stepper({0, 0, -9.81});
  stepper.step(cloth, {}, 0, 0.01);
  EXPECT_EQ(cloth.mesh.x, before);
  cloth.mesh.x[3].z() = std::numeric_limits<double>::quiet_NaN();
  EXPECT_THROW(stepper.step(cloth, {}, 0, 0.01), std::invalid_argument);
  EXPECT_THROW(stepper.step(make_cloth(make_grid({})), {}, 0, 0), std::invalid_argument);
  for (const int number : {0, 1, 2, 3}) {
    Cloth broken = make_cloth(make_grid({}));
    double* const places[] = {&broken.mesh.x[2][1], &broken.mesh.X[2][1], &broken.v[2][1], &broken.V[2][1]};
    *places[number] = std::numeric_limits<double>::quiet_NaN();
    EXPECT_THROW(stepper.step(broken, {}, 0, 0.01), std::invalid_argument) << number;
  }
}

/// What a pass reports that maps `from` and refuses at these vertices; without a map it changed nothing.
RemeshResult pass(std::vector<int> from, std::vector<int> refused) {
  RemeshResult result;
  result.report.changed = !from.empty();
  result.report.splits = 1;
  result.report.vertex_map = std::move(from);
  for (const int v : refused) result.report.refusals.push_back({.reason = RefusalReason::TooThin, .vertex = v});
  return result;
}

std::vector<int> refused_vertices(const RemeshResult& result) {
  std::vector<int> vertices;
  for (const Refusal& refusal : result.report.refusals) vertices.push_back(refusal.vertex);
  return vertices;
}

TEST(ChainedPasses, MapAndRefusalsAreInTheNumberingOfTheResult) {
  const int none = Mesh::none;
  // 3 vertices -> 5, of which the second pass takes away two and renumbers the rest.
  const std::vector<int> first{4, none, 0}, second{2, none, 0, none, 1};
  const RemeshResult both = chain_passes(pass(first, {0, 3, 4, none}), pass(second, {1}));
  EXPECT_EQ(both.report.vertex_map, (std::vector<int>{1, none, 2}));
  EXPECT_EQ(refused_vertices(both), (std::vector<int>{2, none, 1, none, 1}));
  EXPECT_EQ(both.report.splits, 2);

  const RemeshResult only_second = chain_passes(pass({}, {0, 4}), pass(second, {1}));
  EXPECT_EQ(only_second.report.vertex_map, second);
  EXPECT_EQ(refused_vertices(only_second), (std::vector<int>{2, 1, 1}));

  const RemeshResult only_first = chain_passes(pass(first, {3}), pass({}, {1}));
  EXPECT_EQ(only_first.report.vertex_map, first);
  EXPECT_EQ(refused_vertices(only_first), (std::vector<int>{3, 1}));
}

}  // namespace
}  // namespace crease
