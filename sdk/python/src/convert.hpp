// SPDX-License-Identifier: Apache-2.0
// What crosses between C++ and Python: JSON, and arrays of numbers that are moved and not copied.
#pragma once

#include <utility>
#include <vector>

#include <pybind11/numpy.h>
#include <pybind11/pybind11.h>
#include <nlohmann/json.hpp>

#include "binnacle/time.hpp"

namespace binnacle::python {

namespace py = pybind11;

using Json = nlohmann::ordered_json;

/// Dicts, lists, numbers and texts; a number that is not finite is null in JSON, and None.
py::object to_python(const Json& json);

/// The numbers move into the array, which owns them: its memory is theirs.
template <class T>
py::array_t<T> to_array(std::vector<T>&& numbers, std::vector<py::ssize_t> shape) {
  auto* const owned = new std::vector<T>(std::move(numbers));
  const py::capsule owner(owned, [](void* memory) { delete static_cast<std::vector<T>*>(memory); });
  return py::array_t<T>(std::move(shape), owned->data(), owner);
}
template <class T>
py::array_t<T> to_array(std::vector<T>&& numbers) {
  const auto size = static_cast<py::ssize_t>(numbers.size());
  return to_array(std::move(numbers), {size});
}

inline constexpr Time last_time = Time{1} << 62;  // so that differences are exact: 146 years

/// Seconds (float, int) or numpy.timedelta64, which is exact. Throws py::type_error that names what was found, ValueError
/// for what is not finite or beyond ±146 years.
Time to_time(py::handle time, const char* name);

}  // namespace binnacle::python
