// SPDX-License-Identifier: Apache-2.0
#include "numbers.hpp"

#include <algorithm>
#include <cmath>
#include <cstring>

namespace binnacle::python {

namespace {

constexpr int most_dimensions = 3;

bool is_double(const Py_buffer& view) {
  return view.itemsize == sizeof(double) && view.format && view.format[0] == 'd' && view.format[1] == '\0';
}

std::string text_of(const py::ssize_t* sizes, int dimensions) {
  std::string text = "(";
  for (int i = 0; i < dimensions; ++i) text += (i > 0 ? ", " : "") + std::to_string(sizes[i]);
  return text + (dimensions == 1 ? ",)" : ")");
}

/// numpy.asarray, which raises for lists of unequal length.
py::object as_array(py::handle object) { return py::module_::import("numpy").attr("asarray")(object); }

std::string kind_of(const py::object& array) { return array.attr("dtype").attr("kind").cast<std::string>(); }

/// What numpy.asarray does with a mask is to drop it: what it hides would be taken for data.
void refuse_masked(PyObject* object, const std::string& what) {
  static PyTypeObject* const masked =
      reinterpret_cast<PyTypeObject*>(py::object(py::module_::import("numpy.ma").attr("MaskedArray")).release().ptr());
  if (!PyObject_TypeCheck(object, masked)) return;
  const auto count = py::module_::import("numpy.ma").attr("count_masked")(py::handle(object)).cast<py::ssize_t>();
  if (count > 0)
    throw py::value_error(what + " is a masked array, " + std::to_string(count) +
                          " masked: say what these are with .filled(numpy.nan), or leave them out with .compressed()");
}

}  // namespace

Numbers::Numbers(PyObject* object, const std::string& what, std::vector<double>& room) {
  refuse_masked(object, what);
  if (!borrow(object) && !copy(object, room)) convert(object, what);
}

bool Numbers::borrow(PyObject* object) {
  if (!PyObject_CheckBuffer(object)) return false;
  if (PyObject_GetBuffer(object, &view_, PyBUF_C_CONTIGUOUS | PyBUF_FORMAT) != 0) {
    PyErr_Clear();
    return false;
  }
  has_view_ = true;
  if (!is_double(view_) || view_.ndim > most_dimensions) {
    PyBuffer_Release(&view_);
    has_view_ = false;
    return false;
  }
  data_ = static_cast<const double*>(view_.buf);
  dimensions_ = view_.ndim;
  std::copy_n(view_.shape, view_.ndim, sizes_);
  return true;
}

bool Numbers::copy(PyObject* object, std::vector<double>& room) {
  if (!PyList_CheckExact(object) && !PyTuple_CheckExact(object)) return false;
  const auto count = PySequence_Fast_GET_SIZE(object);
  room.clear();
  for (py::ssize_t i = 0; i < count; ++i) {
    PyObject* const item = PySequence_Fast_GET_ITEM(object, i);
    if (!PyFloat_Check(item) && !(PyLong_Check(item) && !PyBool_Check(item))) return false;
    const double value = PyFloat_AsDouble(item);
    if (value == -1 && PyErr_Occurred()) throw py::error_already_set();
    room.push_back(value);
  }
  data_ = room.data();
  dimensions_ = 1;
  sizes_[0] = count;
  return true;
}

void Numbers::convert(PyObject* object, const std::string& what) {
  const py::object array = as_array(object);
  if (std::strchr("fiu", kind_of(array)[0]) == nullptr)
    throw py::type_error(what + " has the type " + py::str(array.attr("dtype")).cast<std::string>() + " (" +
                         Py_TYPE(object)->tp_name + "); expected an array of real numbers");
  const auto numbers = py::array_t<double, py::array::c_style | py::array::forcecast>::ensure(array);
  if (!numbers) throw py::error_already_set();
  if (numbers.ndim() > most_dimensions)
    throw py::value_error(what + " has " + std::to_string(numbers.ndim()) + " dimensions");
  data_ = numbers.data();
  dimensions_ = static_cast<int>(numbers.ndim());
  std::copy_n(numbers.shape(), numbers.ndim(), sizes_);
  converted_ = numbers;
}

std::string Numbers::shape() const { return text_of(sizes_, dimensions_); }

Room::Room(PyObject* object, std::size_t size) {
  if (PyObject_GetBuffer(object, &view_, PyBUF_C_CONTIGUOUS | PyBUF_FORMAT | PyBUF_WRITABLE) != 0) {
    PyErr_Clear();
    throw py::type_error(std::string("out is not a writable array of float64 in a row, but a ") +
                         Py_TYPE(object)->tp_name);
  }
  if (is_double(view_) && view_.ndim == 1 && view_.shape[0] == static_cast<py::ssize_t>(size)) return;
  const std::string found = text_of(view_.shape, view_.ndim) + " of type '" + (view_.format ? view_.format : "?") + "'";
  PyBuffer_Release(&view_);
  throw py::value_error("out has the shape " + found + "; expected (" + std::to_string(size) + ",) of float64");
}

namespace {

void check_time(bool is_good, const std::string& what, py::ssize_t i, const std::string& found) {
  if (!is_good)
    throw py::value_error(what + "[" + std::to_string(i) + "] is " + found +
                          ": times are finite and within 146 years of 0");
}

}  // namespace

Time to_instant(py::handle time, const char* name, bool is_optional) {
  const Time t = to_time(time, name);
  if (t == no_time && !is_optional) throw py::value_error(std::string(name) + " is NaT: a sample has a time");
  if (t != no_time && (t < -last_time || t > last_time))
    throw py::value_error(std::string(name) + " is " + std::to_string(t) + " ns: times are within 146 years of 0");
  return t;
}

std::vector<Time> to_times(py::handle given, const std::string& what, bool is_optional) {
  refuse_masked(given.ptr(), what);
  const py::object array = as_array(given);
  const std::string kind = kind_of(array);
  if (array.attr("ndim").cast<int>() != 1)
    throw py::value_error(what + " has the shape " + py::str(array.attr("shape")).cast<std::string>() +
                          "; expected (n,)");
  std::vector<Time> times;
  if (kind == "m") {
    const auto ticks =
        py::array_t<std::int64_t, py::array::c_style>::ensure(array.attr("astype")("m8[ns]").attr("view")("i8"));
    if (!ticks) throw py::error_already_set();
    times.assign(ticks.data(), ticks.data() + ticks.size());
    for (py::ssize_t i = 0; i < ticks.size(); ++i) {
      const Time t = times[static_cast<std::size_t>(i)];
      if (t == no_time)
        check_time(is_optional, what, i, "NaT");
      else
        check_time(std::abs(t) <= last_time, what, i, std::to_string(t) + " ns");
    }
    return times;
  }
  if (std::strchr("fiu", kind[0]) == nullptr && !(array.attr("size").cast<py::ssize_t>() == 0))
    throw py::type_error(what + " has the type " + py::str(array.attr("dtype")).cast<std::string>() +
                         "; expected numbers of seconds or numpy.timedelta64");
  const auto numbers = py::array_t<double, py::array::c_style | py::array::forcecast>::ensure(array);
  if (!numbers) throw py::error_already_set();
  times.resize(static_cast<std::size_t>(numbers.size()));
  for (py::ssize_t i = 0; i < numbers.size(); ++i) {
    const double s = numbers.data()[i];
    const bool is_none = is_optional && std::isnan(s);
    if (!is_none) check_time(std::abs(s) <= static_cast<double>(last_time) * 1e-9, what, i, std::to_string(s) + " s");
    times[static_cast<std::size_t>(i)] = is_none ? no_time : nanoseconds(s);
  }
  return times;
}

}  // namespace binnacle::python
