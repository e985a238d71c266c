// SPDX-License-Identifier: MIT
#define CREASE_LANES 8
#include "element_kernels_impl.hpp"

namespace crease {

const ElementKernels& avx512_element_kernels() {
  return kernels;
}

}  // namespace crease
