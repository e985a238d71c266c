// SPDX-License-Identifier: MIT
#include "crease/collision/detect.hpp"

#include <algorithm>
#include <cmath>

#include "crease/base/require.hpp"
#include "fcl_bridge.hpp"
#include "narrow_phase.hpp"
#include "sweep.hpp"

namespace crease {
namespace {

// Added to the broad phase's bounds [m], so that round-off in them never decides about a contact.
constexpr double round_off = 1e-8;

void sort_unique(std::vector<int>& ids) {
  std::sort(ids.begin(), ids.end());
  ids.erase(std::unique(ids.begin(), ids.end()), ids.end());
}

// Ascending, each once.
std::vector<int> vertices_of(const Mesh& mesh, std::span<const int> faces) {
  std::vector<char> marked(mesh.X.size(), 0);
  for (const int f : faces) {
    for (const int i : mesh.face(f)) marked[static_cast<std::size_t>(i)] = 1;
  }
  std::vector<int> vertices;
  for (int i = 0; i < mesh.vertex_slots(); ++i) {
    if (marked[static_cast<std::size_t>(i)]) vertices.push_back(i);
  }
  return vertices;
}

// Canonical half-edges, ascending, each once.
std::vector<int> edges_of(const Mesh& mesh, std::span<const int> faces) {
  std::vector<int> edges;
  for (const int f : faces) {
    for (int k = 0; k < 3; ++k) edges.push_back(mesh.edge_of(3 * f + k));
  }
  sort_unique(edges);
  return edges;
}

// Faces that reach deeper than `depth` below every face of the solid. All others, and their edges, touch a sharp
// feature only near it: their penetrations are bounded by shallow_bound.
std::vector<int> deep_faces(const Mesh& mesh, const PlacedObstacle& obstacle, std::span<const int> faces,
                            std::span<const int> vertices, double depth) {
  if (obstacle.faces.empty()) return {};
  CREASE_ASSERT(obstacle.faces.size() <= 32);
  std::vector<unsigned> above(mesh.X.size(), 0);  // bit k: not deeper than `depth` below face k
  for (const int i : vertices) {
    const auto v = static_cast<std::size_t>(i);
    for (std::size_t k = 0; k < obstacle.faces.size(); ++k) {
      const FacePlane& face = obstacle.faces[k];
      if (face.offset - face.normal.dot(mesh.x[v]) <= depth) above[v] |= 1u << k;
    }
  }
  std::vector<int> deep;
  for (const int f : faces) {
    const auto& [a, b, c] = mesh.face(f);
    const auto bits = [&](int i) { return above[static_cast<std::size_t>(i)]; };
    if ((bits(a) & bits(b) & bits(c)) == 0) deep.push_back(f);
  }
  return deep;
}

// Nothing of the cloth beyond this distance of the obstacle is in reach: motion is affine on every face, so that its
// fastest vertex is its fastest point.
double largest_reach(const Cloth& cloth, const Pose& pose, const DetectOptions& options) {
  double speed2 = 0;
  for (int i = 0; options.look_ahead > 0 && i < cloth.mesh.vertex_slots(); ++i) {
    const auto k = static_cast<std::size_t>(i);
    if (cloth.mesh.vertex_live(i)) {
      speed2 = std::max(speed2, (cloth.v[k] - pose.velocity_at(cloth.mesh.x[k])).squaredNorm());
    }
  }
  return options.threshold + options.margin + options.look_ahead * std::sqrt(speed2);
}

Eigen::AlignedBox3d grown(const Eigen::AlignedBox3d& bounds, double by) {
  const Vec3 margin = Vec3::Constant(by + round_off);
  return {bounds.min() - margin, bounds.max() + margin};
}

void check(const Cloth& cloth, std::span<const PosedObstacle> obstacles, const DetectOptions& options) {
  require(std::isfinite(options.threshold) && options.threshold >= 0, "detect: expected a finite threshold >= 0");
  require(std::isfinite(options.look_ahead) && options.look_ahead >= 0, "detect: expected a finite look-ahead >= 0");
  require(std::isfinite(options.margin) && options.margin >= 0, "detect: expected a finite margin >= 0");
  for (int i = 0; i < cloth.mesh.vertex_slots(); ++i) {
    const auto k = static_cast<std::size_t>(i);
    require(!cloth.mesh.vertex_live(i) || (cloth.mesh.x[k].allFinite() && cloth.v[k].allFinite()),
            "detect: expected finite positions and velocities");
  }
  for (const PosedObstacle& obstacle : obstacles) {
    require(obstacle.shape != nullptr, "detect: expected obstacles with a shape");
    require(obstacle.pose.position.allFinite() && obstacle.pose.rotation.allFinite(), "detect: expected finite poses");
  }
}

// A contact of the end of a motion as one of its beginning. Its weights, point and normal are what a row needs that is
// linear in the velocity; those of the beginning may not even be there, as where an edge of the cloth reaches a sharp
// edge's end only under way.
Contact of_beginning(Contact contact, const Cloth& cloth, const Pose& start, const Pose& end) {
  contact.point = start.to_world(end.to_local(contact.point));
  contact.velocity = start.velocity_at(contact.point);
  Vec3 x = Vec3::Zero();
  for (int k = 0; k < 3 && k < contact.n_vertices; ++k) x += contact.weights[k] * cloth.mesh.x[contact.vertices[k]];
  contact.distance = contact.normal.dot(x - contact.point);
  contact.normal = start.rotation * (end.rotation.transpose() * contact.normal);
  return contact;
}

// One obstacle's contacts in the order the header promises. The tree is asked once for the whole obstacle and, for what
// is left of the cloth, once for each sharp feature.
class ObstacleSearch {
 public:
  ObstacleSearch(const Cloth& cloth, const FaceTree& tree, const PlacedObstacle& obstacle, const DetectOptions& options)
      : mesh_(cloth.mesh),
        tree_(tree),
        obstacle_(obstacle),
        options_(options),
        narrow_(cloth, obstacle, options),
        reach_(largest_reach(cloth, obstacle.source.pose, options)) {}

