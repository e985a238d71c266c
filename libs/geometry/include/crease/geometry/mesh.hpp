// SPDX-License-Identifier: MIT
#pragma once

#include <array>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "crease/base/types.hpp"

namespace crease {

/// Index-based triangle mesh that lives in two spaces: material positions X (the cloth lying flat), world positions x.
///
/// Representation. Face f holds three vertices counter-clockwise in material space. Half-edge h = 3 f + k runs from
/// corner k of face f to corner (k+1) % 3. `twin(h)` is the half-edge of the neighbouring face that runs the other way,
/// or `none` on the border. An edge is named by either of its half-edges; `edge_of(h)` is the canonical one
/// (min(h, twin)). Vertices and faces are removed by marking and their slots are not reused until `compact()`, so ids
/// stay valid through a remeshing pass. Every operation is deterministic.
///
/// Seams. Panels that are sewn together stay apart in material space: each side of a seam has border vertices of its
/// own. Those that are one point of the sewn cloth are *tied*: they share their world position, bit for bit. Two border
/// edges whose ends are tied crosswise are the two sides of a seam. Operations keep both: a seam is split and coarsened
/// on both sides at once.
///
/// Invariants, checked by `validate()`: edge-manifold with one fan of faces a vertex that goes round it at most once,
/// every live face has positive material area, twins agree, tags agree on both sides, no vertex without a face; tied
/// vertices stand at one place and never in one face, and a seam has two sides, which run in opposite directions.
class Mesh {
 public:
  static constexpr int none = -1;

  Mesh() = default;
  /// @pre X.size() == x.size(); throws std::invalid_argument naming the first face that is out of range, repeated,
  ///      inverted or of zero area in material space, or that makes the mesh non-manifold; a vertex in no face too.
  Mesh(std::vector<Vec2> material, std::vector<Vec3> world, const std::vector<std::array<int, 3>>& faces);

  // -- sizes and liveness (slots include removed entries until compact()) ---------------------------------------------
  int vertex_slots() const { return static_cast<int>(X.size()); }
  int face_slots() const { return static_cast<int>(faces_.size()); }
  int n_vertices() const { return n_vertices_; }  ///< live vertices
  int n_faces() const { return n_faces_; }        ///< live faces
  bool vertex_live(int v) const { return vertex_halfedge_[v] != none; }
  bool face_live(int f) const { return faces_[f][0] != none; }
  bool is_compact() const { return n_vertices_ == vertex_slots() && n_faces_ == face_slots(); }

  // -- adjacency -----------------------------------------------------------------------------------------------------
  const std::array<int, 3>& face(int f) const { return faces_[f]; }
  static int face_of(int h) { return h / 3; }
  static int next(int h) { return h % 3 == 2 ? h - 2 : h + 1; }
  static int prev(int h) { return h % 3 == 0 ? h + 2 : h - 1; }
  int from(int h) const { return faces_[h / 3][h % 3]; }
  int to(int h) const { return from(next(h)); }
  int opposite(int h) const { return from(prev(h)); }  ///< the corner of h's face that is not on h
  int twin(int h) const { return twin_[h]; }
  int edge_of(int h) const { return twin_[h] == none || h < twin_[h] ? h : twin_[h]; }
  bool is_border(int h) const { return twin_[h] == none; }
  bool is_border_vertex(int v) const;
  /// One half-edge that leaves v; on the border the one whose face is first in counter-clockwise order, so that
  /// walking h -> twin(prev(h)) from it meets every face of v.
  int halfedge(int v) const { return vertex_halfedge_[v]; }
  /// Half-edges that leave v, counter-clockwise, one a face.
  std::vector<int> outgoing(int v) const;
  /// Whether `test(h)` holds for all of outgoing(v), asked in that order until one fails; allocates nothing.
  template <typename Test>
  bool all_outgoing(int v, Test&& test) const {
    const int first = vertex_halfedge_[v];
    int h = first;
    do {
      if (!test(h)) return false;
      h = twin_[prev(h)];
    } while (h != none && h != first);
    return true;
  }
  /// Vertices joined to v by an edge, counter-clockwise; on the border from one border neighbour to the other.
  std::vector<int> neighbours(int v) const;
  /// The half-edge from a to b, or that from b to a if only it exists (border), or none.
  int find_edge(int a, int b) const;
  /// Canonical half-edges of all live edges, ascending.
  std::vector<int> edges() const;

  // -- material geometry ---------------------------------------------------------------------------------------------
  double material_area(int f) const;    ///< signed, positive for a valid face [m^2]
  double material_length(int h) const;  ///< [m]
  /// Angle by which the border turns at a border vertex: 0 on a straight border, pi/2 at the corner of a square [rad].
  double border_turn(int v) const;
  /// Border vertex where the border turns by more than `angle` [rad]: never moved, collapsed or made Eulerian.
  bool is_material_corner(int v, double angle = 0.2) const;

  // -- seams ---------------------------------------------------------------------------------------------------------
  bool has_seams() const { return !tied_.empty(); }
  /// The next vertex in the ring of those that are tied to v; v itself if there is none.
  int tied(int v) const { return tied_.empty() ? v : tied_[v]; }
  bool is_tied(int v) const { return tied(v) != v; }
  /// Whether a and b are one point of the sewn cloth (or one vertex).
  bool are_tied(int a, int b) const;
  /// The other side of the seam at border half-edge h, which runs the other way; none where h is no seam.
  int seam_twin(int h) const;
  /// Two ends of an edge.
  struct Ends {
    int vertex = none, into = none;
  };
  /// The edge from `vertex` to `into` as the other side of a seam has it; none, none where it is no side of one.
  Ends across_seam(int vertex, int into) const;
  /// Whether v is tied or the end of a seam.
  bool on_seam(int v) const;
  /// Makes a and b, and all that are tied to them, one point of the sewn cloth.
  /// @pre both live, x[a] == x[b], in no face together; validate() tells whether the seams that this makes are sound
  void tie(int a, int b);

