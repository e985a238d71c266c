// SPDX-License-Identifier: MIT
#include "block_pattern.hpp"

#include <algorithm>
#include <limits>
#include <span>

#include "crease/base/require.hpp"

namespace crease {

namespace {

// Vertices coupled to each vertex, itself included, ascending; `row` is the offset of their rows inside a column.
struct Couplings {
  std::vector<int> start, vertex, row;

  int row_of(int i, int j) const {
    const auto begin = vertex.begin() + start[j], end = vertex.begin() + start[j + 1];
    const auto found = std::lower_bound(begin, end, i);
    CREASE_ASSERT(found != end && *found == i);
    return row[found - vertex.begin()];
  }
};

// Sorts each vertex' list and drops what is repeated.
void sort_unique(Couplings& couplings) {
  int out = 0, begin = 0;
  for (std::size_t j = 0; j + 1 < couplings.start.size(); ++j) {
    const int end = couplings.start[j + 1];
    const auto first = couplings.vertex.begin() + begin;
    std::sort(first, couplings.vertex.begin() + end);
    const auto last = std::unique(first, couplings.vertex.begin() + end);
    couplings.start[j] = out;
    out = static_cast<int>(std::copy(first, last, couplings.vertex.begin() + out) - couplings.vertex.begin());
    begin = end;
  }
  couplings.start.back() = out;
  couplings.vertex.resize(out);
}

Couplings make_couplings(const Mesh& mesh, const DofMap& dofs, std::span<const Hinge> hinges) {
  const int n = mesh.n_vertices();
  Couplings couplings;
  couplings.start.assign(n + 1, 0);
  // Every face lists its three corners at each corner; a hinge adds the pair of flaps, all else stands in a face. Tied
  // vertices are listed as the one that owns their unknowns.
  const auto owner = [&](int v) { return dofs.owner(v); };
  for (int f = 0; f < mesh.n_faces(); ++f) {
    for (const int v : mesh.face(f)) couplings.start[owner(v) + 1] += 3;
  }
  for (const Hinge& hinge : hinges) {
    ++couplings.start[owner(hinge.vertex[2]) + 1];
    ++couplings.start[owner(hinge.vertex[3]) + 1];
  }
  for (int v = 0; v < n; ++v) couplings.start[v + 1] += couplings.start[v];

  couplings.vertex.resize(couplings.start[n]);
  std::vector<int> next(couplings.start.begin(), couplings.start.end() - 1);
  for (int f = 0; f < mesh.n_faces(); ++f) {
    for (const int v : mesh.face(f)) {
      for (const int w : mesh.face(f)) couplings.vertex[next[owner(v)]++] = owner(w);
    }
  }
  for (const Hinge& hinge : hinges) {
    const int left = owner(hinge.vertex[2]), right = owner(hinge.vertex[3]);
    couplings.vertex[next[left]++] = right;
    couplings.vertex[next[right]++] = left;
  }
  sort_unique(couplings);

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
  const Couplings couplings = make_couplings(mesh, dofs, hinges);
  BlockPattern pattern;
  pattern.stride = lay_out(couplings, dofs, matrix);
  const auto first_value = [&](int i, int j) {
    return matrix.outerIndexPtr()[dofs.x(j)] + couplings.row_of(dofs.owner(i), dofs.owner(j));
  };
  pattern.faces.resize(mesh.n_faces());
  for (int f = 0; f < mesh.n_faces(); ++f) {
    for (int i = 0; i < 3; ++i) {
      for (int j = 0; j < 3; ++j) pattern.faces[f].at[3 * i + j] = first_value(mesh.face(f)[i], mesh.face(f)[j]);
    }
  }
  pattern.hinges.reserve(hinges.size());
  for (const Hinge& hinge : hinges) {
    BlockPattern::HingeBlocks& blocks = pattern.hinges.emplace_back(BlockPattern::HingeBlocks{hinge, {}});
    for (int i = 0; i < 4; ++i) {
      for (int j = 0; j < 4; ++j) blocks.at[4 * i + j] = first_value(hinge.vertex[i], hinge.vertex[j]);
    }
  }
  return pattern;
}

}  // namespace crease
