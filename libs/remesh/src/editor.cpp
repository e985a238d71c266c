// SPDX-License-Identifier: MIT
#include "editor.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include <Eigen/QR>

#include "crease/base/require.hpp"
#include "crease/geometry/triangle.hpp"
#include "metric.hpp"
#include "momentum.hpp"
#include "neighbourhood.hpp"
#include "transfer.hpp"

namespace crease {

namespace {

// Largest cotangent first, one arc tangent at the end: this runs over every face of every call.
double smallest_material_angle(const Mesh& mesh) {
  double cotangent = 1 / std::sqrt(3.0);  // equilateral: no triangle does better
  for (int f = 0; f < mesh.face_slots(); ++f) {
    if (!mesh.face_live(f)) continue;
    const auto& [i, j, k] = mesh.face(f);
    const Vec2 a = mesh.X[j] - mesh.X[i], b = mesh.X[k] - mesh.X[i], c = b - a;
    cotangent = std::max(cotangent, std::max({a.dot(b), -a.dot(c), b.dot(c)}) / cross2(a, b));
  }
  return std::atan2(1.0, cotangent);
}

template <typename T>
void drop_removed(std::vector<T>& entries, const std::vector<int>& renumbering, int n) {
  // New ids never exceed old ones, so moving forward overwrites nothing that is still needed.
  for (std::size_t i = 0; i < entries.size(); ++i)
    if (renumbering[i] != Mesh::none) entries[renumbering[i]] = entries[i];
  entries.resize(static_cast<std::size_t>(n));
}

/// Energy of velocities that are rounding beside others, as a share of theirs.
constexpr double rounding_energy = 1e-24;
/// Less of an EOL vertex's velocity than this in Xdot is none.
constexpr double least_share = 0.01;
/// Rings of vertices that may pay for it.
constexpr int share_rings = 3;

std::vector<Slip> slips_at(const Cloth& cloth, const std::vector<int>& vertices) {
  std::vector<Slip> slips;
  for (const int v : vertices)
    if (cloth.is_eol(v) && !cloth.V[v].isZero(0))
      slips.push_back({v, vertex_deformation_gradient(cloth.mesh, v) * cloth.V[v]});
  return slips;
}

/// Where F has changed, the old Xdot is another motion of the material: the nearest to a share of the old one.
void keep_slips(const std::vector<Slip>& slips, double share, Cloth& cloth) {
  for (const auto& [v, velocity] : slips)
    if (cloth.mesh.vertex_live(v) && cloth.is_eol(v))
      cloth.V[v] = vertex_deformation_gradient(cloth.mesh, v).completeOrthogonalDecomposition().solve(share * velocity);
}

/// The material's velocity there from before, for want of another.
void stop_slips(const std::vector<Slip>& slips, Cloth& cloth) {
  for (const auto& [v, velocity] : slips)
    if (cloth.mesh.vertex_live(v) && cloth.is_eol(v)) {
      cloth.v[v] -= velocity;
      cloth.V[v].setZero();
    }
}

/// Faces at the slipping vertices that are not in the patch.
std::vector<int> other_faces(const Cloth& cloth, const std::vector<Slip>& slips, std::span<const int> patch) {
  std::vector<int> others;
  for (const Slip& slip : slips)
    if (cloth.mesh.vertex_live(slip.vertex))
      for (const int f : faces_around(cloth.mesh, slip.vertex))
        if (std::find(patch.begin(), patch.end(), f) == patch.end()) others.push_back(f);
  std::sort(others.begin(), others.end());
  others.erase(std::unique(others.begin(), others.end()), others.end());
  return others;
}

}  // namespace

Editor::Editor(const Cloth& cloth, bool conserve)
    : cloth_(cloth), n_given_(cloth.mesh.vertex_slots()), conserve_(conserve) {
  report_.before = motion(cloth);
  drift_ = report_.before.linear / report_.before.area;
  for (const Vec3& v : cloth.v) fastest_ = std::max(fastest_, v.squaredNorm());
}

// A seam's two new vertices come one after the other.
void Editor::add_vertex(const Vec3& v, const Vec2& V, const FeatureId& feature, std::uint64_t pins) {
  cloth_.v.push_back(v);
  cloth_.V.push_back(V);
  cloth_.feature.push_back(feature);
  cloth_.pins.push_back(pins);
  CREASE_ASSERT(cloth_.v.size() <= cloth_.mesh.X.size());
  report_.changed = true;
  ++report_.splits;
}

Vec3 Editor::mean_position(const std::vector<int>& vertices) const {
  Vec3 sum = Vec3::Zero();
  for (const int v : vertices) sum += mesh().x[v];
  return sum / static_cast<double>(vertices.size());
}

// The faces at h, if their velocity fields, each with its own F, may disagree along it: a split there averages them.
std::vector<int> Editor::disagreeing_faces(int h) const {
  if (mesh().is_border(h) || mesh().tag(h) != 0) return {};
  std::vector<int> faces{Mesh::face_of(h), Mesh::face_of(mesh().twin(h))};
  const bool agree = !cloth_.is_eol(mesh().from(h)) && !cloth_.is_eol(mesh().to(h));
  return agree || !conserve_ ? std::vector<int>{} : faces;
}

Mesh::Split Editor::split(int h, double t) {
  const std::vector<int> faces = disagreeing_faces(h);
  if (faces.empty()) return split_alone(h, t);
  std::vector<int> payers{mesh().from(h), mesh().opposite(h), mesh().to(h), mesh().opposite(mesh().twin(h))};
  const Frame frame{mean_position(payers), drift_};
  const std::vector<Slip> slips = slips_at(cloth_, payers);
  const Account before = account(cloth_, faces, frame);
  Mesh::Split done = split_alone(h, t);
  payers.push_back(done.vertex);
  pay(before, done.faces, frame, slips, payers);
  return done;
}

Mesh::Split Editor::split_alone(int h, double t) {
  const int a = mesh().from(h), b = mesh().to(h), tag = mesh().tag(h);
  const std::uint64_t pins = cloth_.pins[a] & cloth_.pins[b];
  Vec3 v = edge_velocity(cloth_, h, t);
  Vec2 V = Vec2::Zero();
  FeatureId feature;
  if (tag != 0) {
    v = (1 - t) * cloth_.v[a] + t * cloth_.v[b];
    V = (1 - t) * cloth_.V[a] + t * cloth_.V[b];
    feature = tag_feature(tag);
    feature.lifted = cloth_.feature[a].lifted || cloth_.feature[b].lifted;
    feature.away = std::max(cloth_.feature[a].away, cloth_.feature[b].away);
  }
  const Mesh::Split done = cloth_.mesh.split(h, t);
  add_vertex(v, V, feature, pins);
  if (done.tied != Mesh::none) add_vertex(v, V, feature, pins);
  return done;
}

Mesh::Split Editor::split_face(int f, const Vec3& b) {
  const std::array<Vec3, 3> w = corner_velocities(cloth_, f);
  const Mesh::Split done = cloth_.mesh.split_face(f, b);
  add_vertex((b[0] * w[0] + b[1] * w[1] + b[2] * w[2]) / b.sum(), Vec2::Zero(), FeatureId{}, 0);
  return done;
}

// Rounding of what moves at the cloth's speed is not paid for.
bool Editor::settled(const Account& before, std::span<const int> faces, const Frame& frame,
                     const std::vector<int>& payers, int rings) {
  const Account after = account(cloth_, faces, frame);
  return std::max(before.kinetic, after.kinetic) <= rounding_energy * fastest_ * before.area ||
         settle(cloth_, before, after, frame, payers, rings);
}

// Where those around cannot pay, the EOL vertices help: by the F that they have now, by slipping more slowly, and at
// last by going along with the material.
void Editor::pay(Account before, std::span<const int> faces, const Frame& frame, const std::vector<Slip>& slips,
                 const std::vector<int>& payers) {
  if (settled(before, faces, frame, payers, paying_rings)) return;
  std::vector<int> all = other_faces(cloth_, slips, faces);
  before += account(cloth_, all, frame);
  all.insert(all.end(), faces.begin(), faces.end());
  if (!slips.empty()) {
    for (const double share : {1.0, 0.5, 0.25, 0.0}) {
      keep_slips(slips, share, cloth_);
      if (settled(before, all, frame, payers, paying_rings)) return;
    }
    stop_slips(slips, cloth_);
    if (settled(before, all, frame, payers, paying_rings)) return;
  }
  settle_in_part(cloth_, before, account(cloth_, all, frame), frame, payers);
}

template <typename Change>
void Editor::change_patch(std::span<const int> faces, std::vector<int> payers, Change change) {
  report_.changed = true;
  if (!conserve_) {
    change();
    return;
  }
  const Frame frame{mean_position(payers), drift_};
  const std::vector<Slip> slips = slips_at(cloth_, payers);
  const Account before = account(cloth_, faces, frame);
  pay(before, change(), frame, slips, payers);
}

std::array<int, 2> Editor::flip(int h) {
  const int g = mesh().twin(h);
  const std::array<int, 2> faces{Mesh::face_of(h), Mesh::face_of(g)};
  change_patch(faces, {mesh().from(h), mesh().opposite(h), mesh().to(h), mesh().opposite(g)},
               [&] { return cloth_.mesh.flip(h); });
  ++report_.flips;
  return faces;
}

Mesh::Collapse Editor::collapse(int vertex, int into) {
  std::vector<int> faces = faces_around(mesh(), vertex), payers = mesh().neighbours(vertex);
  const int tied = mesh().across_seam(vertex, into).vertex;
  if (tied != Mesh::none) {
    const std::vector<int> faces_there = faces_around(mesh(), tied), payers_there = mesh().neighbours(tied);
    faces.insert(faces.end(), faces_there.begin(), faces_there.end());
    payers.insert(payers.end(), payers_there.begin(), payers_there.end());
  }
  Mesh::Collapse done;
  change_patch(faces, std::move(payers), [&]() -> const std::vector<int>& {
    done = cloth_.mesh.collapse_vertex(vertex, into);
    return done.faces;
  });
  report_.collapses += tied == Mesh::none ? 1 : 2;
  return done;
}

template <typename Change>
void Editor::change_star(int vertex, Change change) {
  std::vector<int> payers = mesh().neighbours(vertex);
  payers.push_back(vertex);
  const std::vector<int> faces = faces_around(mesh(), vertex);
  change_patch(faces, std::move(payers), [&]() -> const std::vector<int>& {
    change();
    return faces;
  });
}

void Editor::slide(int vertex, const Vec2& X, const Vec3& x, const Vec3& v) {
  CREASE_ASSERT(!cloth_.is_eol(vertex) && !mesh().on_seam(vertex));
  change_star(vertex, [&] {
    cloth_.mesh.X[vertex] = X;
    cloth_.mesh.x[vertex] = x;
    cloth_.v[vertex] = v;
  });
}

void Editor::slide_along(int vertex, int towards, double t) {
  CREASE_ASSERT(mesh().tag(mesh().find_edge(vertex, towards)) != 0);
  const auto mix = [&](auto& of) { of[vertex] = (1 - t) * of[vertex] + t * of[towards]; };
  change_star(vertex, [&] {
    mix(cloth_.mesh.X);
    mix(cloth_.mesh.x);
    mix(cloth_.v);
    mix(cloth_.V);
  });
}

Surrounds Editor::surrounds(int vertex) const {
  std::vector<int> star = mesh().neighbours(vertex);
  star.push_back(vertex);
  Surrounds s{vertex, mesh().X[vertex], mesh().x[vertex], std::move(star), {}, cloth_.v, report_.changed};
  for (const int u : s.star) s.V.push_back(cloth_.V[u]);
  return s;
}

void Editor::take_back(const Surrounds& before) {
  cloth_.mesh.X[before.vertex] = before.X;
  cloth_.mesh.x[before.vertex] = before.x;
  for (std::size_t i = 0; i < before.V.size(); ++i) cloth_.V[before.star[i]] = before.V[i];
  cloth_.v = before.v;
  report_.changed = before.changed;
}

// The move to the feature changes F in the faces, and with it what other EOL vertices there carry.
void Editor::ride(int vertex, const FeatureId& feature, const Vec3& point) {
  CREASE_ASSERT(!cloth_.is_eol(vertex) && !mesh().on_seam(vertex));
  change_star(vertex, [&] {
    cloth_.feature[vertex] = feature;
    cloth_.mesh.x[vertex] = point;
  });
  ++report_.inserted;
}

// In a fold the faces' own F may be far from their mean, and F V of one that is nearly crushed tells little of V: all
// of it could be faster than anything around can pay for.
void Editor::share(int vertex, const Vec2& V, const Mat32& F) {
  if (V.isZero(0)) return;
  report_.changed = true;
  std::vector<int> payers = mesh().neighbours(vertex);
  payers.push_back(vertex);
  const std::vector<int> faces = faces_around(mesh(), vertex);
  const Frame frame{mean_position(payers), drift_};
  const Account before = account(cloth_, faces, frame);
  const Vec3 v = cloth_.v[vertex];
  for (double share = 1; share > least_share; share /= 2) {
    cloth_.v[vertex] = v + share * F * V;
    cloth_.V[vertex] = share * V;
    if (!conserve_ || settled(before, faces, frame, payers, share_rings)) return;
  }
  cloth_.v[vertex] = v;
  cloth_.V[vertex].setZero();
}

void Editor::release(int vertex) {
  change_star(vertex, [&] { make_lagrangian(cloth_, vertex); });
  report_.changed = true;
  ++report_.released;
}

void Editor::note_left(std::span<const LeftStretch> stretches) {
  cloth_.left.insert(cloth_.left.end(), stretches.begin(), stretches.end());
}

void Editor::set_tag(int h, int tag) {
  if (mesh().tag(h) == tag) return;
  cloth_.mesh.set_tag(h, tag);
  report_.changed = true;
}

void Editor::refuse(RefusalReason reason, int vertex, const Vec2& X) {
  report_.refusals.push_back({reason, vertex, X});
}

void Editor::refuse_once(RefusalReason reason, const Vec2& X) {
  const auto is_same = [&](const Refusal& r) { return r.reason == reason; };
  if (std::none_of(report_.refusals.begin(), report_.refusals.end(), is_same)) refuse(reason, Mesh::none, X);
}

RemeshResult Editor::finish() && {
  report_.smallest_angle = smallest_material_angle(mesh());
  report_.after = report_.changed ? motion(cloth_) : report_.before;
  report_.momentum_change = report_.after.linear - report_.before.linear;
  if (!report_.changed) return {std::move(cloth_), std::move(report_)};
  const std::vector<int> renumbering = cloth_.mesh.compact().vertex;
  const int n = cloth_.mesh.n_vertices();
  drop_removed(cloth_.v, renumbering, n);
  drop_removed(cloth_.V, renumbering, n);
  drop_removed(cloth_.feature, renumbering, n);
  drop_removed(cloth_.pins, renumbering, n);
  report_.vertex_map.assign(renumbering.begin(), renumbering.begin() + n_given_);
  for (Refusal& refusal : report_.refusals)
    if (refusal.vertex >= 0) refusal.vertex = renumbering[refusal.vertex];
  return {std::move(cloth_), std::move(report_)};
}

}  // namespace crease
