// SPDX-License-Identifier: Apache-2.0
#include "arrays.hpp"

#include <map>
#include <mutex>
#include <optional>
#include <utility>

#include <pybind11/stl.h>

#include "arrays_source.hpp"
#include "binnacle/unit.hpp"
#include "kept.hpp"
#include "numbers.hpp"

namespace binnacle::python {

namespace {

/// All arrays that something still refers to, by their content.
class Table {
 public:
  std::shared_ptr<const ArrayData> put(std::shared_ptr<const ArrayData> data) {
    const std::lock_guard lock(mutex_);
    std::erase_if(by_content_, [](const auto& item) { return item.second.expired(); });
    auto& place = by_content_[data->content];
    if (auto there = place.lock()) return there;
    place = data;
    return data;
  }
  std::shared_ptr<const ArrayData> find(const std::string& content) const {
    const std::lock_guard lock(mutex_);
    const auto found = by_content_.find(content);
    return found == by_content_.end() ? nullptr : found->second.lock();
  }

 private:
  mutable std::mutex mutex_;
  std::map<std::string, std::weak_ptr<const ArrayData>> by_content_;
};

Table& table() {
  static Table table;
  return table;
}

/// Copies the arrays, once: line by line, as next() reads them.
std::shared_ptr<const ArrayData> make_data(std::string content, std::vector<std::string> names,
                                           const py::array_t<Time>& times,
                                           const std::optional<py::array_t<Time>>& starts, const py::list& arrays) {
  auto data = std::make_shared<ArrayData>();
  const auto count = static_cast<std::size_t>(times.size()), width = names.size();
  data->content = std::move(content);
  data->names = std::move(names);
  data->times.assign(times.data(), times.data() + count);
  if (starts) data->starts.assign(starts->data(), starts->data() + count);
  data->values.resize(count * width);
  for (std::size_t column = 0; column < width; ++column) {
    const auto array = arrays[column].cast<py::array_t<double>>();
    const auto numbers = array.unchecked<1>();
    for (std::size_t line = 0; line < count; ++line)
      data->values[line * width + column] = numbers(static_cast<py::ssize_t>(line));
  }
  return table().put(std::move(data));
}

}  // namespace

std::shared_ptr<const ArrayData> find_arrays(const std::string& content) { return table().find(content); }

void add_array_types(Registry& registry) {
  registry.add<ArraysSource>();
  registry.add<KeepSink>();
}

void bind_arrays(py::module_& module) {
  py::class_<ArrayData, std::shared_ptr<ArrayData>>(module, "ArrayData");
  module.def("array_data", [](std::string content, std::vector<std::string> names, const py::array_t<Time>& times,
                              const std::optional<py::array_t<Time>>& starts, const py::list& arrays) {
    return std::const_pointer_cast<ArrayData>(make_data(std::move(content), std::move(names), times, starts, arrays));
  });
  module.def("times", [](py::handle times, const std::string& what, bool is_optional) {
    return to_array(to_times(times, what, is_optional));
  });
  module.def("si_unit", [](const std::string& text) -> std::optional<std::string> {
    const auto unit = parse_unit(text);
    return unit ? std::optional(si_unit(unit->dimension)) : std::nullopt;
  });
  bind_kept(module);
}

}  // namespace binnacle::python
