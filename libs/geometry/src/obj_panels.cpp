// SPDX-License-Identifier: MIT
#include "obj_panels.hpp"

#include <algorithm>
#include <numeric>
#include <tuple>

namespace crease {
namespace {

// Corner k of face f is number 3 f + k. Corners are united into vertices of panels, and those into points of the cloth.
class Sets {
 public:
  explicit Sets(std::size_t n) : parent_(n) { std::iota(parent_.begin(), parent_.end(), 0); }
  int root(int i) {
    while (parent_[i] != i) i = parent_[i] = parent_[parent_[i]];
    return i;
  }
  void unite(int i, int j) {
    const auto [low, high] = std::minmax({root(i), root(j)});
    parent_[high] = low;
  }

 private:
  std::vector<int> parent_;
};

int next(int corner) {
  return corner % 3 == 2 ? corner - 2 : corner + 1;
}

// A directed edge, named by the corner it begins at, and by what its ends are.
struct Side {
  int from, to, corner;
};

struct Sewing {
  const ObjText& text;
  Sets vertices, points;

  explicit Sewing(const ObjText& text_) : text(text_), vertices(3 * text.faces.size()), points(3 * text.faces.size()) {}

  int v(int corner) const { return text.faces[corner / 3].v[corner % 3]; }
  int vt(int corner) const { return text.faces[corner / 3].vt[corner % 3]; }
  int line(int corner) const { return text.faces[corner / 3].line; }

  /// Unites the ends of sides that run opposite ways between the same ends, in `points` and, if asked, in `vertices`;
  /// returns the sides without such a partner. Two that run the same way are no manifold.
  std::vector<int> match(std::vector<Side> sides, bool as_vertices);
  void require_one_fan();
};

std::vector<int> Sewing::match(std::vector<Side> sides, bool as_vertices) {
  const auto less = [](const Side& p, const Side& q) {
    return std::tie(p.from, p.to, p.corner) < std::tie(q.from, q.to, q.corner);
  };
  std::sort(sides.begin(), sides.end(), less);
  for (std::size_t i = 1; i < sides.size(); ++i) {
    const Side &p = sides[i - 1], &q = sides[i];
    if (p.from != q.from || p.to != q.to) continue;
    text.fail(line(q.corner), "edge " + std::to_string(v(q.corner) + 1) + "-" + std::to_string(v(next(q.corner)) + 1) +
                                  " runs the same way in two triangles (the other on line " +
                                  std::to_string(line(p.corner)) + "): the mesh is not manifold there");
  }
  std::vector<int> alone;
  for (const Side& side : sides) {
    const auto found = std::lower_bound(sides.begin(), sides.end(), Side{side.to, side.from, -1}, less);
    if (found == sides.end() || found->from != side.to || found->to != side.from) {
      alone.push_back(side.corner);
      continue;
    }
    for (Sets* sets : {&points, &vertices}) {
      if (sets == &vertices && !as_vertices) continue;
      sets->unite(side.corner, next(found->corner));
      sets->unite(next(side.corner), found->corner);
    }
  }
  return alone;
}

void Sewing::require_one_fan() {
  std::vector<int> fan(text.positions.size(), -1);
  for (int corner = 0; corner < 3 * static_cast<int>(text.faces.size()); ++corner) {
    int& known = fan[v(corner)];
    if (known >= 0 && known != points.root(corner))
      text.fail(line(corner), "vertex " + std::to_string(v(corner) + 1) +
                                  " joins two pieces that share nothing else: the mesh is not manifold there; "
                                  "duplicate it");
    known = points.root(corner);
  }
  for (std::size_t i = 0; i < fan.size(); ++i)
    if (fan[i] < 0)
      text.fail(text.position_lines[i], "vertex " + std::to_string(i + 1) + " is in no triangle: remove it");
}

// The first texture coordinate with the same value, for each.
std::vector<int> distinct_texcoords(const ObjText& text) {
  const auto key = [&](int i) { return std::tuple(text.texcoords[i].x(), text.texcoords[i].y(), i); };
  std::vector<int> order(text.texcoords.size()), first(text.texcoords.size());
  std::iota(order.begin(), order.end(), 0);
  std::sort(order.begin(), order.end(), [&](int i, int j) { return key(i) < key(j); });
  for (std::size_t i = 0; i < order.size(); ++i) {
    const bool same = i > 0 && text.texcoords[order[i]] == text.texcoords[order[i - 1]];
    first[order[i]] = same ? first[order[i - 1]] : order[i];
  }
  return first;
}

}  // namespace

ObjPanels sew_panels(const ObjText& text) {
  Sewing sewing(text);
  const int n_corners = 3 * static_cast<int>(text.faces.size());
  // What stands at a corner: its v and vt, as one number.
  const std::vector<int> distinct = distinct_texcoords(text);
  std::vector<std::array<int, 2>> sites;
  for (int c = 0; c < n_corners; ++c) sites.push_back({sewing.v(c), distinct[sewing.vt(c)]});
  std::vector<std::array<int, 2>> kinds = sites;
  std::sort(kinds.begin(), kinds.end());
  const auto site = [&](int c) {
    return static_cast<int>(std::lower_bound(kinds.begin(), kinds.end(), sites[c]) - kinds.begin());
  };
  std::vector<Side> sides;
  for (int c = 0; c < n_corners; ++c) sides.push_back({site(c), site(next(c)), c});
  const std::vector<int> borders = sewing.match(std::move(sides), true);
  sides.clear();
  for (const int c : borders) sides.push_back({sewing.v(c), sewing.v(next(c)), c});
  sewing.match(std::move(sides), false);
  sewing.require_one_fan();

  // Each panel vertex by its lowest vt, then its lowest corner; the first of each v comes to that v's place.
  std::vector<int> lowest(static_cast<std::size_t>(n_corners), -1);
  for (int c = 0; c < n_corners; ++c) {
    int& vt = lowest[sewing.vertices.root(c)];
    if (vt < 0 || sewing.vt(c) < vt) vt = sewing.vt(c);
  }
  std::vector<int> roots;
  for (int c = 0; c < n_corners; ++c)
    if (lowest[c] >= 0) roots.push_back(c);
  std::sort(roots.begin(), roots.end(), [&](int p, int q) { return std::tie(lowest[p], p) < std::tie(lowest[q], q); });
  ObjPanels panels;
  panels.vertices.assign(text.positions.size(), {-1, -1});
  std::vector<int> number(static_cast<std::size_t>(n_corners), -1);
  for (const int root : roots) {
    const int v = sewing.v(root);
    const bool is_first = panels.vertices[v].v < 0;
    number[root] = is_first ? v : static_cast<int>(panels.vertices.size());
    if (is_first)
      panels.vertices[v] = {v, lowest[root]};
    else
      panels.vertices.push_back({v, lowest[root]});
  }
  for (int c = 0; c < n_corners; c += 3) {
    const auto at = [&](int corner) { return number[sewing.vertices.root(corner)]; };
    panels.faces.push_back({at(c), at(c + 1), at(c + 2)});
  }
  return panels;
}

}  // namespace crease