  // -- edge tags: 0 = plain; any other number names a line that must stay in the mesh as a chain of edges ------------
  int tag(int h) const { return tag_[h]; }
  void set_tag(int h, int tag);  ///< both sides

  // -- operations: `can_*` first; an operation asserts it ------------------------------------------------------------
  // A new face is accepted if its material orientation is exactly positive and it is no round-off sliver: an altitude
  // below 1e-9 of the longest edge is what three points of a straight border leave behind after rounding.
  /// What a split made.
  struct Split {
    int vertex;              ///< the new vertex
    std::vector<int> faces;  ///< every face that is new or changed
    int tied = none;         ///< the new vertex on the other side of a seam, which is vertex + 1
  };
  /// Splits edge h at from + t (to - from), 0 < t < 1, in both spaces. Both halves inherit the tag; the one or two new
  /// inner edges have none. The surface does not change. The half towards from(h) keeps the slot h. The other side of a
  /// seam is split at 1 - t, and the two new vertices are tied.
  /// @pre the children keep positive material area: see can_split.
  bool can_split(int h, double t) const;
  Split split(int h, double t);
  /// Splits face f at the point with barycentric coordinates b (all positive).
  bool can_split_face(int f, const Vec3& b) const;
  Split split_face(int f, const Vec3& b);
  /// Replaces edge ac by bd in the two faces of h. False on the border, on a tagged edge, where bd exists already,
  /// where b and d are tied, or where a new face would have no positive material area.
  bool can_flip(int h) const;
  std::array<int, 2> flip(int h);  ///< the two faces, both changed
  /// What a collapse did.
  struct Collapse {
    int vertex;  ///< the vertex that went
    int into;
    std::vector<int> faces;  ///< live faces that changed (around `into`)
    std::vector<int> removed_faces;
    Ends tied;  ///< what went into what on the other side of a seam, where there was one
  };
  /// Removes from(h), moving its edges to to(h). False if the link condition fails, if a border vertex would leave the
  /// border or shorten it through a corner, if a tagged line would be shortened other than along itself (exactly two
  /// edges with the same tag at from(h), h one of them; or from(h) untagged), if a new seam would come to be, or if a
  /// face that stays would have two tied corners or a material area not above `min_area` (absolute, >= 0). Tags of
  /// merging edges are kept (a tagged one wins).
  ///
  /// A vertex on a seam goes along the seam, and the one that it is tied to goes with it on the other side. So that
  /// both panels keep their shape and what is sewn to what, the seam must run straight through both and part its two
  /// edges in one proportion. Its ends stay, and where more than two panels meet.
  bool can_collapse(int h, double min_area = 0.0) const;
  Collapse collapse(int h);
  /// The same, named by its two vertices: a border edge has a half-edge in one direction only, yet either end may go.
  bool can_collapse_vertex(int vertex, int into, double min_area = 0.0) const;
  Collapse collapse_vertex(int vertex, int into);

  // -- upkeep --------------------------------------------------------------------------------------------------------
  /// Old -> new vertex and face ids (none = removed).
  struct Renumbering {
    std::vector<int> vertex, face;
  };
  /// Drops the removed slots, keeping order.
  Renumbering compact();
  /// First broken invariant in words, or nothing.
  std::optional<std::string> validate() const;

  // One entry a vertex slot; the caller may move vertices freely as long as material areas stay positive.
  std::vector<Vec2> X;  ///< material positions [m]
  std::vector<Vec3> x;  ///< world positions [m]

 private:
  Split split_side(int h, double t);
  bool can_split_side(int h, double t) const;
  int border_halfedge(int a, int b, int except = none) const;  // from the place of a to that of b, or none
  bool are_joined(int a, int b) const;                         // whether there is one, in either direction
  bool closes_a_seam(int vertex, int into) const;
  bool seam_allows_collapse(int vertex, int into) const;
  bool can_collapse_side(int vertex, int into, double min_area) const;
  void collapse_side(Collapse& result, int vertex, int into);
  std::optional<std::string> seam_trouble() const;
  int add_face(int a, int b, int c);
  int add_vertex(const Vec2& material, const Vec3& world);
  void remove_face(int f);
  void link(int h, int g);               // makes h and g twins; g may be none
  void move_side(int from_h, int to_h);  // hands twin and tag of one half-edge over to another
  void anchor(int h);                    // makes h, or the first half-edge clockwise of it, halfedge(from(h))
  void require_face(int f) const;
  void pair_halfedges();         // twins from faces_; throws if an edge is not manifold
  void anchor_vertices();        // vertex_halfedge_ from twins; throws if a vertex is not manifold
  bool winds_once(int v) const;  // whether the faces of an interior vertex go round it once
  bool tags_allow_collapse(int vertex, int edge) const;
  bool links_allow_collapse(int vertex, int into, int edge) const;
  std::optional<std::string> face_trouble(int f) const;
  std::optional<std::string> vertex_trouble(int v, int n_incident) const;

  std::vector<std::array<int, 3>> faces_;
  std::vector<int> twin_, tag_;  // one entry a half-edge
  std::vector<int> vertex_halfedge_;
  std::vector<int> tied_;  // one entry a vertex; empty without seams
  int n_vertices_ = 0, n_faces_ = 0;
};

}  // namespace crease
