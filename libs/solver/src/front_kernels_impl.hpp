// SPDX-License-Identifier: MIT
// Included by one source file a kind of processor, which sets `CREASE_LANES`, the doubles of a vector register.
#include "front_kernels.hpp"

#ifdef EIGEN_WORLD_VERSION
#error "No Eigen in kernels: what it inlines would be laid out, and shared, as on this one kind of processor."
#endif

namespace crease {
namespace {

constexpr int lanes = CREASE_LANES;
constexpr int parts = 8 / lanes;  ///< vectors a column of a panel
/// Columns of a register tile. With 8 lanes a tile is 24 x 8 (24 of 32 registers accumulate), with 4 lanes 8 x 4 and
/// with 2 lanes 8 x 2 (8 of 16); each is enough to hide the latency of an addition.
constexpr int tile_columns = lanes == 8 ? 8 : lanes == 4 ? 4 : 2;
constexpr int tile_panels = lanes == 8 ? 3 : 1;
constexpr double largest_pivot = 1e300;

typedef double Vector __attribute__((vector_size(8 * lanes), aligned(8), may_alias));

inline Vector& at(double* p) {
  return *reinterpret_cast<Vector*>(p);
}
inline const Vector& at(const double* p) {
  return *reinterpret_cast<const Vector*>(p);
}

enum class Start { Given, Zero };

/// C <- C - A B^T, or -A B^T. `panels` panels of 8 rows against 8 columns, `depth` long.
/// @param A, stride  the panels of A stand `stride` doubles apart
template <int panels, Start start>
inline void multiply_tile(double* const* C, const double* A, std::ptrdiff_t stride, const double* B, int depth) {
  for (int first = 0; first < 8; first += tile_columns) {
    Vector sum[tile_columns][panels * parts] = {};
    for (int k = 0; k < depth; ++k) {
      Vector a[panels * parts];
#pragma GCC unroll 16
      for (int p = 0; p < panels; ++p)
#pragma GCC unroll 16
        for (int v = 0; v < parts; ++v) a[p * parts + v] = at(A + p * stride + 8 * k + v * lanes);
#pragma GCC unroll 16
      for (int j = 0; j < tile_columns; ++j)
#pragma GCC unroll 16
        for (int i = 0; i < panels * parts; ++i) sum[j][i] += a[i] * B[8 * k + first + j];
    }
#pragma GCC unroll 16
    for (int j = 0; j < tile_columns; ++j)
#pragma GCC unroll 16
      for (int p = 0; p < panels; ++p)
#pragma GCC unroll 16
        for (int v = 0; v < parts; ++v) {
          Vector& c = at(C[p] + 8 * (first + j) + v * lanes);
          c = (start == Start::Given ? c : Vector{}) - sum[j][p * parts + v];
        }
  }
}

template <Start start>
void multiply(int panels, double* const* C, const double* A, std::ptrdiff_t stride, const double* B, int depth) {
  if constexpr (tile_panels == 3) {
    if (panels == 3) return multiply_tile<3, start>(C, A, stride, B, depth);
    if (panels == 2) return multiply_tile<2, start>(C, A, stride, B, depth);
  }
  for (int p = 0; p < panels; ++p) multiply_tile<1, start>(C + p, A + p * stride, stride, B, depth);
}

/// X <- X L^-T for 8 rows of X, L the lower triangle of `tile`.
inline void solve_tile(double* X, const double* tile) {
  for (int v = 0; v < parts; ++v) {
    Vector x[8];
#pragma GCC unroll 8
    for (int k = 0; k < 8; ++k) x[k] = at(X + 8 * k + v * lanes);
#pragma GCC unroll 8
    for (int k = 0; k < 8; ++k) {
      x[k] *= tile[9 * k];
#pragma GCC unroll 8
      for (int j = k + 1; j < 8; ++j) x[j] -= x[k] * tile[8 * k + j];
    }
#pragma GCC unroll 8
    for (int k = 0; k < 8; ++k) at(X + 8 * k + v * lanes) = x[k];
  }
}

/// Lower triangle of the first `width` columns of a tile, reciprocals on the diagonal.
inline bool factorize_tile(double* tile, int width) {
  for (int k = 0; k < width; ++k) {
    double* column = tile + 8 * k;
    const double pivot = column[k];
    if (!(pivot > 0 && pivot < largest_pivot)) return false;
    const double inverse = 1 / __builtin_sqrt(pivot);
    for (int v = 0; v < parts; ++v) at(column + v * lanes) *= Vector{} + inverse;
    for (int j = k + 1; j < width; ++j)
      for (int v = 0; v < parts; ++v) at(tile + 8 * j + v * lanes) -= at(column + v * lanes) * column[j];
    column[k] = inverse;
  }
  return true;
}

inline int smaller(int a, int b) {
  return a < b ? a : b;
}

bool factorize(FrontShape shape, double* L, double* U) {
  const int n_columns = shape.column_panels(), n_border = shape.border_panels();
  const auto stride = static_cast<std::ptrdiff_t>(shape.row_panel_size());
  double* C[max_rhs_panels];
  for (int j = 0; j < n_columns; ++j) {
    const double* row = L + j * stride;
    double* tile = L + j * stride + 64 * j;
    multiply<Start::Given>(1, &tile, row, stride, row, 8 * j);
    if (!factorize_tile(tile, smaller(8, shape.pivots - 8 * j))) return false;
    for (int i = j + 1; i < n_columns + n_border; i += max_rhs_panels) {
      const int panels = smaller(max_rhs_panels, n_columns + n_border - i);
      for (int p = 0; p < panels; ++p) C[p] = L + (i + p) * stride + 64 * j;
      if (j > 0) multiply<Start::Given>(panels, C, L + i * stride, stride, row, 8 * j);
      for (int p = 0; p < panels; ++p) solve_tile(C[p], tile);
    }
  }
  const double* below = L + n_columns * stride;
  for (int i = 0; i < n_border; i += max_rhs_panels) {
    const int panels = smaller(max_rhs_panels, n_border - i);
    for (int j = 0; j < i + panels; ++j) {
      const int skip = j > i ? j - i : 0;  // of the three, the panels that lie above the diagonal
      for (int p = skip; p < panels; ++p) C[p] = U + FrontShape::update_panel(i + p) + 64 * j;
      multiply<Start::Zero>(panels - skip, C + skip, below + (i + skip) * stride, stride, below + j * stride,
                            shape.pivots);
    }
  }
  return true;
}

/// Rows of one panel of a child that belong into one panel of its parent.
struct RowGroup {
  int begin, end;   ///< rows of the child's panel
  int lane[8];      ///< where each goes, by row of the child's panel
  double* target;   ///< the parent's panel
  const int* rows;  ///< of the parent, for the child's columns
  int shift;        ///< number of the parent's row whose column comes first in `target`

