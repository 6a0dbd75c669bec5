// SPDX-License-Identifier: Apache-2.0
// Samples into sessions, one by one and many at once.
#include <optional>

#include "fastcall.hpp"
#include "interrupt.hpp"
#include "numbers.hpp"
#include "session.hpp"

namespace binnacle::python {

namespace {

std::string joined(const std::vector<std::string>& names) {
  std::string text;
  for (const auto& name : names) text += (text.empty() ? "" : ", ") + name;
  return text;
}

std::string channel_text(const SampleShape& shape) { return "channel '" + shape.name + "'"; }

std::string count_text(const std::vector<std::string>& names, const char* what) {
  return std::to_string(names.size()) + " " + what + (names.empty() ? "" : " (" + joined(names) + ")");
}

/// What Python gave for a sample, held for the time of a call.
class GivenSample {
 public:
  GivenSample(OpenSession& open, int channel, PyObject* t0, PyObject* t, PyObject* fields, PyObject* rows,
              PyObject* covariance)
      : shape_(open.shapes[static_cast<std::size_t>(channel)]) {
    take_times(t0, t);
    take_fields(fields, open.numbers);
    if (rows) take_rows(rows);
    if (covariance) take_covariance(covariance);
    view_.available = true;
  }

  const SampleView& view() const { return view_; }

 private:
  void take_times(PyObject* t0, PyObject* t) {
    if (!t) throw py::type_error("t is None: a sample has a time (t0 is None for an instant)");
    view_.t = to_instant(t, "t", false);
    if (t0) view_.t0 = to_instant(t0, "t0", true);
    if (view_.t0 != no_time && view_.t0 >= view_.t)
      throw py::value_error("a sample on " + channel_text(shape_) + " begins at t0 = " + std::to_string(view_.t0) +
                            " ns and ends at t = " + std::to_string(view_.t) + " ns: t0 < t, or None for an instant");
  }

  void take_fields(PyObject* given, std::vector<double>& room) {
    if (!given) {
      if (!shape_.fields.empty())
        throw py::type_error(channel_text(shape_) + " has " + count_text(shape_.fields, "fields") + "; got None");
      return;
    }
    fields_.emplace(given, "fields", room);
    if (fields_->dimensions() != 1 || fields_->size(0) != static_cast<py::ssize_t>(shape_.fields.size()))
      throw py::value_error(channel_text(shape_) + " has " + count_text(shape_.fields, "fields") +
                            "; got an array of shape " + fields_->shape());
    view_.fields = fields_->data();
  }

  void take_rows(PyObject* given) {
    rows_.emplace(given, "rows", room_);
    const auto width = static_cast<py::ssize_t>(shape_.row_fields.size());
    if (width == 0 || rows_->dimensions() != 2 || rows_->size(1) != width || rows_->size(0) > shape_.max_rows)
      throw py::value_error(channel_text(shape_) + " takes up to " + std::to_string(shape_.max_rows) + " rows of " +
                            count_text(shape_.row_fields, "fields") + "; got an array of shape " + rows_->shape());
    view_.rows = static_cast<int>(rows_->size(0));
    view_.row_fields = rows_->data();
  }

  void take_covariance(PyObject* given) {
    covariance_.emplace(given, "covariance", room_);
    const auto dof = static_cast<py::ssize_t>(shape_.covariance.size());
    if (dof == 0 || covariance_->dimensions() != 2 || covariance_->size(0) != dof || covariance_->size(1) != dof)
      throw py::value_error(channel_text(shape_) +
                            (dof == 0 ? std::string(" takes no covariance")
                                      : " takes a covariance of " + count_text(shape_.covariance, "rows and columns")) +
                            "; got an array of shape " + covariance_->shape());
    for (py::ssize_t i = 0; i < dof; ++i)
      for (py::ssize_t j = 0; j < i; ++j)
        if (covariance_->data()[i * dof + j] != covariance_->data()[j * dof + i])
          throw py::value_error("the covariance is not symmetric: [" + std::to_string(i) + ", " + std::to_string(j) +
                                "] and [" + std::to_string(j) + ", " + std::to_string(i) + "] differ");
    view_.covariance = covariance_->data();  // rows are columns: it is symmetric
  }

  const SampleShape& shape_;
  SampleView view_;
  std::optional<Numbers> fields_, rows_, covariance_;
  std::vector<double> room_;  // of a row that is a list: refused by its shape
};

std::string_view text_of(PyObject* name) {
  py::ssize_t size = 0;
  const char* const text = PyUnicode_Check(name) ? PyUnicode_AsUTF8AndSize(name, &size) : nullptr;
  if (text) return {text, static_cast<std::size_t>(size)};
  if (PyErr_Occurred()) throw py::error_already_set();
  throw py::type_error(std::string("a channel's name is a str, not ") + Py_TYPE(name)->tp_name);
}

constexpr std::array of_channel{"t0", "t", "fields", "rows", "covariance"};
constexpr std::array of_session{"channel", "t0", "t", "fields", "rows", "covariance"};

enum class Way { push, add };

/// The GIL is released for a scope, so that threads with sessions of their own work side by side.
class Unlocked {
 public:
  Unlocked() : state_(PyEval_SaveThread()) {}
  ~Unlocked() { PyEval_RestoreThread(state_); }
  Unlocked(const Unlocked&) = delete;
  Unlocked& operator=(const Unlocked&) = delete;

