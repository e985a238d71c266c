// SPDX-License-Identifier: MIT
#include "crease/dynamics/assemble.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <string>
#include <vector>

#include "block_pattern.hpp"
#include "crease/base/require.hpp"
#include "crease/base/workers.hpp"
#include "crease/dynamics/inertia.hpp"
#include "crease/geometry/triangle.hpp"
#include "element.hpp"
#include "shares.hpp"

namespace crease {

namespace {

using Mat5 = Eigen::Matrix<double, 5, 5>;

// B_i^T W B_j with B = (I, -F): a world block in the unknowns (xdot, Xdot) of two vertices.                [Eq. 10]
Mat5 to_eol_block(const Mat3& W, const Mat32& F_i, const Mat32& F_j, bool diagonal) {
  const Mat32 WF = W * F_j;
  Mat5 block;
  block.topLeftCorner<3, 3>() = W;
  block.topRightCorner<3, 2>() = -WF;
  block.bottomLeftCorner<2, 3>().noalias() = -F_i.transpose() * W;
  block.bottomRightCorner<2, 2>().noalias() = F_i.transpose() * WF;
  if (diagonal) {  // symmetric up to rounding: make it exact
    for (int row = 1; row < 5; ++row) {
      for (int col = 0; col < row; ++col) block(row, col) = block(col, row);
    }
  }
  return block;
}

// Adds one lane of a block of 3 unknowns by 3, or its transpose, to columns `stride` long.
inline void add_to(double* values, int stride, const Lanes (&W)[9], int lane) {
  for (int col = 0; col < 3; ++col) {
    for (int row = 0; row < 3; ++row) values[col * stride + row] += W[3 * col + row][lane];
  }
}

inline void add_transposed_to(double* values, int stride, const Lanes (&W)[9], int lane) {
  for (int col = 0; col < 3; ++col) {
    for (int row = 0; row < 3; ++row) values[col * stride + row] += W[3 * row + col][lane];
  }
}

Mat3 matrix_of(const Lanes (&W)[9], int lane) {
  Mat3 result;
  for (int k = 0; k < 9; ++k) result(k % 3, k / 3) = W[k][lane];
  return result;
}

inline Vec3 vector_of(const Lanes (&w)[3], int lane) {
  return {w[0][lane], w[1][lane], w[2][lane]};
}

// Where HingeBatch::weight has corners (i, j), or (j, i).
constexpr int pair(int i, int j) {
  return i <= j ? j * (j + 1) / 2 + i : pair(j, i);
}

// Faces from which on it is worth waking threads, which takes some microseconds each.
constexpr int least_shared = 500;

// One pass over the elements of a share, adding into its part of a system laid out by `pattern`.
struct Pass {
  const Cloth& cloth;
  const DofMap& dofs;
  const Material& material;
  const DynamicsOptions& options;
  const BlockPattern& pattern;
  double stiffness_scale;  // h^2 + h damping [s^2]
  const Share& share;
  AssembledSystem& system;
  std::vector<Energies>& face_energies;  // one a face, or none: then this is the only share, and adds them up
  std::vector<double>& hinge_energies;   // one a hinge
  std::vector<double>& bending;          // one a block: of the hinges without an Eulerian vertex
  const ElementKernels& kernels;

  void run();

