// SPDX-License-Identifier: MIT
#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <numeric>

#include <Eigen/Geometry>

#include "crease/geometry/closed_surface.hpp"

namespace crease {
namespace {

// A triangle whose area is below this share of its longest edge squared is a line, whatever rounding made of it.
constexpr double zero_area = 1e-12;

using Directed = std::array<int, 2>;
using EdgeOwners = std::map<Directed, std::vector<int>>;  // directed edge -> triangles that run along it

std::string triangle_name(int t) {
  return "triangle " + std::to_string(t + 1);
}

std::string edge_name(const Directed& e) {
  return "edge " + std::to_string(e[0] + 1) + "-" + std::to_string(e[1] + 1);
}

// The first of a kind in full, the rest as a number: a file turned inside out has one mistake, not thousands.
class Findings {
 public:
  void add(const std::string& text) {
    if (n_++ == 0) first_ = text;
  }
  void report(std::vector<std::string>& problems) const {
    if (n_ > 0) problems.push_back(n_ == 1 ? first_ : first_ + " (and " + std::to_string(n_ - 1) + " more like it)");
  }

 private:
  int n_ = 0;
  std::string first_;
};

bool has_area(const TriangleSurface& surface, const std::array<int, 3>& t) {
  const Vec3 p = surface.vertices[t[1]] - surface.vertices[t[0]], q = surface.vertices[t[2]] - surface.vertices[t[0]];
  const double longest = std::max({p.squaredNorm(), q.squaredNorm(), (p - q).squaredNorm()});
  return p.cross(q).norm() > zero_area * longest;
}

void find_bad_triangles(const TriangleSurface& surface, std::vector<std::string>& problems) {
  const int n = static_cast<int>(surface.vertices.size());
  Findings missing, infinite, flat;
  for (int t = 0; t < static_cast<int>(surface.triangles.size()); ++t) {
    const auto& corners = surface.triangles[t];
    if (std::any_of(corners.begin(), corners.end(), [&](int i) { return i < 0 || i >= n; })) {
      missing.add(triangle_name(t) + " names a vertex that does not exist");
    } else if (std::any_of(corners.begin(), corners.end(), [&](int i) { return !surface.vertices[i].allFinite(); })) {
      infinite.add(triangle_name(t) + " has a corner that is not finite");
    } else if (!has_area(surface, corners)) {
      flat.add(triangle_name(t) + " has no area: remove it or move its corners apart");
    }
  }
  missing.report(problems);
  infinite.report(problems);
  flat.report(problems);
}

void find_bad_edges(const EdgeOwners& owners, std::vector<std::string>& problems) {
  Findings open, twisted, crowded;
  for (const auto& [edge, triangles] : owners) {
    const auto back = owners.find({edge[1], edge[0]});
    const std::size_t n_back = back == owners.end() ? 0 : back->second.size();
    const std::size_t n = triangles.size() + n_back;
    if (n == 1) {
      open.add(edge_name(edge) + " has a triangle on one side alone, " + triangle_name(triangles[0]) +
               ": the mesh is not closed; close the hole or merge doubled vertices");
    } else if (n == 2 && n_back == 0) {
      twisted.add(edge_name(edge) + " runs the same way in " + triangle_name(triangles[0]) + " and " +
                  triangle_name(triangles[1]) + ": they disagree about the outside; reverse one of them");
    } else if (n > 2 && (edge[0] < edge[1] || n_back == 0)) {
      crowded.add(edge_name(edge) + " joins " + std::to_string(n) + " triangles, where a solid has two");
    }
  }
  open.report(problems);
  twisted.report(problems);
  crowded.report(problems);
}

// @pre every edge has its two sides
void find_pinched_vertices(const TriangleSurface& surface, const EdgeOwners& owners,
                           std::vector<std::string>& problems) {
  std::vector<int> total(surface.vertices.size(), 0), start(surface.vertices.size(), -1);
  for (int t = 0; t < static_cast<int>(surface.triangles.size()); ++t)
    for (const int i : surface.triangles[t]) ++total[i], start[i] = t;
  Findings pinched;
  for (int i = 0; i < static_cast<int>(surface.vertices.size()); ++i) {
    if (start[i] < 0) continue;  // a vertex of no triangle says nothing
    int round = 0, t = start[i];
    do {
      const auto& corners = surface.triangles[t];
      const auto k = static_cast<std::size_t>(std::find(corners.begin(), corners.end(), i) - corners.begin());
      t = owners.at({i, corners[(k + 2) % 3]}).front();
    } while (++round < total[i] && t != start[i]);
    if (round != total[i])
      pinched.add("vertex " + std::to_string(i + 1) + " joins two parts that share nothing else there: duplicate it");
  }
  pinched.report(problems);
}

int root(std::vector<int>& parent, int i) {
  while (parent[i] != i) i = parent[i] = parent[parent[i]];
  return i;
}

// Of every connected part. A hollow's inner surface is refused with it: cloth cannot get there.
void find_inverted_parts(const TriangleSurface& surface, std::vector<std::string>& problems) {
  std::vector<int> parent(surface.vertices.size());
  std::iota(parent.begin(), parent.end(), 0);
  for (const auto& [a, b, c] : surface.triangles) {
    parent[root(parent, a)] = root(parent, b);
    parent[root(parent, b)] = root(parent, c);
  }
  std::map<int, std::pair<double, int>> parts;  // root -> six times the volume, first triangle
  for (int t = 0; t < static_cast<int>(surface.triangles.size()); ++t) {
    const auto& corners = surface.triangles[t];
    const int part = root(parent, corners[0]);
    const Vec3& about = surface.vertices[part];
    const Vec3 a = surface.vertices[corners[0]] - about, b = surface.vertices[corners[1]] - about;
    const auto it = parts.try_emplace(part, 0.0, t).first;
    it->second.first += a.dot(b.cross(surface.vertices[corners[2]] - about));
  }
  Findings inverted;
  for (const auto& [part, found] : parts)
    if (!(found.first > 0))
      inverted.add("the part with " + triangle_name(found.second) +
                   " is inside out: its corners must run counter-clockwise seen from outside; reverse its triangles");
  inverted.report(problems);
}

}  // namespace

std::vector<std::string> surface_problems(const TriangleSurface& surface) {
  std::vector<std::string> problems;
  if (surface.triangles.empty()) return {"has no triangles"};
  find_bad_triangles(surface, problems);
  if (!problems.empty()) return problems;
  EdgeOwners owners;
  for (int t = 0; t < static_cast<int>(surface.triangles.size()); ++t)
    for (std::size_t k = 0; k < 3; ++k)
      owners[{surface.triangles[t][k], surface.triangles[t][(k + 1) % 3]}].push_back(t);
  find_bad_edges(owners, problems);
  if (!problems.empty()) return problems;
  find_pinched_vertices(surface, owners, problems);
  find_inverted_parts(surface, problems);
  return problems;
}

}  // namespace crease
