// SPDX-License-Identifier: MIT
#include <algorithm>
#include <filesystem>
#include <fstream>
#include <iterator>

#include <gtest/gtest.h>

#include "support/mesh_edits.hpp"

namespace crease {
namespace {

TEST(Edits, KeepEveryInvariant) {
  EXPECT_EQ(support::run_random_edits(10'000), std::nullopt);
}

// What the fuzzer has found worth keeping, without the fuzzer.
TEST(Edits, KeepEveryInvariantOnTheCorpus) {
  std::vector<std::filesystem::path> files;
  for (const auto& entry : std::filesystem::directory_iterator(CREASE_CORPUS)) files.push_back(entry.path());
  std::sort(files.begin(), files.end());
  ASSERT_FALSE(files.empty());
  for (const auto& file : files) {
    SCOPED_TRACE(file.filename().string());
    std::ifstream in(file, std::ios::binary);
    const std::vector<char> text{std::istreambuf_iterator<char>(in), {}};
    const std::vector<std::uint8_t> bytes(text.begin(), text.end());
    EXPECT_EQ(support::run_edits(bytes), std::nullopt);
  }
}

}  // namespace
}  // namespace crease
