// SPDX-License-Identifier: MIT
//
// The same motion, however the mesh lies under an edge, from a moving frame, from below, and with the cloth turned
// over.
#include <gtest/gtest.h>

#include <charconv>
#include <cmath>
#include <numbers>
#include <string>
#include <vector>

#include "support/scene_text.hpp"
#include "support/sheet_runs.hpp"

namespace crease {
namespace {

using testing::apart;
using testing::run_sheet;
using testing::SheetRun;

constexpr double length = 1;  // of the sheet [m]

std::string digits(double value) {
  char text[32];
  return {text, std::to_chars(text, text + sizeof text, value).ptr};  // all of them: 1e-12 must not be lost
}

/// A sheet of 1 x 1 m, .5 mm above a table whose edge goes through (place, .5), turned by some degrees; held along the
/// border x = 1, which is over the table, the rest falls over the edge. Its mesh is regular: lines every 1/16 m.
struct EdgeScene {
  double place = 0.5, degrees = 0;
  std::string placement = R"({"origin": [0, 0, 0]})", held = "u1", pattern = "cross";

  LoadedScene load() const {
    const double angle = degrees * std::numbers::pi / 180;
    const TestFolder folder;
    return load_scene(folder.write("edge.json", R"({"format": 1, "name": "edge", "duration": 1, "time_step": 0.005,
      "gravity": [0, 0, -9.8], "cloths": [{"shape": {"grid": {"size": [1, 1], "cells": [16, 16], "pattern": ")" +
                                                    pattern + R"("}},
        "placement": )" + placement +
                                                    R"(, "remeshing": {"method": "conformal", "size": [0.03, 0.08]},
        "material": {"density": 0.05, "youngs": 500, "poisson": 0.3, "bending": 1e-5, "damping": 0.005},
        "pins": [{"where": {"edge": ")" + held +
                                                    R"("}}]}],
      "obstacles": [{"box": {"size": [4, 8, 1]}, "rotation": {"axis": [0, 0, 1], "degrees": )" +
                                                    digits(degrees) + R"(}, "position": [)" +
                                                    digits(place + 2 * std::cos(angle)) + "," +
                                                    digits(0.5 + 2 * std::sin(angle)) + R"(, -0.5005]}]})"));
  }
};

double farthest_apart(const SheetRun& a, const SheetRun& b) {
  double farthest = 0;
  EXPECT_EQ(a.states.size(), b.states.size());
  for (std::size_t k = 0; k < std::min(a.states.size(), b.states.size()); ++k)
    farthest = std::max(farthest, apart(a.states[k], b.states[k]));
  return farthest;
}

// Along a mesh line, through mesh vertices at 30 degrees, along the diagonals of the cells, along the border; and off
// by so little that only rounding can tell. The chain may take other vertices then, and the mesh beside it other
// diagonals: two discretisations of one motion. Most agree to a few times the offset; the farthest seen is 2.3e-4 m,
// and 2.6e-3 m on a mesh twice as coarse.
TEST(Invariance, AnEdgeAnywhereOnTheMeshGivesTheSameMotion) {
  for (const EdgeScene& scene : {EdgeScene{0.5, 0}, EdgeScene{0.5, 30}, EdgeScene{0.5, 45}, EdgeScene{0, 0}}) {
    const SheetRun on = run_sheet(scene.load(), 0.3);
    for (const double off : {1e-12, -1e-12, 1e-6, -1e-6}) {
      SCOPED_TRACE("at " + digits(scene.place) + ", " + digits(scene.degrees) + " degrees, off by " + digits(off));
      EdgeScene beside = scene;
      beside.place += off;
      const SheetRun run = run_sheet(beside.load(), 0.3);
      EXPECT_LE(farthest_apart(on, run), 1e-3 * length);
      EXPECT_LE(run.deepest, 1e-3 * length);
    }
  }
}

/// A sheet of 1 x 1 m, held along some of its borders, and a box that comes up on its tip at .3 m/s, at (x, y) and from
/// 2 mm below.
struct TipScene {
  double x, y;
  std::vector<std::string> held;

