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

#include "crease/dynamics/assemble.hpp"
#include "crease/geometry/grid.hpp"
#include "measure.hpp"

namespace crease {
namespace {

struct Timed {
  std::string name;
  std::function<void()> run;
  clockid_t clock = CLOCK_THREAD_CPUTIME_ID;
  std::vector<double> milliseconds = {};

  double median() {
    std::sort(milliseconds.begin(), milliseconds.end());
    return milliseconds[milliseconds.size() / 2];
  }
};

/// Each in turn, until a second a candidate or so is spent.
void take_turns(std::vector<Timed>& candidates) {
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

struct Problem {
  BlockGraph graph;
  SparseMatrix H;
  double lift = 0;         ///< on the diagonal: the sheet is flat enough for EOL unknowns to be undecided
  std::vector<char> held;  ///< contacts of the third on the table, material motion along the edge
  int n_faces = 0, n_eol = 0, n_held = 0;
};

Problem make_problem(int cells) {
  GridOptions grid;
  grid.cells = {cells, cells};
  grid.pattern = GridPattern::Irregular;
  Cloth cloth = make_cloth(make_grid(grid));
  const double spacing = 1.0 / cells, edge = 2.0 / 3;
  for (int v = 0; v < cloth.mesh.n_vertices(); ++v) {
    const Vec2& X = cloth.mesh.X[v];
    const double over = std::max(0.0, edge - X.x());
    cloth.mesh.x[v] = Vec3(edge - 0.6 * over, X.y() + 0.01 * std::sin(9 * X.x()), -0.8 * over);
    if (X.x() >= edge) cloth.mesh.x[v] = Vec3(X.x(), X.y(), 0);
    const bool inside = X.y() > 0.5 * spacing && X.y() < 1 - 0.5 * spacing;
    if (inside && std::abs(X.x() - edge) < 0.5 * spacing) cloth.feature[v].kind = FeatureKind::Edge;
  }
  const DofMap dofs = make_dof_map(cloth);
  Material material;
  Assembler assembler;
  Problem problem;
  problem.H = assembler.assemble(cloth, dofs, material, {}, 0.005, false).H;
  problem.graph = graph_of(problem.H, dofs.start);
  problem.lift = 1e-6 * problem.H.diagonal().maxCoeff();
  problem.n_faces = cloth.mesh.n_faces();
  problem.held.assign(static_cast<std::size_t>(dofs.size()), 0);
  for (int v = 0; v < cloth.mesh.n_vertices(); ++v) {
    if (cloth.mesh.X[v].x() >= edge || dofs.is_eol(v)) problem.held[dofs.x(v) + 2] = 1;
    if (dofs.is_eol(v)) problem.held[dofs.X(v) + 1] = 1;
    problem.n_eol += dofs.is_eol(v);
  }
  problem.n_held = static_cast<int>(std::count(problem.held.begin(), problem.held.end(), 1));
  return problem;
}

void check(bool done, const char* what) {
  if (done) return;
  std::fprintf(stderr, "factor_benchmark: %s failed\n", what);
  std::exit(1);
}

void measure(int cells) {
  const Problem problem = make_problem(cells);
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
  std::printf("two threads: %.3g ms instead of %.3g by the clock, %.2f times as fast\n", two, one, one / two);
}

}  // namespace
}  // namespace crease

int main(int argc, char** argv) {
  std::vector<int> cells{12, 39, 77, 158};
  if (argc > 1) cells.clear();
  for (int i = 1; i < argc; ++i) cells.push_back(std::atoi(argv[i]));
  for (const int n : cells) crease::measure(n);
}
