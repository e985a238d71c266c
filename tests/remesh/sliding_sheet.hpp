// SPDX-License-Identifier: MIT
#pragma once

#include <cmath>
#include <cstdint>
#include <map>
#include <numbers>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "crease/geometry/grid.hpp"
#include "crease/geometry/triangle.hpp"
#include "crease/remesh/remesh.hpp"
#include "support/contacts.hpp"

/// A sheet that slides over the edge of a table in a motion that is known exactly, so that every remeshing pass can be
/// compared with the truth. World: the table's edge is the y axis, its top z = 0, x > 0; beyond it the sheet goes down
/// at `fold`. Material: the unit square, turned by `angle`; s is the signed distance from the edge along the sheet.
namespace crease::support {

class SlidingSheet {
 public:
  struct Setup {
    GridPattern pattern = GridPattern::Cross;
    int cells = 20;
    double angle = 0;    ///< of the sheet to the edge [rad]
    double fold = 0;     ///< [rad]
    double curl = 0;     ///< curvature of the part beyond the edge, which is a circular cylinder [1/m]
    double place = 0.7;  ///< s of the sheet's centre at the start is place - 0.5, towards the table
  };

  explicit SlidingSheet(const Setup& setup) : setup_(setup), shift_(0.5 - setup.place) {
    GridOptions grid;
    grid.cells = {setup.cells, setup.cells};
    grid.pattern = setup.pattern;
    cloth = make_cloth(make_grid(grid));
    place_all();
  }

  PosedObstacle table() const {
    static const ObstacleShape box = make_box(Vec3(8, 16, 1));
    Pose pose;
    pose.position = Vec3(4, 0, -0.5);
    return {&box, pose};
  }

  Vec2 across() const { return {std::cos(setup_.angle), -std::sin(setup_.angle)}; }  ///< grad_X s
  double s(const Vec2& X) const { return across().dot(X - Vec2(0.5, 0.5)) + shift_; }
  Vec3 world(const Vec2& X) const {
    const double along = Vec2(std::sin(setup_.angle), std::cos(setup_.angle)).dot(X - Vec2(0.5, 0.5));
    const double d = s(X);
    if (d >= 0) return {d, along, 0};
    // Chord of the arc of length |d| that leaves the edge at the angle `fold`.
    const double half = 0.5 * setup_.curl * d, chord = half == 0 ? d : d * std::sin(half) / half;
    return {chord * std::cos(setup_.fold + half), along, chord * std::sin(setup_.fold + half)};
  }
  /// Velocity of the material on one side of the edge.
  Vec3 velocity(bool on_table) const {
    return on_table ? Vec3(speed, 0, 0) : Vec3(speed * std::cos(setup_.fold), 0, speed * std::sin(setup_.fold));
  }

  /// Bends the sheet down behind its chain.
  void bend(double fold, double curl = 0) {
    setup_.fold = fold;
    setup_.curl = curl;
    place_all();
  }

  /// Slides the sheet by d: EOL vertices keep to the edge and move in the material, on the border along it.
  void slide(double d) {
    shift_ += d;
    for (int v = 0; v < cloth.mesh.n_vertices(); ++v) {
      if (!cloth.is_eol(v)) continue;
      Vec2 way = across();
      if (cloth.mesh.is_border_vertex(v)) {
        const std::vector<int> around = cloth.mesh.neighbours(v);
        way = (cloth.mesh.X[around.front()] - cloth.mesh.X[around.back()]).normalized();
        way /= way.dot(across());
      }
      cloth.mesh.X[v] -= d * way;
      cloth.V[v] = -speed * way;
    }
    place_all();
  }

  RemeshResult conform(const ConformOptions& options) const {
    const PosedObstacle obstacle = table();
    const std::span<const PosedObstacle> obstacles(&obstacle, 1);
    return crease::conform(cloth, feature_contacts(cloth, obstacles, options.snap), obstacles, options);
  }

  /// Height of an EOL vertex over the opposite side of a face, the smallest there is: how far the chain can move [m].
  double room() const {
    double least = 1;
    for (int h = 0; h < 3 * cloth.mesh.n_faces(); ++h)
      if (cloth.is_eol(cloth.mesh.from(h)))
        least =
            std::min(least, 2 * cloth.mesh.material_area(Mesh::face_of(h)) / cloth.mesh.material_length(Mesh::next(h)));
    return least;
  }

  /// What is wrong with the chain, or nothing. One chain: every EOL vertex on it, in order along the edge, from end to
  /// end without a gap; and the surface where it should be.
  std::optional<std::string> trouble() const {
    std::map<double, int> order;
    for (int v = 0; v < cloth.mesh.n_vertices(); ++v) {
      if (cloth.is_eol(v)) order[cloth.mesh.x[v].y()] = v;
      // A chain that meets the border at too small an angle has ended; between there and the border facets cut across
      // the fold, so a vertex is off by no more than its way to the border.
      const Vec2& X = cloth.mesh.X[v];
      const double to_border = std::min(X.minCoeff(), (Vec2(1, 1) - X).minCoeff());
      if ((cloth.mesh.x[v] - world(X)).norm() > std::max(1e-3, to_border < 5e-3 ? to_border : 0.0))
        return "vertex " + std::to_string(v) + " is off";
    }
    if (static_cast<int>(order.size()) != cloth.n_eol()) return "two EOL vertices in one place";
    int previous = Mesh::none, tagged = 0;
    for (const auto& [y, v] : order) {
      if (previous != Mesh::none) {
        const int h = cloth.mesh.find_edge(previous, v);
        if (h == Mesh::none || cloth.mesh.tag(h) == 0) return "gap at y = " + std::to_string(y);
      }
      previous = v;
    }
    for (const int h : cloth.mesh.edges()) tagged += cloth.mesh.tag(h) != 0 ? 1 : 0;
    if (!order.empty() && tagged != static_cast<int>(order.size()) - 1) return "tagged edges beside the chain";
    return validate(cloth);
  }

  Cloth cloth;
  static constexpr double speed = 0.4;  ///< [m/s]

 private:
  void place_all() {
    for (int v = 0; v < cloth.mesh.n_vertices(); ++v) {
      const Vec3 x = world(cloth.mesh.X[v]);
      cloth.mesh.x[v] = cloth.is_eol(v) ? Vec3(0, x.y(), 0) : x;
      if (!cloth.is_eol(v)) cloth.v[v] = velocity(s(cloth.mesh.X[v]) >= 0);
    }
  }

  Setup setup_;
  double shift_;
};

}  // namespace crease::support
