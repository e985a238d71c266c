// SPDX-License-Identifier: MIT
#pragma once

#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "crease/geometry/cloth.hpp"

namespace crease {

/// State of a run between two steps. Everything else that a run goes on with follows from the scene and the step.
struct Checkpoint {
  int step = 0;
  std::vector<Cloth> cloths;
};

/// Binary, bit-exact, little-endian: a text line, the scene's resolved text, the step, the cloths, a hash of all before
/// it.
std::string encode_checkpoint(const std::string& scene, int step, std::span<const Cloth> cloths);

/// False if it was written for another scene. Throws like decode_checkpoint.
bool belongs_to(std::string_view bytes, const std::string& scene);

/// Throws std::runtime_error in words for one that is damaged or from another version.
Checkpoint decode_checkpoint(std::string_view bytes);

}  // namespace crease
