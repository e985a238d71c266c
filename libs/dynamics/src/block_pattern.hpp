// SPDX-License-Identifier: MIT
#pragma once

#include <array>
#include <vector>

#include "crease/base/types.hpp"
#include "crease/geometry/dof_map.hpp"
#include "crease/geometry/mesh.hpp"

namespace crease {

/// Two faces that share an edge; vertices in the order of BendingElement.
struct Hinge {
  std::array<int, 4> vertex;  ///< edge from, edge to, opposite in face 0, opposite in face 1
  std::array<int, 2> face;
};

/// The hinge at half-edge h of an interior edge.
Hinge hinge_at(const Mesh& mesh, int h);

/// Where the vertex blocks of every element stand in a column-compressed matrix.
///
/// The rows of one vertex are contiguous in every column, and the columns of one vertex are equally long. So one offset
/// into the value array and the column length of vertex j locate the whole block (i, j).
struct BlockPattern {
  struct FaceBlocks {
    std::array<int, 9> at;  ///< first value of block (i, j) at [3 i + j]
  };
  struct HingeBlocks {
    Hinge hinge;
    std::array<int, 16> at;  ///< first value of block (i, j) at [4 i + j]
  };
  std::vector<FaceBlocks> faces;
  std::vector<HingeBlocks> hinges;  ///< empty if made without
  std::vector<int> stride;          ///< column length of each vertex' columns
};

/// Lays out `matrix` (both triangles, values zero) for couplings inside faces and, on request, inside hinges.
BlockPattern make_block_pattern(const Mesh& mesh, const DofMap& dofs, bool with_hinges, SparseMatrix& matrix);

}  // namespace crease
