// SPDX-License-Identifier: MIT
#pragma once

#include <algorithm>
#include <cstddef>
#include <vector>

#include "aligned_buffer.hpp"
#include "crease/base/types.hpp"
#include "front_kernels.hpp"

namespace crease {

/// Half-solved columns Y = L^-1 C, in panels of eight: row after row inside a panel, which is how the kernels have
/// them. They come in batches, each of which is padded with columns of zeros to whole panels. Most are zero in most
/// rows, so each batch knows which strips of rows it has anything in.
class HalfSolves {
 public:
  static constexpr int width = FrontShape::panel;       ///< columns of a panel
  static constexpr int batch = width * max_rhs_panels;  ///< columns of the largest batch
  static constexpr int strip = 64;                      ///< rows

  explicit HalfSolves(const FrontKernels& kernels) : kernels_(&kernels) {}

  /// No columns, of so many rows.
  void clear(int n_rows);
  /// With the padding.
  int n_columns() const { return first_column_.back(); }
  int n_batches() const { return static_cast<int>(first_column_.size()) - 1; }

  /// Makes a batch of zeros. @return its panels, 8 n_rows doubles each, one after the other
  double* add_batch(int n_columns);
  /// @param met  the rows in which the last batch has something
  void set_rows(const std::vector<char>& met);

  /// Writes the columns from `first` of Y^T Y, and their mirror image. @pre `first` begins a batch
  void fill_gram(int first, MatX& gram) const;
  /// x <- x - Y z
  void subtract_product(const VecX& z, VecX& x) const;
  /// Y^T y
  VecX transposed_product(const VecX& y) const;

 private:
  struct Batch {
    AlignedBuffer values;
    std::vector<char> has;  ///< one a strip
  };
  int n_strips() const { return (n_rows_ + strip - 1) / strip; }
  int rows_of(int s) const { return std::min(strip, n_rows_ - s * strip); }
  int n_panels(int b) const { return (first_column_[b + 1] - first_column_[b]) / width; }
  /// Rows of a strip in a panel of a batch.
  const double* at(int b, int panel, int s) const {
    return batches_[b].values.data() + width * (static_cast<std::ptrdiff_t>(panel) * n_rows_ + s * strip);
  }

  const FrontKernels* kernels_;
  int n_rows_ = 0;
  std::vector<int> first_column_{0};
  std::vector<Batch> batches_;  ///< more than are in use: memory is kept
};

}  // namespace crease
