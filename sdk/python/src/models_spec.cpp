// SPDX-License-Identifier: Apache-2.0
#include "models_spec.hpp"

#include <utility>

#include <pybind11/stl.h>

#include "models.hpp"

namespace binnacle::python {

namespace {

std::string json_of(const py::handle& value) {
  return py::module_::import("json").attr("dumps")(value).cast<std::string>();
}

template <class T>
T member(const py::object& spec, const char* name) {
  const py::object value = spec.attr(name);
  try {
    return value.cast<T>();
  } catch (const py::cast_error&) {
    throw py::type_error(std::string("spec.") + name + " is " + py::repr(value).cast<std::string>() +
                         ", which is not what it takes");
  }
}

template <class Spec>
py::class_<Spec> bind_fluent(py::module_& module, const char* name) {
  return py::class_<Spec>(module, name)
      .def_readonly("name", &Spec::name)
      .def(
          "about", [](Spec self, std::string line) -> Spec { return std::move(self).about(std::move(line)); },
          py::arg("line"));
}

void bind_parameter(py::module_& module) {
  using P = ParameterSpec;
  bind_fluent<P>(module, "ParameterSpec")
      .def("required", [](P self) -> P { return std::move(self).required(); })
      .def(
          "defaults", [](P self, py::handle value) -> P { return std::move(self).defaults(json_of(value)); },
          py::arg("value"))
      .def(
          "above", [](P self, double bound) -> P { return std::move(self).above(bound); }, py::arg("bound"))
      .def(
          "at_least", [](P self, double bound) -> P { return std::move(self).at_least(bound); }, py::arg("bound"))
      .def(
          "below", [](P self, double bound) -> P { return std::move(self).below(bound); }, py::arg("bound"))
      .def(
          "at_most", [](P self, double bound) -> P { return std::move(self).at_most(bound); }, py::arg("bound"))
      .def(
          "plausible", [](P self, double least, double most) -> P { return std::move(self).plausible(least, most); },
          py::arg("least"), py::arg("most"))
      .def(
          "sized_by", [](P self, std::string port) -> P { return std::move(self).sized_by(std::move(port)); },
          py::arg("port"))
      .def(
          "formerly", [](P self, std::string key) -> P { return std::move(self).formerly(std::move(key)); },
          py::arg("key"));
  module.def("number", &parameter::number, py::arg("name"), py::arg("unit"));
  module.def("integer", &parameter::integer, py::arg("name"));
  module.def("boolean", &parameter::boolean, py::arg("name"));
  module.def("text", &parameter::text, py::arg("name"));
  module.def("path", &parameter::path, py::arg("name"));
  module.def("time", &parameter::time, py::arg("name"));
  module.def("choice", &parameter::choice, py::arg("name"), py::arg("choices"));
  module.def("vector", &parameter::vector, py::arg("name"), py::arg("unit"), py::arg("size") = P::any_size);
  module.def("matrix", &parameter::matrix, py::arg("name"), py::arg("unit"), py::arg("rows") = P::any_size,
             py::arg("cols") = P::any_size);
  module.def("object_of", &parameter::object, py::arg("name"), py::arg("members"));
  module.def("list_of", &parameter::list, py::arg("name"), py::arg("element"));
  module.def("map_of", &parameter::map, py::arg("name"), py::arg("element"));
}

void bind_ports_and_fields(py::module_& module) {
  bind_fluent<PortSpec>(module, "PortSpec")
      .def("optional", [](PortSpec self) -> PortSpec { return std::move(self).optional(); })
      .def(
          "formerly",
          [](PortSpec self, std::string port) -> PortSpec { return std::move(self).formerly(std::move(port)); },
          py::arg("port"));
  module.def("reads", &reads, py::arg("name"), py::arg("kind"), py::arg("text") = "");
  module.def("advances", &advances, py::arg("name"), py::arg("kind"), py::arg("text") = "");
  bind_fluent<FieldSpec>(module, "FieldSpec")
      .def("optional", [](FieldSpec self) -> FieldSpec { return std::move(self).optional(); })
      .def("per_row", [](FieldSpec self) -> FieldSpec { return std::move(self).per_row(); });
  module.def("field", &field::level, py::arg("name"), py::arg("unit"));
  module.def("rate", &field::rate, py::arg("name"), py::arg("unit"));
  module.def("increment", &field::increment, py::arg("name"), py::arg("unit"));
  bind_fluent<ChannelPort>(module, "ChannelPort").def("optional", [](ChannelPort self) -> ChannelPort {
    return std::move(self).optional();
  });
  module.def("input", &input, py::arg("name"), py::arg("fields"));
}

// ---- parameters

py::object python_value(const ParameterValue& value, const ParameterSpec& spec) {
  switch (spec.type) {
    case ParameterType::number: return py::float_(value.number);
    case ParameterType::integer: return py::int_(value.integer);
    case ParameterType::boolean: return py::bool_(value.boolean);
    case ParameterType::text:
    case ParameterType::choice:
    case ParameterType::path: return py::str(value.text);
    case ParameterType::time: return py::float_(seconds(value.integer));
    case ParameterType::vector:
      return sealed(copy_of(value.numbers.data(), static_cast<py::ssize_t>(value.numbers.size())));
    case ParameterType::matrix: return sealed(copy_of(value.numbers.data(), value.rows, value.cols, value.rows));
    case ParameterType::list: {
      py::list list;
      for (const auto& element : value.elements) list.append(python_value(element, spec.members.at(0)));
      return list;
    }
    case ParameterType::map: {
      py::dict dict;
      for (const auto& [key, element] : value.members) dict[py::str(key)] = python_value(element, spec.members.at(0));
      return dict;
    }
    case ParameterType::object: return binnacle::python::to_python(Parameters(value), spec.members);
  }
  return py::none();
}

/// As a ParameterValue, which Parameters does not give away.
ParameterValue value_of(const Parameters& parameters, const ParameterSpec& spec) {
  ParameterValue value;
  const auto& name = spec.name;
  const auto numbers = [&](const auto& matrix) {
    value.numbers.assign(matrix.data(), matrix.data() + matrix.size());
    value.rows = static_cast<int>(matrix.rows());
    value.cols = static_cast<int>(matrix.cols());
  };
  switch (spec.type) {
    case ParameterType::number: value.number = parameters.number(name); break;
    case ParameterType::integer: value.integer = parameters.integer(name); break;
    case ParameterType::boolean: value.boolean = parameters.boolean(name); break;
    case ParameterType::text:
    case ParameterType::choice:
    case ParameterType::path: value.text = parameters.text(name); break;
    case ParameterType::time: value.integer = parameters.time(name); break;
    case ParameterType::vector: numbers(parameters.vector(name)); break;
    case ParameterType::matrix: numbers(parameters.matrix(name)); break;
    case ParameterType::list: value.elements = parameters.list(name); break;
    case ParameterType::map:
    case ParameterType::object: value.members = parameters.members(name); break;
  }
  return value;
}

}  // namespace

py::dict to_python(const Parameters& parameters, const std::vector<ParameterSpec>& specs) {
  py::dict dict;
  for (const auto& spec : specs)
    if (parameters.has(spec.name)) dict[py::str(spec.name)] = python_value(value_of(parameters, spec), spec);
  return dict;
}

ComponentSpec spec_of(const std::string& type, const py::object& spec) {
  ComponentSpec made;
  made.type = type;
  made.summary = member<std::string>(spec, "summary");
  made.source = member<std::string>(spec, "source");
  made.parameters = member<std::vector<ParameterSpec>>(spec, "parameters");
  made.ports = member<std::vector<PortSpec>>(spec, "ports");
  made.fields = member<std::vector<FieldSpec>>(spec, "fields");
  made.driving_rates = member<std::vector<FieldSpec>>(spec, "driving_rates");
  made.inputs = member<std::vector<ChannelPort>>(spec, "inputs");
  made.kind = member<std::string>(spec, "kind");
  for (const auto& [from, to] : {std::pair{"example", &made.example}, std::pair{"surroundings", &made.surroundings}})
    if (const py::object value = spec.attr(from); !value.is_none()) *to = json_of(value);
  return made;
}

py::array_t<double> copy_of(const double* numbers, py::ssize_t count) { return py::array_t<double>(count, numbers); }

py::array_t<double> copy_of(const double* numbers, int rows, int columns, int stride) {
  py::array_t<double> array({rows, columns});
  auto to = array.mutable_unchecked<2>();
  for (int j = 0; j < columns; ++j)
    for (int i = 0; i < rows; ++i) to(i, j) = numbers[i + static_cast<std::ptrdiff_t>(j) * stride];
  return array;
}

py::array_t<double> sealed(py::array_t<double> array) {
  py::detail::array_proxy(array.ptr())->flags &= ~py::detail::npy_api::NPY_ARRAY_WRITEABLE_;
  return array;
}

void bind_model_specs(py::module_& module) {
  bind_parameter(module);
  bind_ports_and_fields(module);
}

}  // namespace binnacle::python
