// SPDX-License-Identifier: MIT
#include "crease/base/workers.hpp"

#include <condition_variable>
#include <mutex>
#include <string>
#include <system_error>
#include <thread>
#include <vector>

#include "crease/base/require.hpp"

namespace crease {

struct Workers::Impl {
  int n_threads = 1;
  std::mutex mutex;
  std::condition_variable work, rest;  ///< there is something to do; everything is done
  // Guarded by the mutex:
  const std::function<void(int)>* job = nullptr;
  int next = 0, n_jobs = 0, unfinished = 0;
  bool over = false;
  std::vector<std::thread> threads;

  void start();
  void take_jobs(std::unique_lock<std::mutex>& lock);
  void serve();
};

void Workers::Impl::start() {
  try {
    while (static_cast<int>(threads.size()) + 1 < n_threads) threads.emplace_back([this] { serve(); });
  } catch (const std::system_error&) {
    n_threads = static_cast<int>(threads.size()) + 1;  // no more threads to be had
  }
}

/// Until none is left to be taken.
void Workers::Impl::take_jobs(std::unique_lock<std::mutex>& lock) {
  while (next < n_jobs) {
    const int mine = next++;
    lock.unlock();
    (*job)(mine);
    lock.lock();
    if (--unfinished == 0) rest.notify_one();
  }
}

void Workers::Impl::serve() {
  std::unique_lock lock(mutex);
  while (!over) {
    take_jobs(lock);
    work.wait(lock, [this] { return over || next < n_jobs; });
  }
}

Workers::Workers(int n_threads) : impl_(std::make_unique<Impl>()) {
  require(n_threads >= 1, "Workers: expected at least one thread, got " + std::to_string(n_threads));
  impl_->n_threads = n_threads;
}

Workers::~Workers() {
  if (!impl_) return;
  {
    const std::lock_guard lock(impl_->mutex);
    impl_->over = true;
  }
  impl_->work.notify_all();
  for (std::thread& thread : impl_->threads) thread.join();
}
Workers::Workers(Workers&&) noexcept = default;

void Workers::run(int n_jobs, const std::function<void(int)>& job) {
  Impl& impl = *impl_;
  if (n_jobs > 1) impl.start();
  std::unique_lock lock(impl.mutex);
  impl.job = &job;
  impl.next = 0;
  impl.n_jobs = impl.unfinished = n_jobs;
  if (n_jobs > 1) impl.work.notify_all();
  impl.take_jobs(lock);
  impl.rest.wait(lock, [&impl] { return impl.unfinished == 0; });
}

}  // namespace crease
