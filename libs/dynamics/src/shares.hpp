// SPDX-License-Identifier: MIT
#pragma once

#include <vector>

#include "block_pattern.hpp"

namespace crease {

/// The columns of some vertices, and all that adds to them. What touches the columns of two shares is computed by both,
/// each of which keeps its own part: so every number of the system is the same sum for any number of shares.
struct Share {
  std::vector<char> owned;    ///< one a vertex
  std::vector<int> vertices;  ///< owned ones that have unknowns
  // With a vertex among those owned, ascending:
  std::vector<int> faces;
  std::vector<int> plain_hinges, eol_hinges;  ///< without and with an Eulerian vertex
};

/// Strips of the sheet that take about the same time, across its longer side.
std::vector<Share> share_out(const Mesh& mesh, const DofMap& dofs, const BlockPattern& pattern, int n_shares);

}  // namespace crease
