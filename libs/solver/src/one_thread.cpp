// SPDX-License-Identifier: MIT
#include "one_thread.hpp"

#include <dlfcn.h>

namespace crease {
namespace {

using Get = int (*)();
using Set = void (*)(int);

/// Looked up by name: both libraries come with CHOLMOD or not at all (another BLAS, another build), and neither is a
/// dependency of ours.
template <class Function>
Function find_function(const char* name) {
  return reinterpret_cast<Function>(dlsym(RTLD_DEFAULT, name));
}

struct Switches {
  Get blas_get = find_function<Get>("openblas_get_num_threads");
  Set blas_set = find_function<Set>("openblas_set_num_threads");
  Get omp_get = find_function<Get>("omp_get_max_active_levels");
  Set omp_set = find_function<Set>("omp_set_max_active_levels");
};

const Switches& switches() {
  static const Switches found;
  return found;
}

}  // namespace

OneThread::OneThread() {
  const Switches& s = switches();
  if (s.blas_get && s.blas_set && (blas_threads_ = s.blas_get()) > 1) s.blas_set(1);
  if (s.omp_get && s.omp_set && (omp_levels_ = s.omp_get()) > 0) s.omp_set(0);
}

OneThread::~OneThread() {
  if (blas_threads_ > 1) switches().blas_set(blas_threads_);
  if (omp_levels_ > 0) switches().omp_set(omp_levels_);
}

}  // namespace crease
