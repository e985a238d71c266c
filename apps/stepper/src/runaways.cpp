// SPDX-License-Identifier: MIT
#include "runaways.hpp"

#include <algorithm>
#include <iterator>

namespace crease {
namespace {

/// Smallest share of its material area that a triangle may keep in one step. An EOL vertex may thus cross at most 0.3
/// of the altitude ahead of it: the material Courant number at which explicit velocity terms are still accurate.
constexpr double min_area_share = 0.7;
/// Altitude of a triangle over its longest side below which no step may make it thinner. The remesher repairs what it
/// can long before. Of the rest, shares alone would let the area vanish step by step, and the stiffness grow until all
/// other motion is rounding beside it.
constexpr double thinnest = 1e-3;

bool is_needle(const Mesh& mesh, int face) {
  double longest = 0;
  for (int k = 0; k < 3; ++k) longest = std::max(longest, mesh.material_length(3 * face + k));
  return 2 * mesh.material_area(face) < thinnest * longest * longest;
}

}  // namespace

Runaways find_runaways(const Cloth& before, const Cloth& after) {
  Runaways found;
  const auto rides = [&](int v) { return before.is_eol(v); };
  for (int f = 0; f < before.mesh.n_faces(); ++f) {
    const auto& corners = before.mesh.face(f);
    if (std::none_of(corners.begin(), corners.end(), rides)) continue;
    const double area = after.mesh.material_area(f), area_before = before.mesh.material_area(f);
    const bool goes_too_far = area < min_area_share * area_before;
    if (!goes_too_far && !(area < area_before && is_needle(after.mesh, f))) continue;
    std::copy_if(corners.begin(), corners.end(), std::back_inserter(goes_too_far ? found.too_far : found.at_needles),
                 rides);
  }
  return found;
}

}  // namespace crease
