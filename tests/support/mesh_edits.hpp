// SPDX-License-Identifier: MIT
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "crease/geometry/cloth.hpp"
#include "crease/remesh/remesh.hpp"
#include "support/meshes.hpp"
#include "support/seams.hpp"

/// Any string of bytes as a sequence of mesh operations on some sheet, with everything checked after each. The fuzzer
/// and the random tests share it.
namespace crease::support {

/// Two panels that lie over each other in material space and share nothing.
inline Mesh panels() {
  const Mesh one = grid(GridPattern::Cross, 4, 4), other = grid(GridPattern::Irregular, 5, 5, 3);
  std::vector<Vec2> X = one.X;
  std::vector<Vec3> x = one.x;
  std::vector<std::array<int, 3>> faces;
  for (int f = 0; f < one.n_faces(); ++f) faces.push_back(one.face(f));
  X.insert(X.end(), other.X.begin(), other.X.end());
  x.insert(x.end(), other.x.begin(), other.x.end());
  for (int f = 0; f < other.n_faces(); ++f) {
    faces.push_back(other.face(f));
    for (int& v : faces.back()) v += one.n_vertices();
  }
  return Mesh(X, x, faces);
}

class MeshEdits {
 public:
  static constexpr int n_sheets = 15;

  /// @param sheet  which mesh, in [0, n_sheets)
  /// @param chain  0: none; 1: across the sheet; 2: half of it, then round a corner; on sewn sheets always none
  MeshEdits(int sheet, int chain) : cloth_(make_cloth(sheet_of_kind(sheet))) {
    if (chain > 0 && !cloth_.mesh.has_seams()) lay_chain(chain);
    area_ = total_area(cloth_.mesh);
    chain_length_ = chain_length();
    euler_ = euler_characteristic(cloth_.mesh);
    for (const bool sewn : {false, true}) border_length_[sewn] = border_length(cloth_.mesh, sewn);
  }

  /// Does the operations that the bytes stand for, or says what is wrong after one of them.
  std::optional<std::string> run(std::span<const std::uint8_t> bytes) {
    bytes_ = bytes;
    while (!bytes_.empty()) {
      const char* name = operate();
      if (std::optional<std::string> trouble = check())
        return std::string(name) + ", operation " + std::to_string(n_done_) + ": " + *trouble;
      ++n_done_;
    }
    return std::nullopt;
  }

  int n_done() const { return n_done_; }
  const Cloth& cloth() const { return cloth_; }

 private:
  // Made once: the fuzzer asks for one of them thousands of times.
  static const Mesh& sheet_of_kind(int sheet) {
    static const std::vector<Mesh> sheets = [] {
      std::vector<Mesh> made;
      for (const NamedMesh& named : all_meshes()) made.push_back(named.mesh);
      for (const Mesh& mesh : {slit(), panels(), halves().mesh, patchwork().mesh, tube(4), pillow(), dart()})
        made.push_back(mesh);
      return made;
    }();
    return sheets.at(static_cast<std::size_t>(sheet));
  }

  // The line x = 0.6, y < top; with a corner, from there on to larger x. In the world the line is the y axis, which one
  // edge of an obstacle lies along, and the second leg the x axis shifted to the corner.
  void lay_chain(int kind) {
    Mesh& mesh = cloth_.mesh;
    const Vec2 corner(0.6, 0.4);
    const auto near = [](double a, double b) { return std::abs(a - b) < 1e-9; };
    const auto on_leg = [&](const Vec2& P, int leg) {
      if (leg == 1) return near(P.x(), corner.x()) && (kind == 1 || P.y() < corner.y() + 1e-9);
      return kind == 2 && near(P.y(), corner.y()) && P.x() > corner.x() - 1e-9;
    };
    for (const int h : mesh.edges()) {
      const int a = mesh.from(h), b = mesh.to(h);
      for (const int leg : {1, 2}) {
        if (mesh.is_border(h) || mesh.is_material_corner(a) || mesh.is_material_corner(b)) continue;
        if (!on_leg(mesh.X[a], leg) || !on_leg(mesh.X[b], leg)) continue;
        mesh.set_tag(h, edge_tag(0, leg));
        for (const int v : {a, b}) {
          FeatureId& feature = cloth_.feature[v];
          const bool turns = kind == 2 && near(mesh.X[v].x(), corner.x()) && near(mesh.X[v].y(), corner.y());
          feature = turns ? FeatureId{0, FeatureKind::Corner, 0} : FeatureId{0, FeatureKind::Edge, leg};
        }
      }
    }
    for (int v = 0; v < mesh.n_vertices(); ++v) mesh.x[v] -= Vec3(corner.x(), corner.y(), 0);
  }

