// SPDX-License-Identifier: MIT
#include "crease/dynamics/assemble.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <string>
#include <system_error>
#include <thread>
#include <vector>

#include "block_pattern.hpp"
#include "crease/base/require.hpp"
#include "crease/dynamics/bending.hpp"
#include "crease/dynamics/inertia.hpp"
#include "crease/dynamics/membrane.hpp"
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

// Adds a block of 3 unknowns by 3, or its transpose, to columns `stride` long.
inline void add_to(double* values, int stride, const Mat3& W) {
  for (int col = 0; col < 3; ++col) {
    for (int row = 0; row < 3; ++row) values[col * stride + row] += W(row, col);
  }
}

inline void add_transposed_to(double* values, int stride, const Mat3& W) {
  for (int col = 0; col < 3; ++col) {
    for (int row = 0; row < 3; ++row) values[col * stride + row] += W(col, row);
  }
}

// Faces from which on it is worth starting threads, each of which takes some 20 microseconds of it.
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
  std::vector<Energies>& face_energies;  // one a face
  std::vector<double>& hinge_energies;   // one a hinge

  void run();

 private:
  bool owns(int vertex) const { return share.owned[vertex] != 0; }
  void clear();
  void add_face(int f);
  void add_hinge(int hinge);
  void add_face_matrix(const FaceState& face, const Mat9& stiffness, const BlockPattern::FaceBlocks& blocks);
  void add_velocity_terms(const FaceState& face);
  void add_hinge_matrix(const BlockPattern::HingeBlocks& blocks, const BendingElement& element,
                        const std::array<Mat32, 2>* F);
  void add_block(int i, int j, int at_ij, int at_ji, const Mat3& W, const Mat32& F_i, const Mat32& F_j);
  void add_force(int vertex, const Vec3& f, const Mat32& F);
};

void Pass::run() {
  clear();
  for (const int f : share.faces) add_face(f);
  for (const int hinge : share.hinges) add_hinge(hinge);
}

void Pass::clear() {
  const int* const first = system.H.outerIndexPtr();
  for (const int v : share.vertices) {
    const int begin = dofs.start[v], end = dofs.start[v + 1];
    std::fill(system.H.valuePtr() + first[begin], system.H.valuePtr() + first[end], 0.0);
    system.rhs.segment(begin, end - begin).setZero();
    system.force.segment(begin, end - begin).setZero();
  }
}

