// SPDX-License-Identifier: MIT
#pragma once

#include <array>
#include <vector>

#include "crease/base/types.hpp"
#include "crease/geometry/dof_map.hpp"
#include "crease/geometry/mesh.hpp"

namespace crease {

/// Two faces that share an edge, or are sewn together along one; vertices in the order of BendingElement.
struct Hinge {
  std::array<int, 4> vertex;  ///< edge from and to in face 0, opposite in face 0, opposite in face 1
  std::array<int, 2> face;
  int sewn_to = Mesh::none;  ///< the half-edge of face 1 on the other side of the seam
};

/// One for every edge that bends, ascending by half-edge: interior edges and seams.
std::vector<Hinge> all_hinges(const Mesh& mesh);

/// Material positions of a hinge's vertices. Across a seam face 1 is laid against face 0, scaled to the length of the
/// edge there: with the same angles, so that a seam between straight borders bends like the cloth itself.
std::array<Vec2, 4> flat_hinge(const Mesh& mesh, const Hinge& hinge);

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
    std::array<int, 16> block;  ///< number of block (i, j) at [4 i + j]
  };
  std::vector<FaceBlocks> faces;
  std::vector<HingeBlocks> hinges;  ///< empty if made without
  std::vector<int> stride;          ///< column length of each vertex' columns; tied vertices share theirs
  std::vector<int> block_start;     ///< n_vertices + 1: the first block in each vertex' columns
  std::vector<int> first_of;        ///< first value of each block
};

/// Lays out `matrix` (both triangles, values zero) for couplings inside faces and, on request, inside hinges.
BlockPattern make_block_pattern(const Mesh& mesh, const DofMap& dofs, bool with_hinges, SparseMatrix& matrix);

}  // namespace crease