 private:
  bool owns(int vertex) const { return share.owned[vertex] != 0; }
  void clear();
  void fill_diagonals();
  void add_faces();
  void add_hinges();
  void add_face(int f, const FaceBatch& batch, int lane);
  void add_plain_hinge(int hinge, const HingeBatch& batch, int lane);
  void add_eol_hinge(int hinge, const HingeBatch& batch, int lane);
  void add_face_matrix(int f, const FaceBatch& batch, int lane);
  void add_eol_terms(int f, const FaceBatch& batch, int lane);
  void add_block(int i, int j, int at_ij, int at_ji, const Mat3& W, const Mat32& F_i, const Mat32& F_j);
  void add_force(int vertex, const Vec3& f, const Mat32& F);
};

void Pass::run() {
  clear();
  add_hinges();
  add_faces();
}

// Calls `read` with an element and its lane for all lanes of a batch, the kernel, and `add` alike. Of the last batch,
// what is too many is read, but not added.
template <class Batch, class Read, class Kernel, class Add>
void go_through(const std::vector<int>& elements, Batch& batch, Read read, Kernel kernel, Add add) {
  const int n = static_cast<int>(elements.size());
  for (int first = 0; first < n; first += batch_lanes) {
    for (int lane = 0; lane < batch_lanes; ++lane) read(elements[std::min(first + lane, n - 1)], batch, lane);
    kernel(batch);
    for (int lane = 0; lane < std::min(batch_lanes, n - first); ++lane) add(elements[first + lane], batch, lane);
  }
}

void Pass::add_faces() {
  const FaceConstants constants = face_constants(material, options.gravity, stiffness_scale);
  FaceBatch faces;
  go_through(
      share.faces, faces, [&](int f, FaceBatch& batch, int lane) { read_face(cloth, f, batch, lane); },
      [&](FaceBatch& batch) { kernels.faces(constants, batch); },
      [&](int f, const FaceBatch& batch, int lane) { add_face(f, batch, lane); });
}

void Pass::add_hinges() {
  const double scaled_bending = scaled(material.bending);
  HingeBatch hinges;
  const auto read = [&](int hinge, HingeBatch& batch, int lane) {
    read_hinge(cloth.mesh, pattern.hinges[hinge].hinge, batch, lane);
  };
  const auto kernel = [&](HingeBatch& batch) { kernels.hinges(scaled_bending, stiffness_scale, batch); };
  go_through(share.plain_hinges, hinges, read, kernel,
             [&](int hinge, const HingeBatch& batch, int lane) { add_plain_hinge(hinge, batch, lane); });
  fill_diagonals();
  go_through(share.eol_hinges, hinges, read, kernel,
             [&](int hinge, const HingeBatch& batch, int lane) { add_eol_hinge(hinge, batch, lane); });
}

void Pass::clear() {
  for (const int v : share.vertices) {
    const int begin = dofs.start[v], end = dofs.start[v + 1];
    system.rhs.segment(begin, end - begin).setZero();
    system.force.segment(begin, end - begin).setZero();
    std::fill(bending.begin() + pattern.block_start[v], bending.begin() + pattern.block_start[v + 1], 0.0);
  }
}

// Writes all of H: the hinges that have been added up so far, whose blocks are multiples of the unit matrix.
void Pass::fill_diagonals() {
  double* const values = system.H.valuePtr();
  const int* const first = system.H.outerIndexPtr();
  for (const int v : share.vertices) {
    std::fill(values + first[dofs.start[v]], values + first[dofs.start[v + 1]], 0.0);
    const int diagonal = pattern.stride[v] + 1;
    for (int k = pattern.block_start[v]; k < pattern.block_start[v + 1]; ++k) {
      double* const block = values + pattern.first_of[k];
      block[0] = block[diagonal] = block[2 * diagonal] = bending[k];
    }
  }
}

// Entry (i, j) of an element whose F is given, and its transpose (j, i); i == j once.
void Pass::add_block(int i, int j, int at_ij, int at_ji, const Mat3& W, const Mat32& F_i, const Mat32& F_j) {
  double* const values = system.H.valuePtr();
  const int rows = dofs.is_eol(i) ? 5 : 3, cols = dofs.is_eol(j) ? 5 : 3;
  Mat5 block;
  if (rows == 3 && cols == 3)
    block.topLeftCorner<3, 3>() = W;
  else
    block = to_eol_block(W, F_i, F_j, i == j);
  for (int col = 0; col < cols && owns(j); ++col) {
    for (int row = 0; row < rows; ++row) values[at_ij + col * pattern.stride[j] + row] += block(row, col);
  }
  for (int row = 0; row < rows && i != j && owns(i); ++row) {
    for (int col = 0; col < cols; ++col) values[at_ji + row * pattern.stride[i] + col] += block(row, col);
  }
}

void Pass::add_force(int vertex, const Vec3& f, const Mat32& F) {
  if (!owns(vertex)) return;
  system.force.segment<3>(dofs.x(vertex)) += f;
  if (dofs.is_eol(vertex)) system.force.segment<2>(dofs.X(vertex)) -= F.transpose() * f;
}

void Pass::add_face_matrix(int f, const FaceBatch& batch, int lane) {
  const std::array<int, 3>& v = cloth.mesh.face(f);
  const std::array<int, 9>& at = pattern.faces[f].at;
  double* const values = system.H.valuePtr();
  int block = 0;
  for (int i = 0; i < 3; ++i) {
    for (int j = i; j < 3; ++j, ++block) {
      if (owns(v[j])) add_to(values + at[3 * i + j], pattern.stride[v[j]], batch.H[block], lane);
      if (i != j && owns(v[i])) add_transposed_to(values + at[3 * j + i], pattern.stride[v[i]], batch.H[block], lane);
    }
  }
}

void Pass::add_face(int f, const FaceBatch& batch, int lane) {
  const std::array<int, 3>& v = cloth.mesh.face(f);
  if (face_energies.empty())
    system.energies += energies_of(batch, lane);
  else if (owns(v[0]))
    face_energies[f] = energies_of(batch, lane);
  if (dofs.is_eol(v[0]) || dofs.is_eol(v[1]) || dofs.is_eol(v[2])) return add_eol_terms(f, batch, lane);
  add_face_matrix(f, batch, lane);
  for (int i = 0; i < 3; ++i) {
    if (!owns(v[i])) continue;
    system.force.segment<3>(dofs.x(v[i])) += vector_of(batch.force[i], lane);
    system.rhs.segment<3>(dofs.x(v[i])) += vector_of(batch.impulse[i], lane);
  }
}

// All of a face with an Eulerian corner. The velocity terms go also to where all Xdot are zero: there those of the
// single faces cancel at a vertex only in their sum.
void Pass::add_eol_terms(int f, const FaceBatch& batch, int lane) {
  const std::array<int, 3>& v = cloth.mesh.face(f);
  const std::array<int, 9>& at = pattern.faces[f].at;
  Mat32 F;
  F << vector_of(batch.F[0], lane), vector_of(batch.F[1], lane);
  int block = 0;
  for (int i = 0; i < 3; ++i) {
    for (int j = i; j < 3; ++j)
      add_block(v[i], v[j], at[3 * i + j], at[3 * j + i], matrix_of(batch.H[block++], lane), F, F);
  }
  TriangleState state{material_corners(cloth.mesh, f), world_corners(cloth.mesh, f), {}, {}};
  for (int i = 0; i < 3; ++i) {
    state.V[i] = cloth.V[v[i]];
    state.v[i] = cloth.v[v[i]];
  }
  const Mat32 g = barycentric_gradients(state.X);
  const Vec15 C = options.velocity_terms ? eol_velocity_terms(state, material.density) : Vec15::Zero();
  for (int i = 0; i < 3; ++i) {
    if (!owns(v[i])) continue;
    const int x = dofs.x(v[i]);
    const Vec3 impulse = vector_of(batch.impulse[i], lane);
    add_force(v[i], vector_of(batch.force[i], lane), F);
    system.force.segment<3>(x) -= C.segment<3>(3 * i);
    system.rhs.segment<3>(x) += impulse;
    if (!dofs.is_eol(v[i])) continue;
    system.force.segment<2>(x + 3) -= batch.membrane[lane] * g.row(i).transpose() + C.segment<2>(9 + 2 * i);
    system.rhs.segment<2>(x + 3) -= F.transpose() * impulse;
  }
}

void Pass::add_plain_hinge(int hinge, const HingeBatch& batch, int lane) {
  const BlockPattern::HingeBlocks& blocks = pattern.hinges[hinge];
  const std::array<int, 4>& v = blocks.hinge.vertex;
  if (owns(v[0])) hinge_energies[hinge] = batch.energy[lane];
  for (int j = 0; j < 4; ++j) {
    if (!owns(v[j])) continue;
    for (int i = 0; i < 4; ++i) bending[blocks.block[4 * i + j]] += batch.weight[pair(i, j)][lane];
    system.force.segment<3>(dofs.x(v[j])) += vector_of(batch.force[j], lane);
  }
}

// F is the plain mean of the two faces. At an unstretched fold the bending force is along (F_0 - F_1) N and
// |F_0 N| = |F_1 N|, so this mean, and no other, lets bending push the fold nowhere. Across a seam each face has its
// own material axes, so each side has its own F; on the seam itself no vertex is Eulerian.
void Pass::add_eol_hinge(int hinge, const HingeBatch& batch, int lane) {
  const BlockPattern::HingeBlocks& blocks = pattern.hinges[hinge];
  const std::array<int, 4>& v = blocks.hinge.vertex;
  if (owns(v[0])) hinge_energies[hinge] = batch.energy[lane];
  std::array<Mat32, 2> F;  // for face 0 and the edge; for the opposite in face 1
  for (std::size_t side = 0; side < 2; ++side) F[side] = deformation_gradient(cloth.mesh, blocks.hinge.face[side]);
  if (blocks.hinge.sewn_to == Mesh::none) F[0] = F[1] = 0.5 * (F[0] + F[1]);
  for (int j = 0; j < 4; ++j) {
    add_force(v[j], vector_of(batch.force[j], lane), F[j / 3]);
    for (int i = 0; i <= j; ++i)
      add_block(v[i], v[j], pattern.first_of[blocks.block[4 * i + j]], pattern.first_of[blocks.block[4 * j + i]],
                batch.weight[pair(i, j)][lane] * Mat3::Identity(), F[i / 3], F[j / 3]);
  }
}

}  // namespace

struct Assembler::Impl {
  Impl(int n_threads, const ElementKernels& found) : threads(n_threads), workers(n_threads), kernels(&found) {}

