// SPDX-License-Identifier: MIT
#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

#include <Eigen/Geometry>
#include <Eigen/LU>

#include "crease/geometry/triangle.hpp"
#include "crease/remesh/remesh.hpp"
#include "metric.hpp"
#include "options.hpp"
#include "transfer.hpp"

// Notation: G = grad_X of a nodal quantity on a face (3x2); N = grad_X of the nodal normals; g_i = grad_X alpha_i, one
// a row of a 3x2 matrix. A chain (tagged edges) is a fold that the mesh resolves exactly, so nothing here looks across
// it: tagged edges have no dihedral angle, and nodal normals on a chain belong to one side of it.
namespace crease {

namespace {

// The metric's edge length may grow by this factor from one edge to the next.
constexpr double gradation = 1.4;
constexpr int max_gradation_sweeps = 24;

// Unit normal at every half-edge's origin, as its face sees it: a mean over the faces that are reached round the
// vertex without crossing a chain. Weights 1/(|e1|^2 |e2|^2) make it exact on a sphere.                        [MAX99]
std::vector<Vec3> corner_normals(const Mesh& mesh) {
  std::vector<Vec3> normals(static_cast<std::size_t>(3 * mesh.face_slots()), Vec3::Zero());
  std::vector<int> sector;
  const auto close_sector = [&] {
    Vec3 sum = Vec3::Zero();
    for (const int h : sector) {
      const Vec3 e1 = mesh.x[mesh.to(h)] - mesh.x[mesh.from(h)], e2 = mesh.x[mesh.opposite(h)] - mesh.x[mesh.from(h)];
      const double weight = e1.squaredNorm() * e2.squaredNorm();
      if (weight > 0) sum += e1.cross(e2) / weight;
    }
    const double length = sum.norm();
    if (length > 0) sum /= length;
    for (const int h : sector) normals[h] = sum;
    sector.clear();
  };
  for (int v = 0; v < mesh.vertex_slots(); ++v) {
    if (!mesh.vertex_live(v)) continue;
    const int first = mesh.halfedge(v);
    // Start behind a chain edge, so that no sector is cut by the place where the round begins.
    int start = first, h = first;
    do {
      if (mesh.tag(h) != 0) start = h;
      h = mesh.twin(Mesh::prev(h));
    } while (h != Mesh::none && h != first);
    if (h == Mesh::none) start = first;
    h = start;
    do {
      if (mesh.tag(h) != 0 && !sector.empty()) close_sector();
      sector.push_back(h);
      h = mesh.twin(Mesh::prev(h));
    } while (h != Mesh::none && h != start);
    close_sector();
  }
  return normals;
}

Mat32 gradient(const std::array<Vec3, 3>& nodal, const Mat32& g) {
  return nodal[0] * g.row(0) + nodal[1] * g.row(1) + nodal[2] * g.row(2);
}

// Signed world dihedral of every edge, at its canonical half-edge: 0 at borders and chains.
std::vector<double> dihedrals(const Mesh& mesh, const std::vector<Vec3>& face_normals) {
  std::vector<double> angles(static_cast<std::size_t>(3 * mesh.face_slots()), 0.0);
  for (int h = 0; h < 3 * mesh.face_slots(); ++h) {
    const int g = mesh.twin(h);
    if (g <= h || mesh.tag(h) != 0 || !mesh.face_live(Mesh::face_of(h))) continue;
    const Vec3 &n0 = face_normals[Mesh::face_of(h)], &n1 = face_normals[Mesh::face_of(g)];
    const Vec3 e = (mesh.x[mesh.to(h)] - mesh.x[mesh.from(h)]).normalized();
    angles[h] = angles[g] = std::atan2(e.dot(n0.cross(n1)), n0.dot(n1));
  }
  return angles;
}

// S^T S of the shape operator from the dihedral angles of the face's edges; it sees sawtooth folds, which average out
// of nodal normals.
Mat2 dihedral_curvature(const Mesh& mesh, int face, const std::vector<double>& angles, double area) {
  Mat2 S = Mat2::Zero();
  for (int h = 3 * face; h < 3 * face + 3; ++h) {
    if (angles[h] == 0) continue;
    const Vec2 E = mesh.X[mesh.to(h)] - mesh.X[mesh.from(h)];
    const Vec2 t(E.y(), -E.x());  // length |E|, so theta/2 |E| t t^T with unit t is theta/2 t t^T / |E|
    S -= 0.5 * angles[h] / E.norm() * t * t.transpose();
  }
  S /= area;
  return S * S;
}

// G without the rigid rotation that fits it best: a turning sheet asks for no refinement.
Mat32 without_spin(const Mat32& G, const Mat32& F) {
  const Mat3 A = F.squaredNorm() * Mat3::Identity() - F * F.transpose();
  const Vec3 b = F.col(0).cross(G.col(0)) + F.col(1).cross(G.col(1));
  const double size2 = F.squaredNorm();
  if (!(A.determinant() > 1e-12 * size2 * size2 * size2)) return G;  // crumpled to a line: no rotation to speak of
  const Vec3 spin = A.inverse() * b;
  Mat32 result = G;
  result.col(0) -= spin.cross(F.col(0));
  result.col(1) -= spin.cross(F.col(1));
  return result;
}

// Edges short enough that the buckle which takes up a compression has an amplitude of at most c: per direction the
// larger root m of c^2 m^2 + E m + K = 0, K the curvature across it, which stiffens like a rib.            [NARAIN12]
Mat2 compression_tensor(const Mat32& F, const Mat2& NtN, double c) {
  const Mat2 E = F.transpose() * F - Mat2::Identity();
  const Mat2 K = NtN.trace() * Mat2::Identity() - NtN;
  const Mat2 D = E * E - 4 * c * c * K;
  const Mat2 root = map_eigenvalues(D, [](double l) { return std::copysign(std::sqrt(std::abs(l)), l); });
  const Mat2 M = (root - E) / (2 * c * c);
  return map_eigenvalues(M, [](double l) { return std::max(l, 0.0); });
}

Mat2 limited(const Mat2& M, const AdaptOptions& options) {
  const double least = 1 / (options.size[1] * options.size[1]), most = 1 / (options.size[0] * options.size[0]);
  if (!M.allFinite()) return least * Mat2::Identity();
  const Spectrum s = spectrum(M);
  const double large = std::clamp(s.large, least, most);
  const double small = std::max(std::clamp(s.small, least, most), options.aspect * options.aspect * large);
  return with_eigenvalues(s, large, small);
}

Mat2 face_tensor(const Cloth& cloth, int face, const std::vector<double>& angles, const std::vector<Vec3>& normals,
                 const AdaptOptions& options) {
  const Mesh& mesh = cloth.mesh;
  const Mat32 g = barycentric_gradients(material_corners(mesh, face));
  const Mat32 F = gradient(world_corners(mesh, face), g);
  const Mat32 N = gradient({normals[3 * face], normals[3 * face + 1], normals[3 * face + 2]}, g);
  const Mat2 NtN = N.transpose() * N;
  const Mat32 W = without_spin(gradient(corner_velocities(cloth, face), g), F);
  const double angle2 = options.angle * options.angle, speed2 = options.velocity * options.velocity;
  const std::array<Mat2, 4> terms{dihedral_curvature(mesh, face, angles, mesh.material_area(face)) / angle2,
                                  NtN / angle2, W.transpose() * W / speed2,
                                  compression_tensor(F, NtN, options.compression)};
  return limited(tensor_max(terms), options);
}

// Log-Euclidean, area-weighted mean of the face tensors at each vertex: the mean of sizes, not of densities.
std::vector<Mat2> vertex_means(const Mesh& mesh, const std::vector<Mat2>& faces) {
  std::vector<Mat2> logs(static_cast<std::size_t>(mesh.vertex_slots()), Mat2::Zero());
  std::vector<double> areas(logs.size(), 0.0);
  for (int f = 0; f < mesh.face_slots(); ++f) {
    if (!mesh.face_live(f)) continue;
    const double area = mesh.material_area(f);
    const Mat2 weighted = area * map_eigenvalues(faces[f], [](double l) { return std::log(l); });
    for (const int v : mesh.face(f)) {
      logs[v] += weighted;
      areas[v] += area;
    }
  }
  for (std::size_t v = 0; v < logs.size(); ++v)
    if (areas[v] > 0) logs[v] = map_eigenvalues(logs[v] / areas[v], [](double l) { return std::exp(l); });
  return logs;
}

// A tensor with its eigenvalues, which say at once whether one can demand anything of another.
struct Size {
  Mat2 M;
  double large, small;
  explicit Size(const Mat2& tensor) : M(tensor) {
    const Spectrum s = spectrum(tensor);
    large = s.large;
    small = s.small;
  }
};

// Raises the tensor at `to` to what `from`, an edge e away, allows it to fall to. Returns whether it did.
bool spread(const Size& from, Size& to, const Vec2& e) {
  if (from.large <= to.small) return false;
  const double growth = 1 + std::sqrt(e.dot(from.M * e)) * std::log(gradation);
  if (from.large <= to.small * growth * growth) return false;
  const std::array<Mat2, 2> both{from.M / (growth * growth), to.M};
  const Mat2 raised = tensor_max(both);
  // Changes this small decide no edge; they only keep the sweeps going.
  if (raised.trace() <= to.M.trace() * (1 + 1e-6)) return false;
  to = Size(raised);
  return true;
}

void limit_gradation(const Mesh& mesh, std::vector<Mat2>& tensors, const AdaptOptions& options) {
  if (options.size[1] <= options.size[0]) return;
  std::vector<Size> sizes(tensors.begin(), tensors.end());
  const std::vector<int> edges = mesh.edges();
  for (int sweep = 0; sweep < max_gradation_sweeps; ++sweep) {
    bool changed = false;
    for (const int h : edges) {
      const int a = mesh.from(h), b = mesh.to(h);
      const Vec2 e = mesh.X[b] - mesh.X[a];
      changed |= spread(sizes[a], sizes[b], e);
      changed |= spread(sizes[b], sizes[a], e);
    }
    if (!changed) break;
  }
  for (std::size_t v = 0; v < tensors.size(); ++v) tensors[v] = sizes[v].M;
}

}  // namespace

std::vector<Mat2> sizing_field(const Cloth& cloth, const AdaptOptions& options) {
  require_valid(options);
  const Mesh& mesh = cloth.mesh;
  std::vector<Vec3> face_normals(static_cast<std::size_t>(mesh.face_slots()), Vec3::Zero());
  for (int f = 0; f < mesh.face_slots(); ++f)
    if (mesh.face_live(f)) face_normals[f] = face_normal(mesh, f);
  const std::vector<double> angles = dihedrals(mesh, face_normals);
  const std::vector<Vec3> normals = corner_normals(mesh);
  std::vector<Mat2> faces(face_normals.size(), Mat2::Identity());
  for (int f = 0; f < mesh.face_slots(); ++f)
    if (mesh.face_live(f)) faces[f] = face_tensor(cloth, f, angles, normals, options);
  std::vector<Mat2> tensors = vertex_means(mesh, faces);
  limit_gradation(mesh, tensors, options);
  return tensors;
}

}  // namespace crease
