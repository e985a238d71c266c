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
  std::vector<int> corner;   // into `shared`, one a half-edge: its origin's

  explicit Normals(const Mesh& mesh);
  const Vec3& at(int h) const { return shared[corner[h]]; }

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

WeightedNormal weighted_normal(const Mesh& mesh, int face) {
  const auto x = world_corners(mesh, face);
  const Vec3 a = x[1] - x[0], b = x[2] - x[0];
  const Vec3 opposite2((b - a).squaredNorm(), b.squaredNorm(), a.squaredNorm());
  const double product = opposite2.prod();
  return {a.cross(b), product > 0 ? Vec3(opposite2 / product) : Vec3::Zero(), opposite2.maxCoeff()};
}

Normals::Normals(const Mesh& mesh)
    : face(static_cast<std::size_t>(mesh.face_slots()), Vec3::Zero()),
      shared(static_cast<std::size_t>(mesh.vertex_slots()), Vec3::Zero()),
      corner(3 * face.size(), 0) {
  std::vector<int> on_chain;
  for (int f = 0; f < mesh.face_slots(); ++f) {
    if (!mesh.face_live(f)) continue;
    const auto [normal, weights, longest2] = weighted_normal(mesh, f);
    const double length = normal.norm();
    if (length > degenerate * longest2) face[f] = normal / length;
    for (int k = 0; k < 3; ++k) {
      const int h = 3 * f + k, v = mesh.from(h);
      corner[h] = v;
      shared[v] += weights[k] * normal;
      if (mesh.tag(h) != 0) on_chain.insert(on_chain.end(), {v, mesh.to(h)});
    }
  }
  std::sort(on_chain.begin(), on_chain.end());
  on_chain.erase(std::unique(on_chain.begin(), on_chain.end()), on_chain.end());
  for (const int v : on_chain) split_at_chain(mesh, v);
  for (Vec3& n : shared)
    if (const double length = n.norm(); length > 0) n /= length;
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

// The angle whose chord on the unit circle is c: a series that is good to 1e-7 up to 17 degrees, where nearly all folds
// are, as the arc sine takes its time.
double angle_of_chord(double c) {
  const double c2 = c * c;
  if (c2 < 0.09) return c * (1 + c2 / 24 * (1 + c2 * 9 / 80));
  return 2 * std::asin(std::min(0.5 * c, 1.0));
}

// Signed world dihedral of every edge, at both its half-edges: 0 at borders and chains.
std::vector<double> dihedrals(const Mesh& mesh, const std::vector<Vec3>& face_normals) {
  std::vector<double> angles(3 * face_normals.size(), 0.0);
  for (int h = 0; h < 3 * mesh.face_slots(); ++h) {
    const int g = mesh.twin(h);
    if (g <= h || mesh.tag(h) != 0 || !mesh.face_live(Mesh::face_of(h))) continue;
    const Vec3 &n0 = face_normals[Mesh::face_of(h)], &n1 = face_normals[Mesh::face_of(g)];
    if (n0.isZero(0) || n1.isZero(0)) continue;
    const double angle = angle_of_chord((n1 - n0).norm());
    const bool up = n0.cross(n1).dot(mesh.x[mesh.to(h)] - mesh.x[mesh.from(h)]) > 0;
    angles[h] = angles[g] = up ? angle : -angle;
  }
  return angles;
}

// What all faces share while their tensors are made.
struct Field {
  const Cloth& cloth;
  const Mesh& mesh;
  const Normals normals;
  const std::vector<double> angles;
  const AdaptOptions& options;
  const double least, most;  // eigenvalues of the longest and of the shortest edge

  Field(const Cloth& cloth_, const AdaptOptions& options_)
      : cloth(cloth_),
        mesh(cloth.mesh),
        normals(mesh),
        angles(dihedrals(mesh, normals.face)),
        options(options_),
        least(1 / (options.size[1] * options.size[1])),
        most(1 / (options.size[0] * options.size[0])) {}

  Tensor face_tensor(int face, double area) const;
  Tensor limited(const Tensor& M) const;
};

// S^2 of the shape operator from the dihedral angles of the face's edges; it sees sawtooth folds, which average out of
// nodal normals.
Tensor dihedral_curvature(const Field& field, int face, double area) {
  Tensor S;
  for (int h = 3 * face; h < 3 * face + 3; ++h) {
    if (field.angles[h] == 0) continue;
    const Vec2 E = field.mesh.X[field.mesh.to(h)] - field.mesh.X[field.mesh.from(h)];
    // theta/2 |E| t t^T with the unit normal t of E; t t^T is the disk of centre (t.x^2 - t.y^2, 2 t.x t.y) / 2.
    const double squared = E.squaredNorm(), weight = 0.25 * field.angles[h] * std::sqrt(squared) / area;
    const Vec2 centre(E.y() * E.y() - E.x() * E.x(), -2 * E.x() * E.y());
    S = S - weight * Tensor{centre / squared, 1};
  }
  return square(S);
}

Mat32 gradient(const Vec3& a, const Vec3& b, const Vec3& c, const Mat32& g) {
  return (b - a) * g.row(1) + (c - a) * g.row(2);
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

Tensor Field::face_tensor(int f, double area) const {
  const Mat32 g = barycentric_gradients(material_corners(mesh, f));
  const auto x = world_corners(mesh, f);
  const Mat32 F = gradient(x[0], x[1], x[2], g);
  const Tensor NtN = Tensor::gram(gradient(normals.at(3 * f), normals.at(3 * f + 1), normals.at(3 * f + 2), g));
  const double angle2 = options.angle * options.angle, speed2 = options.velocity * options.velocity;
  std::array<Tensor, 4> terms;
  std::size_t n = 0;
  const auto add = [&](const Tensor& term) {
    if (!(term.large() <= least)) terms[n++] = term;
  };
  add(1 / angle2 * dihedral_curvature(*this, f, area));
  add(1 / angle2 * NtN);
  const auto w = corner_velocities(cloth, f);
  const Mat32 G = gradient(w[0], w[1], w[2], g);
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
    const double area = mesh.material_area(f);
    const Tensor M = field.face_tensor(f, area);
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