  void append_to(std::vector<Contact>& contacts) const {
    const std::vector<int> faces = tree_.overlapping(grown(obstacle_.bounds, reach_));
    if (faces.empty()) return;
    const auto append = [&](const std::optional<Contact>& contact) {
      if (contact) contacts.push_back(*contact);
    };
    const std::vector<int> vertices = vertices_of(mesh_, faces);
    for (const int vertex : vertices)
      for (const Contact& contact : narrow_.vertex_face(vertex)) contacts.push_back(contact);
    const std::vector<int> deep = deep_faces(mesh_, obstacle_, faces, vertices, options_.threshold);
    const auto append_edges = [&](const std::vector<PlacedEdge>& edges, FeatureKind kind) {
      for (int e = 0; e < static_cast<int>(edges.size()); ++e) {
        const PlacedEdge& edge = edges[static_cast<std::size_t>(e)];
        Eigen::AlignedBox3d bounds(edge.a);
        bounds.extend(edge.a + edge.length * edge.tangent);
        for (const int halfedge : edges_of(mesh_, faces_near(bounds, deep)))
          append(narrow_.edge_edge(halfedge, edge, {obstacle_.index, kind, e}));
      }
    };
    append_edges(obstacle_.edges, FeatureKind::Edge);
    append_edges(obstacle_.blunt_edges, FeatureKind::None);
    for (int c = 0; c < static_cast<int>(obstacle_.corners.size()); ++c) {
      const Eigen::AlignedBox3d bounds(obstacle_.corners[static_cast<std::size_t>(c)].position);
      for (const int face : faces_near(bounds, deep)) append(narrow_.corner_face(c, face));
    }
  }

 private:
  std::vector<int> faces_near(const Eigen::AlignedBox3d& feature, std::span<const int> deep) const {
    std::vector<int> faces = tree_.overlapping(grown(feature, shallow_bound * reach_));
    if (deep.empty()) return faces;
    faces.insert(faces.end(), deep.begin(), deep.end());
    sort_unique(faces);
    return faces;
  }

  const Mesh& mesh_;
  const FaceTree& tree_;
  const PlacedObstacle& obstacle_;
  const DetectOptions& options_;
  NarrowPhase narrow_;
  double reach_;
};

}  // namespace

struct Detector::Impl {
  FaceTree tree;
};

Detector::Detector() : impl_(std::make_unique<Impl>()) {}
Detector::~Detector() = default;
Detector::Detector(Detector&&) noexcept = default;
Detector& Detector::operator=(Detector&&) noexcept = default;

std::vector<Contact> Detector::detect(const Cloth& cloth, std::span<const PosedObstacle> obstacles,
                                      const DetectOptions& options) {
  check(cloth, obstacles, options);
  std::vector<Contact> contacts;
  if (obstacles.empty()) return contacts;
  impl_->tree.update(cloth.mesh);
  for (int o = 0; o < static_cast<int>(obstacles.size()); ++o) {
    const PlacedObstacle obstacle = place(obstacles[static_cast<std::size_t>(o)], o);
    ObstacleSearch(cloth, impl_->tree, obstacle, options).append_to(contacts);
  }
  return contacts;
}

std::vector<Contact> Detector::foresee(const Cloth& cloth, std::span<const PosedObstacle> obstacles, double h,
                                       double depth) {
  require(std::isfinite(h) && h > 0 && std::isfinite(depth) && depth >= 0,
          "foresee: expected a finite h > 0 and a finite depth >= 0");
  check(cloth, obstacles, {});
  Cloth moved = cloth;
  for (std::size_t i = 0; i < moved.mesh.x.size(); ++i) moved.mesh.x[i] += h * moved.v[i];
  std::vector<PosedObstacle> after(obstacles.begin(), obstacles.end());
  for (PosedObstacle& obstacle : after) obstacle.pose = pose_after(obstacle.pose, h);
  std::vector<Contact> contacts = detect(moved, after, {.threshold = depth});
  std::erase_if(contacts, [depth](const Contact& contact) { return contact.distance >= -depth; });
  for (Contact& contact : contacts)
    contact = of_beginning(contact, cloth, obstacles[contact.obstacle].pose, after[contact.obstacle].pose);
  for (int o = 0; o < static_cast<int>(obstacles.size()); ++o) {
    const std::vector<Contact> passed = passed_features(cloth, place(obstacles[o], o), h, depth);
    contacts.insert(contacts.end(), passed.begin(), passed.end());
  }
  return contacts;
}

}  // namespace crease