  int threads;
  Workers workers;
  const ElementKernels* kernels;
  AssembledSystem system;
  BlockPattern pattern;
  std::vector<Share> shares;
  std::vector<Energies> face_energies;
  std::vector<double> hinge_energies, bending;
  bool with_hinges = false;

  void lay_out(const Mesh& mesh, const DofMap& dofs, bool bends, bool same_topology);
  void finish(double h);
};

void Assembler::Impl::lay_out(const Mesh& mesh, const DofMap& dofs, bool bends, bool same_topology) {
  const bool fits = system.H.rows() == dofs.size() && with_hinges == bends &&
                    pattern.faces.size() == static_cast<std::size_t>(mesh.n_faces());
  if (same_topology && fits) return;
  pattern = make_block_pattern(mesh, dofs, bends, system.H);
  with_hinges = bends;
  shares = share_out(mesh, dofs, pattern, mesh.n_faces() < least_shared ? 1 : threads);
  system.rhs.resize(dofs.size());
  system.force.resize(dofs.size());
  face_energies.resize(shares.size() > 1 ? pattern.faces.size() : 0);
  hinge_energies.resize(pattern.hinges.size());
  bending.resize(pattern.first_of.size());
}

// Energies are added up here, in one order for any number of threads.
void Assembler::Impl::finish(double h) {
  system.rhs += h * system.force;
  for (const Energies& face : face_energies) system.energies += face;
  for (const double hinge : hinge_energies) system.energies.bending += hinge;
}

Assembler::Assembler(int threads, ElementKernelSet kernels) {
  require(threads >= 1, "Assembler: expected at least one thread, got " + std::to_string(threads));
  impl_ = std::make_unique<Impl>(threads, find_element_kernels(kernels));
}
Assembler::~Assembler() = default;
Assembler::Assembler(Assembler&&) noexcept = default;
Assembler& Assembler::operator=(Assembler&&) noexcept = default;

const AssembledSystem& Assembler::assemble(const Cloth& cloth, const DofMap& dofs, const Material& material,
                                           const DynamicsOptions& options, double h, bool same_topology) {
  require(cloth.mesh.is_compact(), "Assembler: expected a compact mesh");
  require(dofs.start.size() == static_cast<std::size_t>(cloth.mesh.n_vertices()) + 1,
          "Assembler: expected the DofMap of this cloth");
  require(std::isfinite(h) && h > 0, "Assembler: expected a time step > 0 [s]");
  require_valid(material);

  impl_->lay_out(cloth.mesh, dofs, material.bending > 0, same_topology);
  impl_->system.energies = {};
  impl_->workers.run(static_cast<int>(impl_->shares.size()), [&](int k) {
    Pass{.cloth = cloth,
         .dofs = dofs,
         .material = material,
         .options = options,
         .pattern = impl_->pattern,
         .stiffness_scale = h * (h + material.damping),
         .share = impl_->shares[k],
         .system = impl_->system,
         .face_energies = impl_->face_energies,
         .hinge_energies = impl_->hinge_energies,
         .bending = impl_->bending,
         .kernels = *impl_->kernels}
        .run();
  });
  impl_->finish(h);
  return impl_->system;
}

}  // namespace crease
