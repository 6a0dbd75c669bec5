// SPDX-License-Identifier: Apache-2.0
#include "kept.hpp"

#include <limits>
#include <map>
#include <mutex>
#include <utility>

#include "binnacle/sample.hpp"

namespace binnacle::python {

namespace {

std::mutex places_mutex;

/// What is still held by whoever wants it, by number.
std::map<std::int64_t, std::weak_ptr<KeptSamples>>& by_number() {
  static std::map<std::int64_t, std::weak_ptr<KeptSamples>> kept;
  return kept;
}

std::shared_ptr<KeptSamples> find(std::int64_t number) {
  const std::lock_guard lock(places_mutex);
  const auto found = by_number().find(number);
  return found == by_number().end() ? nullptr : found->second.lock();
}

std::int64_t put(const std::shared_ptr<KeptSamples>& samples) {
  const std::lock_guard lock(places_mutex);
  static std::int64_t last = 0;
  std::erase_if(by_number(), [](const auto& item) { return item.second.expired(); });
  by_number()[++last] = samples;
  return last;
}

}  // namespace

ComponentSpec KeepSink::spec() {
  ComponentSpec spec;
  spec.type = "keep";
  spec.summary = "samples of a channel in memory, for run(keep=[…]) in Python";
  spec.parameters = {parameter::integer("into").required().about("number of the place, which run() gives")};
  spec.inputs = {input("input", {field::level("x", "m")}).whole().about("any channel")};
  return spec;
}

KeepSink::KeepSink(const Binding& binding) : into_(find(binding.parameters().integer("into"))) {
  if (!into_) throw ComponentError("there is no such place: run(keep=[…]) makes this sink, and nothing else", "/into");
  const Input input = binding.input("input");
  for (const FieldSpec& field : binding.channel(input).fields)
    (field.is_per_row ? shape_.row_fields : shape_.fields).push_back(field);
  for (const NamedUnit& component : binding.covariance(input)) shape_.covariance_of.push_back(component.name);
}

void KeepSink::open() { *into_ = shape_; }

void KeepSink::on(Input, const SampleView& sample) {
  const auto append = [](std::vector<double>& into, const double* from, std::size_t count) {
    if (from)
      into.insert(into.end(), from, from + count);
    else
      into.insert(into.end(), count, std::numeric_limits<double>::quiet_NaN());
  };
  into_->t.push_back(sample.t);
  into_->t0.push_back(sample.t0);
  into_->rows.push_back(sample.rows);
  const std::size_t dof = shape_.covariance_of.size();
  append(into_->values, sample.fields, shape_.fields.size());
  append(into_->row_values, sample.row_fields, static_cast<std::size_t>(sample.rows) * shape_.row_fields.size());
  append(into_->covariances, sample.covariance, dof * dof);
}

namespace {

py::list named(const std::vector<FieldSpec>& fields) {
  const auto kind = [](FieldKind of) {
    return of == FieldKind::rate ? "rate" : of == FieldKind::increment ? "increment" : "level";
  };
  py::list list;
  for (const auto& field : fields) list.append(py::make_tuple(field.name, field.unit, kind(field.kind)));
  return list;
}

/// All that was kept, moved out.
py::dict take(KeptSamples& kept) {
  const auto lines = [](std::vector<double>& numbers, std::size_t width, std::size_t count) {
    return to_array(std::move(numbers), {static_cast<py::ssize_t>(count), static_cast<py::ssize_t>(width)});
  };
  py::list covariance_of;
  for (const auto& name : kept.covariance_of) covariance_of.append(name);
  const auto count = kept.t.size(), dof = kept.covariance_of.size();
  const auto width = kept.row_fields.size();
  const auto row_count = width == 0 ? 0 : kept.row_values.size() / width;
  py::dict dict;
  dict["fields"] = named(kept.fields);
  dict["row_fields"] = named(kept.row_fields);
  dict["covariance_of"] = covariance_of;
  dict["values"] = lines(kept.values, kept.fields.size(), count);
  dict["row_values"] = lines(kept.row_values, width, row_count);
  const auto n = static_cast<py::ssize_t>(dof);
  dict["covariances"] = to_array(std::move(kept.covariances), {static_cast<py::ssize_t>(count), n, n});
  dict["t"] = to_array(std::move(kept.t));
  dict["t0"] = to_array(std::move(kept.t0));
  dict["rows"] = to_array(std::move(kept.rows));
  kept = {};
  return dict;
}

}  // namespace

void bind_kept(py::module_& module) {
  py::class_<KeptSamples, std::shared_ptr<KeptSamples>>(module, "KeptSamples")
      .def(py::init<>())
      .def("place", [](const std::shared_ptr<KeptSamples>& self) { return put(self); })
      .def("take", &take);
}

}  // namespace binnacle::python
