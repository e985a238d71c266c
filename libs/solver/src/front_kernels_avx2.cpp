// SPDX-License-Identifier: MIT
#define CREASE_LANES 4
#include "front_kernels_impl.hpp"

namespace crease {

const FrontKernels& avx2_front_kernels() {
  static constexpr FrontKernels kernels = make_kernels("avx2");
  return kernels;
}

}  // namespace crease