  std::uint8_t byte() {
    if (bytes_.empty()) return 0;
    const std::uint8_t b = bytes_.front();
    bytes_ = bytes_.subspan(1);
    return b;
  }
  int pick_of(int n) { return n <= 0 ? 0 : (256 * byte() + byte()) % n; }
  double share() { return (byte() + 0.5) / 256; }  // in (0, 1)

  const char* operate() {
    const int kind = byte() % 16;
    if (cloth_.mesh.n_faces() > 250 && kind < 8) return collapse();
    if (kind < 4) return split();
    if (kind < 5) return split_face();
    if (kind < 8) return flip();
    if (kind < 13) return collapse();
    if (kind < 14) return compact();
    if (kind < 15) return stir();
    return adapt_all();
  }

  int live_halfedge() {
    const int start = pick_of(cloth_.mesh.face_slots());
    int f = start;
    while (!cloth_.mesh.face_live(f)) f = (f + 1) % cloth_.mesh.face_slots();
    return 3 * f + byte() % 3;
  }

  void add_vertex(int tag) {
    cloth_.v.push_back(Vec3::Zero());
    cloth_.V.push_back(Vec2::Zero());
    cloth_.feature.push_back(tag != 0 ? tag_feature(tag) : FeatureId{});
    cloth_.pins.push_back(0);
  }

  const char* split() {
    const int h = live_halfedge();
    const double t = share();
    if (cloth_.mesh.can_split(h, t)) {
      const int tag = cloth_.mesh.tag(h);
      const bool sewn = cloth_.mesh.split(h, t).tied != Mesh::none;
      add_vertex(tag);
      if (sewn) add_vertex(0);
    }
    return "split";
  }

  const char* split_face() {
    const int f = Mesh::face_of(live_halfedge());
    const Vec3 b(share(), share(), share());
    if (cloth_.mesh.can_split_face(f, b)) {
      cloth_.mesh.split_face(f, b);
      add_vertex(0);
    }
    return "split of a face";
  }

  const char* flip() {
    const int h = live_halfedge();
    if (cloth_.mesh.can_flip(h)) cloth_.mesh.flip(h);
    return "flip";
  }

  // As the remesher does it: pins, corners and ends of chains stay, and nothing on a chain leaves it.
  const char* collapse() {
    const int h = live_halfedge();
    const bool forth = byte() % 2 == 0;
    const Mesh& mesh = cloth_.mesh;
    const int vertex = forth ? mesh.from(h) : mesh.to(h), into = forth ? mesh.to(h) : mesh.from(h);
    const bool end =
        cloth_.is_eol(vertex) && (mesh.is_border_vertex(vertex) || cloth_.feature[vertex].kind == FeatureKind::Corner);
    if (cloth_.pins[vertex] == 0 && !end && mesh.can_collapse_vertex(vertex, into))
      cloth_.mesh.collapse_vertex(vertex, into);
    return "collapse";
  }

  const char* compact() {
    const int n = cloth_.mesh.vertex_slots();
    const std::vector<int> now = cloth_.mesh.compact().vertex;
    for (int v = 0; v < n; ++v) {
      if (now[v] == Mesh::none) continue;
      cloth_.v[now[v]] = cloth_.v[v];
      cloth_.V[now[v]] = cloth_.V[v];
      cloth_.feature[now[v]] = cloth_.feature[v];
      cloth_.pins[now[v]] = cloth_.pins[v];
    }
    const auto size = static_cast<std::size_t>(cloth_.mesh.n_vertices());
    cloth_.v.resize(size);
    cloth_.V.resize(size);
    cloth_.feature.resize(size);
    cloth_.pins.resize(size);
    return "compact";
  }

  // New world positions and velocities, off the chain; now and then a pin.
  const char* stir() {
    Rng rng(byte());
    const double height = 0.2 * share();
    const int pinned = pick_of(20 * cloth_.mesh.vertex_slots());
    for (int v = 0; v < cloth_.mesh.vertex_slots(); ++v) {
      if (!cloth_.mesh.vertex_live(v)) continue;
      cloth_.v[v] = Vec3(uniform(rng, -1, 1), uniform(rng, -1, 1), uniform(rng, -1, 1));
      if (cloth_.is_eol(v)) continue;
      const Vec2& X = cloth_.mesh.X[v];
      cloth_.mesh.x[v].z() = height * std::sin(8 * X.x()) * std::cos(7 * X.y());
      if (v == pinned) cloth_.pins[v] = 1;
    }
    match_tied();
    return "stir";
  }

