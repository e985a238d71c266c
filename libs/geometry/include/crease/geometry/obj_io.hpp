// SPDX-License-Identifier: MIT
#pragma once

#include <filesystem>
#include <iosfwd>
#include <span>
#include <string>
#include <vector>

#include "crease/geometry/closed_surface.hpp"
#include "crease/geometry/cloth.hpp"

namespace crease {

/// Reads a cloth mesh: v = world position, vt = material coordinate in metres. An edge whose two triangles have other
/// vt at it is a seam: its v become a vertex on each side, tied. Vertex i is v number i + 1, with the lowest vt it has;
/// the further vertices of seams follow, by vt. Panels should lie side by side in vt: how far a fold is from the border
/// is measured there. Polygons are refused; a file without vt, a non-manifold, inverted or zero-area triangle too.
/// Throws std::runtime_error "FILE:LINE: what is wrong and what would be right".
Mesh read_obj(const std::filesystem::path& file);

/// Reads the surface of an obstacle: v and f, the rest is not looked at. Polygons are refused; whether it is closed is
/// for surface_problems() to say. Throws std::runtime_error "FILE:LINE: what is wrong and what would be right".
TriangleSurface read_surface_obj(const std::filesystem::path& file);

struct NamedCloth {
  std::string name;
  const Cloth* cloth;
};
/// Writes `# time T`, `# eol i j ...` (v, 1-based), `v`, `vt`, `f a/a b/b c/c`; one `o NAME` each with several cloths.
/// There is one `vt` a vertex, and one `v` for all that are tied: without seams they have the same numbers.
/// Each number is the shortest decimal that reads back as the same double.
void write_obj(std::ostream& out, std::span<const NamedCloth> cloths, double time);

}  // namespace crease