  LoadedScene load() const {
    std::string pins;
    for (const std::string& border : held)
      pins += (pins.empty() ? "" : ",") + (R"({"where": {"edge": ")" + border + R"("}})");
    const TestFolder folder;
    return load_scene(folder.write("tip.json", R"({"format": 1, "name": "tip", "duration": 1, "time_step": 0.005,
      "gravity": [0, 0, -9.8], "cloths": [{"shape": {"grid": {"size": [1, 1], "cells": [12, 12], "pattern": "cross"}},
        "remeshing": {"method": "conformal", "size": [0.04, 0.1]}, "pins": [)" +
                                                   pins +
                                                   R"(],
        "material": {"density": 0.05, "youngs": 500, "poisson": 0.3, "bending": 1e-5, "damping": 0.005}}],
      "obstacles": [{"box": {"size": [0.3, 0.3, 0.3]}, "position": [)" +
                                                   digits(x) + "," + digits(y) + R"(, -0.262],
        "rotation": {"axis": [1, -1, 0], "degrees": 54.7356103}, "motion": [{"time": 0, "velocity": [0, 0, 0.3]}]}]})"));
  }
};

// Through the middle, the border, the corner, and just beside them. In the middle the mesh stays the same; elsewhere,
// as above, two discretisations of one motion. (A free sheet buckles, and then these motions are centimetres apart, as
// they are for a vertex of the sheet moved by as much: see CornerPush.)
TEST(Invariance, ATipAnywhereUnderAHeldSheetGivesTheSameMotion) {
  for (const TipScene& scene :
       {TipScene{0.5, 0.5, {"u0", "u1", "v0", "v1"}}, TipScene{0.5, 0, {"u0", "u1", "v1"}},
        TipScene{0.5, 0.02, {"u0", "u1", "v1"}}, TipScene{0, 0, {"u1", "v1"}}, TipScene{0.015, 0.015, {"u1", "v1"}}}) {
    const SheetRun on = run_sheet(scene.load(), 0.15);
    for (const double off : {1e-12, -1e-12, 1e-6, -1e-6}) {
      SCOPED_TRACE("at " + digits(scene.x) + ", " + digits(scene.y) + ", off by " + digits(off));
      TipScene beside = scene;
      beside.x += off, beside.y += off;
      const SheetRun run = run_sheet(beside.load(), 0.15);
      EXPECT_LE(farthest_apart(on, run), 1e-3 * length);
      EXPECT_LE(run.deepest, 1e-3 * length);
    }
  }
}

// Everything at 10 m/s, 5 cm a step: places round to 2e-16 of the way gone, and what the solver leaves is of that size.
// Nothing but differences of velocities may enter. On an irregular mesh: of a regular one's equal diagonals rounding
// chooses, and the motions are two discretisations then, here 3e-6 m apart.
TEST(Invariance, ABoxThatMovesWithTheClothGivesTheSameMotion) {
  EdgeScene scene{0.473, 0};
  scene.pattern = "irregular";
  const LoadedScene still = scene.load();
  const SheetRun at_rest = run_sheet(still, 0.3);
  for (const Vec3& drift : {Vec3(10, 0, 0), Vec3(6, -8, 0), Vec3(0, 8, 6)}) {
    SCOPED_TRACE(drift.transpose());
    LoadedScene moving = still;
    for (Vec3& v : moving.cloths[0].v) v = drift;
    moving.scene.cloths[0].pins[0].motion = {{.time = 0, .velocity = drift}};
    moving.scene.obstacles[0].motion = {{.time = 0, .velocity = drift}};
    const SheetRun run = run_sheet(moving, 0.3);
    ASSERT_EQ(run.states.size(), at_rest.states.size());
    for (std::size_t k = 0; k < run.states.size(); ++k) {
      const Vec3 way = -still.scene.time_step * static_cast<double>(k) * drift;
      EXPECT_LE(apart(
                    at_rest.states[k], run.states[k], [](const Vec2& X) { return X; }, way),
                1e-9)
          << "step " << k;
    }
  }
}

// A plate rises at .5 m/s under a free sheet, 1 cm below it; the blow is inelastic, so that from then on the sheet is
// the plate's: .5 m/s everywhere, on it within rounding, and with the kinetic energy m v^2 / 2 of that.
TEST(Invariance, ARisingPlateCarriesAFreeSheet) {
  constexpr double speed = 0.5, gap = 0.01;
  for (const std::string g : {"0", "-9.8"}) {
    SCOPED_TRACE(g);
    const TestFolder folder;
    const LoadedScene loaded = load_scene(folder.write(
        "plate.json", R"({"format": 1, "name": "plate", "duration": 1, "time_step": 0.005, "gravity": [0, 0, )" + g +
                          R"(], "cloths": [{"shape": {"grid": {"size": [1, 1], "cells": [8, 8]}},
          "material": {"density": 0.05, "youngs": 50, "poisson": 0.01, "bending": 1e-5},
          "remeshing": {"method": "conformal", "size": [0.06, 0.15]}}],
        "obstacles": [{"box": {"size": [1.4, 1.4, 0.1]}, "position": [0.5, 0.5, -0.06],
          "motion": [{"time": 0, "velocity": [0, 0, 0.5]}]}]})"));
    const SheetRun run = run_sheet(loaded, 0.3);
    EXPECT_LE(run.deepest, 1e-12);
    const Material& material = loaded.scene.cloths[0].material;
    const double carried = 0.5 * material.density * speed * speed;  // of 1 m^2 [J]
    for (std::size_t k = 0; k < run.states.size(); ++k) {
      const Cloth& cloth = run.states[k];
      const double time = static_cast<double>(k) * loaded.scene.time_step;
      const Energies energies = measure_energies(cloth, material, loaded.scene.gravity);
      EXPECT_LE(energies.kinetic, carried * (1 + 1e-9)) << "at " << time;
      if (time < gap / speed + 2 * loaded.scene.time_step) continue;
      EXPECT_NEAR(energies.kinetic, carried, 1e-9 * carried) << "at " << time;
      EXPECT_LE(energies.membrane + energies.bending, 1e-12) << "at " << time;
      for (int v = 0; v < cloth.mesh.n_vertices(); ++v) {
        EXPECT_NEAR(cloth.v[v].z(), speed, 1e-9) << "at " << time;
        EXPECT_NEAR(cloth.mesh.x[v].z(), speed * time - gap, 1e-9) << "at " << time;
      }
    }
  }
}

// The world in a mirror that lies in the sheet: the table is above it, gravity upwards, and the cloth touches it with
// its other face. The mesh is numbered as before, so nothing may differ but signs.
TEST(Invariance, TheOtherFaceOfTheClothGivesTheSameMotion) {
  const Mat3 mirror = Vec3(1, 1, -1).asDiagonal();
  for (const double degrees : {0.0, 30.0}) {
    SCOPED_TRACE(degrees);
    const LoadedScene above = EdgeScene{0.47, degrees}.load();
    LoadedScene below = above;
    below.scene.gravity = mirror * above.scene.gravity;
    Pose& table = below.scene.obstacles[0].start;
    table.position = mirror * table.position;
    table.rotation = mirror * table.rotation * mirror;  // a box is its own mirror image
    const SheetRun a = run_sheet(above, 0.3);
    SheetRun b = run_sheet(below, 0.3);
    for (Cloth& cloth : b.states)
      for (Vec3& x : cloth.mesh.x) x = mirror * x;
    EXPECT_LE(farthest_apart(a, b), 1e-9);
    EXPECT_GT(a.states.back().n_eol(), 10);
    EXPECT_EQ(a.states.back().n_eol(), b.states.back().n_eol());
  }
}

// The cloth put down with one material axis, or both, the other way round: first with its faces down. The mesh looks
// the same but is numbered otherwise, and of equals the first goes first: where the chain takes a vertex and which
// diagonal stays may differ, as in the first of these tests. The farthest seen is 3.7e-5 m.
TEST(Invariance, TheClothTurnedOverGivesTheSameMotion) {
  struct Turned {
    const char *placement, *held;
    bool flip_u, flip_v;
  };
  for (const double place : {0.5, 0.47}) {
    const SheetRun as_was = run_sheet(EdgeScene{place, 0}.load(), 0.3);
    for (const Turned& turned :
         {Turned{R"({"origin": [1, 0, 0], "u": [-1, 0, 0], "v": [0, 1, 0]})", "u0", true, false},
          Turned{R"({"origin": [0, 1, 0], "u": [1, 0, 0], "v": [0, -1, 0]})", "u1", false, true},
          Turned{R"({"origin": [1, 1, 0], "u": [-1, 0, 0], "v": [0, -1, 0]})", "u0", true, true}}) {
      SCOPED_TRACE(digits(place) + ", " + turned.placement);
      const SheetRun run = run_sheet(EdgeScene{place, 0, turned.placement, turned.held}.load(), 0.3);
      const auto twin = [&](const Vec2& X) {
        return Vec2(turned.flip_u ? 1 - X.x() : X.x(), turned.flip_v ? 1 - X.y() : X.y());
      };
      for (std::size_t k = 0; k < run.states.size(); ++k)
        EXPECT_LE(apart(as_was.states[k], run.states[k], twin), 2e-4 * length) << "step " << k;
    }
  }
}

}  // namespace
}  // namespace crease
