// SPDX-License-Identifier: MIT
//
// What it takes to assemble the matrix of one implicit step: in place on one thread and on two, with its pattern made
// anew, and by way of triplets with the same element kernels; beside one factorisation of the same matrix. All take
// turns in one process; processor time.
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <vector>

#include "crease/dynamics/bending.hpp"
#include "crease/dynamics/inertia.hpp"
#include "crease/dynamics/membrane.hpp"
#include "crease/geometry/triangle.hpp"
#include "hanging_sheet.hpp"
#include "measure.hpp"

namespace crease {
namespace {

using Triplets = std::vector<Eigen::Triplet<double>>;

/// J^T W J, J = (I, -F), for the vertices that have unknowns for it.
void add_block(const DofMap& dofs, int i, int j, const Mat3& W, const Mat32& F, Triplets& entries) {
  Eigen::Matrix<double, 5, 5> block;
  block << W, -W * F, -F.transpose() * W, F.transpose() * W * F;
  for (int col = 0; col < (dofs.is_eol(j) ? 5 : 3); ++col)
    for (int row = 0; row < (dofs.is_eol(i) ? 5 : 3); ++row)
      entries.emplace_back(dofs.x(i) + row, dofs.x(j) + col, block(row, col));
}

SparseMatrix assemble_triplets(const HangingSheet& sheet) {
  const Mesh& mesh = sheet.cloth.mesh;
  const double stiffness = HangingSheet::h * (HangingSheet::h + sheet.material.damping);
  Triplets entries;
  for (int f = 0; f < mesh.n_faces(); ++f) {
    const auto X = material_corners(mesh, f);
    const auto x = world_corners(mesh, f);
    const Mat9 K = stiffness * membrane_element(X, x, sheet.material).stiffness;
    const Mat32 F = deformation_gradient(X, x);
    const double mass = sheet.material.density * mesh.material_area(f) / 12;
    for (int i = 0; i < 3; ++i)
      for (int j = 0; j < 3; ++j) {
        const Mat3 W = K.block<3, 3>(3 * i, 3 * j) + (i == j ? 2 * mass : mass) * Mat3::Identity();
        add_block(sheet.dofs, mesh.face(f)[i], mesh.face(f)[j], W, F, entries);
      }
  }
  for (const int e : mesh.edges()) {
    if (mesh.is_border(e)) continue;
    const int v[] = {mesh.from(e), mesh.to(e), mesh.opposite(e), mesh.opposite(mesh.twin(e))};
    const BendingElement bending =
        bending_element({mesh.X[v[0]], mesh.X[v[1]], mesh.X[v[2]], mesh.X[v[3]]}, sheet.material.bending);
    const Mat32 F =
        0.5 * (deformation_gradient(mesh, Mesh::face_of(e)) + deformation_gradient(mesh, Mesh::face_of(mesh.twin(e))));
    for (int i = 0; i < 4; ++i)
      for (int j = 0; j < 4; ++j)
        add_block(sheet.dofs, v[i], v[j], stiffness * bending.c * bending.k[i] * bending.k[j] * Mat3::Identity(), F,
                  entries);
  }
  SparseMatrix H(sheet.dofs.size(), sheet.dofs.size());
  H.setFromTriplets(entries.begin(), entries.end());
  return H;
}

struct Row {
  double faces, in_place, anew, triplets, factor;
};

Row measure(int cells) {
  const HangingSheet sheet = make_hanging_sheet(cells);
  const DynamicsOptions options;
  Assembler one, fresh, two(2), clock(1);
  const auto assemble = [&](Assembler& assembler, bool same) {
    assembler.assemble(sheet.cloth, sheet.dofs, sheet.material, options, HangingSheet::h, same);
  };
  const auto factor = make_block_cholesky();
  if (!factor->analyze(sheet.graph)) std::exit((std::fprintf(stderr, "assembly_benchmark: analysis failed\n"), 1));
  const SparseMatrix H = assemble_triplets(sheet);
  if (!((H - sheet.H).norm() <= 1e-12 * sheet.H.norm()))
    std::exit((std::fprintf(stderr, "assembly_benchmark: the two ways make two matrices\n"), 1));
  std::vector<Timed> timed;
  timed.push_back({"in place", [&] { assemble(one, true); }});
  timed.push_back({"pattern anew", [&] { assemble(fresh, false); }});
  timed.push_back({"triplets", [&] { assemble_triplets(sheet); }});
  timed.push_back({"factor", [&] { factor->factorize(sheet.H, {}, sheet.lift); }});
  timed.push_back({"one thread", [&] { assemble(clock, true); }, CLOCK_MONOTONIC});
  timed.push_back({"two threads", [&] { assemble(two, true); }, CLOCK_MONOTONIC});
  take_turns(timed);
  const auto turns = static_cast<int>(timed.back().milliseconds.size());
  const double alone = busier_thread(timed[4].run, turns), busier = busier_thread(timed[5].run, turns);
  const Row row{static_cast<double>(sheet.n_faces), timed[0].median(), timed[1].median(), timed[2].median(),
                timed[3].median()};
  std::printf("| %.0f | %.3g | %.3g | %.3g | %.3g | %.1f | %.2f | %.2f (%.2f) | %.0f |\n", row.faces, row.in_place,
              row.anew, row.triplets, row.factor, row.triplets / row.in_place, row.in_place / row.factor,
              alone / busier, timed[4].best() / timed[5].best(), peak_memory());
  std::fflush(stdout);
  return row;
}

/// Exponent of the faces by which a time grows between two sizes.
double growth(const Row& small, const Row& large, double Row::*time) {
  return std::log(large.*time / small.*time) / std::log(large.faces / small.faces);
}

}  // namespace
}  // namespace crease

int main(int argc, char** argv) {
  std::vector<int> cells{12, 39, 77, 158, 316};
  if (argc > 1) cells.clear();
  for (int i = 1; i < argc; ++i) cells.push_back(std::atoi(argv[i]));
  std::printf(
      "| faces | in place [ms] | pattern anew [ms] | triplets [ms] | own factor [ms] | triplets / in place | in place "
      "/ "
      "factor | two threads, times as fast by the busier one's time (by the clock, best turn) | peak memory [MB] "
      "|\n|---|---|---|---|---|---|---|---|---|\n");
  std::vector<crease::Row> rows;
  for (const int n : cells) rows.push_back(crease::measure(n));
  using crease::Row;
  for (std::size_t k = 1; k < rows.size(); ++k)
    std::printf("%s%.0f to %.0f faces: assembly %.2f, pattern anew %.2f, factor %.2f\n",
                k == 1 ? "\nGrowth with faces^p, p: " : "  ", rows[k - 1].faces, rows[k].faces,
                crease::growth(rows[k - 1], rows[k], &Row::in_place), crease::growth(rows[k - 1], rows[k], &Row::anew),
                crease::growth(rows[k - 1], rows[k], &Row::factor));
}