// Entry (i, j) of an element whose F is given, and its transpose (j, i); i == j once.
void Pass::add_block(int i, int j, int at_ij, int at_ji, const Mat3& W, const Mat32& F_i, const Mat32& F_j) {
  double* const values = system.H.valuePtr();
  const Mat5 block = to_eol_block(W, F_i, F_j, i == j);
  const int rows = dofs.is_eol(i) ? 5 : 3, cols = dofs.is_eol(j) ? 5 : 3;
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

void Pass::add_face_matrix(const FaceState& face, const Mat9& stiffness, const BlockPattern::FaceBlocks& blocks) {
  double* const values = system.H.valuePtr();
  for (int i = 0; i < 3; ++i) {
    for (int j = i; j < 3; ++j) {
      Mat3 W = stiffness_scale * stiffness.block<3, 3>(3 * i, 3 * j);
      W.diagonal().array() += face.mass / 12 * (i == j ? 2 : 1);
      const int at_ij = blocks.at[3 * i + j], at_ji = blocks.at[3 * j + i];
      if (face.eol) {
        add_block(face.vertex[i], face.vertex[j], at_ij, at_ji, W, face.F, face.F);
        continue;
      }
      if (owns(face.vertex[j])) add_to(values + at_ij, pattern.stride[face.vertex[j]], W);
      if (i != j && owns(face.vertex[i])) add_transposed_to(values + at_ji, pattern.stride[face.vertex[i]], W);
    }
  }
}

// Also where all Xdot are zero: there the terms of the single faces cancel at a vertex only in their sum.
void Pass::add_velocity_terms(const FaceState& face) {
  const Vec15 C = eol_velocity_terms(face.state, material.density);
  for (int i = 0; i < 3; ++i) {
    const int v = face.vertex[i];
    if (!owns(v)) continue;
    system.force.segment<3>(dofs.x(v)) -= C.segment<3>(3 * i);
    if (dofs.is_eol(v)) system.force.segment<2>(dofs.X(v)) -= C.segment<2>(9 + 2 * i);
  }
}

void Pass::add_face(int f) {
  const FaceState face = read_face(cloth, f, material.density);
  const MembraneElement membrane = membrane_element(face.state.X, face.state.x, material);
  add_face_matrix(face, membrane.stiffness, pattern.faces[f]);
  if (owns(face.vertex[0])) face_energies[f] = energies_of(face, options.gravity, membrane.energy);

  for (int i = 0; i < 3; ++i) {
    const int v = face.vertex[i];
    if (!owns(v)) continue;
    add_force(v, membrane.force.segment<3>(3 * i) + face.mass / 3 * options.gravity, face.F);
    system.rhs.segment<3>(dofs.x(v)) += face.motion.p[i];
    if (dofs.is_eol(v)) system.rhs.segment<2>(dofs.X(v)) -= face.F.transpose() * face.motion.p[i];
  }
  if (!face.eol) return;
  const Mat32 g = barycentric_gradients(face.state.X);
  for (int i = 0; i < 3; ++i) {
    const int v = face.vertex[i];
    if (dofs.is_eol(v) && owns(v)) system.force.segment<2>(dofs.X(v)) -= membrane.energy * g.row(i).transpose();
  }
  if (options.velocity_terms) add_velocity_terms(face);
}

// On a hinge with an Eulerian vertex F is the plain mean of its two faces. At an unstretched fold the bending force is
// along (F_0 - F_1) N and |F_0 N| = |F_1 N|, so this mean, and no other, lets bending push the fold nowhere. Across a
// seam each face has its own material axes, so each side has its own F; on the seam itself no vertex is Eulerian.
void Pass::add_hinge(int hinge) {
  const BlockPattern::HingeBlocks& blocks = pattern.hinges[hinge];
  const Mesh& mesh = cloth.mesh;
  const std::array<int, 4>& v = blocks.hinge.vertex;
  const BendingElement element = bending_element(flat_hinge(mesh, blocks.hinge), material.bending);
  Vec3 curvature = Vec3::Zero();
  bool eol = false;
  for (int i = 0; i < 4; ++i) {
    curvature += element.k[i] * mesh.x[v[i]];
    eol = eol || dofs.is_eol(v[i]);
  }
  if (owns(v[0])) hinge_energies[hinge] = 0.5 * element.c * curvature.squaredNorm();

  std::array<Mat32, 2> F{Mat32::Zero(), Mat32::Zero()};  // for face 0 and the edge; for the opposite in face 1
  if (eol) {
    for (std::size_t side = 0; side < 2; ++side) F[side] = deformation_gradient(mesh, blocks.hinge.face[side]);
    if (blocks.hinge.sewn_to == Mesh::none) F[0] = F[1] = 0.5 * (F[0] + F[1]);
  }
  for (int i = 0; i < 4; ++i) add_force(v[i], -element.c * element.k[i] * curvature, F[i / 3]);
  add_hinge_matrix(blocks, element, eol ? &F : nullptr);
}

// F = nullptr: all four vertices are Lagrangian.
void Pass::add_hinge_matrix(const BlockPattern::HingeBlocks& blocks, const BendingElement& element,
                            const std::array<Mat32, 2>* F) {
  double* const values = system.H.valuePtr();
  const std::array<int, 4>& v = blocks.hinge.vertex;
  for (int j = 0; j < 4; ++j) {
    const int diagonal = pattern.stride[v[j]] + 1;
    if (F == nullptr && !owns(v[j])) continue;
    for (int i = 0; i < 4; ++i) {
      const double w = stiffness_scale * element.c * (element.k[i] * element.k[j]);  // same bits for (j, i)
      const int at = blocks.at[4 * i + j];
      if (F == nullptr) {
        double* const block = values + at;
        block[0] += w;
        block[diagonal] += w;
        block[2 * diagonal] += w;
      } else if (i <= j) {
        add_block(v[i], v[j], at, blocks.at[4 * j + i], w * Mat3::Identity(), (*F)[i / 3], (*F)[j / 3]);
      }
    }
  }
}

}  // namespace

struct Assembler::Impl {
  int threads = 1;
  AssembledSystem system;
  BlockPattern pattern;
  std::vector<Share> shares;
  std::vector<Energies> face_energies;
  std::vector<double> hinge_energies;
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
  face_energies.resize(pattern.faces.size());
  hinge_energies.resize(pattern.hinges.size());
}

// Energies are added up here, in one order for any number of threads.
void Assembler::Impl::finish(double h) {
  system.rhs += h * system.force;
  system.energies = {};
  for (const Energies& face : face_energies) system.energies += face;
  for (const double bending : hinge_energies) system.energies.bending += bending;
}

Assembler::Assembler(int threads) : impl_(std::make_unique<Impl>()) {
  require(threads >= 1, "Assembler: expected at least one thread, got " + std::to_string(threads));
  impl_->threads = threads;
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
  const auto run = [&](const Share& share) {
    Pass{.cloth = cloth,
         .dofs = dofs,
         .material = material,
         .options = options,
         .pattern = impl_->pattern,
         .stiffness_scale = h * (h + material.damping),
         .share = share,
         .system = impl_->system,
         .face_energies = impl_->face_energies,
         .hinge_energies = impl_->hinge_energies}
        .run();
  };
  {
    std::vector<std::jthread> threads;
    for (std::size_t k = 1; k < impl_->shares.size(); ++k) {
      try {
        threads.emplace_back(run, std::cref(impl_->shares[k]));
      } catch (const std::system_error&) {
        run(impl_->shares[k]);  // no more threads to be had
      }
    }
    run(impl_->shares[0]);
  }
  impl_->finish(h);
  return impl_->system;
}

}  // namespace crease
