// SPDX-License-Identifier: MIT
#pragma once

#include <vector>

#include "crease/remesh/remesh.hpp"
#include "metric.hpp"

namespace crease {

/// sizing_field() in the form that the remesher works with.
std::vector<Tensor> vertex_sizes(const Cloth& cloth, const AdaptOptions& options);

/// Raises the tensors until the metric's edge length grows by no more than a fixed factor from one edge to the next.
void limit_gradation(const Mesh& mesh, std::vector<Tensor>& tensors);

}  // namespace crease
