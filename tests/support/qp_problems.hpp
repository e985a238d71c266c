// SPDX-License-Identifier: MIT
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <random>
#include <vector>

#include "crease/solver/qp.hpp"

/// Quadratic programs made in code.
namespace crease::support {

inline SparseRows sparse_rows(const MatX& A) {
  return SparseRows(A.sparseView());
}

inline QpProblem dense_problem(const MatX& H, const VecX& f, const MatX& A_eq, const VecX& b_eq, const MatX& A_in,
                               const VecX& b_in) {
  QpProblem problem;
  problem.H = H.sparseView();
  problem.f = f;
  problem.A_eq = A_eq.size() ? sparse_rows(A_eq) : SparseRows(b_eq.size(), H.cols());
  problem.A_in = A_in.size() ? sparse_rows(A_in) : SparseRows(b_in.size(), H.cols());
  problem.b_eq = b_eq;
  problem.b_in = b_in;
  return problem;
}

inline double objective(const QpProblem& problem, const VecX& q) {
  return 0.5 * q.dot(problem.H * q) - problem.f.dot(q);
}

struct Random {
  explicit Random(std::uint64_t seed) : engine(seed) {}
  std::mt19937_64 engine;

  double normal() { return std::normal_distribution<double>()(engine); }
  double uniform(double a, double b) { return std::uniform_real_distribution<double>(a, b)(engine); }
  int integer(int a, int b) { return std::uniform_int_distribution<int>(a, b)(engine); }
  VecX vector(int n) {
    return VecX::NullaryExpr(n, [&] { return normal(); });
  }
  MatX matrix(int rows, int cols) {
    return MatX::NullaryExpr(rows, cols, [&] { return normal(); });
  }
  std::vector<char> flags(Eigen::Index n) {
    std::vector<char> f(static_cast<size_t>(n));
    for (char& flag : f) flag = static_cast<char>(integer(0, 1));
    return f;
  }
};

/// Strictly convex, dense, rows across all unknowns; feasible, because a point was picked before the bounds.
inline QpProblem random_dense(Random& random, int n, int m_eq, int m_in) {
  const MatX B = random.matrix(n, n);
  const VecX q = random.vector(n);
  const MatX A_eq = random.matrix(m_eq, n), A_in = random.matrix(m_in, n);
  VecX b_in = A_in * q;
  for (double& b : b_in) b -= random.uniform(0, 1);
  return dense_problem(B * B.transpose() + 0.1 * MatX::Identity(n, n), 3 * random.vector(n), A_eq, A_eq * q, A_in,
                       b_in);
}

/// What a step of cloth looks like to the solver: vertices on a grid, each tied to its neighbours by springs stiff
/// along the edge and soft across, with a mass; blocks of 3 unknowns (every fifth row of vertices 5, the last two of
/// which a material velocity v seen in the world as -F v).
struct ClothLike {
  int side = 8;
  double mass = 1e-5, stiffness = 1e-3;  ///< of a vertex [kg]; h^2 k of a spring [kg]
  bool eulerian = true;
};

inline QpProblem cloth_like(Random& random, const ClothLike& cloth) {
  const int n_vertices = cloth.side * cloth.side;
  QpProblem problem;
  problem.blocks.push_back(0);
  for (int v = 0; v < n_vertices; ++v)
    problem.blocks.push_back(problem.blocks.back() + (cloth.eulerian && (v / cloth.side) % 5 == 2 ? 5 : 3));
  const int n = problem.blocks.back();
  std::vector<Eigen::Triplet<double>> entries;
  // Adds weight * |w_a - w_b|^2 with world velocity w = x - F X along `direction` (w_b absent: mass).
  const auto jacobian = [&](int v, const Eigen::RowVector3d& direction, double sign, const Mat32& F) {
    std::vector<std::pair<int, double>> row;
    for (int i = 0; i < 3; ++i) row.emplace_back(problem.blocks[v] + i, sign * direction[i]);
    if (problem.blocks[v + 1] - problem.blocks[v] == 5)
      for (int i = 0; i < 2; ++i) row.emplace_back(problem.blocks[v] + 3 + i, -sign * direction.dot(F.col(i)));
    return row;
  };
  const auto add = [&](const std::vector<std::pair<int, double>>& row, double weight) {
    for (const auto& [i, a] : row)
      for (const auto& [j, b] : row) entries.emplace_back(i, j, weight * a * b);
  };
  const auto random_F = [&] { return Mat32(random.matrix(3, 2) * 0.3 + MatX::Identity(3, 2)); };
  for (int v = 0; v < n_vertices; ++v)
    for (int side = 0; side < 2; ++side) {
      const Mat32 F = random_F();  // the two sides of an edge differ, else the material motion would be undecided
      for (int k = 0; k < 3; ++k) add(jacobian(v, Eigen::RowVector3d::Unit(k), 1, F), 0.5 * cloth.mass);
    }
  const auto spring = [&](int a, int b) {
    const Vec3 along = random.vector(3).normalized();
    const Mat32 F_a = random_F(), F_b = random_F();
    for (int k = 0; k < 3; ++k) {
      const Eigen::RowVector3d direction = Vec3::Unit(k).transpose();
      auto row = jacobian(a, direction, 1, F_a);
      const auto other = jacobian(b, direction, -1, F_b);
      row.insert(row.end(), other.begin(), other.end());
      add(row, 1e-3 * cloth.stiffness);
    }
    auto row = jacobian(a, along.transpose(), 1, F_a);
    const auto other = jacobian(b, along.transpose(), -1, F_b);
    row.insert(row.end(), other.begin(), other.end());
    add(row, cloth.stiffness);
  };
  for (int j = 0; j < cloth.side; ++j)
    for (int i = 0; i < cloth.side; ++i) {
      const int v = j * cloth.side + i;
      if (i + 1 < cloth.side) spring(v, v + 1);
      if (j + 1 < cloth.side) spring(v, v + cloth.side);
      if (i + 1 < cloth.side && j + 1 < cloth.side) spring(v, v + cloth.side + 1);
    }
  problem.H.resize(n, n);
  problem.H.setFromTriplets(entries.begin(), entries.end());
  // Rounding of the sums differs between the triangles; a solver is given one symmetric matrix.
  problem.H = SparseMatrix(0.5 * (problem.H + SparseMatrix(problem.H.transpose())));
  problem.f = cloth.mass * random.vector(n);
  problem.A_eq.resize(0, n);
  problem.A_in.resize(0, n);
  return problem;
}

/// Collects constraint rows one at a time.
class RowBuilder {
 public:
  explicit RowBuilder(Eigen::Index n) : n_(n) {}
  void add(int start, const VecX& a, double b) {
    for (int i = 0; i < a.size(); ++i) entries_.emplace_back(static_cast<int>(b_.size()), start + i, a[i]);
    b_.push_back(b);
  }
  void add(const std::vector<std::pair<int, VecX>>& parts, double b) {
    for (const auto& [start, a] : parts)
      for (int i = 0; i < a.size(); ++i) entries_.emplace_back(static_cast<int>(b_.size()), start + i, a[i]);
    b_.push_back(b);
  }
  void finish(SparseRows& A, VecX& b) const {
    A.resize(static_cast<int>(b_.size()), n_);
    A.setFromTriplets(entries_.begin(), entries_.end());
    b = Eigen::Map<const VecX>(b_.data(), static_cast<Eigen::Index>(b_.size()));
  }