  CREASE_ALWAYS_INLINE double* column(int j) const { return target + 8 * (rows[j] - shift); }
};

/// Columns begin..end, in which all rows of the group lie on or below the diagonal.
inline void add_columns(const RowGroup& group, int begin, int end, const double* values) {
  if constexpr (lanes == 8) {
    // One permutation moves a whole column; lanes of other groups are masked.
    typedef long long Lanes __attribute__((vector_size(8 * lanes)));
    Lanes from = {}, mask = {};
    for (int i = group.begin; i < group.end; ++i) from[group.lane[i]] = i, mask[group.lane[i]] = -1;
    for (int j = begin; j < end; ++j)
      at(group.column(j)) += (Vector)((Lanes)__builtin_shuffle(at(values + 8 * j), from) & mask);
  } else {
    for (int j = begin; j < end; ++j)
      for (int i = group.begin; i < group.end; ++i) group.column(j)[group.lane[i]] += values[8 * j + i];
  }
}

enum class Part { Pivots, Update };

template <Part part>
void add_child(FrontShape shape, int n, int n_pivots, const int* rows, const double* update, double* target) {
  const int begin = part == Part::Pivots ? 0 : n_pivots, end = part == Part::Pivots ? n_pivots : n;
  RowGroup group{};
  group.rows = rows;
  group.shift = part == Part::Pivots ? 0 : 8 * shape.column_panels();
  for (int first = begin - begin % 8; first < n; first += 8) {
    const double* values = update + FrontShape::update_panel(first / 8);
    const int last = smaller(8, n - first);
    for (group.end = first < begin ? begin - first : 0; group.end < last;) {
      group.begin = group.end;
      const int panel = (rows[first + group.begin] - group.shift) / 8;
      for (; group.end < last && (rows[first + group.end] - group.shift) / 8 == panel; ++group.end)
        group.lane[group.end] = (rows[first + group.end] - group.shift) % 8;
      group.target = target + (part == Part::Pivots ? static_cast<std::size_t>(panel) * shape.row_panel_size()
                                                    : FrontShape::update_panel(panel));
      add_columns(group, begin, smaller(end, first + group.begin + 1), values);
      for (int j = first + group.begin + 1; j < smaller(end, first + group.end); ++j)
        for (int i = j - first; i < group.end; ++i) group.column(j)[group.lane[i]] += values[8 * j + i];
    }
  }
}

/// out <- A y for one panel.
inline void panel_times(const double* A, int depth, const double* y, double* out) {
  for (int v = 0; v < parts; ++v) {
    Vector sum[4] = {};
    int k = 0;
    for (; k + 4 <= depth; k += 4)
#pragma GCC unroll 4
      for (int u = 0; u < 4; ++u) sum[u] += at(A + 8 * (k + u) + v * lanes) * y[k + u];
    for (; k < depth; ++k) sum[0] += at(A + 8 * k + v * lanes) * y[k];
    at(out + v * lanes) = (sum[0] + sum[1]) + (sum[2] + sum[3]);
  }
}

void forward(FrontShape shape, const double* L, double* y, double* product) {
  const auto stride = static_cast<std::ptrdiff_t>(shape.row_panel_size());
  for (int j = 0; j < shape.column_panels(); ++j, L += stride) {
    double sum[8];
    panel_times(L, 8 * j, y, sum);
    const double* tile = L + 64 * j;
    const int width = smaller(8, shape.pivots - 8 * j);
    for (int i = 0; i < width; ++i) {
      double value = y[8 * j + i] - sum[i];
      for (int k = 0; k < i; ++k) value -= tile[8 * k + i] * y[8 * j + k];
      y[8 * j + i] = value * tile[9 * i];
    }
  }
  for (int b = 0; b < shape.border_panels(); ++b) panel_times(L + b * stride, shape.pivots, y, product + 8 * b);
}

void backward(FrontShape shape, const double* L, const double* below, double* y) {
  const int n_columns = shape.column_panels();
  const auto stride = static_cast<std::ptrdiff_t>(shape.row_panel_size());
  for (int j = n_columns - 1; j >= 0; --j) {
    const int width = smaller(8, shape.pivots - 8 * j);
    Vector sum[8] = {};
    // The panels below tile j: first those of later pivots (the last of them may be cut short), then the border.
    for (int i = j + 1; i < n_columns + shape.border_panels(); ++i) {
      double cut[8] = {};
      if (i < n_columns)
        for (int k = 0; k < smaller(8, shape.pivots - 8 * i); ++k) cut[k] = y[8 * i + k];
      const double* x = i < n_columns ? cut : below + 8 * (i - n_columns);
      const double* A = L + i * stride + 64 * j;
      for (int v = 0; v < parts; ++v)
#pragma GCC unroll 8
        for (int k = 0; k < 8; ++k) sum[k] += at(A + 8 * k + v * lanes) * at(x + v * lanes);
    }
    const double* tile = L + j * stride + 64 * j;
    for (int k = width - 1; k >= 0; --k) {
      double value = y[8 * j + k];
      for (int u = 0; u < lanes; ++u) value -= sum[k][u];
      for (int i = k + 1; i < width; ++i) value -= tile[8 * k + i] * y[8 * j + i];
      y[8 * j + k] = value * tile[9 * k];
    }
  }
}

/// The right-hand sides are transposed in memory, so they look like further rows of the front: L^-1 B is what
/// factorising [K B; B^T .] leaves in the last rows.
void forward_batch(FrontShape shape, const double* L, int n_panels, double* const* Y, double* const* product) {
  const int n_columns = shape.column_panels();
  const auto stride = static_cast<std::ptrdiff_t>(shape.row_panel_size());
  const std::ptrdiff_t rhs_stride = n_panels > 1 ? Y[1] - Y[0] : 0;
  double* C[max_rhs_panels];
  double last[max_rhs_panels][64];
  for (int j = 0; j < n_columns; ++j) {
    const int width = smaller(8, shape.pivots - 8 * j);
    for (int p = 0; p < n_panels; ++p) {
      C[p] = Y[p] + 64 * j;
      if (width == 8) continue;
      for (int i = 0; i < 64; ++i) last[p][i] = i < 8 * width ? C[p][i] : 0.0;
      C[p] = last[p];
    }
    if (j > 0) multiply<Start::Given>(n_panels, C, Y[0], rhs_stride, L + j * stride, 8 * j);
    for (int p = 0; p < n_panels; ++p) {
      solve_tile(C[p], L + j * stride + 64 * j);
      if (width < 8)
        for (int i = 0; i < 8 * width; ++i) Y[p][64 * j + i] = last[p][i];
    }
  }
  for (int b = 0; b < shape.border_panels(); ++b) {
    for (int p = 0; p < n_panels; ++p) C[p] = product[p] + 64 * b;
    multiply<Start::Zero>(n_panels, C, Y[0], rhs_stride, L + (n_columns + b) * stride, shape.pivots);
  }
}

void product(int n, const double* A, const double* B, double* C) {
  multiply_tile<1, Start::Zero>(&C, A, 0, B, n);
}

void subtract_rows(int n_panels, const double* const* A, const double* const* z, int n, double* x) {
  for (int i = 0; i < n; ++i) {
    Vector sum[parts] = {};
    for (int p = 0; p < n_panels; ++p)
      for (int v = 0; v < parts; ++v) sum[v] += at(A[p] + 8 * i + v * lanes) * at(z[p] + v * lanes);
    for (int v = 0; v < parts; ++v)
      for (int u = 0; u < lanes; ++u) x[i] -= sum[v][u];
  }
}

constexpr FrontKernels make_kernels(const char* name) {
  return {name,        factorize,    add_child<Part::Pivots>, add_child<Part::Update>,
          forward,     backward,     forward_batch,           product,
          panel_times, subtract_rows};
}

}  // namespace
}  // namespace crease
