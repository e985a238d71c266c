// SPDX-License-Identifier: MIT
#include <cstdio>

#include "support/mesh_edits.hpp"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  if (const auto trouble = crease::support::run_edits({data, size})) {
    std::fprintf(stderr, "%s\n", trouble->c_str());
    __builtin_trap();
  }
  return 0;
}
