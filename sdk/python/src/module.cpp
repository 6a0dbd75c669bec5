// SPDX-License-Identifier: Apache-2.0
// binnacle._core: what of the package is C++. Nobody imports it but the package.
#include <pybind11/pybind11.h>

#include "analyses.hpp"
#include "arrays.hpp"
#include "binnacle/version.hpp"
#include "conformance.hpp"
#include "errors.hpp"
#include "loaded.hpp"
#include "models.hpp"
#include "observers.hpp"
#include "results.hpp"
#include "run.hpp"
#include "session.hpp"

PYBIND11_MODULE(_core, module) {
  module.attr("version") = BINNACLE_VERSION;
  binnacle::python::bind_errors(module);
  binnacle::python::bind_composition(module);
  binnacle::python::bind_results(module);
  binnacle::python::bind_observers(module);
  binnacle::python::bind_run(module);
  binnacle::python::bind_session(module);
  binnacle::python::bind_arrays(module);
  binnacle::python::bind_analyses(module);
  binnacle::python::bind_models(module);
  binnacle::python::bind_conform(module);
}
