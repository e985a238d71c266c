// SPDX-License-Identifier: MIT
#pragma once

// What the benchmarks share: the clock, turns, and a matrix's graph of blocks.

#include <sys/resource.h>

#include <algorithm>
#include <ctime>
#include <functional>
#include <string>
#include <utility>
#include <vector>

#include "crease/solver/block_cholesky.hpp"

namespace crease {

inline double seconds_of(clockid_t clock) {
  timespec t{};
  clock_gettime(clock, &t);
  return static_cast<double>(t.tv_sec) + 1e-9 * static_cast<double>(t.tv_nsec);
}

/// Most memory that the process has had at once so far [MB].
inline double peak_memory() {
  rusage usage{};
  getrusage(RUSAGE_SELF, &usage);
  return 1e-3 * static_cast<double>(usage.ru_maxrss);
}

struct Timed {
  std::string name;
  std::function<void()> run;
  clockid_t clock = CLOCK_THREAD_CPUTIME_ID;
  std::vector<double> milliseconds = {};

  double median() {
    std::sort(milliseconds.begin(), milliseconds.end());
    return milliseconds[milliseconds.size() / 2];
  }
  double best() const { return *std::min_element(milliseconds.begin(), milliseconds.end()); }
};

/// Each in turn, until a second a candidate or so is spent.
inline void take_turns(std::vector<Timed>& candidates) {
  double spent = 0;
  const double budget = 0.4 * static_cast<double>(candidates.size());
  for (int turn = 0; turn < 5 || (turn < 400 && spent < budget); ++turn)
    for (Timed& timed : candidates) {
      const double start = seconds_of(timed.clock);
      timed.run();
      const double seconds = seconds_of(timed.clock) - start;
      if (turn > 0) timed.milliseconds.push_back(1e3 * seconds);  // the first touches fresh memory
      spent += seconds;
    }
}

/// Processor time of the busier of the two threads of a call, the caller being one of them; median [ms]. Unlike the
/// clock it tells what two threads are worth also where other work is on the cores.
inline double busier_thread(const std::function<void()>& call, int turns) {
  Timed timed{"", call};
  for (int turn = 0; turn <= turns; ++turn) {
    const double both = seconds_of(CLOCK_PROCESS_CPUTIME_ID), own = seconds_of(CLOCK_THREAD_CPUTIME_ID);
    call();
    const double caller = seconds_of(CLOCK_THREAD_CPUTIME_ID) - own;
    const double other = seconds_of(CLOCK_PROCESS_CPUTIME_ID) - both - caller;
    if (turn > 0) timed.milliseconds.push_back(1e3 * std::max(caller, other));
  }
  return timed.median();
}

/// @pre H stores every entry of its blocks
inline BlockGraph graph_of(const SparseMatrix& H, const std::vector<int>& starts) {
  BlockGraph graph;
  graph.starts = starts;
  std::vector<int> block_of(static_cast<std::size_t>(H.rows()));
  for (int k = 0; k < graph.n_blocks(); ++k)
    std::fill(block_of.begin() + starts[k], block_of.begin() + starts[k + 1], k);
  for (int k = 0; k < graph.n_blocks(); ++k) {
    for (SparseMatrix::InnerIterator entry(H, starts[k]); entry; ++entry)
      if (const int other = block_of[entry.row()];
          static_cast<int>(graph.inner.size()) == graph.outer.back() || graph.inner.back() != other)
        graph.inner.push_back(other);
    graph.outer.push_back(static_cast<int>(graph.inner.size()));
  }
  return graph;
}

}  // namespace crease
