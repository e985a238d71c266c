// SPDX-License-Identifier: MIT
#include "crease/collision/detect.hpp"

#include <algorithm>
#include <cmath>

#include "crease/base/require.hpp"
#include "fcl_bridge.hpp"
#include "narrow_phase.hpp"

namespace crease {
namespace {

// Added to the broad phase's bounds [m], so that round-off in them never decides about a contact.
constexpr double round_off = 1e-8;

// What the broad phase leaves over of the cloth, each list ascending.
struct Candidates {
  std::vector<int> vertices, edges, faces;
};

void sort_unique(std::vector<int>& ids) {
  std::sort(ids.begin(), ids.end());
  ids.erase(std::unique(ids.begin(), ids.end()), ids.end());
}

Candidates around(const Mesh& mesh, std::vector<int> faces) {
  Candidates found;
  found.vertices.reserve(3 * faces.size());
  found.edges.reserve(3 * faces.size());
  for (const int f : faces) {
    for (int k = 0; k < 3; ++k) {
      found.vertices.push_back(mesh.face(f)[static_cast<std::size_t>(k)]);
      found.edges.push_back(mesh.edge_of(3 * f + k));
    }
  }
  sort_unique(found.vertices);
  sort_unique(found.edges);
  found.faces = std::move(faces);
  return found;
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
  return options.threshold + options.look_ahead * std::sqrt(speed2);
}

Eigen::AlignedBox3d grown(const Eigen::AlignedBox3d& bounds, double by) {
  const Vec3 margin = Vec3::Constant(by + round_off);
  return {bounds.min() - margin, bounds.max() + margin};
}

void check(const Cloth& cloth, std::span<const PosedObstacle> obstacles, const DetectOptions& options) {
  require(std::isfinite(options.threshold) && options.threshold >= 0, "detect: expected a finite threshold >= 0");
  require(std::isfinite(options.look_ahead) && options.look_ahead >= 0, "detect: expected a finite look-ahead >= 0");
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

// In the order the header promises; features in the outer loops.
void append_contacts(const Cloth& cloth, const PlacedObstacle& obstacle, const Candidates& candidates,
                     const DetectOptions& options, std::vector<Contact>& contacts) {
  const NarrowPhase narrow(cloth, obstacle, options);
  const auto append = [&](std::optional<Contact>&& contact) {
    if (contact) contacts.push_back(*contact);
  };
  if (!obstacle.faces.empty()) {
    for (const int vertex : candidates.vertices) append(narrow.vertex_face(vertex));
  }
  for (int e = 0; e < static_cast<int>(obstacle.edges.size()); ++e) {
    for (const int halfedge : candidates.edges) append(narrow.edge_edge(halfedge, e));
  }
  for (int c = 0; c < static_cast<int>(obstacle.corners.size()); ++c) {
    for (const int face : candidates.faces) append(narrow.corner_face(c, face));
  }
}

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
    const double reach = largest_reach(cloth, obstacle.source.pose, options);
    std::vector<int> faces = impl_->tree.overlapping(grown(obstacle.bounds, reach));
    if (faces.empty()) continue;
    append_contacts(cloth, obstacle, around(cloth.mesh, std::move(faces)), options, contacts);
  }
  return contacts;
}

}  // namespace crease
