// SPDX-License-Identifier: MIT
#define CREASE_LANES 2
#include "element_kernels_impl.hpp"

namespace crease {

const ElementKernels& generic_element_kernels() {
  return kernels;
}

}  // namespace crease
