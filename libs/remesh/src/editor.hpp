// SPDX-License-Identifier: MIT
#pragma once

#include <array>
#include <span>
#include <vector>

#include "crease/geometry/cloth.hpp"
#include "crease/remesh/remesh.hpp"
#include "momentum.hpp"

namespace crease {

/// How fast the material slips past an EOL vertex, in the world.
struct Slip {
  int vertex;
  Vec3 velocity;  ///< F Xdot, F that of the vertex
};

/// What a slide of a vertex may change: where the vertex is, V of its star, v as far as settle() goes.
struct Surrounds {
  int vertex;
  Vec2 X;
  Vec3 x;
  std::vector<int> star;
  std::vector<Vec2> V;  ///< of the star
  std::vector<Vec3> v;  ///< of all
  bool changed;         ///< whether the cloth had been
};

/// A cloth while it is being remeshed: the mesh's operations, each of which carries velocities, features and pins along
/// and keeps momentum, and the account of what was done. Vertex ids stay valid until finish().
///
/// Momentum. A split keeps the velocity field, but for one: at an edge that ends in an Eulerian vertex the two faces
/// disagree about the velocity there, and their mean is taken. Such splits, flips, collapses, moves, and the
/// beginning and end of a ride change the velocity field: settle() sees to it that they neither lose momentum nor raise
/// the kinetic energy.
class Editor {
 public:
  /// @param conserve  false: velocities are interpolated and nothing else, for comparison
  /// @pre cloth.mesh.is_compact()
  explicit Editor(const Cloth& cloth, bool conserve = true);

  const Cloth& cloth() const { return cloth_; }
  const Mesh& mesh() const { return cloth_.mesh; }
  RemeshReport& report() { return report_; }

  // Each needs the mesh's own `can_*` to hold.
  /// A tagged edge gets an EOL vertex with both velocities interpolated, any other a Lagrangian one.
  Mesh::Split split(int h, double t);
  Mesh::Split split_face(int f, const Vec3& b);
  std::array<int, 2> flip(int h);
  Mesh::Collapse collapse(int vertex, int into);

  /// Moves a Lagrangian vertex along the surface: to the material point X, with the world position and velocity there.
  void slide(int vertex, const Vec2& X, const Vec3& x, const Vec3& v);
  /// Moves an EOL vertex along a chain edge, by the share t of the way to the other end: where it is and both
  /// velocities are linear between the two.
  void slide_along(int vertex, int towards, double t);
  Surrounds surrounds(int vertex) const;
  /// Takes back slides, the last one first: each has its surrounds from just before it, and nothing else was done
  /// since.
  void take_back(const Surrounds& before);
  /// Makes a Lagrangian vertex EOL at `point` of a feature, its material velocity zero for the moment.
  void ride(int vertex, const FeatureId& feature, const Vec3& point);
  /// Shares the velocity of an EOL vertex that has none in Xdot yet: Xdot given, or as large a part of it as those near
  /// can pay for; world velocity kept.
  void share(int vertex, const Vec2& V, const Mat32& F);
  void release(int vertex);
  /// Notes that a chain has left these.
  void note_left(std::span<const LeftStretch> stretches);
  void set_tag(int h, int tag);

  void refuse(RefusalReason reason, int vertex, const Vec2& X);
  /// Only the first of a kind: a whole chain refused at a border is one thing to report.
  void refuse_once(RefusalReason reason, const Vec2& X);

  /// The compact cloth and the completed report. With nothing done, the very cloth that was given.
  RemeshResult finish() &&;

 private:
  void add_vertex(const Vec3& v, const Vec2& V, const FeatureId& feature, std::uint64_t pins);
  /// Runs `change` of the faces of a patch, which returns those that are there afterwards, and settles it with
  /// `payers`.
  template <typename Change>
  void change_patch(std::span<const int> faces, std::vector<int> payers, Change change);
  /// The same for a change of one vertex that leaves the mesh as it is.
  template <typename Change>
  void change_star(int vertex, Change change);
  /// Makes up for what an operation did to faces that carried `before` and are these now. @see settle()
  bool settled(const Account& before, std::span<const int> faces, const Frame& frame, const std::vector<int>& payers,
               int rings);
  /// The same as far as possible.
  void pay(Account before, std::span<const int> faces, const Frame& frame, const std::vector<Slip>& slips,
           const std::vector<int>& payers);
  std::vector<int> disagreeing_faces(int h) const;
  Mesh::Split split_alone(int h, double t);
  Vec3 mean_position(const std::vector<int>& vertices) const;

  Cloth cloth_;
  RemeshReport report_;
  int n_given_;
  bool conserve_;
  Vec3 drift_;          // mean velocity of the cloth given
  double fastest_ = 0;  // square of its largest speed
};

}  // namespace crease
