// SPDX-License-Identifier: MIT
#pragma once

#include <filesystem>
#include <span>
#include <string>

#include "crease/geometry/obj_io.hpp"

namespace crease {

/// One frame as XML PolyData with raw appended arrays: Points, Polys; point data `uv` (TCoords), `velocity` (of the
/// material, in the world), `material_velocity` (third component 0), `eol`, `cloth` (index of the sheet); cell data
/// `cloth`; field data `TimeValue`. Floating-point arrays are Float64, so that a check on frames loses no digit.
std::string vtp_text(std::span<const NamedCloth> cloths, double time);

/// ParaView's list of frames with their times.
std::string pvd_text(std::span<const double> frame_times);

/// frames/000012.vtp
std::filesystem::path frame_path(int frame, const char* extension);

}  // namespace crease
