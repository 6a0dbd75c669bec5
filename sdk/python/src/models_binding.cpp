// SPDX-License-Identifier: Apache-2.0
#include "models_binding.hpp"

#include <algorithm>
#include <bit>
#include <cstring>

#include <pybind11/stl.h>

#include "models_spec.hpp"

namespace binnacle::python {

// ---- memory

MemoryLayout::Item MemoryLayout::described(const std::string& name, const py::handle& value) {
  Item item{name, false, true, {}, 0, 1};
  if (PyFloat_Check(value.ptr())) return item;
  if (PyLong_Check(value.ptr()) && !PyBool_Check(value.ptr())) {
    item.is_integer = true;
    return item;
  }
  if (!py::isinstance<py::array>(value))
    throw py::type_error("memory '" + name + "' starts as " + py::repr(value).cast<std::string>() +
                         ": what a model remembers is a float, an int, or a numpy array of either");
  const auto array = py::reinterpret_borrow<py::array>(value);
  item.is_integer = array.dtype().kind() == 'i' || array.dtype().kind() == 'u';
  if (!item.is_integer && array.dtype().kind() != 'f')
    throw py::type_error("memory '" + name + "' is an array of " + py::str(array.dtype()).cast<std::string>() +
                         ": it takes float64 or int64");
  item.is_scalar = false;
  item.shape.assign(array.shape(), array.shape() + array.ndim());
  item.count = static_cast<std::size_t>(array.size());
  return item;
}

void MemoryLayout::store(const Item& item, const py::handle& value, std::uint64_t* words) {
  const auto refuse = [&](const std::string& what) {
    throw py::value_error("memory '" + item.name + "' has become " + py::repr(value).cast<std::string>() + ": " + what);
  };
  if (item.is_scalar && item.is_integer) {
    words[item.first] =
        std::bit_cast<std::uint64_t>(py::int_(py::reinterpret_borrow<py::object>(value)).cast<std::int64_t>());
  } else if (item.is_scalar) {
    words[item.first] =
        std::bit_cast<std::uint64_t>(py::float_(py::reinterpret_borrow<py::object>(value)).cast<double>());
  } else {
    const auto copy = [&](const auto& array) {
      if (!array) throw py::error_already_set();
      if (!std::equal(item.shape.begin(), item.shape.end(), array.shape(), array.shape() + array.ndim()))
        refuse("it keeps the shape that it was declared with");
      if (item.count > 0) std::memcpy(words + item.first, array.data(), item.count * sizeof(std::uint64_t));
    };
    constexpr int how = py::array::c_style | py::array::forcecast;
    if (item.is_integer)
      copy(py::array_t<std::int64_t, how>::ensure(value));
    else
      copy(py::array_t<double, how>::ensure(value));
  }
}

void MemoryLayout::add(const py::dict& items) {
  for (const auto& [key, value] : items) {
    Item item = described(key.cast<std::string>(), value);
    if (std::any_of(items_.begin(), items_.end(), [&](const Item& other) { return other.name == item.name; }))
      throw py::value_error("memory '" + item.name + "' is declared twice");
    item.first = initial_.size();
    initial_.resize(item.first + item.count);
    store(item, value, initial_.data());
    items_.push_back(std::move(item));
  }
}

void MemoryLayout::write_initial(std::byte* memory) const {
  if (!initial_.empty()) std::memcpy(memory, initial_.data(), initial_.size() * sizeof(std::uint64_t));
}

py::dict MemoryLayout::read(const std::byte* memory) const {
  py::dict dict;
  for (const auto& item : items_) {
    const std::byte* const at = memory + item.first * sizeof(std::uint64_t);
    py::object value;
    if (!item.is_scalar) {
      const auto array = item.is_integer ? py::array(py::array_t<std::int64_t>(item.shape))
                                         : py::array(py::array_t<double>(item.shape));
      if (item.count > 0) std::memcpy(const_cast<void*>(array.data()), at, item.count * sizeof(std::uint64_t));
      value = array;
    } else if (item.is_integer) {
      std::int64_t number = 0;
      std::memcpy(&number, at, sizeof number);
      value = py::int_(number);
    } else {
      double number = 0;
      std::memcpy(&number, at, sizeof number);
      value = py::float_(number);
    }
    dict[py::str(item.name)] = value;
  }
  return dict;
}

void MemoryLayout::write(const py::dict& items, std::byte* memory) const {
  if (items.size() != items_.size())
    throw py::key_error("memory holds " + py::str(py::list(items)).cast<std::string>() +
                        ", which is not what the model declared: binding.keeps({…}) in __init__");
  std::vector<std::uint64_t> words(initial_.size());
  for (const auto& item : items_) {
    const py::str key(item.name);
    if (!items.contains(key)) throw py::key_error("memory '" + item.name + "' is gone");
    store(item, items[key], words.data());
  }
  if (!words.empty()) std::memcpy(memory, words.data(), words.size() * sizeof(std::uint64_t));
}

// ---- binding

ModelBinding::ModelBinding(const Binding& binding, const ModelClass& model, const NoiseBinding* noise)
    : binding_(&binding), model_(&model) {
  if (!noise) return;
  max_rows = noise->max_rows;
  for (const auto& group : noise->groups) noise_groups.emplace_back(group.name, group.unit);
}

const Binding& ModelBinding::binding() const {
  if (!binding_)
    throw std::runtime_error("the binding is over: a model asks and declares in its __init__, and nowhere else");
  return *binding_;
}

py::dict ModelBinding::parameters() const { return to_python(binding().parameters(), model_->spec.parameters); }

py::dict ModelBinding::ports() const {
  const py::object make = py::module_::import("binnacle._models").attr("Port");
  py::dict dict;
  for (const auto& port : binding().ports()) {
    py::list components;
    for (const auto& component : port.components) components.append(py::make_tuple(component.name, component.unit));
    dict[py::str(port.name)] = make(port.bound, port.kind, port.dof, port.stored_size, components);
  }
  return dict;
}

bool ModelBinding::is_bound(const std::string& name) const {
  for (const auto& port : binding().ports())
    if (port.name == name) return port.bound;
  for (const auto& field : model_->spec.fields)
    if (field.name == name)
      return field.is_per_row ? binding().row_field(name).is_bound() : binding().field(name).is_bound();
  for (const auto& input : model_->spec.inputs)
    if (input.name == name) return binding().input(name).is_bound();
  throw py::key_error("the spec declares neither a port nor a field nor an input '" + name + "'");
}

std::vector<std::pair<std::string, std::string>> ModelBinding::covariance(
    const std::optional<std::string>& input) const {
  std::vector<std::pair<std::string, std::string>> components;
  const auto& all = input ? binding().covariance(binding().input(*input)) : binding().covariance();
  for (const auto& component : all) components.emplace_back(component.name, component.unit);
  return components;
}

namespace {

using Pair = std::pair<std::string, std::string>;

void group(ModelBinding& self, std::string name, std::optional<std::string> port, int rows, std::string unit) {
  if (port) self.port(*port);
  if (!port && unit.empty())
    throw py::value_error("group '" + name + "' needs a port, whose error its rows are, or a unit");
  self.groups.push_back({std::move(name), std::move(port), rows, std::move(unit)});
}

void add_pair(ModelBinding& self, std::optional<std::vector<Pair>>& to, const std::string& a, const std::string& b) {
  self.port(a), self.port(b);
  if (!to) to.emplace();
  to->emplace_back(a, b);
}

void emits(ModelBinding& self, const std::string& name, std::vector<FieldSpec> fields, int max_rows,
           const std::vector<Pair>& covariance) {
  self.binding();
  ChannelDeclaration channel(name, std::move(fields));
  channel.max_rows = max_rows;
  for (const auto& [component, unit] : covariance) channel.covariance.push_back({component, unit});
  if (channel.count(true) > 0 && max_rows < 1)
    throw py::value_error("channel '" + name + "' has fields per row: it needs max_rows");
  self.channels.push_back(std::move(channel));
}

void yields(ModelBinding& self, const std::string& kind, int stored_size, const std::vector<Pair>& components) {
  self.binding();
  PortBinding block;
  block.kind = kind;
  block.stored_size = stored_size;
  for (const auto& [name, unit] : components) block.components.push_back({name, unit});
  self.yields = std::move(block);
}

}  // namespace

void bind_model_bindings(py::module_& module) {
  using B = ModelBinding;
  py::class_<B, std::shared_ptr<B>>(module, "Binding")
      .def_property_readonly("name", [](const B& self) { return self.binding().name(); })
      .def_property_readonly("parameters", &B::parameters)
      .def_property_readonly("ports", &B::ports)
      .def("is_bound", &B::is_bound, py::arg("name"))
      .def("covariance", &B::covariance, py::arg("input") = py::none())
      .def_property_readonly("samples_per_step", [](const B& self) { return self.binding().samples_per_step(); })
      .def_readonly("max_rows", &B::max_rows)
      .def_readonly("groups", &B::noise_groups)
      .def(
          "figure",
          [](const B& self, std::string name, double value, std::string unit) {
            self.binding().figure(std::move(name), value, std::move(unit));
          },
          py::arg("name"), py::arg("value"), py::arg("unit"))
      .def(
          "note", [](const B& self, std::string text) { self.binding().note(std::move(text)); }, py::arg("message"))
      .def(
          "rows", [](B& self, int most) { self.binding(), self.rows = most; }, py::arg("most"))
      .def("group", &group, py::arg("name"), py::arg("port") = py::none(), py::arg("rows") = 0, py::arg("unit") = "")
      .def("reads",
           [](B& self, const py::args& ports) {
             self.reads.emplace();
             for (const auto& port : ports) self.port(self.reads->emplace_back(port.cast<std::string>()));
           })
      .def("wants_covariance", [](B& self) { self.binding(), self.wants_covariance = true; })
      .def("judged_by_nominal", [](B& self) { self.binding(), self.is_judged_by_nominal = true; })
      .def(
          "couples",
          [](B& self, const std::string& to, const std::string& from) { add_pair(self, self.couples, to, from); },
          py::arg("to"), py::arg("from_"))
      .def(
          "adds_noise",
          [](B& self, const std::string& a, const std::string& b) { add_pair(self, self.adds_noise, a, b); },
          py::arg("to"), py::arg("from_"))
      .def(
          "step",
          [](B& self, const std::string& port, double size) {
            self.port(port);
            if (!(size > 0)) throw py::value_error("the step on port '" + port + "' is not above 0");
            self.steps[port] = size;
          },
          py::arg("port"), py::arg("size"))
      .def(
          "constants",
          [](B& self, std::vector<double> numbers) { self.binding(), self.constants = std::move(numbers); },
          py::arg("numbers"))
      .def(
          "keeps", [](B& self, const py::dict& items) { self.binding(), self.memory.add(items); }, py::arg("items"))
      .def("yields", &yields, py::arg("kind"), py::arg("stored_size"), py::arg("components"))
      .def(
          "yields_like", [](B& self, const std::string& port) { self.yields = self.binding().block(port); },
          py::arg("port"))
      .def("emits", &emits, py::arg("name"), py::arg("fields"), py::arg("max_rows") = 0,
           py::arg("covariance") = std::vector<Pair>());
}

}  // namespace binnacle::python
