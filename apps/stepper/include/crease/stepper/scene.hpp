// SPDX-License-Identifier: MIT
#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <variant>
#include <vector>

#include "crease/base/types.hpp"
#include "crease/dynamics/material.hpp"
#include "crease/geometry/grid.hpp"
#include "crease/geometry/obstacle.hpp"
#include "crease/remesh/remesh.hpp"
#include "crease/solver/qp_solver.hpp"

namespace crease {

enum class RemeshMethod { None, Adaptive, Conformal };
enum class ContactMethod { Eol, LagrangianAveraged, LagrangianCone };

/// Where a pin holds: exactly one of the contract's forms.
struct PinWhere {
  enum class Kind { Corner, Edge, Material, Vertices };
  Kind kind = Kind::Corner;
  std::string name;  ///< "00".."11" or "u0".."v1"
  Vec2 material = Vec2::Zero();
  std::vector<int> vertices;  ///< 0-based
};

struct PinSpec {
  PinWhere where;
  std::array<bool, 3> axes{true, true, true};
  std::vector<MotionKey> motion;  ///< angular velocity unused
  double ramp = 0;                ///< each change of velocity is smoothed over this time [s]
  std::optional<double> release;  ///< [s]
};

struct ClothSpec {
  std::string name = "cloth";
  std::variant<GridOptions, std::filesystem::path> shape;  ///< grid (with placement) or OBJ file
  Vec3 velocity = Vec3::Zero();
  Material material;
  RemeshMethod remeshing = RemeshMethod::None;
  AdaptOptions adapt;
  std::vector<PinSpec> pins;
};

enum class FrameFormat { Vtp, Obj };

/// A scene with every default filled in.
struct Scene {
  std::string name, description;
  double duration = 0, time_step = 0.005;
  Vec3 gravity{0, 0, -9.81};
  std::vector<ClothSpec> cloths;
  std::vector<Obstacle> obstacles;
  ContactMethod contact = ContactMethod::Eol;
  double threshold = 1e-3;
  bool velocity_terms = true;
  QpMethod qp = QpMethod::ActiveSet;
  double tolerance = 1e-8;
  double fps = 60;
  std::vector<FrameFormat> formats{FrameFormat::Vtp};
};

}  // namespace crease
