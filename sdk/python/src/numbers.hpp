// SPDX-License-Identifier: Apache-2.0
// Arguments that are numbers, read where they lie: anything with a buffer of float64, else a copy.
#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "convert.hpp"

namespace binnacle::python {

/// Numbers of an argument for the time of a call, row by row. A buffer of contiguous float64 (numpy, array, memoryview) is
/// borrowed; lists and tuples of numbers are copied into `room`; all else goes through numpy.asarray.
class Numbers {
 public:
  /// Throws TypeError, with `what` it is, where these are no real numbers, ValueError where some of them are masked.
  Numbers(PyObject* object, const std::string& what, std::vector<double>& room);
  ~Numbers() {
    if (has_view_) PyBuffer_Release(&view_);
  }
  Numbers(const Numbers&) = delete;
  Numbers& operator=(const Numbers&) = delete;

  const double* data() const { return data_; }
  int dimensions() const { return dimensions_; }
  /// Of up to three dimensions.
  py::ssize_t size(int dimension) const { return sizes_[dimension]; }
  /// "(100, 6)"
  std::string shape() const;

 private:
  bool borrow(PyObject* object);
  bool copy(PyObject* object, std::vector<double>& room);
  void convert(PyObject* object, const std::string& what);

  Py_buffer view_;
  bool has_view_ = false;
  py::object converted_;
  const double* data_ = nullptr;
  int dimensions_ = 0;
  py::ssize_t sizes_[3] = {0, 0, 0};
};

/// A writable array of so many float64 in a row. Throws TypeError or ValueError that say what `out` is instead.
class Room {
 public:
  Room(PyObject* object, std::size_t size);
  ~Room() { PyBuffer_Release(&view_); }
  Room(const Room&) = delete;
  Room& operator=(const Room&) = delete;

  double* data() const { return static_cast<double*>(view_.buf); }

 private:
  Py_buffer view_;
};

/// As to_time(), of a sample: NaT is none (no_time) where it `is_optional`, else ValueError.
Time to_instant(py::handle time, const char* name, bool is_optional);

/// Times of many samples: numbers of seconds, or numpy.timedelta64. `is_optional`: NaN and NaT stand for none (no_time).
/// Throws TypeError or ValueError with `what` and the index; ValueError for masked times.
std::vector<Time> to_times(py::handle times, const std::string& what, bool is_optional);

}  // namespace binnacle::python
