// SPDX-License-Identifier: MIT
#include "sizing.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include <Eigen/Geometry>
#include <Eigen/LU>

#include "crease/geometry/triangle.hpp"
#include "options.hpp"
#include "transfer.hpp"

// Notation: G = grad_X of a nodal quantity on a face (3x2); N = grad_X of the nodal normals; g_i = grad_X alpha_i, one
// a row of a 3x2 matrix. A chain (tagged edges) is a fold that the mesh resolves exactly, so nothing here looks across
// it: tagged edges have no dihedral angle, and nodal normals on a chain belong to one side of it.
//
// A term that asks for no edge below the longest allowed is left out before its tensor is made: the limits ask for that
// much anyway, and on most of a sheet no other term is left.
namespace crease {

namespace {

// Normals of the world surface; at a vertex on a chain each side has its own.
struct Normals {
  std::vector<Vec3> face;    // unit, zero where there is none
  std::vector<Vec3> shared;  // unit
  std::vector<int> corner;   // into `shared`, one a half-edge: its origin's; empty where there is no chain

  explicit Normals(const Mesh& mesh);
  /// @param vertex  where half-edge h begins
  const Vec3& at(int h, int vertex) const { return shared[corner.empty() ? vertex : corner[h]]; }

 private:
  void split_at_chain(const Mesh& mesh, int vertex);
};

// Below this ratio of altitude to edge the direction of a normal is rounding noise.
constexpr double degenerate = 1e-13;

// Area vector of a face, and for each corner a weight that makes vertex normals exact on a sphere: 1/(|e1|^2 |e2|^2)
// with the two sides that meet there. [MAX99]
struct WeightedNormal {
  Vec3 normal, weights;
  double longest2;  // squared longest side
};

inline WeightedNormal weighted_normal(const Mesh& mesh, int face) {
  const std::array<int, 3>& corners = mesh.face(face);
  const Vec3 a = mesh.x[corners[1]] - mesh.x[corners[0]], b = mesh.x[corners[2]] - mesh.x[corners[0]];
  const Vec3 opposite2((b - a).squaredNorm(), b.squaredNorm(), a.squaredNorm());
  const double product = opposite2.prod();
  return {a.cross(b), product > 0 ? Vec3(opposite2 * (1 / product)) : Vec3::Zero(), opposite2.maxCoeff()};
}

Normals::Normals(const Mesh& mesh)
    : face(static_cast<std::size_t>(mesh.face_slots()), Vec3::Zero()),
      shared(static_cast<std::size_t>(mesh.vertex_slots()), Vec3::Zero()) {
  std::vector<int> on_chain;
  for (int f = 0; f < mesh.face_slots(); ++f) {
    if (!mesh.face_live(f)) continue;
    const auto [normal, weights, longest2] = weighted_normal(mesh, f);
    const double length = normal.norm();
    if (length > degenerate * longest2) face[f] = normal * (1 / length);
    const std::array<int, 3>& corners = mesh.face(f);
    for (int k = 0; k < 3; ++k) {
      shared[corners[k]] += weights[k] * normal;
      if (mesh.tag(3 * f + k) != 0) on_chain.insert(on_chain.end(), {corners[k], mesh.to(3 * f + k)});
    }
  }
  if (!on_chain.empty()) {
    corner.resize(3 * face.size());
    for (int h = 0; h < static_cast<int>(corner.size()); ++h) corner[h] = mesh.from(h);
  }
  std::sort(on_chain.begin(), on_chain.end());
  on_chain.erase(std::unique(on_chain.begin(), on_chain.end()), on_chain.end());
  for (const int v : on_chain) split_at_chain(mesh, v);
  for (Vec3& n : shared)
    if (const double length = n.norm(); length > 0) n *= 1 / length;
}

// One sum for every run of faces between two chain edges, in the order of outgoing(v). In the interior the first and
// the last run are one unless a chain edge parts them.
void Normals::split_at_chain(const Mesh& mesh, int vertex) {
  std::vector<int> around = mesh.outgoing(vertex);
  const auto begins_run = [&](int h) { return mesh.tag(h) != 0; };
  if (!mesh.is_border_vertex(vertex))
    std::rotate(around.begin(), std::find_if(around.begin(), around.end(), begins_run), around.end());
  for (const int h : around) {
    if (h == around.front() || begins_run(h)) shared.push_back(Vec3::Zero());
    corner[h] = static_cast<int>(shared.size()) - 1;
    const auto [normal, weights, longest2] = weighted_normal(mesh, Mesh::face_of(h));
    shared.back() += weights[h % 3] * normal;
  }
}

// The angle whose chord on the unit circle is c, over c, by c^2: a series that is good to 1e-7 up to 17 degrees, where
// nearly all folds are, as the arc sine takes its time.
double angle_by_chord(double c2) {
  if (c2 < 0.09) return 1 + c2 / 24 * (1 + c2 * 9 / 80);
  const double c = std::sqrt(c2);
  return 2 * std::asin(std::min(0.5 * c, 1.0)) / c;
}

// Shape operator of every face times its area, from the world dihedrals of its edges, 0 at borders and chains:
// -S A = sum theta/2 |E| t t^T, t the unit normal of the material edge E. It sees sawtooth folds, which average out of
// nodal normals.
std::vector<Tensor> dihedral_shapes(const Mesh& mesh, const std::vector<Vec3>& face_normals) {
  std::vector<Tensor> shapes(face_normals.size());
  for (int f = 0; f < mesh.face_slots(); ++f) {
    if (!mesh.face_live(f)) continue;
    const std::array<int, 3>& corners = mesh.face(f);
    for (int k = 0; k < 3; ++k) {
      const int h = 3 * f + k, g = mesh.twin(h);
      if (g <= h || mesh.tag(h) != 0) continue;
      const Vec3 &n0 = face_normals[f], &n1 = face_normals[Mesh::face_of(g)];
      const double c2 = (n1 - n0).squaredNorm();
      if (c2 == 0 || c2 + 2 * n0.dot(n1) < 1.5) continue;  // it is 2, but 1 where a face has no normal
      const int from = corners[k], to = corners[k == 2 ? 0 : k + 1];
      const Vec2 E = mesh.X[to] - mesh.X[from];
      // theta/2 |E| t t^T; t t^T is the disk of centre (t.x^2 - t.y^2, 2 t.x t.y) / 2.
      const double squared = E.squaredNorm(), weight = 0.25 * std::sqrt(c2 / squared) * angle_by_chord(c2);
      const Tensor along{{E.y() * E.y() - E.x() * E.x(), -2 * E.x() * E.y()}, squared};
      const bool up = n0.cross(n1).dot(mesh.x[to] - mesh.x[from]) > 0;
      const Tensor bend = (up ? weight : -weight) * along;
      shapes[f] = shapes[f] + bend;
      shapes[Mesh::face_of(g)] = shapes[Mesh::face_of(g)] + bend;
    }
  }
  return shapes;
}

// Gradients of a face's quantities, given by their differences to corner 0.
struct MaterialFrame {
  Vec2 g1, g2;  // gradients of the barycentric coordinates of corners 1 and 2
  double area;

