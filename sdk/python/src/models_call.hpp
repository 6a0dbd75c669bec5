// SPDX-License-Identifier: Apache-2.0
// A call from the kernel into Python: the GIL, what is raised, and what goes in and comes out as arrays.
#pragma once

#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "binnacle/model_input.hpp"
#include "binnacle/result.hpp"
#include "models.hpp"

namespace binnacle::python {

/// What is being raised, as C++ throws it: a ComponentError where Python made one, a std::runtime_error with the traceback
/// else. Ctrl-C is raised again where Python looks next. Holds the GIL.
[[noreturn]] void rethrow(py::error_already_set& raised);

template <class Call>
auto in_python(const Call& call) {
  const py::gil_scoped_acquire locked;
  try {
    return call();
  } catch (py::error_already_set& raised) {
    rethrow(raised);
  } catch (py::builtin_exception& raised) {
    raised.set_error();
    py::error_already_set as_python;
    rethrow(as_python);
  }
}

/// The package's own classes that calls need.
struct PythonNames {
  PythonNames();
  Held sample, driving, step, innovation, update, refusal;
};

/// A method of the object, with the names of the arguments that it takes beyond those of its role.
class Method {
 public:
  Method() = default;
  Method(const py::object& object, const char* name, const py::dict& extras);

  bool takes(const char* name) const;
  explicit operator bool() const { return static_cast<bool>(call_); }
  /// extras: all there are; those that it does not take are not handed on.
  template <class... Arguments>
  py::object operator()(const py::dict& extras, Arguments&&... arguments) const {
    return call_.get()(std::forward<Arguments>(arguments)..., **extras);
  }

 private:
  Held call_;
  std::vector<std::string> extras_;
};

/// Samples with fields by name.
class SampleNames {
 public:
  explicit SampleNames(const std::vector<FieldSpec>& fields = {});
  /// covariance_dof: of the channel's covariance.
  py::object operator()(const PythonNames& names, const SampleView& sample, int covariance_dof = 0) const;
  py::dict fields(const double* epoch) const;

 private:
  std::vector<Held> epoch_, row_;
};

/// Driving rates by name; None where there are none.
py::object to_python(const PythonNames& names, const Driving& u, const std::vector<FieldSpec>& rates);
/// Samples of auxiliary channels by input; None where one has emitted nothing yet.
py::dict to_python(const PythonNames& names, const AuxiliarySamples& auxiliary, const ComponentSpec& spec,
                   const std::vector<SampleNames>& inputs);
/// P by pairs of names.
py::dict to_python(const PortCovariance& P, const std::vector<Port>& ports, const ComponentSpec& spec);

/// A refusal that a model returned, its reason kept for good.
std::optional<Result> refusal_of(const PythonNames& names, const py::object& answer);
void leave(const Notes& notes, const py::list& texts);

/// What a model returned as numbers. `what` is how messages call it.
using ReturnedNumbers = py::array_t<double, py::array::forcecast>;
ReturnedNumbers numbers_of(const py::handle& value, const std::string& what);
/// `size` numbers; one number where size is 1.
void copy_vector(const py::handle& value, const std::string& what, int size, double* to);
/// rows × cols; a vector where one of both is 1, a number where both are.
void copy_matrix(const py::handle& value, const std::string& what, int rows, int cols, double* to, int stride);
/// size × size; a vector is its diagonal.
void copy_covariance(const py::handle& value, const std::string& what, int size, double* to, int stride);

}  // namespace binnacle::python
