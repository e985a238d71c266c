// SPDX-License-Identifier: MIT
#define CREASE_LANES 8
#include "front_kernels_impl.hpp"

namespace crease {

const FrontKernels& avx512_front_kernels() {
  static constexpr FrontKernels kernels = make_kernels("avx512");
  return kernels;
}

}  // namespace crease