 private:
  Eigen::Index n_;
  std::vector<Eigen::Triplet<double>> entries_;
  std::vector<double> b_;
};

struct Contacts {
  double share = 0.3;       ///< of the vertices that touch something
  double pinned = 0.03;     ///< of the vertices held by equalities
  bool degenerate = false;  ///< repeated, opposite, nearly parallel and surplus normals
  int edge_edge = 0;        ///< rows over four vertices
  int general_eq = 0;       ///< equalities over two vertices
};

/// Contacts, pins and edge-edge rows on top of cloth_like(); feasible for q = 0 moved by a common drift.
inline void add_contacts(Random& random, const Contacts& contacts, QpProblem& problem) {
  const Eigen::Index n = problem.f.size();
  const int n_vertices = static_cast<int>(problem.blocks.size()) - 1;
  const VecX point = random.vector(static_cast<int>(n));  // stays feasible
  RowBuilder eq(n), in(n);
  const auto normal = [&] { return VecX(random.vector(3).normalized()); };
  const auto add_in = [&](int v, const VecX& a, double slack) {
    in.add(problem.blocks[v], a, a.dot(point.segment(problem.blocks[v], a.size())) - slack);
  };
  for (int v = 0; v < n_vertices; ++v) {
    const int start = problem.blocks[v], size = problem.blocks[v + 1] - start;
    if (random.uniform(0, 1) < contacts.pinned) {
      for (int k = 0; k < 3; ++k) eq.add(start, VecX::Unit(size, k), point[start + k]);
      if (contacts.degenerate) eq.add(start, 2 * VecX::Unit(size, 1), 2 * point[start + 1]);
    } else if (size == 5) {
      VecX t = VecX::Zero(5);
      t.tail(2) = random.vector(2).normalized();
      eq.add(start, t, t.dot(point.segment(start, 5)));
    }
    if (random.uniform(0, 1) > contacts.share) continue;
    const VecX a = normal();
    const double slack = random.integer(0, 1) * random.uniform(0, 1);
    add_in(v, a, slack);
    if (size == 5) add_in(v, normal(), slack);
    if (!contacts.degenerate) continue;
    switch (random.integer(0, 5)) {
      case 0:
        add_in(v, a, slack);  // the same again
        break;
      case 1:
        add_in(v, 3 * a, 2 * slack);  // scaled, looser
        break;
      case 2:
        add_in(v, -a, 0.5);  // a gap between two walls
        break;
      case 3:
        add_in(v, (a + 1e-3 * normal()).normalized(), slack);
        break;
      case 4:
        for (int k = 0; k < 4; ++k) add_in(v, normal(), 0.1 * k);  // more than a vertex has directions
        break;
      default:
        add_in(v, (a + 1e-6 * normal()).normalized(), slack);
        break;
    }
  }
  const auto across = [&](int count) {
    std::vector<std::pair<int, VecX>> parts;
    const VecX a = normal();
    std::vector<int> vertices;
    while (static_cast<int>(vertices.size()) < std::min(count, n_vertices)) {
      const int v = random.integer(0, n_vertices - 1);
      if (std::find(vertices.begin(), vertices.end(), v) == vertices.end()) vertices.push_back(v);
    }
    double weight = 0.7, value = 0;
    for (const int v : vertices) {
      parts.emplace_back(problem.blocks[v], weight * a);
      value += parts.back().second.dot(point.segment(problem.blocks[v], 3));
      weight = weight > 0 ? weight - 1 : weight + 1.2;
    }
    return std::pair{parts, value};
  };
  for (int k = 0; k < contacts.edge_edge; ++k) {
    const auto [parts, value] = across(4);
    in.add(parts, value - random.integer(0, 1) * random.uniform(0, 1));
    if (contacts.degenerate && k % 4 == 0) in.add(parts, value - 1);
    if (contacts.degenerate && k % 4 == 1) in.add(parts, value);
  }
  for (int k = 0; k < contacts.general_eq; ++k) {
    const auto [parts, value] = across(2);
    eq.add(parts, value);
    if (contacts.degenerate && k % 3 == 0) eq.add(parts, value);
  }
  eq.finish(problem.A_eq, problem.b_eq);
  in.finish(problem.A_in, problem.b_in);
}

}  // namespace crease::support
