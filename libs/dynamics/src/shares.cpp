// SPDX-License-Identifier: MIT
#include "shares.hpp"

#include <algorithm>
#include <numeric>

namespace crease {

namespace {

/// Time that an Eulerian vertex takes with the elements about it, in that of others (measured at 3000 and 12000 faces).
constexpr int eol_weight = 7;

/// The share of each vertex; tied vertices go with the one that owns their unknowns.
std::vector<int> cut_into_strips(const Mesh& mesh, const DofMap& dofs, int n_shares) {
  const int n = mesh.n_vertices();
  std::vector<int> share(n, 0);
  if (n_shares == 1 || n == 0) return share;
  Vec2 low = mesh.X[0], high = mesh.X[0];
  for (const Vec2& X : mesh.X) {
    low = low.cwiseMin(X);
    high = high.cwiseMax(X);
  }
  const int axis = high.x() - low.x() >= high.y() - low.y() ? 0 : 1;
  std::vector<int> sorted(n);
  std::iota(sorted.begin(), sorted.end(), 0);
  std::sort(sorted.begin(), sorted.end(), [&](int a, int b) {
    return mesh.X[a][axis] != mesh.X[b][axis] ? mesh.X[a][axis] < mesh.X[b][axis] : a < b;
  });
  const auto weight = [&](int v) { return dofs.is_eol(v) ? eol_weight : 1; };
  long long all = 0, before = 0;
  for (int v = 0; v < n; ++v) all += weight(v);
  for (const int v : sorted) {
    share[v] = static_cast<int>(before * n_shares / all);
    before += weight(v);
  }
  for (int v = 0; v < n; ++v) share[v] = share[dofs.owner(v)];  // the owner is the lowest
  return share;
}

}  // namespace

std::vector<Share> share_out(const Mesh& mesh, const DofMap& dofs, const BlockPattern& pattern, int n_shares) {
  const std::vector<int> share_of = cut_into_strips(mesh, dofs, n_shares);
  std::vector<Share> shares(n_shares);
  for (int k = 0; k < n_shares; ++k) {
    Share& share = shares[k];
    for (const int other : share_of) share.owned.push_back(other == k);
    const auto touches = [&](const auto& vertices) {
      return std::any_of(vertices.begin(), vertices.end(), [&](int v) { return share.owned[v] != 0; });
    };
    for (int v = 0; v < mesh.n_vertices(); ++v)
      if (share.owned[v] && dofs.owner(v) == v) share.vertices.push_back(v);
    for (int f = 0; f < mesh.n_faces(); ++f)
      if (touches(mesh.face(f))) share.faces.push_back(f);
    for (int hinge = 0; hinge < static_cast<int>(pattern.hinges.size()); ++hinge) {
      const auto& vertices = pattern.hinges[hinge].hinge.vertex;
      if (!touches(vertices)) continue;
      const bool eol = std::any_of(vertices.begin(), vertices.end(), [&](int v) { return dofs.is_eol(v); });
      (eol ? share.eol_hinges : share.plain_hinges).push_back(hinge);
    }
  }
  return shares;
}

}  // namespace crease
