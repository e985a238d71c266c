// SPDX-License-Identifier: MIT
#pragma once

#include <array>
#include <filesystem>
#include <string>
#include <vector>

#include "crease/base/types.hpp"

namespace crease {

/// What a file is read as: a surface needs no texture coordinates, and those it has are not looked at.
enum class ObjUse { Cloth, Surface };

struct ObjFace {
  std::array<int, 3> v, vt;  ///< from 0; vt of a cloth only
  int line;
};

/// An OBJ file as it stands, its indices checked.
struct ObjText {
  std::filesystem::path file;
  std::vector<Vec3> positions;
  std::vector<int> position_lines;
  std::vector<Vec2> texcoords;
  std::vector<ObjFace> faces;

  [[noreturn]] void fail(int line, const std::string& what) const;
};

/// Throws std::runtime_error "FILE:LINE: what is wrong and what would be right".
ObjText read_obj_text(const std::filesystem::path& file, ObjUse use);

}  // namespace crease
