// SPDX-License-Identifier: MIT
#pragma once

#include <memory>
#include <vector>

#include <Eigen/Geometry>

#include "crease/geometry/mesh.hpp"

namespace crease {

/// The only door to FCL: its types, its exceptions and its messages stay behind it.

/// FCL's tree of axis-aligned boxes over the faces of a mesh.
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
