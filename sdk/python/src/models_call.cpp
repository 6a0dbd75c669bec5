// SPDX-License-Identifier: Apache-2.0
#include "models_call.hpp"

#include <algorithm>
#include <mutex>
#include <set>
#include <stdexcept>

#include "binnacle/parameters.hpp"
#include "models_spec.hpp"

namespace binnacle::python {

void rethrow(py::error_already_set& raised) {
  if (raised.matches(PyExc_KeyboardInterrupt)) {
    PyErr_SetInterrupt();
    throw std::runtime_error("KeyboardInterrupt");
  }
  const py::module_ models = py::module_::import("binnacle._models");
  if (raised.matches(models.attr("ComponentError"))) {
    const py::object error = raised.value();
    throw ComponentError(py::str(error).cast<std::string>(), error.attr("pointer").cast<std::string>());
  }
  const py::object trace = raised.trace() ? raised.trace() : py::object(py::none());
  throw std::runtime_error(models.attr("traceback_of")(raised.value(), trace).cast<std::string>());
}

PythonNames::PythonNames() {
  const py::gil_scoped_acquire locked;
  const py::module_ models = py::module_::import("binnacle._models");
  const auto get = [&](const char* name) { return Held(models.attr(name)); };
  sample = get("Sample");
  driving = get("Driving");
  step = get("Step");
  innovation = get("Innovation");
  update = get("AfterUpdate");
  refusal = get("Refusal");
}

Method::Method(const py::object& object, const char* name, const py::dict& extras) : call_(object.attr(name)) {
  if (!extras.contains(name)) return;
  for (const auto& extra : extras[name]) extras_.push_back(extra.cast<std::string>());
}

bool Method::takes(const char* name) const { return std::find(extras_.begin(), extras_.end(), name) != extras_.end(); }

// ---- samples

SampleNames::SampleNames(const std::vector<FieldSpec>& fields) {
  for (const auto& field : fields) (field.is_per_row ? row_ : epoch_).emplace_back(py::str(field.name));
}

py::dict SampleNames::fields(const double* epoch) const {
  py::dict dict;
  for (std::size_t i = 0; i < epoch_.size(); ++i) dict[epoch_[i].get()] = py::float_(epoch[i]);
  return dict;
}

py::object SampleNames::operator()(const PythonNames& names, const SampleView& sample, int covariance_dof) const {
  py::dict dict = fields(sample.fields);
  const auto width = static_cast<py::ssize_t>(row_.size());
  for (py::ssize_t i = 0; i < width; ++i) {
    py::array_t<double> column(sample.rows);
    double* const to = column.mutable_data();
    for (int row = 0; row < sample.rows; ++row) to[row] = sample.row_fields[row * width + i];
    dict[row_[static_cast<std::size_t>(i)].get()] = sealed(std::move(column));
  }
  const auto time = [](Time t) { return t == no_time ? py::object(py::none()) : py::object(py::int_(t)); };
  const py::object covariance =
      sample.covariance && covariance_dof > 0
          ? py::object(sealed(copy_of(sample.covariance, covariance_dof, covariance_dof, covariance_dof)))
          : py::object(py::none());
  return names.sample.get()(dict, time(sample.t), time(sample.t0), sample.rows, covariance);
}

py::object to_python(const PythonNames& names, const Driving& u, const std::vector<FieldSpec>& rates) {
  py::object by_name = py::none();
  if (u.rates) {
    py::dict dict;
    for (std::size_t i = 0; i < rates.size(); ++i) dict[py::str(rates[i].name)] = u.rates.data()[i];
    by_name = dict;
  }
  return names.driving.get()(u.t == no_time ? py::object(py::none()) : py::object(py::int_(u.t)), by_name, u.bridges);
}

py::dict to_python(const PythonNames& names, const AuxiliarySamples& auxiliary, const ComponentSpec& spec,
                   const std::vector<SampleNames>& inputs) {
  py::dict dict;
  for (std::size_t i = 0; i < inputs.size(); ++i) {
    const SampleView& sample = auxiliary[Input(static_cast<int>(i))];
    dict[py::str(spec.inputs[i].name)] = sample.available ? inputs[i](names, sample) : py::object(py::none());
  }
  return dict;
}

py::dict to_python(const PortCovariance& P, const std::vector<Port>& ports, const ComponentSpec& spec) {
  py::dict dict;
  for (const Port a : ports)
    for (const Port b : ports)
      if (const ConstMatrixView block = P(a, b))
        dict[py::make_tuple(spec.ports[static_cast<std::size_t>(a.index())].name,
                            spec.ports[static_cast<std::size_t>(b.index())].name)] =
            sealed(copy_of(block.data, block.rows, block.cols, block.stride));
  return dict;
}

// ---- refusals and notes

namespace {

/// A reason is a text with static lifetime, and a model may make one anew for each sample.
const char* kept_for_good(const std::string& reason) {
  static auto& mutex = *new std::mutex;
  static auto& reasons = *new std::set<std::string>;
  constexpr std::size_t most = 4096;
  const std::lock_guard lock(mutex);
  if (reasons.size() >= most && !reasons.contains(reason))
    return "one of more reasons than are kept: leave numbers out of them";
  return reasons.insert(reason).first->c_str();
}

}  // namespace

std::optional<Result> refusal_of(const PythonNames& names, const py::object& answer) {
  if (!py::isinstance(answer, names.refusal.get())) return std::nullopt;
  const char* const reason = kept_for_good(answer.attr("reason").cast<std::string>());
  const auto kind = answer.attr("kind").cast<std::string>();
  if (kind == "unsupported") return Result::unsupported(reason);
  if (kind == "invalid") return Result::invalid(reason);
  return Result::failed(reason);
}

void leave(const Notes& notes, const py::list& texts) {
  for (const auto& text : texts) notes.leave(py::str(text).cast<std::string>().c_str());
}

// ---- numbers

namespace {

std::string shape_of(const ReturnedNumbers& array) {
  return "of shape " + py::str(py::reinterpret_borrow<py::object>(array).attr("shape")).cast<std::string>();
}

[[noreturn]] void refuse(const std::string& what, const ReturnedNumbers& found, const std::string& expected) {
  throw py::value_error(what + " is " + shape_of(found) + "; it takes " + expected);
}

std::string pair_text(int rows, int cols) { return "(" + std::to_string(rows) + ", " + std::to_string(cols) + ")"; }

}  // namespace

ReturnedNumbers numbers_of(const py::handle& value, const std::string& what) {
  if (!value.is_none())
    if (const ReturnedNumbers array = ReturnedNumbers::ensure(value)) return array;
  PyErr_Clear();
  throw py::type_error(what + " is " + py::repr(value).cast<std::string>() + ", which is not an array of numbers");
}

void copy_vector(const py::handle& value, const std::string& what, int size, double* to) {
  const ReturnedNumbers array = numbers_of(value, what);
  if (array.ndim() > 1 || array.size() != size || (array.ndim() == 0 && size != 1))
    refuse(what, array, "(" + std::to_string(size) + ",)");
  if (array.ndim() == 0)
    to[0] = *array.data();
  else
    for (py::ssize_t i = 0; i < size; ++i) to[i] = array.at(i);
}

void copy_matrix(const py::handle& value, const std::string& what, int rows, int cols, double* to, int stride) {
  const ReturnedNumbers array = numbers_of(value, what);
  if (array.ndim() == 2 && array.shape(0) == rows && array.shape(1) == cols) {
    const auto from = array.unchecked<2>();
    for (int j = 0; j < cols; ++j)
      for (int i = 0; i < rows; ++i) to[i + static_cast<std::ptrdiff_t>(j) * stride] = from(i, j);
  } else if (array.ndim() < 2 && array.size() == rows * cols && (rows == 1 || cols == 1)) {
    for (int i = 0; i < rows * cols; ++i)
      to[rows == 1 ? static_cast<std::ptrdiff_t>(i) * stride : i] = array.ndim() == 0 ? *array.data() : array.at(i);
  } else {
    refuse(what, array, pair_text(rows, cols));
  }
}

void copy_covariance(const py::handle& value, const std::string& what, int size, double* to, int stride) {
  const ReturnedNumbers array = numbers_of(value, what);
  if (array.ndim() == 2) return copy_matrix(array, what, size, size, to, stride);
  if (array.size() != size || (array.ndim() == 0 && size != 1))
    refuse(what, array, pair_text(size, size) + ", or the variances of its rows");
  for (int j = 0; j < size; ++j)
    for (int i = 0; i < size; ++i)
      to[i + static_cast<std::ptrdiff_t>(j) * stride] = i != j ? 0 : array.ndim() == 0 ? *array.data() : array.at(i);
}

}  // namespace binnacle::python
