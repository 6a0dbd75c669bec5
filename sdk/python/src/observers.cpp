// SPDX-License-Identifier: Apache-2.0
#include "observers.hpp"

#include <memory>

#include <pybind11/stl.h>

#include "results/results.hpp"

namespace binnacle::python {

namespace {

/// A record as Python sees it during the call.
template <class Record>
class View {
 public:
  View(const Record& record, Sizes sizes, Wants wants) : record_(&record), sizes_(sizes), wants_(wants) {}
  void close() { record_ = nullptr; }
  const Record& record() const {
    if (!record_)
      throw std::runtime_error(
          "the record is gone: it is there during the call of the observer, and what is taken of it then stays (each "
          "array is a copy)");
    return *record_;
  }
  ConstMatrixView at(const Field<Record>& field) const { return field.wanted(record(), sizes_, wants_); }

 private:
  const Record* record_;
  Sizes sizes_;
  Wants wants_;
};

template <class Record>
using Class = py::class_<View<Record>, std::shared_ptr<View<Record>>>;

template <class Record>
Class<Record> bind_record(py::module_& module, const char* name, const char* text,
                          std::span<const Field<Record>> fields) {
  Class<Record> type(module, name, text);
  for (const Field<Record>& field : fields)
    type.def_property_readonly(
        field.name, [field](const View<Record>& view) { return copied(view.at(field), field.is_vector); },
        field.is_vector ? "A copy, (n,); None where there is none."
                        : "A copy, (rows, columns); None where there is none.");
  return type;
}

template <class Record, class Get>
void bind_time(Class<Record>& type, const std::string& name, Get get) {
  type.def_property_readonly(
      name.c_str(), [get](const View<Record>& view) { return results::nearest_seconds(get(view.record())); }, "[s]");
  type.def_property_readonly((name + "_ns").c_str(), [get](const View<Record>& view) { return get(view.record()); },
                             "[ns], exact");
}

py::object method_of(const py::object& observer, const char* name) { return py::getattr(observer, name, py::none()); }

}  // namespace

PythonObserver::PythonObserver(const std::string& filter, const py::object& observer, Sizes sizes, Failure& failure)
    : started_(method_of(observer, "started")),
      restored_(method_of(observer, "restored")),
      rewound_(method_of(observer, "rewound")),
      stepped_(method_of(observer, "stepped")),
      offered_(method_of(observer, "offered")),
      inflated_(method_of(observer, "inflated")),
      sizes_(sizes),
      failure_(failure) {
  bool has_methods = false;
  for (const auto* method : {&started_, &restored_, &rewound_, &stepped_, &offered_, &inflated_})
    has_methods = has_methods || !method->is_none();
  if (!has_methods) {
    if (PyCallable_Check(observer.ptr()) == 0)
      throw py::type_error("observers['" + filter + "'] is of type '" + Py_TYPE(observer.ptr())->tp_name +
                           "': an observer is called with each record, or has some of the methods started, restored, "
                           "rewound, stepped, offered, inflated");
    stepped_ = offered_ = observer;
  }
  const py::object wants = py::getattr(observer, "wants", py::none());
  if (!wants.is_none()) wants_ = wants_of(py::list(wants).cast<std::vector<std::string>>());
}

template <class Call>
void PythonObserver::guarded(const py::object& method, Call&& call) {
  if (method.is_none() || failure_.is_there()) return;
  const py::gil_scoped_acquire locked;
  try {
    call();
  } catch (...) {
    failure_.note(std::current_exception());
  }
}

template <class Record>
void PythonObserver::call_with(const py::object& method, const Record& record) {
  guarded(method, [&] {
    const auto view = std::make_shared<View<Record>>(record, sizes_, wants_);
    const py::object of_python = py::cast(view);
    try {
      method(of_python);
    } catch (...) {
      view->close();
      throw;
    }
    view->close();
  });
}

void PythonObserver::call_with_state(const py::object& method, Time t, const double* x, ConstMatrixView P) {
  guarded(method, [&] {
    method(results::nearest_seconds(t), copied({x, sizes_.stored, 1, sizes_.stored}, true), copied(P, false));
  });
}

void PythonObserver::rewound(Time t) {
  guarded(rewound_, [&] { rewound_(t == no_time ? py::object(py::none()) : py::float_(results::nearest_seconds(t))); });
}

void bind_observers(py::module_& module) {
  auto step = bind_record<StepRecord>(module, "Step",
                                      "One propagation, from t0 to t1. There during the call of the observer only.",
                                      step_fields());
  bind_time(step, "t0", [](const StepRecord& record) { return record.t0; });
  bind_time(step, "t1", [](const StepRecord& record) { return record.t1; });
  auto update = bind_record<UpdateRecord>(module, "Update",
                                          "What became of one sample. There during the call of the observer only.",
                                          update_fields());
  bind_time(update, "t", [](const UpdateRecord& record) { return record.t; });
  update.def_property_readonly(
      "measurement", [](const View<UpdateRecord>& view) { return view.record().measurement; }, "Its index");
  update.def_property_readonly("outcome", [](const View<UpdateRecord>& view) {
    return results::outcome_names[static_cast<std::size_t>(view.record().outcome)];
  });
  update.def_property_readonly("reason",
                               [](const View<UpdateRecord>& view) { return std::string(view.record().reason); });
  update.def_property_readonly("rows", [](const View<UpdateRecord>& view) { return view.record().rows; });
  update.def_property_readonly("left_out", [](const View<UpdateRecord>& view) { return view.record().left_out; });
  update.def_property_readonly("nis", [](const View<UpdateRecord>& view) { return view.record().nis; });
  auto inflation =
      bind_record<InflationRecord>(module, "Inflation", "P was opened. There during the call of the observer only.",
                                   inflation_fields());
  bind_time(inflation, "t", [](const InflationRecord& record) { return record.t; });
  inflation.def_property_readonly("measurement",
                                  [](const View<InflationRecord>& view) { return view.record().measurement; });
}

}  // namespace binnacle::python
