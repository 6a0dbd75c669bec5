// SPDX-License-Identifier: Apache-2.0
#include "errors.hpp"

#include <exception>

#include "wording/diagnostics_json.hpp"

namespace binnacle::python {

py::list to_python(const Diagnostics& diagnostics) {
  const py::object make = py::module_::import("binnacle._errors").attr("Diagnostic");
  py::list list;
  for (const auto& item : wording::to_json(diagnostics)) list.append(make(**py::dict(to_python(item))));
  return list;
}

void raise(const Error& error) {
  const py::object make = py::module_::import("binnacle._errors").attr("error_of");
  const py::object exception = make(error.exit_status(), error.what(), to_python(error.diagnostics()));
  PyErr_SetObject(py::type::of(exception).ptr(), exception.ptr());
}

void bind_errors(py::module_&) {
  py::register_exception_translator([](std::exception_ptr thrown) {
    try {
      if (thrown) std::rethrow_exception(thrown);
    } catch (const Error& error) {
      raise(error);
    }
  });
}

}  // namespace binnacle::python
