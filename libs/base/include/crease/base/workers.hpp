// SPDX-License-Identifier: MIT
#pragma once

#include <functional>
#include <memory>

namespace crease {

/// Threads that are kept, for jobs far shorter than it takes to start one. They sleep between runs.
class Workers {
 public:
  /// @param n_threads  >= 1, of which the caller of run() is one; the others start with the first run that has work for
  /// them
  explicit Workers(int n_threads);
  ~Workers();
  Workers(Workers&&) noexcept;

  /// Calls job(0) .. job(n_jobs - 1), each once, and returns when all are done. Whoever is free takes the next one:
  /// where no thread wakes up in time, or none is to be had, the caller does them all.
  /// @param job  must not throw, nor call run()
  void run(int n_jobs, const std::function<void(int)>& job);

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace crease
