// SPDX-License-Identifier: MIT
#pragma once

namespace crease {

/// One thread in OpenBLAS and OpenMP while it lives; the former setting returns with its end.
/// CHOLMOD 3 asks OpenMP for four threads in its supernodal code whatever the environment says, which costs a factor of
/// two on small fronts; OpenBLAS' threads gain nothing on them. One thread also gives the same bytes in every run.
class OneThread {
 public:
  OneThread();
  ~OneThread();
  OneThread(const OneThread&) = delete;
  OneThread& operator=(const OneThread&) = delete;

 private:
  int blas_threads_ = 0, omp_levels_ = 0;
};

}  // namespace crease
