// SPDX-License-Identifier: MIT
#define CREASE_LANES 2
#include "front_kernels_impl.hpp"

namespace crease {

const FrontKernels& generic_front_kernels() {
  static constexpr FrontKernels kernels = make_kernels("generic");
  return kernels;
}

}  // namespace crease
