// SPDX-License-Identifier: MIT
//
// What a factorisation costs: ours, under every set of kernels, against CHOLMOD's, on the matrix of one implicit step
// of a sheet that hangs over a table's edge. All take turns in one process, one thread, and the processor time of that
// thread is counted, medians: the machine drifts by more than what is to be told apart.
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <ctime>
#include <functional>
#include <string>
#include <vector>

#include "hanging_sheet.hpp"
#include "measure.hpp"

namespace crease {
namespace {

void check(bool done, const char* what) {
  if (done) return;
  std::fprintf(stderr, "factor_benchmark: %s failed\n", what);
  std::exit(1);
}

void measure(int cells) {
  const HangingSheet problem = make_hanging_sheet(cells);
  const int n = problem.graph.n_unknowns();
  std::vector<CholeskyOptions> options;
  std::vector<std::string> names;
  std::vector<FrontKernelSet> kernels = available_front_kernels();
  std::reverse(kernels.begin(), kernels.end());
  for (const FrontKernelSet set : kernels)
    options.push_back({CholeskyMethod::Multifrontal, set}), names.push_back(to_string(set));
  options.push_back({CholeskyMethod::Cholmod, FrontKernelSet::Best});
  names.emplace_back("CHOLMOD");
  std::vector<std::unique_ptr<BlockCholesky>> factor;
  for (const CholeskyOptions& option : options) {
    factor.push_back(make_block_cholesky(option));
    check(factor.back()->analyze(problem.graph), "analyze");
  }
  const std::vector<int> order = factor[0]->order();
  const double flops = factor.back()->cost().flops;
  std::printf("\n%d faces, %d unknowns (%d EOL vertices, %d held), %.3g entries in L, %.3g flops (ours %.3g)\n\n",
              problem.n_faces, n, problem.n_eol, problem.n_held, factor.back()->cost().entries, flops,
              factor[0]->cost().flops);
  std::vector<Timed> timed;
  const MatX b = MatX::Random(n, 1);
  MatX columns = MatX::Zero(n, 24);
  for (int j = 0; j < columns.cols(); ++j) {
    const int block = static_cast<int>((static_cast<long long>(j) * 7919) % problem.graph.n_blocks());
    for (int at = problem.graph.outer[block]; at < problem.graph.outer[block + 1]; ++at)
      columns.col(j).segment(problem.graph.starts[problem.graph.inner[at]], 3).setOnes();
  }
  for (std::size_t k = 0; k < factor.size(); ++k) {
    BlockCholesky& f = *factor[k];
    timed.push_back({"held", [&] { check(f.factorize(problem.H, problem.held, problem.lift), "factorize"); }});
    timed.push_back({"free", [&] { check(f.factorize(problem.H, {}, problem.lift), "factorize"); }});
    timed.push_back({"solve", [&] { f.solve(b); }});
    timed.push_back({"batch", [&] { f.forward(columns); }});
  }
  const auto own = make_block_cholesky();
  timed.push_back({"", [&] { check(own->analyze(problem.graph), "analyze"); }});
  timed.push_back({"", [&] { check(own->analyze(problem.graph, order), "analyze"); }});
  const auto dissected = make_block_cholesky();
  const auto dissect = [&] { return make_block_order(problem.graph, BlockOrdering::NestedDissection); };
  check(dissected->analyze(problem.graph, dissect()), "analyze");
  const double dissected_flops = dissected->cost().flops;
  timed.push_back({"", [&] { dissect(); }});
  timed.push_back({"", [&] { check(dissected->factorize(problem.H, {}, problem.lift), "factorize"); }});
  std::vector<std::unique_ptr<BlockCholesky>> threaded;
  for (const int threads : {1, 2}) {
    threaded.push_back(make_block_cholesky({.threads = threads}));
    BlockCholesky& f = *threaded.back();
    check(f.analyze(problem.graph), "analyze");
    timed.push_back({"", [&] { check(f.factorize(problem.H, {}, problem.lift), "factorize"); }, CLOCK_MONOTONIC});
  }
  take_turns(timed);
  std::printf(
      "| | factor, contacts held [ms] | factor, all free [ms] | Gflop/s | one solve [ms] | 24 half-solves [ms] |\n");
  std::printf("|---|---|---|---|---|---|\n");
  for (std::size_t k = 0; k < factor.size(); ++k) {
    const double held = timed[4 * k].median(), free = timed[4 * k + 1].median();
    std::printf("| %s | %.3g | %.3g | %.3g | %.3g | %.3g |\n", names[k].c_str(), held, free, 1e-6 * flops / free,
                timed[4 * k + 2].median(), timed[4 * k + 3].median());
  }
  const std::size_t last = 4 * factor.size();
  const double analysis = timed[last].median(), symbolic = timed[last + 1].median();
  const std::size_t reference = last - 4;
  std::printf("\nCHOLMOD / ours: %.2f held, %.2f free, %.2f solve, %.2f half-solves\n",
              timed[reference].median() / timed[0].median(), timed[reference + 1].median() / timed[1].median(),
              timed[reference + 2].median() / timed[2].median(), timed[reference + 3].median() / timed[3].median());
  std::printf("order %.3g ms, symbolic %.3g ms; both / factor %.2f held, %.2f free\n", analysis - symbolic, symbolic,
              analysis / timed[0].median(), analysis / timed[1].median());
  std::printf("by nested dissection: order %.3g ms, %.3g flops, factor, all free %.3g ms\n", timed[last + 2].median(),
              dissected_flops, timed[last + 3].median());
  const double one = timed[last + 4].median(), two = timed[last + 5].median();
  const double busier = busier_thread(timed[last + 5].run, static_cast<int>(timed[last + 5].milliseconds.size()));
  std::printf(
      "two threads: %.2f times as fast by the busier one's processor time, %.2f by the clock (best turn %.2f)\n",
      timed[1].median() / busier, one / two, timed[last + 4].best() / timed[last + 5].best());
}

}  // namespace
}  // namespace crease

int main(int argc, char** argv) {
  std::vector<int> cells{12, 39, 77, 158};
  if (argc > 1) cells.clear();
  for (int i = 1; i < argc; ++i) cells.push_back(std::atoi(argv[i]));
  for (const int n : cells) crease::measure(n);
}
