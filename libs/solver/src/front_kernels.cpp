// SPDX-License-Identifier: MIT
#include "front_kernels.hpp"

#include "crease/base/require.hpp"
#include "crease/solver/block_cholesky.hpp"
#include "find_kernels.hpp"

namespace crease {

std::vector<FrontKernelSet> available_front_kernels() {
  std::vector<FrontKernelSet> found{FrontKernelSet::Generic};
#if defined(__x86_64__)
  const bool avx2 = __builtin_cpu_supports("avx2") && __builtin_cpu_supports("fma");
  if (avx2) found.push_back(FrontKernelSet::Avx2);
  if (avx2 && __builtin_cpu_supports("avx512f")) found.push_back(FrontKernelSet::Avx512);
#endif
  return found;
}

const char* to_string(FrontKernelSet kernels) {
  switch (kernels) {
    case FrontKernelSet::Best:
      return "best";
    case FrontKernelSet::Generic:
      return "generic";
    case FrontKernelSet::Avx2:
      return "AVX2";
    case FrontKernelSet::Avx512:
      return "AVX-512";
  }
  return "unknown";
}

const FrontKernels& find_front_kernels(FrontKernelSet set) {
  const std::vector<FrontKernelSet> available = available_front_kernels();
  if (set == FrontKernelSet::Best) set = available.back();
  bool found = false;
  for (const FrontKernelSet other : available) found = found || other == set;
  require(found, std::string("make_block_cholesky: expected kernels of this processor, got ") + to_string(set));
#if defined(__x86_64__)
  if (set == FrontKernelSet::Avx2) return avx2_front_kernels();
  if (set == FrontKernelSet::Avx512) return avx512_front_kernels();
#endif
  return generic_front_kernels();
}

}  // namespace crease
