// SPDX-License-Identifier: Apache-2.0
// How numbers cross the library boundary: plain pointers into kernel memory, seen through unaligned Eigen maps.
#pragma once

#include <Eigen/Core>

#include <span>

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

/// A rows×cols block of a column-major matrix: element (i, j) is data[i + j * stride].
struct MatrixView {
  double* data = nullptr;
  int rows = 0;
  int cols = 0;
  int stride = 0;

  double& operator()(int i, int j) const noexcept { return data[i + static_cast<long>(j) * stride]; }
  explicit operator bool() const noexcept { return data != nullptr; }

  template <int Rows, int Cols>
  StridedMapOf<Rows, Cols> as() const {
    return {data, rows, cols, Eigen::OuterStride<>(stride)};
  }
  StridedMapOf<Eigen::Dynamic, Eigen::Dynamic> as() const { return {data, rows, cols, Eigen::OuterStride<>(stride)}; }
};

}  // namespace binnacle
