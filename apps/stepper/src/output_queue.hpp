// SPDX-License-Identifier: MIT
#pragma once

#include <condition_variable>
#include <deque>
#include <exception>
#include <functional>
#include <mutex>
#include <thread>

namespace crease {

/// Does what waits for the disk, job by job in the order given, in a thread of its own, so that no step waits for it.
/// After a job that throws none is done any more.
class OutputQueue {
 public:
  OutputQueue();
  ~OutputQueue();  ///< does what is left
  OutputQueue(const OutputQueue&) = delete;
  OutputQueue& operator=(const OutputQueue&) = delete;

  /// Waits only where many are waiting already. Throws what an earlier job has thrown.
  void push(std::function<void()> job);

  /// Returns when all are done. Throws what one of them has thrown.
  void finish();

 private:
  void serve();
  void wait_until_fewer_than(std::size_t most, std::unique_lock<std::mutex>& lock);

  std::mutex mutex_;
  std::condition_variable given_, done_;
  // Guarded by the mutex:
  std::deque<std::function<void()>> jobs_;  ///< the first is under way
  std::exception_ptr failure_;
  bool over_ = false;
  std::thread thread_;  ///< none where none is to be had: push() does the job itself
};

}  // namespace crease
