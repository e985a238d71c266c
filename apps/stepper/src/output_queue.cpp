// SPDX-License-Identifier: MIT
#include "output_queue.hpp"

#include <csignal>
#include <system_error>
#include <utility>

namespace crease {
namespace {

/// Of frames and checkpoints, which may be large; as many as a disk needs for a hitch.
constexpr std::size_t most_waiting = 8;

}  // namespace

OutputQueue::OutputQueue() {
  // Signals are for the thread that takes the steps: a new one inherits what is blocked here.
  sigset_t all, before;
  sigfillset(&all);
  pthread_sigmask(SIG_SETMASK, &all, &before);
  try {
    thread_ = std::thread([this] { serve(); });
  } catch (const std::system_error&) {  // no more threads to be had
  }
  pthread_sigmask(SIG_SETMASK, &before, nullptr);
}

OutputQueue::~OutputQueue() {
  if (!thread_.joinable()) return;
  {
    const std::lock_guard lock(mutex_);
    over_ = true;
  }
  given_.notify_one();
  thread_.join();
}

void OutputQueue::push(std::function<void()> job) {
  if (!thread_.joinable()) return job();
  std::unique_lock lock(mutex_);
  wait_until_fewer_than(most_waiting, lock);
  jobs_.push_back(std::move(job));
  given_.notify_one();
}

void OutputQueue::finish() {
  std::unique_lock lock(mutex_);
  wait_until_fewer_than(1, lock);
}

void OutputQueue::wait_until_fewer_than(std::size_t most, std::unique_lock<std::mutex>& lock) {
  done_.wait(lock, [&] { return jobs_.size() < most; });  // a failure leaves none
  if (failure_) std::rethrow_exception(failure_);
}

void OutputQueue::serve() {
  std::unique_lock lock(mutex_);
  while (true) {
    given_.wait(lock, [this] { return over_ || !jobs_.empty(); });
    if (jobs_.empty()) return;
    const std::function<void()>& job = jobs_.front();  // stays where it is while others are added
    std::exception_ptr failure;
    lock.unlock();
    try {
      job();
    } catch (...) {
      failure = std::current_exception();
    }
    lock.lock();
    jobs_.pop_front();
    if (failure) {
      failure_ = failure;
      jobs_.clear();
    }
    done_.notify_all();
  }
}

}  // namespace crease
