// SPDX-License-Identifier: MIT
#include "element_kernels.hpp"

#include <algorithm>

#include "crease/base/require.hpp"
#include "element.hpp"

namespace crease {

std::vector<ElementKernelSet> available_element_kernels() {
  std::vector<ElementKernelSet> found{ElementKernelSet::Generic};
#if defined(__x86_64__)
  const bool avx2 = __builtin_cpu_supports("avx2");
  if (avx2) found.push_back(ElementKernelSet::Avx2);
  if (avx2 && __builtin_cpu_supports("avx512f")) found.push_back(ElementKernelSet::Avx512);
#endif
  return found;
}

const ElementKernels& find_element_kernels(ElementKernelSet set) {
  const std::vector<ElementKernelSet> available = available_element_kernels();
  if (set == ElementKernelSet::Best) set = available.back();
  require(std::find(available.begin(), available.end(), set) != available.end(),
          "Assembler: expected kernels that this processor runs");
#if defined(__x86_64__)
  if (set == ElementKernelSet::Avx2) return avx2_element_kernels();
  if (set == ElementKernelSet::Avx512) return avx512_element_kernels();
#endif
  return generic_element_kernels();
}

}  // namespace crease
