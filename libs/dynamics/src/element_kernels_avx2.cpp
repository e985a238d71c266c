// SPDX-License-Identifier: MIT
#define CREASE_LANES 4
#include "element_kernels_impl.hpp"

namespace crease {

const ElementKernels& avx2_element_kernels() {
  return kernels;
}

}  // namespace crease
