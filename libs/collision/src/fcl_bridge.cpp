// SPDX-License-Identifier: MIT
#include "fcl_bridge.hpp"

#include <algorithm>
#include <array>
#include <exception>
#include <limits>
#include <utility>

// Its fit() must be known before the tree's templates that call it.
#include <fcl/math/bv/utility.h>

#include <fcl/geometry/bvh/BVH_model.h>
#include <fcl/geometry/shape/box.h>
#include <fcl/narrowphase/detail/gjk_solver_libccd.h>
#include <fcl/narrowphase/detail/primitive_shape_algorithm/triangle_distance.h>

#include "crease/base/require.hpp"
#include "crease/collision/separation.hpp"

// FCL's objects hold Eigen members. Built with AVX, ours would be laid out otherwise than those of the installed
// library, and nothing but wrong numbers would tell.
static_assert(EIGEN_MAX_STATIC_ALIGN_BYTES == 16,
              "build without -march flags: FCL's layout depends on Eigen's alignment");

namespace crease {

namespace {

// Faces seen in so many calls in a row are taken to last. A step that remeshes looks at the same faces twice, after
// remeshing and at the start of the next step; a tree built for those two would never pay.
constexpr int lasting = 4;

}  // namespace

struct FaceTree::Impl {
  std::vector<int> face_ids;                  // live faces, ascending; FCL's triangle k is face_ids[k]
  std::vector<std::array<int, 3>> triangles;  // their vertices
  std::size_t n_points = 0;
  int times_seen = 0;                                // calls in a row with these faces
  std::vector<fcl::AABBd> list;                      // one box a live face while there is no tree
  std::unique_ptr<fcl::BVHModel<fcl::AABBd>> model;  // never empty: FCL refuses an empty model

  bool take_faces(const Mesh& mesh);
  void fill_list(const Mesh& mesh);
  void build(const Mesh& mesh);
};

// Whether they are the same as before.
bool FaceTree::Impl::take_faces(const Mesh& mesh) {
  const auto n = static_cast<std::size_t>(mesh.n_faces());
  bool same = n == face_ids.size() && mesh.x.size() == n_points;
  face_ids.resize(n);
  triangles.resize(n);
  n_points = mesh.x.size();
  std::size_t k = 0;
  for (int f = 0; f < mesh.face_slots(); ++f) {
    if (!mesh.face_live(f)) continue;
    same = same && face_ids[k] == f && triangles[k] == mesh.face(f);
    face_ids[k] = f;
    triangles[k++] = mesh.face(f);
  }
  return same;
}

void FaceTree::Impl::fill_list(const Mesh& mesh) {
  list.clear();
  for (const auto& t : triangles) {
    fcl::AABBd box;
    for (const int i : t) box += mesh.x[static_cast<std::size_t>(i)];
    list.push_back(box);
  }
}

void FaceTree::Impl::build(const Mesh& mesh) {
  std::vector<fcl::Triangle> indices;
  indices.reserve(triangles.size());
  for (const auto& t : triangles) {
    indices.emplace_back(static_cast<std::size_t>(t[0]), static_cast<std::size_t>(t[1]),
                         static_cast<std::size_t>(t[2]));
  }
  list.clear();
  model = std::make_unique<fcl::BVHModel<fcl::AABBd>>();
  model->beginModel(static_cast<int>(indices.size()), static_cast<int>(n_points));
  model->addSubModel(mesh.x, indices);
  model->endModel();
}

FaceTree::FaceTree() : impl_(std::make_unique<Impl>()) {}
FaceTree::~FaceTree() = default;
FaceTree::FaceTree(FaceTree&&) noexcept = default;
FaceTree& FaceTree::operator=(FaceTree&&) noexcept = default;

void FaceTree::update(const Mesh& mesh) {
  impl_->times_seen = impl_->take_faces(mesh) ? std::min(impl_->times_seen + 1, lasting) : 1;
  if (impl_->times_seen < lasting || impl_->triangles.empty()) {
    impl_->model.reset();
    impl_->fill_list(mesh);
  } else if (!impl_->model) {
    impl_->build(mesh);
  } else {
    impl_->model->beginReplaceModel();
    impl_->model->replaceSubModel(mesh.x);
    impl_->model->endReplaceModel(/*refit=*/true, /*bottomup=*/true);
  }
}

std::vector<int> FaceTree::overlapping(const Eigen::AlignedBox3d& bounds) const {
  std::vector<int> found;
  if (bounds.isEmpty()) return found;
  const fcl::AABBd box(bounds.min(), bounds.max());
  for (std::size_t k = 0; k < impl_->list.size(); ++k) {
    if (impl_->list[k].overlap(box)) found.push_back(impl_->face_ids[k]);
  }
  if (!impl_->model) return found;
  std::vector<int> stack{0};
  while (!stack.empty()) {
    const auto& node = impl_->model->getBV(stack.back());
    stack.pop_back();
    if (!node.bv.overlap(box)) continue;
    if (node.isLeaf()) {
      found.push_back(impl_->face_ids[static_cast<std::size_t>(node.primitiveId())]);
    } else {
      stack.push_back(node.leftChild());
      stack.push_back(node.rightChild());
    }
  }
  std::sort(found.begin(), found.end());
  return found;
}

namespace {

std::optional<double> box_distance(const std::array<Vec3, 3>& triangle, const PosedObstacle& obstacle) {
  const fcl::Boxd box(2 * obstacle.shape->half_size);
  fcl::Transform3d pose = fcl::Transform3d::Identity();
  pose.linear() = obstacle.pose.rotation;
  pose.translation() = obstacle.pose.position;
  fcl::detail::GJKSolver_libccdd solver;
  solver.distance_tolerance = 1e-12;  // [m]
  solver.max_distance_iterations = 1000;
  double distance = 0;
  try {
    const bool apart =
        solver.shapeTriangleDistance(box, pose, triangle[0], triangle[1], triangle[2], &distance, nullptr, nullptr);
    return apart ? std::max(distance, 0.0) : 0.0;
  } catch (const std::exception&) {
    return std::nullopt;
  }
}

// The triangle against every one of the mesh; one that is wholly inside meets none of them.
double mesh_distance(const std::array<Vec3, 3>& triangle, const PosedObstacle& obstacle) {
  if (*signed_distance(*obstacle.shape, obstacle.pose, triangle[0]) <= 0) return 0;
  double nearest = std::numeric_limits<double>::infinity();
  for (const auto& t : obstacle.shape->triangles) {
    std::array<Vec3, 3> other;
    for (std::size_t k = 0; k < 3; ++k) other[k] = obstacle.pose.to_world(obstacle.shape->vertices[t[k]]);
    Vec3 p, q;
    nearest = std::min(nearest, fcl::detail::TriangleDistanced::triDistance(triangle[0], triangle[1], triangle[2],
                                                                            other[0], other[1], other[2], p, q));
  }
  return nearest;
}

}  // namespace

std::optional<double> triangle_distance(const std::array<Vec3, 3>& triangle, const PosedObstacle& obstacle) {
  require(obstacle.shape != nullptr, "triangle_distance: expected an obstacle with a shape");
  if (obstacle.shape->kind == ObstacleShape::Kind::Box) return box_distance(triangle, obstacle);
  if (obstacle.shape->kind == ObstacleShape::Kind::Mesh) return mesh_distance(triangle, obstacle);
  return std::nullopt;
}

}  // namespace crease
