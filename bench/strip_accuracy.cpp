// SPDX-License-Identifier: MIT
//
// Error against run time of the strip that slides over a table's edge, whose exact solution is known.
#include <chrono>
#include <cstdio>

#include "support/strip_run.hpp"

int main() {
  using namespace crease;
  using namespace crease::testing;
  std::printf(
      "found by    n      h [s]  position [L]  reaction [rho g L W]  lift-off - exact [m]  cut steps  time [s]\n");
  for (const bool mark_fold : {true, false})
    for (const int n : {10, 20, 40})
      for (const double h : {4e-3, 2e-3, 1e-3, 5e-4}) {
        StripSetup setup{Strip{}};
        setup.cells = {n, std::max(2, n / 5)};
        setup.mark_fold = mark_fold;
        const auto start = std::chrono::steady_clock::now();
        const StripRun run = run_strip(setup, h, 0.6);
        const std::chrono::duration<double> wall = std::chrono::steady_clock::now() - start;
        std::printf("%-9s %3d %10.4g %13.2e %21.2e %21.2e %10d %9.2f\n", mark_fold ? "given" : "contact", n, h,
                    shifted_error(run, setup.strip, h), reaction_error(run, setup.strip, h),
                    run.lift_overhang - setup.strip.lift_overhang(), run.cuts, wall.count());
      }
}
