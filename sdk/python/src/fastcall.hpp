// SPDX-License-Identifier: Apache-2.0
// Methods that are called once a sample: by CPython's own convention (METH_FASTCALL), past pybind11's dispatch, which takes
// as long as a filter's step. They are added to classes that pybind11 made.
#pragma once

#include <array>
#include <cstddef>
#include <exception>
#include <stdexcept>
#include <string>

#include "errors.hpp"

namespace binnacle::python {

/// Arguments by position in `names`, of which the first `required` have to be there; null: not given.
template <std::size_t N>
std::array<PyObject*, N> arguments_of(const char* method, const std::array<const char*, N>& names, std::size_t required,
                                      PyObject* const* given, py::ssize_t count, PyObject* keywords) {
  std::array<PyObject*, N> arguments{};
  const std::string call = std::string(method) + "()";
  if (count > static_cast<py::ssize_t>(N))
    throw py::type_error(call + " takes at most " + std::to_string(N) + " arguments; got " + std::to_string(count));
  for (py::ssize_t i = 0; i < count; ++i) arguments[static_cast<std::size_t>(i)] = given[i];
  const py::ssize_t named = keywords ? PyTuple_GET_SIZE(keywords) : 0;
  for (py::ssize_t k = 0; k < named; ++k) {
    PyObject* const keyword = PyTuple_GET_ITEM(keywords, k);
    std::size_t i = 0;
    while (i < N && PyUnicode_CompareWithASCIIString(keyword, names[i]) != 0) ++i;
    if (i == N) throw py::type_error(call + " has no argument '" + py::str(keyword).cast<std::string>() + "'");
    if (arguments[i]) throw py::type_error(call + " got '" + names[i] + "' twice");
    arguments[i] = given[count + k];
  }
  for (std::size_t i = 0; i < required; ++i)
    if (!arguments[i]) throw py::type_error(call + " lacks the argument '" + names[i] + "'");
  for (auto*& argument : arguments)
    if (argument == Py_None) argument = nullptr;
  return arguments;
}

/// Calls, and leaves what is thrown as Python's exception: as pybind11 does it, with Binnacle's own errors.
template <class Call>
PyObject* guarded(Call&& call) noexcept {
  try {
    try {
      return call();
    } catch (const Error& error) {
      raise(error);
    }
  } catch (py::error_already_set& error) {
    error.restore();
  } catch (const py::builtin_exception& error) {
    error.set_error();
  } catch (const std::out_of_range& error) {
    PyErr_SetString(PyExc_IndexError, error.what());
  } catch (const std::invalid_argument& error) {
    PyErr_SetString(PyExc_ValueError, error.what());
  } catch (const std::bad_alloc&) {
    PyErr_NoMemory();
  } catch (const std::exception& error) {
    PyErr_SetString(PyExc_RuntimeError, error.what());
  }
  return nullptr;
}

/// The C++ object of a class that pybind11 made with a holder and one base: what it points to. Throws RuntimeError where a
/// subclass has not called __init__ of its base yet.
template <class T>
T& content_of(PyObject* self) {
  auto* const instance = reinterpret_cast<py::detail::instance*>(self);
  void* const content = instance->simple_layout ? instance->simple_value_holder[0] : nullptr;
  if (!content) throw std::runtime_error("this object was not made: its base's __init__ has not been called");
  return *static_cast<T*>(content);
}

using FastCall = PyObject* (*)(PyObject* self, PyObject* const* arguments, py::ssize_t count, PyObject* keywords);

/// Adds a method to a class. `definition` lives as long as the module.
inline void add_method(py::handle type, PyMethodDef& definition) {
  const auto method =
      py::reinterpret_steal<py::object>(PyDescr_NewMethod(reinterpret_cast<PyTypeObject*>(type.ptr()), &definition));
  if (!method) throw py::error_already_set();
  type.attr(definition.ml_name) = method;
}

}  // namespace binnacle::python