  MaterialFrame(const Mesh& mesh, int face) {
    const std::array<int, 3>& corners = mesh.face(face);
    const Vec2 a = mesh.X[corners[1]] - mesh.X[corners[0]], b = mesh.X[corners[2]] - mesh.X[corners[0]];
    double doubled = cross2(a, b);
    if (!(doubled > 0)) doubled = orient2d(mesh.X[corners[0]], mesh.X[corners[1]], mesh.X[corners[2]]);  // a needle
    const double inverse = 1 / doubled;
    g1 = Vec2(b.y() * inverse, -b.x() * inverse);
    g2 = Vec2(-a.y() * inverse, a.x() * inverse);
    area = 0.5 * doubled;
  }
  Mat32 gradient(const Vec3& at_0, const Vec3& at_1, const Vec3& at_2) const {
    const Vec3 a = at_1 - at_0, b = at_2 - at_0;
    Mat32 result;
    result.col(0) = a * g1.x() + b * g2.x();
    result.col(1) = a * g1.y() + b * g2.y();
    return result;
  }
};

// What all faces share while their tensors are made.
struct Field {
  const Cloth& cloth;
  const Mesh& mesh;
  const Normals normals;
  const std::vector<Tensor> shapes;
  const AdaptOptions& options;
  const double least, most;  // eigenvalues of the longest and of the shortest edge

  Field(const Cloth& cloth_, const AdaptOptions& options_)
      : cloth(cloth_),
        mesh(cloth.mesh),
        normals(mesh),
        shapes(dihedral_shapes(mesh, normals.face)),
        options(options_),
        least(1 / (options.size[1] * options.size[1])),
        most(1 / (options.size[0] * options.size[0])) {}

