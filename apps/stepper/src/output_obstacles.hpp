// SPDX-License-Identifier: MIT
#pragma once

#include <span>
#include <string>

#include "crease/geometry/obstacle.hpp"

namespace crease {

/// obstacles.json: every obstacle's surface and sharp features once, in its own frame, and its pose (world = position +
/// rotation * local, rotation as rows) at each frame of the whole run. Motion is scripted, so the poses are known at
/// the start and the file is written once.
std::string obstacles_json(std::span<const Obstacle> obstacles, std::span<const double> frame_times);

}  // namespace crease
