// SPDX-License-Identifier: MIT
#pragma once

#include <array>
#include <vector>

#include "obj_text.hpp"

namespace crease {

/// The triangles of a text as panels that are sewn together where they share v but not vt.
struct ObjPanels {
  struct Vertex {
    int v, vt;
  };
  std::vector<Vertex> vertices;           ///< one for each v, in their order; then the further ones of seams
  std::vector<std::array<int, 3>> faces;  ///< into `vertices`
};

/// Two triangles belong to one panel across an edge if both ends have the same vt (by value) in both. Where they do
/// not, the edge is a seam. Fails with the line where the cloth, sewn or not, would not be an oriented manifold.
ObjPanels sew_panels(const ObjText& text);

}  // namespace crease
