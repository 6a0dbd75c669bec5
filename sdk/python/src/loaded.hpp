// SPDX-License-Identifier: Apache-2.0
// A config as Python holds it: composed, with what it was loaded with, for the verbs that compose it anew.
#pragma once

#include <exception>
#include <filesystem>
#include <memory>

#include "binnacle/composition.hpp"
#include "convert.hpp"

namespace binnacle::python {

struct Loaded {
  std::filesystem::path path;                      // of the config, or what messages call it
  LoadOptions options;                             // its text included, where it was none of a file
  std::shared_ptr<const Composition> composition;  // none where it is complete only as a variant of its study
  std::exception_ptr failure;                      // why not

  /// Throws what is missing where it is complete only as a variant of its study.
  const std::shared_ptr<const Composition>& composed() const {
    if (failure) std::rethrow_exception(failure);
    return composition;
  }
};

void bind_composition(py::module_& module);

}  // namespace binnacle::python