 private:
  PyThreadState* state_;
};

template <Way way>
void give(OpenSession& open, int channel, const GivenSample& sample) {
  if constexpr (way == Way::push) {
    const Unlocked unlocked;
    open.session.push({channel}, sample.view());
  } else {
    open.session.add({channel}, sample.view());
  }
}

template <Way way>
PyObject* by_channel(PyObject* self, PyObject* const* given, py::ssize_t count, PyObject* keywords) {
  return guarded([&] {
    const auto& channel = content_of<Channel>(self);
    const auto [t0, t, fields, rows, covariance] =
        arguments_of(way == Way::push ? "push" : "add", of_channel, 3, given, count, keywords);
    const Busy busy(*channel.open);
    give<way>(*channel.open, channel.index, {*channel.open, channel.index, t0, t, fields, rows, covariance});
    Py_RETURN_NONE;
  });
}

template <Way way>
PyObject* by_name(PyObject* self, PyObject* const* given, py::ssize_t count, PyObject* keywords) {
  return guarded([&] {
    auto& open = content_of<OpenSession>(self);
    const auto [name, t0, t, fields, rows, covariance] =
        arguments_of(way == Way::push ? "push" : "add", of_session, 4, given, count, keywords);
    if (!name) throw py::type_error("a channel's name is a str, not None");
    const Busy busy(open);
    const int channel = open.channel(text_of(name));
    give<way>(open, channel, {open, channel, t0, t, fields, rows, covariance});
    Py_RETURN_NONE;
  });
}

/// All checked before the first is pushed.
struct ManySamples {
  ManySamples(const SampleShape& shape, py::handle t0s, py::handle ts, py::handle arrays)
      : times(to_times(ts, "ts", false)), fields(arrays.ptr(), "arrays", room) {
    if (!t0s.is_none()) starts = to_times(t0s, "t0s", true);
    const auto count = times.size(), width = shape.fields.size();
    if (!shape.row_fields.empty() && width == 0)
      throw py::value_error(channel_text(shape) + " has rows, which push() takes, sample by sample");
    if (fields.dimensions() != 2 || fields.size(0) != static_cast<py::ssize_t>(count) ||
        fields.size(1) != static_cast<py::ssize_t>(width))
      throw py::value_error(channel_text(shape) + " has " + count_text(shape.fields, "fields") + ": with " +
                            std::to_string(count) + " ts arrays has the shape (" + std::to_string(count) + ", " +
                            std::to_string(width) + "); got " + fields.shape());
    if (!t0s.is_none() && starts.size() != count)
      throw py::value_error("t0s has " + std::to_string(starts.size()) + " times, ts has " + std::to_string(count));
    for (std::size_t i = 0; i < starts.size(); ++i)
      if (starts[i] != no_time && starts[i] >= times[i])
        throw py::value_error("t0s[" + std::to_string(i) + "] = " + std::to_string(starts[i]) +
                              " ns is not before ts[" + std::to_string(i) + "] = " + std::to_string(times[i]) + " ns");
  }

  std::vector<double> room;
  std::vector<Time> times, starts;
  Numbers fields;
};

void push_many(OpenSession& open, int channel, py::handle t0s, py::handle ts, py::handle arrays) {
  const Busy busy(open);
  const SampleShape& shape = open.shapes.at(static_cast<std::size_t>(channel));
  const ManySamples samples(shape, t0s, ts, arrays);
  const std::size_t width = shape.fields.size();
  const double* fields = samples.fields.data();
  SignalWatch watch;
  const py::gil_scoped_release unlocked;
  for (std::size_t i = 0; i < samples.times.size(); ++i, fields += width) {
    if (i % 64 == 0) watch();
    open.session.push({channel}, samples.starts.empty() ? no_time : samples.starts[i], samples.times[i],
                      {fields, width});
  }
}

constexpr const char* push_text =
    "push(t0, t, fields, rows=None, covariance=None)\n--\n\n"
    "A sample of the interval (t0, t], or of the instant t where t0 is None: an instant of the session of its own.\n\n"
    "t0, t: seconds, or numpy.timedelta64. fields: (n,) float64 in the order of .fields [SI], read where they lie; "
    "lists too.\n"
    "rows: (m, n) in the order of .row_fields. covariance: (d, d), symmetric, in the order of .covariance_of.\n"
    "ValueError or TypeError where sizes or times are wrong: then nothing has changed.";
constexpr const char* push_name_text =
    "push(channel, t0, t, fields, rows=None, covariance=None)\n--\n\n"
    "Channel.push() by the channel's name; KeyError, with the nearest name, where there is none.";
constexpr const char* add_text =
    "add(t0, t, fields, rows=None, covariance=None)\n--\n\nOne of several samples of the instant t, until commit(t).";
constexpr const char* add_name_text =
    "add(channel, t0, t, fields, rows=None, covariance=None)\n--\n\n"
    "One of several samples of the instant t, at most one a channel, which commit(t) works on together.";

PyMethodDef method(const char* name, FastCall call, const char* text) {
  return {name, reinterpret_cast<PyCFunction>(reinterpret_cast<void (*)()>(call)), METH_FASTCALL | METH_KEYWORDS, text};
}

}  // namespace

void bind_push(py::handle session, py::handle channel, py::module_& module) {
  static std::array methods{method("push", &by_name<Way::push>, push_name_text),
                            method("add", &by_name<Way::add>, add_name_text),
                            method("push", &by_channel<Way::push>, push_text),
                            method("add", &by_channel<Way::add>, add_text)};
  add_method(session, methods[0]);
  add_method(session, methods[1]);
  add_method(channel, methods[2]);
  add_method(channel, methods[3]);
  module.def("push_many", &push_many, py::arg("session"), py::arg("channel"), py::arg("t0s"), py::arg("ts"),
             py::arg("arrays"));
}

}  // namespace binnacle::python
