// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>

namespace crease {

/// Everything in this header that the kernels call is inlined without exception: a copy compiled with the instructions
/// of one processor must never be the one that the linker keeps for all.
#define CREASE_ALWAYS_INLINE [[gnu::always_inline]] inline

/// A front: the dense piece of L that belongs to one supernode, `pivots` columns, with `border` rows below them.
///
/// Everything is kept in panels of 8 rows, column after column inside a panel, so that every operand of the kernels is
/// read from front to back. Pivots and border are each padded to whole panels with zeros.
///   L  panels of all rows, each with every (padded) pivot column: 64 column_panels() doubles a panel.
///      The diagonal holds reciprocals, 1 / L_kk (0 in the padding); above it lies rubbish.
///   U  lower triangle over the border, panel b with its first 8 (b + 1) columns: starts at update_panel(b).
struct FrontShape {
  int pivots = 0, border = 0;

  static constexpr int panel = 8;
  CREASE_ALWAYS_INLINE static constexpr int panels(int rows) { return (rows + panel - 1) / panel; }
  CREASE_ALWAYS_INLINE static constexpr std::size_t update_panel(int b) {
    return 32 * static_cast<std::size_t>(b) * (static_cast<std::size_t>(b) + 1);
  }

  CREASE_ALWAYS_INLINE int column_panels() const { return panels(pivots); }
  CREASE_ALWAYS_INLINE int border_panels() const { return panels(border); }
  CREASE_ALWAYS_INLINE std::size_t row_panel_size() const { return 64 * static_cast<std::size_t>(column_panels()); }
  CREASE_ALWAYS_INLINE std::size_t factor_size() const {
    return row_panel_size() * static_cast<std::size_t>(column_panels() + border_panels());
  }
  CREASE_ALWAYS_INLINE std::size_t update_size() const { return update_panel(border_panels()); }
};

/// Right-hand sides go through in panels of 8 too, at most three at once.
constexpr int max_rhs_panels = 3;

/// The dense inner loops of the factorisation, one set for each kind of processor. They are compiled with that
/// processor's instructions and must not be called on another. Plain arrays only, and no other header.
struct FrontKernels {
  const char* name;

  /// In place L of the assembled pivot columns; U becomes minus the product of the border rows with their transpose.
  /// @return false at the first pivot that is not positive and finite
  bool (*factorize)(FrontShape shape, double* L, double* U);

  /// Adds the update of a child, with `n` border rows, to the front: entry (i, j) of its lower triangle to row rows[i],
  /// column rows[j]. Rows of the front count from its first pivot and through the padding, and `rows` ascends, pivots
  /// first: the first `n_pivots` columns go to L, the others to U.
  void (*add_to_pivots)(FrontShape shape, int n, int n_pivots, const int* rows, const double* update, double* L);
  void (*add_to_update)(FrontShape shape, int n, int n_pivots, const int* rows, const double* update, double* U);

  /// y <- L_pp^-1 y;  product = L_bp y, padded to whole panels
  void (*forward)(FrontShape shape, const double* L, double* y, double* product);
  /// y <- L_pp^-T (y - L_bp^T below), `below` padded to whole panels with zeros
  void (*backward)(FrontShape shape, const double* L, const double* below, double* y);

  /// forward() of 8 right-hand sides a panel, but with *minus* the product: row i of panel k stands at Y[k] + 8 i, and
  /// so in product[k]. The panels of Y are evenly spaced.
  void (*forward_batch)(FrontShape shape, const double* L, int n_panels, double* const* Y, double* const* product);

  // Of panels of 8 right-hand sides, `n` rows of each:
  /// C = -A^T B, 8 x 8, column after column
  void (*product)(int n, const double* A, const double* B, double* C);
  /// out = A^T y, 8 numbers
  void (*times)(const double* A, int n, const double* y, double* out);
  /// x <- x - sum of A[p] z[p]
  void (*subtract_rows)(int n_panels, const double* const* A, const double* const* z, int n, double* x);
};

const FrontKernels& generic_front_kernels();
#if defined(__x86_64__)
const FrontKernels& avx2_front_kernels();
const FrontKernels& avx512_front_kernels();
#endif

}  // namespace crease
