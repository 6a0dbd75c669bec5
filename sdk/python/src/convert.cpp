// SPDX-License-Identifier: Apache-2.0
#include "convert.hpp"

#include <cmath>

namespace binnacle::python {

py::object to_python(const Json& json) {
  switch (json.type()) {
    case Json::value_t::null:
    case Json::value_t::discarded: return py::none();
    case Json::value_t::boolean: return py::bool_(json.get<bool>());
    case Json::value_t::number_integer: return py::int_(json.get<std::int64_t>());
    case Json::value_t::number_unsigned: return py::int_(json.get<std::uint64_t>());
    case Json::value_t::number_float:
      if (!std::isfinite(json.get<double>())) return py::none();
      return py::float_(json.get<double>());
    case Json::value_t::string: return py::str(json.get_ref<const std::string&>());
    case Json::value_t::binary: return py::bytes();
    case Json::value_t::array: {
      py::list list;
      for (const auto& item : json) list.append(to_python(item));
      return list;
    }
    case Json::value_t::object: {
      py::dict dict;
      for (const auto& [key, value] : json.items()) dict[py::str(key)] = to_python(value);
      return dict;
    }
  }
  return py::none();
}

namespace {

Time checked(double s, const char* name) {
  if (!(std::abs(s) <= static_cast<double>(last_time) * 1e-9))
    throw py::value_error(std::string(name) + " is " + std::to_string(s) +
                          " s: times are finite and within 146 years of 0");
  return nanoseconds(s);
}

}  // namespace

Time to_time(py::handle time, const char* name) {
  if (PyFloat_Check(time.ptr())) return checked(PyFloat_AS_DOUBLE(time.ptr()), name);
  if (PyLong_Check(time.ptr())) return checked(time.cast<double>(), name);
  // numpy's scalars.
  const py::object kind = py::getattr(time, "dtype", py::none());
  if (!kind.is_none() && py::getattr(time, "ndim", py::int_(1)).cast<int>() == 0) {
    const auto letter = kind.attr("kind").cast<std::string>();
    if (letter == "m") return time.attr("astype")("m8[ns]").attr("astype")("i8").cast<std::int64_t>();
    if (letter == "f" || letter == "i" || letter == "u")
      return checked(py::float_(py::reinterpret_borrow<py::object>(time)), name);
  }
  throw py::type_error(std::string(name) + " is of type '" + Py_TYPE(time.ptr())->tp_name +
                       "': a time is a number of seconds or a numpy.timedelta64");
}

}  // namespace binnacle::python
