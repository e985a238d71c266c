// SPDX-License-Identifier: MIT
#include "block_pattern.hpp"

#include <algorithm>
#include <limits>
#include <span>
#include <utility>

#include "crease/base/require.hpp"

namespace crease {

namespace {

// The elements at each vertex, as n_corners * element + corner. Tied vertices are listed as the one that owns their
// unknowns.
struct Incidence {
  std::vector<int> start, corner;

  std::span<const int> at(int vertex) const {
    return std::span(corner).subspan(start[vertex], start[vertex + 1] - start[vertex]);
  }
};

template <class VerticesOf>
Incidence make_incidence(const DofMap& dofs, int n_elements, int n_corners, VerticesOf vertices_of) {
  const auto n = dofs.start.size() - 1;
  Incidence incidence{std::vector<int>(n + 1, 0), std::vector<int>(n_elements * n_corners)};
  for (int e = 0; e < n_elements; ++e) {
    for (const int v : vertices_of(e)) ++incidence.start[dofs.owner(v) + 1];
  }
  for (std::size_t v = 0; v < n; ++v) incidence.start[v + 1] += incidence.start[v];
  std::vector<int> next(incidence.start.begin(), incidence.start.end() - 1);
  for (int e = 0; e < n_elements; ++e) {
    for (int c = 0; c < n_corners; ++c) incidence.corner[next[dofs.owner(vertices_of(e)[c])]++] = n_corners * e + c;
  }
  return incidence;
}

// Vertices coupled to each vertex, itself included, ascending; `row` is the offset of their rows inside a column.
struct Couplings {
  std::vector<int> start, vertex, row;
};

// Of a vertex: all corners of its faces, and the other flap of the hinges of which it is one; all else stands in a
// face.
Couplings make_couplings(const Mesh& mesh, const DofMap& dofs, std::span<const Hinge> hinges, const Incidence& faces_at,
                         const Incidence& hinges_at) {
  const int n = mesh.n_vertices();
  Couplings couplings;
  couplings.start.assign(1, 0);
  couplings.vertex.reserve(13 * static_cast<std::size_t>(n));
  std::vector<int> seen_by(n, Mesh::none);
  for (int j = 0; j < n; ++j) {
    const auto add = [&](int v) {
      const int owner = dofs.owner(v);
      if (std::exchange(seen_by[owner], j) != j) couplings.vertex.push_back(owner);
    };
    for (const int at : faces_at.at(j)) {
      for (const int v : mesh.face(at / 3)) add(v);
    }
    for (const int at : hinges_at.at(j)) {
      if (at % 4 >= 2) add(hinges[at / 4].vertex[at % 4 == 2 ? 3 : 2]);
    }
    std::sort(couplings.vertex.begin() + couplings.start.back(), couplings.vertex.end());
    couplings.start.push_back(static_cast<int>(couplings.vertex.size()));
  }
  couplings.row.resize(couplings.vertex.size());
  for (int j = 0; j < n; ++j) {
    for (int k = couplings.start[j], row = 0; k < couplings.start[j + 1]; ++k) {
      couplings.row[k] = row;
      row += dofs.start[couplings.vertex[k] + 1] - dofs.start[couplings.vertex[k]];
    }
  }
  return couplings;
}

// Fills the index arrays of `matrix`; returns the column length of every vertex.
std::vector<int> lay_out(const Couplings& couplings, const DofMap& dofs, SparseMatrix& matrix) {
  const int n = static_cast<int>(dofs.start.size()) - 1;
  std::vector<int> stride(n);
  std::int64_t non_zeros = 0;
  for (int j = 0; j < n; ++j) {
    if (dofs.owner(j) != j) {  // the owner is the lowest
      stride[j] = stride[dofs.owner(j)];
      continue;
    }
    const int last = couplings.start[j + 1] - 1;
    const int i = couplings.vertex[last];
    stride[j] = couplings.row[last] + dofs.start[i + 1] - dofs.start[i];
    non_zeros += static_cast<std::int64_t>(stride[j]) * (dofs.start[j + 1] - dofs.start[j]);
  }
  require(non_zeros <= std::numeric_limits<int>::max(), "Assembler: the system has more than 2^31 non-zeros");

  matrix.resize(dofs.size(), dofs.size());
  matrix.resizeNonZeros(static_cast<Eigen::Index>(non_zeros));
  int* const outer = matrix.outerIndexPtr();
  int* const inner = matrix.innerIndexPtr();
  int at = 0;
  for (int j = 0; j < n; ++j) {
    for (int column = dofs.start[j]; column < dofs.start[j + 1]; ++column) {
      outer[column] = at;
      for (int k = couplings.start[j]; k < couplings.start[j + 1]; ++k) {
        const int i = couplings.vertex[k];
        for (int row = dofs.start[i]; row < dofs.start[i + 1]; ++row) inner[at++] = row;
      }
    }
  }
  outer[dofs.size()] = at;
  std::fill_n(matrix.valuePtr(), at, 0.0);
  return stride;
}

}  // namespace

std::vector<Hinge> all_hinges(const Mesh& mesh) {
  std::vector<Hinge> hinges;
  hinges.reserve(3 * mesh.n_faces() / 2);
  for (int h = 0; h < 3 * mesh.face_slots(); ++h) {
    const int sewn = mesh.seam_twin(h), other = sewn != Mesh::none ? sewn : mesh.twin(h);
    if (h < other)
      hinges.push_back({{mesh.from(h), mesh.to(h), mesh.opposite(h), mesh.opposite(other)},
                        {Mesh::face_of(h), Mesh::face_of(other)},
                        sewn});
  }
  return hinges;
}

std::array<Vec2, 4> flat_hinge(const Mesh& mesh, const Hinge& hinge) {
  const auto& [from, to, left, right] = hinge.vertex;
  std::array<Vec2, 4> X{mesh.X[from], mesh.X[to], mesh.X[left], mesh.X[right]};
  if (hinge.sewn_to == Mesh::none) return X;
  // The similarity that takes the other side's edge to this one, as a complex factor: here / there.
  const Vec2 here = X[1] - X[0], end = mesh.X[mesh.to(hinge.sewn_to)];
  const Vec2 there = mesh.X[mesh.from(hinge.sewn_to)] - end, p = X[3] - end;
  const Vec2 turn = Vec2(here.dot(there), here.y() * there.x() - here.x() * there.y()) / there.squaredNorm();
  X[3] = X[0] + Vec2(turn.x() * p.x() - turn.y() * p.y(), turn.x() * p.y() + turn.y() * p.x());
  return X;
}

BlockPattern make_block_pattern(const Mesh& mesh, const DofMap& dofs, bool with_hinges, SparseMatrix& matrix) {
  const std::vector<Hinge> hinges = with_hinges ? all_hinges(mesh) : std::vector<Hinge>{};
  const int n_hinges = static_cast<int>(hinges.size());
  const Incidence faces_at = make_incidence(dofs, mesh.n_faces(), 3, [&](int f) { return mesh.face(f); });
  const Incidence hinges_at = make_incidence(dofs, n_hinges, 4, [&](int e) { return hinges[e].vertex; });
  Couplings couplings = make_couplings(mesh, dofs, hinges, faces_at, hinges_at);
  BlockPattern pattern;
  pattern.stride = lay_out(couplings, dofs, matrix);
  pattern.faces.resize(mesh.n_faces());
  pattern.hinges.reserve(hinges.size());
  pattern.first_of.reserve(couplings.vertex.size());
  for (const Hinge& hinge : hinges) pattern.hinges.push_back({hinge, {}});
  std::vector<int> block(mesh.n_vertices());  // of each vertex' rows in the columns of vertex j
  for (int j = 0; j < mesh.n_vertices(); ++j) {
    for (int k = couplings.start[j]; k < couplings.start[j + 1]; ++k) {
      block[couplings.vertex[k]] = k;
      pattern.first_of.push_back(matrix.outerIndexPtr()[dofs.x(j)] + couplings.row[k]);
    }
    for (const int at : faces_at.at(j)) {
      for (int i = 0; i < 3; ++i)
        pattern.faces[at / 3].at[3 * i + at % 3] = pattern.first_of[block[dofs.owner(mesh.face(at / 3)[i])]];
    }
    for (const int at : hinges_at.at(j)) {
      BlockPattern::HingeBlocks& blocks = pattern.hinges[at / 4];
      for (int i = 0; i < 4; ++i) blocks.block[4 * i + at % 4] = block[dofs.owner(blocks.hinge.vertex[i])];
    }
  }
  pattern.block_start = std::move(couplings.start);
  return pattern;
}

}  // namespace crease
