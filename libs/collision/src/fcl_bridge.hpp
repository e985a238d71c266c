// SPDX-License-Identifier: MIT
#pragma once

#include <memory>
#include <vector>

#include <Eigen/Geometry>

#include "crease/geometry/mesh.hpp"

namespace crease {

/// The only door to FCL: its types, its exceptions and its messages stay behind it.

/// Axis-aligned boxes over the faces of a mesh, in FCL's tree as soon as that pays: building it costs about a hundred
/// scans of the plain list of boxes. So new faces are kept as a list, and the tree is built when they prove to last.
/// Both hold the same boxes and find the same faces.
class FaceTree {
 public:
  FaceTree();
  ~FaceTree();
  FaceTree(FaceTree&&) noexcept;
  FaceTree& operator=(FaceTree&&) noexcept;

  /// Takes over the world positions: refits the boxes from the leaves up while the faces are the same, else builds
  /// anew.
  /// @pre finite positions of all live vertices
  void update(const Mesh& mesh);

  /// Faces whose box meets `bounds`, ascending.
  std::vector<int> overlapping(const Eigen::AlignedBox3d& bounds) const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace crease
