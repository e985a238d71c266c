// SPDX-License-Identifier: MIT
#include <cmath>
#include <numbers>

#include "conforming.hpp"
#include "crease/base/require.hpp"
#include "crease/geometry/chain.hpp"
#include "crease/geometry/triangle.hpp"
#include "options.hpp"

namespace crease {

double Conforming::border_cosine(double share) const {
  return std::cos(share * options.border_angle_deg * std::numbers::pi / 180);
}

// Eq. 13 relative to the obstacle: what the cloth moves along with it is no sliding.
void share_velocities(Conforming& c) {
  for (const int v : c.newcomers) {
    if (!c.mesh().vertex_live(v) || !c.cloth().is_eol(v)) continue;
    const Mat32 F = vertex_deformation_gradient(c.mesh(), v);
    const Vec3 obstacle = velocity_at(c.cloth().feature[v], c.obstacles, c.mesh().x[v]);
    const std::vector<Vec2> rows = eulerian_rows(c.cloth(), v, c.obstacles);
    c.editor.share(v, eulerian_share(c.cloth().v[v] - obstacle, F, rows), F);
  }
}

RemeshResult conform(const Cloth& cloth, std::span<const Contact> contacts, std::span<const PosedObstacle> obstacles,
                     const ConformOptions& options) {
  require_valid(options);
  require(cloth.mesh.is_compact(), "conform: expected a compact mesh");
  Conforming c(cloth, obstacles, options);
  release_strays(c);
  insert_contacts(c, contacts);
  connect_chains(c);
  merge_near_chains(c);
  if (options.eulerian) share_velocities(c);
  return std::move(c.editor).finish();
}

}  // namespace crease
