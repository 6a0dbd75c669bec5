// SPDX-License-Identifier: Apache-2.0
// How numbers cross the library boundary: pointers into kernel memory with their sizes, seen through unaligned Eigen
// maps by those who include binnacle/eigen.hpp.
#pragma once

#include <cassert>
#include <concepts>
#include <type_traits>

namespace binnacle {

/// Memory handed out by the kernel is 8-byte aligned and no more: an Eigen built with another EIGEN_MAX_ALIGN_BYTES
/// may read it. No owning Eigen object ever crosses. `Double` is double or const double.
template <class Double, int Rows, int Cols>
struct EigenTypes;                  // of binnacle/eigen.hpp
inline constexpr int dynamic = -1;  ///< a size that is known at run time only: Eigen::Dynamic
template <class Double, int Rows, int Cols = 1>
using MapAs = typename EigenTypes<Double, Rows, Cols>::Map;  ///< packed, column-major
template <int Rows, int Cols = 1>
using MapOf = MapAs<double, Rows, Cols>;  ///< that may be written
template <int Rows, int Cols = 1>
using ConstMapOf = MapAs<const double, Rows, Cols>;  ///< that may only be read
/// A block inside a taller column-major matrix: `stride` doubles from one column to the next.
template <class Double, int Rows, int Cols>
using StridedMapAs = typename EigenTypes<Double, Rows, Cols>::StridedMap;
template <int Rows>
using VectorOf = typename EigenTypes<double, Rows, 1>::Matrix;  ///< that owns its numbers

/// `Rows` doubles at p as a column vector.
template <int Rows, class Double>
MapAs<Double, Rows> vector_at(Double* p) {
  return MapAs<Double, Rows>(p);
}
template <class Double>
MapAs<Double, dynamic> vector_at(Double* p, int rows) {
  return {p, rows};
}

/// `Rows`×`Cols` doubles at p, column-major and dense.
template <int Rows, int Cols, class Double>
MapAs<Double, Rows, Cols> matrix_at(Double* p) {
  return MapAs<Double, Rows, Cols>(p);
}
template <class Double>
MapAs<Double, dynamic, dynamic> matrix_at(Double* p, int rows, int cols) {
  return {p, rows, cols};
}

// Every view is null where there is nothing to see (an open port, a Jacobian that nobody wants): test it with `if`.
// Sizes are checked by assert(), so in builds without NDEBUG.

/// An Eigen object whose numbers need not lie one after the other: a row, a block of a matrix.
template <class Numbers>
concept Scattered = !Numbers::IsVectorAtCompileTime || Numbers::InnerStrideAtCompileTime != 1;
/// Doubles that do: a std::vector or std::array, an Eigen vector, a view.
template <class Numbers, class Double>
concept Contiguous = !Scattered<std::remove_const_t<Numbers>> && requires(Numbers & numbers) {
  { numbers.data() } -> std::convertible_to<Double*>;
  { numbers.size() } -> std::convertible_to<int>;
};

/// `size` doubles: a VectorView may be written, a ConstVectorView only read.
template <class Double>
class VectorViewOf {
 public:
  constexpr VectorViewOf() = default;
  constexpr VectorViewOf(Double* data, int size) noexcept : data_(data), size_(size) {}
  /// What may only be read may also be a temporary.
  template <class Numbers>
  requires(Contiguous<std::remove_reference_t<Numbers>, Double> &&
           (std::is_const_v<Double> ||
            std::is_lvalue_reference_v<Numbers>)) constexpr VectorViewOf(Numbers&& numbers) noexcept
      : VectorViewOf(numbers.data(), static_cast<int>(numbers.size())) {}
  template <int Size>
  constexpr VectorViewOf(Double (&numbers)[Size]) noexcept : VectorViewOf(numbers, Size) {}

  constexpr explicit operator bool() const noexcept { return data_ != nullptr; }
  constexpr Double* data() const noexcept { return data_; }
  constexpr int size() const noexcept { return size_; }
  Double& operator[](int i) const noexcept {
    assert(data_ && i >= 0 && i < size_);
    return data_[i];
  }
  /// All of it: `x.as<3>()`, or `x.as()` where the size is known at run time only.
  template <int Rows = dynamic>
  MapAs<Double, Rows> as() const {
    assert(Rows == dynamic || (data_ && size_ == Rows));
    return MapAs<Double, Rows>(data_, size_);
  }
  VectorViewOf segment(int first, int count) const noexcept {
    assert(data_ && first >= 0 && count >= 0 && first + count <= size_);
    return {data_ + first, count};
  }

 private:
  Double* data_ = nullptr;
  int size_ = 0;
};
using VectorView = VectorViewOf<double>;             ///< that may be written
using ConstVectorView = VectorViewOf<const double>;  ///< that may only be read

/// A rows×cols block of a column-major matrix: element (i, j) is data[i + j * stride].
template <class Double>
struct MatrixViewOf {
  Double* data = nullptr;
  int rows = 0;
  int cols = 0;
  int stride = 0;

  Double& operator()(int i, int j) const noexcept {
    assert(data && i >= 0 && i < rows && j >= 0 && j < cols);
    return data[i + static_cast<long>(j) * stride];
  }
  explicit operator bool() const noexcept { return data != nullptr; }
  operator MatrixViewOf<const double>() const noexcept requires(!std::is_const_v<Double>) {
    return {data, rows, cols, stride};
  }

  /// All of it: `H.as<3, 3>()`, or `H.as()` where the size is known at run time only.
  template <int Rows = dynamic, int Cols = dynamic>
  StridedMapAs<Double, Rows, Cols> as() const {
    assert((Rows == dynamic || (data && rows == Rows)) && (Cols == dynamic || (data && cols == Cols)));
    return {data, rows, cols, typename EigenTypes<Double, Rows, Cols>::Stride(stride)};
  }
  /// The part that begins at (row, col).
  MatrixViewOf block(int row, int col, int row_count, int col_count) const noexcept {
    assert(data && row >= 0 && col >= 0 && row + row_count <= rows && col + col_count <= cols);
    return {data + row + static_cast<long>(col) * stride, row_count, col_count, stride};
  }
};
using MatrixView = MatrixViewOf<double>;             ///< that may be written
using ConstMatrixView = MatrixViewOf<const double>;  ///< that may only be read

}  // namespace binnacle