  Tensor face_tensor(int face, const MaterialFrame& frame) const;
  Tensor limited(const Tensor& M) const;
};

// G without the rigid rotation that fits it best: a turning sheet asks for no refinement. The spin w solves
// (tr C I - F F^T) w = b with C = F^T F and b = sum of F's columns x G's, which F and their normal n diagonalise.
Mat32 without_spin(const Mat32& G, const Mat32& F) {
  const Vec3 f0 = F.col(0), f1 = F.col(1), n = f0.cross(f1);
  const double det = n.squaredNorm(), trace = F.squaredNorm();
  if (!(det > 1e-12 * trace * trace)) return G;  // crumpled to a line: no rotation to speak of
  const Vec3 b = f0.cross(Vec3(G.col(0))) + f1.cross(Vec3(G.col(1)));
  const Vec3 spin = (f0 * f0.dot(b) + f1 * f1.dot(b) + n * (n.dot(b) / trace)) * (1 / det);
  Mat32 result;
  result.col(0) = Vec3(G.col(0)) - spin.cross(f0);
  result.col(1) = Vec3(G.col(1)) - spin.cross(f1);
  return result;
}

// Edges short enough that the buckle which takes up a compression has an amplitude of at most c: per direction the
// larger root m of c^2 m^2 + E m + K = 0, K the curvature across it, which stiffens like a rib.            [NARAIN12]
// E = F^T F - I, and K = tr(N^T N) I - N^T N.
Tensor compression_tensor(const Tensor& E, const Tensor& NtN, double c) {
  const Tensor K{-NtN.centre, NtN.radius};
  const Tensor D = square(E) - 4 * c * c * K;
  const Tensor root = map_eigenvalues(D, [](double l) { return std::copysign(std::sqrt(std::abs(l)), l); });
  return map_eigenvalues(1 / (2 * c * c) * (root - E), [](double l) { return std::max(l, 0.0); });
}

Tensor Field::limited(const Tensor& M) const {
  if (!M.centre.allFinite() || !std::isfinite(M.radius)) return Tensor::isotropic(least);
  const double large = std::clamp(M.large(), least, most);
  const double small = std::max(std::clamp(M.small(), least, most), options.aspect * options.aspect * large);
  return with_eigenvalues(M, large, small);
}

Tensor Field::face_tensor(int f, const MaterialFrame& frame) const {
  const auto& [i, j, k] = mesh.face(f);
  const Mat32 F = frame.gradient(mesh.x[i], mesh.x[j], mesh.x[k]);
  const Tensor NtN =
      Tensor::gram(frame.gradient(normals.at(3 * f, i), normals.at(3 * f + 1, j), normals.at(3 * f + 2, k)));
  std::array<Tensor, 4> terms;
  std::size_t n = 0;
  const auto add = [&](const Tensor& term) {
    if (!(term.large() <= least)) terms[n++] = term;
  };
  const double angle2 = options.angle * options.angle, speed2 = options.velocity * options.velocity;
  add(1 / (angle2 * frame.area * frame.area) * square(shapes[f]));
  add(1 / angle2 * NtN);
  Mat32 G = frame.gradient(cloth.v[i], cloth.v[j], cloth.v[k]);
  if (cloth.is_eol(i) || cloth.is_eol(j) || cloth.is_eol(k)) {
    const auto w = corner_velocities(cloth, f);
    G = frame.gradient(w[0], w[1], w[2]);
  }
  // Without the spin it is less; the larger eigenvalue of G^T G is at most its trace.
  if (!(G.squaredNorm() <= least * speed2)) add(1 / speed2 * Tensor::gram(without_spin(G, F)));
  // The larger root of the compression's polynomial is at most -E / c^2.
  const Tensor E = Tensor::gram(F) - Tensor::isotropic(1);
  const double c = options.compression;
  if (!(-E.small() <= least * c * c)) add(compression_tensor(E, NtN, c));
  return n == 0 ? Tensor::isotropic(least) : limited(tensor_max({terms.data(), n}));
}

// Log-Euclidean, area-weighted mean of the face tensors at each vertex: the mean of sizes, not of densities. Where all
// are the coarsest one there is nothing to average, and no rounding either.
std::vector<Tensor> vertex_means(const Field& field) {
  const Mesh& mesh = field.mesh;
  const Tensor coarsest = Tensor::isotropic(field.least);
  std::vector<Tensor> logs(static_cast<std::size_t>(mesh.vertex_slots()));
  std::vector<double> areas(logs.size(), 0.0);
  std::vector<char> finer(logs.size(), 0);
  const double log_least = std::log(field.least);
  for (int f = 0; f < mesh.face_slots(); ++f) {
    if (!mesh.face_live(f)) continue;
    const MaterialFrame frame(mesh, f);
    const double area = frame.area;
    const Tensor M = field.face_tensor(f, frame);
    const bool is_finer = M.radius > field.least;
    const Tensor log =
        is_finer ? map_eigenvalues(M, [](double l) { return std::log(l); }) : Tensor::isotropic(log_least);
    for (const int v : mesh.face(f)) {
      logs[v] = logs[v] + area * log;
      areas[v] += area;
      finer[v] |= static_cast<char>(is_finer);
    }
  }
  for (std::size_t v = 0; v < logs.size(); ++v)
    logs[v] = finer[v] ? map_eigenvalues(1 / areas[v] * logs[v], [](double l) { return std::exp(l); }) : coarsest;
  return logs;
}

}  // namespace

std::vector<Tensor> vertex_sizes(const Cloth& cloth, const AdaptOptions& options) {
  std::vector<Tensor> sizes = vertex_means(Field(cloth, options));
  if (options.size[1] > options.size[0]) limit_gradation(cloth.mesh, sizes);
  return sizes;
}

std::vector<Mat2> sizing_field(const Cloth& cloth, const AdaptOptions& options) {
  require_valid(options);
  std::vector<Mat2> matrices;
  for (const Tensor& M : vertex_sizes(cloth, options)) matrices.push_back(M.matrix());
  return matrices;
}

}  // namespace crease