  // What is tied is one point.
  void match_tied() {
    for (int i = 0; i < cloth_.mesh.vertex_slots(); ++i)
      for (int v = cloth_.mesh.tied(i); v != i; v = cloth_.mesh.tied(v)) {
        cloth_.mesh.x[v] = cloth_.mesh.x[i];
        cloth_.v[v] = cloth_.v[i];
        cloth_.pins[v] = cloth_.pins[i];
      }
  }

  const char* adapt_all() {
    compact();
    AdaptOptions options;
    options.size[0] = 0.08 + 0.2 * share();
    options.size[1] = options.size[0] * (1 + 3 * share());
    options.aspect = 0.1 + 0.9 * share();
    RemeshResult result = adapt(cloth_, options);
    report_ = result.report;
    cloth_ = std::move(result.cloth);
    return "adapt";
  }

  double chain_length() const {
    double sum = 0;
    for (const int h : cloth_.mesh.edges())
      if (cloth_.mesh.tag(h) != 0) sum += cloth_.mesh.material_length(h);
    return sum;
  }

  std::optional<std::string> check() const {
    if (auto trouble = validate(cloth_)) return trouble;
    // Sums of a few hundred products: rounding, no more.
    if (std::abs(total_area(cloth_.mesh) - area_) > 1e-12 * area_) return "area is lost";
    if (std::abs(chain_length() - chain_length_) > 1e-12) return "the chain's length has changed";
    if (euler_characteristic(cloth_.mesh) != euler_) return "the topology has changed";
    for (const bool sewn : {false, true})
      if (std::abs(border_length(cloth_.mesh, sewn) - border_length_[sewn]) > 1e-12)
        return "a seam or border has changed";
    for (int v = 0; v < cloth_.mesh.vertex_slots(); ++v) {
      if (!cloth_.mesh.vertex_live(v) || !cloth_.is_eol(v)) continue;
      const Vec3& x = cloth_.mesh.x[v];
      const FeatureId& f = cloth_.feature[v];
      const double aside = f.kind == FeatureKind::Corner ? x.norm() : std::hypot(x.z(), f.index == 1 ? x.x() : x.y());
      if (aside > 1e-12) return "vertex " + std::to_string(v) + " has left its feature";
    }
    // Vertices that are held keep their speed whatever mass they come to carry.
    const bool held = std::any_of(cloth_.pins.begin(), cloth_.pins.end(), [](std::uint64_t pins) { return pins != 0; });
    if (!held && report_.after.kinetic > report_.before.kinetic * (1 + 1e-12)) return "the kinetic energy has risen";
    return std::nullopt;
  }

  Cloth cloth_;
  RemeshReport report_;
  std::span<const std::uint8_t> bytes_;
  double area_ = 0, chain_length_ = 0;
  std::array<double, 2> border_length_{};
  int euler_ = 0, n_done_ = 0;
};

/// The whole of one input: two bytes for the sheet, the rest for what is done to it.
inline std::optional<std::string> run_edits(std::span<const std::uint8_t> bytes) {
  if (bytes.size() < 2) return std::nullopt;
  MeshEdits edits(bytes[0] % MeshEdits::n_sheets, bytes[1] % 3);
  return edits.run(bytes.subspan(2));
}

/// Random operations on every sheet with every chain, in turn, until `wanted` are done; what went wrong, with its seed.
inline std::optional<std::string> run_random_edits(int wanted) {
  int done = 0;
  for (std::uint64_t seed = 1; done < wanted; ++seed) {
    Rng rng(seed);
    std::vector<std::uint8_t> bytes(4000);
    for (std::uint8_t& b : bytes) b = static_cast<std::uint8_t>(rng());
    MeshEdits edits(static_cast<int>(seed % MeshEdits::n_sheets), static_cast<int>(seed / MeshEdits::n_sheets % 3));
    if (const auto trouble = edits.run(bytes)) return "seed " + std::to_string(seed) + ": " + *trouble;
    done += edits.n_done();
  }
  return std::nullopt;
}

}  // namespace crease::support
