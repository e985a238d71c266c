// SPDX-License-Identifier: MIT
#include "relax.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

#include "even.hpp"
#include "metric.hpp"
#include "slide.hpp"

namespace crease {

namespace {

// Lengths here are in units of the longest edge. Steps of a vertex: halved while none of its ways leads on.
constexpr double first_step = 0.125, last_step = 0.0005;
// How many steps a vertex may take in its turn, and how many turns all may have.
constexpr int max_steps = 24, max_turns = 40;
// Lengths are drawn so far inside the band, and are done where they are in the band.
constexpr double margin = 0.01;
// Of faces: with edges of at least one half, angles of 23 degrees; what is thinner may not become more so.
constexpr double least_altitude = 0.2;

// A vertex that slides, and where.
struct Star {
  int vertex;
  std::vector<int> ring;  // its neighbours, as places in Patch::X_
  bool is_closed;
  double altitude;  // that its faces keep
  std::vector<Vec2> ways;
};

// Vertices that slide in turn, and those around them, which stay. What drives them is the sum of the squares by which
// lengths are off: it never rises, and where it stops falling they give up.
class Patch {
 public:
  Patch(const Mesh& mesh, std::span<const int> vertices, double unit);

  /// Whether all lengths came to lie in the band.
  bool relax();
  std::vector<Move> moves() const;

 private:
  double altitude(const Star& star, const Vec2& P) const;
  double trouble(const Star& star, const Vec2& P) const;
  bool is_done() const;
  double slide(const Star& star, Vec2& P);

  double unit_;
  std::vector<Vec2> X_;  // first of the stars, in their order, then of the others
  std::vector<Star> stars_;
};

Patch::Patch(const Mesh& mesh, std::span<const int> vertices, double unit) : unit_(unit) {
  std::vector<int> ids(vertices.begin(), vertices.end());
  const auto place_of = [&](int v) {
    const auto found = std::find(ids.begin(), ids.end(), v);
    if (found == ids.end()) return ids.push_back(v), static_cast<int>(ids.size()) - 1;
    return static_cast<int>(found - ids.begin());
  };
  for (const int v : vertices) {
    Star star{v, {}, !mesh.is_border_vertex(v), 0, ways_to_slide(mesh, v)};
    for (const int u : mesh.neighbours(v)) star.ring.push_back(place_of(u));
    stars_.push_back(std::move(star));
  }
  for (const int v : ids) X_.push_back(mesh.X[v] / unit);
  for (std::size_t k = 0; k < stars_.size(); ++k)
    stars_[k].altitude = std::min(least_altitude, altitude(stars_[k], X_[k]));
}

// The least of its faces, over the sides that are not its own.
double Patch::altitude(const Star& star, const Vec2& P) const {
  double least = std::numeric_limits<double>::infinity();
  for (std::size_t k = 0; k < star.ring.size(); ++k) {
    const bool is_last = k + 1 == star.ring.size();
    if (is_last && !star.is_closed) break;
    const Vec2 &S = X_[star.ring[k]], &T = X_[star.ring[is_last ? 0 : k + 1]];
    least = std::min(least, cross2(S - P, T - P) / (T - S).norm());
  }
  return least;
}

double Patch::trouble(const Star& star, const Vec2& P) const {
  double sum = 0;
  for (const int u : star.ring) {
    const double length = (X_[u] - P).norm();
    const double off = std::max({0.0, short_below + margin - length, length - (1 - margin)});
    sum += off * off;
  }
  return sum;
}

bool Patch::is_done() const {
  for (std::size_t k = 0; k < stars_.size(); ++k)
    for (const int u : stars_[k].ring)
      if (const double length = (X_[u] - X_[k]).norm(); length < short_below || length > 1) return false;
  return true;
}

double Patch::slide(const Star& star, Vec2& P) {
  double least = trouble(star, P);
  double step = first_step;
  for (int n = 0; n < max_steps && step > last_step && least > 0; ++n) {
    Vec2 best = P;
    for (const Vec2& way : star.ways) {
      const Vec2 there = P + step * way;
      const double sum = trouble(star, there);
      if (sum < least && altitude(star, there) >= star.altitude) best = there, least = sum;
    }
    if (best == P) step /= 2;
    P = best;
  }
  return least;
}

bool Patch::relax() {
  double left = std::numeric_limits<double>::infinity();
  for (int turn = 0; turn < max_turns; ++turn) {
    double sum = 0;
    for (std::size_t k = 0; k < stars_.size(); ++k) sum += slide(stars_[k], X_[k]);
    if (is_done()) return true;
    if (!(sum < 0.98 * left)) return false;
    left = sum;
  }
  return false;
}

std::vector<Move> Patch::moves() const {
  std::vector<Move> moves;
  for (std::size_t k = 0; k < stars_.size(); ++k) moves.push_back({stars_[k].vertex, unit_ * X_[k]});
  return moves;
}

}  // namespace

std::vector<Move> relax(const Mesh& mesh, std::span<const int> vertices, double longest) {
  Patch patch(mesh, vertices, longest);
  return patch.relax() ? patch.moves() : std::vector<Move>();
}

}  // namespace crease
