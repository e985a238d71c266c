// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <memory>
#include <new>

namespace crease {

/// Uninitialised doubles on a cache line boundary, which vector loads want.
class AlignedBuffer {
 public:
  /// What it held is lost if it has to grow.
  void reserve(std::size_t size) {
    if (size <= size_) return;
    data_.reset();
    size_ = 0;
    data_.reset(static_cast<double*>(::operator new(size * sizeof(double), alignment)));
    size_ = size;
  }
  double* data() const { return data_.get(); }

 private:
  static constexpr std::align_val_t alignment{64};
  struct Delete {
    void operator()(double* p) const { ::operator delete(p, alignment); }
  };
  std::unique_ptr<double, Delete> data_;
  std::size_t size_ = 0;
};

}  // namespace crease
