// SPDX-License-Identifier: Apache-2.0
// How numbers cross the library boundary: pointers into kernel memory with their sizes, seen through unaligned Eigen
// maps.
#pragma once

#include <Eigen/Core>

#include <cassert>
#include <concepts>
#include <type_traits>

namespace binnacle {

/// Memory handed out by the kernel is 8-byte aligned and no more: an Eigen built with another EIGEN_MAX_ALIGN_BYTES
/// may read it. No owning Eigen object ever crosses.
template <int Rows, int Cols = 1>
using MapOf = Eigen::Map<Eigen::Matrix<double, Rows, Cols>, Eigen::Unaligned>;
template <int Rows, int Cols = 1>
using ConstMapOf = Eigen::Map<const Eigen::Matrix<double, Rows, Cols>, Eigen::Unaligned>;
/// A block inside a taller column-major matrix: `stride` doubles from one column to the next.
template <int Rows, int Cols>
using StridedMapOf = Eigen::Map<Eigen::Matrix<double, Rows, Cols>, Eigen::Unaligned, Eigen::OuterStride<>>;
template <int Rows, int Cols>
using ConstStridedMapOf = Eigen::Map<const Eigen::Matrix<double, Rows, Cols>, Eigen::Unaligned, Eigen::OuterStride<>>;

/// `Rows` doubles at p as a column vector.
template <int Rows>
MapOf<Rows> vector_at(double* p) {
  return MapOf<Rows>(p);
}
template <int Rows>
ConstMapOf<Rows> vector_at(const double* p) {
  return ConstMapOf<Rows>(p);
}
inline Eigen::Map<Eigen::VectorXd, Eigen::Unaligned> vector_at(double* p, int rows) { return {p, rows}; }
inline Eigen::Map<const Eigen::VectorXd, Eigen::Unaligned> vector_at(const double* p, int rows) { return {p, rows}; }

/// `Rows`×`Cols` doubles at p, column-major and dense.
template <int Rows, int Cols>
MapOf<Rows, Cols> matrix_at(double* p) {
  return MapOf<Rows, Cols>(p);
}
template <int Rows, int Cols>
ConstMapOf<Rows, Cols> matrix_at(const double* p) {
  return ConstMapOf<Rows, Cols>(p);
}
inline Eigen::Map<Eigen::MatrixXd, Eigen::Unaligned> matrix_at(double* p, int rows, int cols) {
  return {p, rows, cols};
}
inline Eigen::Map<const Eigen::MatrixXd, Eigen::Unaligned> matrix_at(const double* p, int rows, int cols) {
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

/// `size` doubles that may be read.
class ConstVectorView {
 public:
  constexpr ConstVectorView() = default;
  constexpr ConstVectorView(const double* data, int size) noexcept : data_(data), size_(size) {}
  template <Contiguous<const double> Numbers>
  constexpr ConstVectorView(const Numbers& numbers) noexcept
      : ConstVectorView(numbers.data(), static_cast<int>(numbers.size())) {}
  template <int Size>
  constexpr ConstVectorView(const double (&numbers)[Size]) noexcept : ConstVectorView(numbers, Size) {}

  constexpr explicit operator bool() const noexcept { return data_ != nullptr; }
  constexpr const double* data() const noexcept { return data_; }
  constexpr int size() const noexcept { return size_; }
  double operator[](int i) const noexcept {
    assert(data_ && i >= 0 && i < size_);
    return data_[i];
  }
  /// All of it: `x.as<3>()`, or `x.as()` where the size is known at run time only.
  template <int Rows>
  ConstMapOf<Rows> as() const {
    assert(data_ && size_ == Rows);
    return ConstMapOf<Rows>(data_);
  }
  ConstMapOf<Eigen::Dynamic> as() const { return ConstMapOf<Eigen::Dynamic>(data_, size_); }
  ConstVectorView segment(int first, int count) const noexcept {
    assert(data_ && first >= 0 && count >= 0 && first + count <= size_);
    return {data_ + first, count};
  }

 private:
  const double* data_ = nullptr;
  int size_ = 0;
};

/// `size` doubles that may be written.
class VectorView {
 public:
  constexpr VectorView() = default;
  constexpr VectorView(double* data, int size) noexcept : data_(data), size_(size) {}
  template <Contiguous<double> Numbers>
  constexpr VectorView(Numbers& numbers) noexcept : VectorView(numbers.data(), static_cast<int>(numbers.size())) {}
  template <int Size>
  constexpr VectorView(double (&numbers)[Size]) noexcept : VectorView(numbers, Size) {}

  constexpr explicit operator bool() const noexcept { return data_ != nullptr; }
  constexpr double* data() const noexcept { return data_; }
  constexpr int size() const noexcept { return size_; }
  double& operator[](int i) const noexcept {
    assert(data_ && i >= 0 && i < size_);
    return data_[i];
  }
  template <int Rows>
  MapOf<Rows> as() const {
    assert(data_ && size_ == Rows);
    return MapOf<Rows>(data_);
  }
  MapOf<Eigen::Dynamic> as() const { return MapOf<Eigen::Dynamic>(data_, size_); }
  VectorView segment(int first, int count) const noexcept {
    assert(data_ && first >= 0 && count >= 0 && first + count <= size_);
    return {data_ + first, count};
  }

 private:
  double* data_ = nullptr;
  int size_ = 0;
};

/// A rows×cols block of a column-major matrix that may be read: element (i, j) is data[i + j * stride].
struct ConstMatrixView {
  const double* data = nullptr;
  int rows = 0;
  int cols = 0;
  int stride = 0;

  double operator()(int i, int j) const noexcept {
    assert(data && i >= 0 && i < rows && j >= 0 && j < cols);
    return data[i + static_cast<long>(j) * stride];
  }
  explicit operator bool() const noexcept { return data != nullptr; }
  template <int Rows, int Cols>
  ConstStridedMapOf<Rows, Cols> as() const {
    assert(data && rows == Rows && cols == Cols);
    return {data, rows, cols, Eigen::OuterStride<>(stride)};
  }
  ConstStridedMapOf<Eigen::Dynamic, Eigen::Dynamic> as() const {
    return {data, rows, cols, Eigen::OuterStride<>(stride)};
  }
};

/// The same, to be written.
struct MatrixView {
  double* data = nullptr;
  int rows = 0;
  int cols = 0;
  int stride = 0;

  double& operator()(int i, int j) const noexcept {
    assert(data && i >= 0 && i < rows && j >= 0 && j < cols);
    return data[i + static_cast<long>(j) * stride];
  }
  explicit operator bool() const noexcept { return data != nullptr; }
  operator ConstMatrixView() const noexcept { return {data, rows, cols, stride}; }

  /// All of it: `H.as<3, 3>()`, or `H.as()` where the size is known at run time only.
  template <int Rows, int Cols>
  StridedMapOf<Rows, Cols> as() const {
    assert(data && rows == Rows && cols == Cols);
    return {data, rows, cols, Eigen::OuterStride<>(stride)};
  }
  StridedMapOf<Eigen::Dynamic, Eigen::Dynamic> as() const { return {data, rows, cols, Eigen::OuterStride<>(stride)}; }
  /// The part that begins at (row, col).
  MatrixView block(int row, int col, int row_count, int col_count) const noexcept {
    assert(data && row >= 0 && col >= 0 && row + row_count <= rows && col + col_count <= cols);
    return {data + row + static_cast<long>(col) * stride, row_count, col_count, stride};
  }
};

}  // namespace binnacle
