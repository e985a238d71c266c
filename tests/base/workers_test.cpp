// SPDX-License-Identifier: MIT
#include "crease/base/workers.hpp"

#include <gtest/gtest.h>

#include <atomic>
#include <chrono>
#include <stdexcept>
#include <thread>
#include <utility>
#include <vector>

namespace crease {
namespace {

TEST(Workers, DoEveryJobOnceAndAreDoneOnReturn) {
  for (const int n_threads : {1, 2, 5}) {
    Workers workers(n_threads);
    for (int turn = 0; turn < 300; ++turn)
      for (const int n_jobs : {0, 1, 2, 3, 17}) {
        std::vector<int> done(static_cast<std::size_t>(n_jobs),
                              0);  // plain: the return has to order what the jobs wrote
        workers.run(n_jobs, [&](int k) { ++done[k]; });
        ASSERT_EQ(done, std::vector<int>(static_cast<std::size_t>(n_jobs), 1)) << n_threads << " threads";
      }
  }
}

TEST(Workers, ShareTheJobsOut) {
  Workers workers(2);
  std::atomic<int> begun = 0;
  // Each waits for the other to begin; as long as it takes a busy machine to wake a thread, but not for ever.
  const auto deadline = std::chrono::steady_clock::now() + std::chrono::minutes(1);
  workers.run(2, [&](int) {
    ++begun;
    while (begun < 2 && std::chrono::steady_clock::now() < deadline) std::this_thread::yield();
    EXPECT_EQ(begun, 2);
  });
}

TEST(Workers, MayBeMovedAndNeedNoRun) {
  Workers idle(3);
  Workers workers(2);
  workers.run(2, [](int) {});
  Workers moved = std::move(workers);
  std::atomic<int> sum = 0;
  moved.run(10, [&](int k) { sum += k; });
  EXPECT_EQ(sum, 45);
}

TEST(Workers, RefuseToBeNone) {
  EXPECT_THROW(Workers(0), std::invalid_argument);
}

}  // namespace
}  // namespace crease
