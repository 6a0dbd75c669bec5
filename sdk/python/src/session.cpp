// SPDX-License-Identifier: Apache-2.0
#include "session.hpp"

#include <algorithm>
#include <array>
#include <utility>

#include <pybind11/stl.h>

#include "binnacle/state_block.hpp"
#include "errors.hpp"
#include "fastcall.hpp"
#include "loaded.hpp"
#include "numbers.hpp"
#include "results/results.hpp"

namespace binnacle::python {

namespace {

using Handle = std::shared_ptr<OpenSession>;

Estimates estimates_of(const std::string& name) {
  if (name == "live") return Estimates::live;
  if (name == "settled") return Estimates::settled;
  throw py::value_error("estimates is '" + name + "'; expected 'live' or 'settled'");
}

void check_run(int run) {
  if (run < 0) throw py::value_error("run is " + std::to_string(run) + "; runs count from 0");
}

Handle session_of(const Loaded& loaded, std::uint64_t seed, int run, const std::string& estimates) {
  check_run(run);
  return std::make_shared<OpenSession>(loaded.composed(), seed, run, estimates_of(estimates));
}

const BlockInfo& info_of(const OpenSession& open, BlockId id) {
  return open.session.composition()
      .filters()[static_cast<std::size_t>(id.filter.index)]
      .blocks[static_cast<std::size_t>(id.index)];
}

Block block_of(const Handle& open, const std::string& name) {
  const BlockId id = open->block(name);
  return {open, id, info_of(*open, id).declaration->outputs.size()};
}

py::array_t<double> matrix_of(ConstMatrixView from) {
  std::vector<double> numbers;
  numbers.reserve(static_cast<std::size_t>(from.rows * from.cols));
  for (int row = 0; row < from.rows; ++row)
    for (int column = 0; column < from.cols; ++column) numbers.push_back(from(row, column));
  return to_array(std::move(numbers), {from.rows, from.cols});
}

// ---- reading a block

enum class Reading { outputs, sigmas };

template <Reading what>
PyObject* read(PyObject* self, PyObject* const* given, py::ssize_t count, PyObject* keywords) {
  return guarded([&]() -> PyObject* {
    const auto& block = content_of<Block>(self);
    const auto [out] =
        arguments_of(what == Reading::outputs ? "read" : "sigma", std::array{"out"}, 0, given, count, keywords);
    const Busy busy(*block.open);
    const auto read_into = [&](double* numbers) {
      const std::span<double> into(numbers, block.outputs);
      if constexpr (what == Reading::outputs)
        block.open->session.read(block.id, into);
      else
        block.open->session.read_sigma(block.id, into);
    };
    if (out) {
      const Room room(out, block.outputs);
      read_into(room.data());
      return Py_NewRef(out);
    }
    py::array_t<double> fresh(static_cast<py::ssize_t>(block.outputs));
    read_into(fresh.mutable_data());
    return fresh.release().ptr();
  });
}

constexpr const char* read_text =
    "read(out=None)\n--\n\nThe block's readable outputs, (n,) in the order of .outputs [SI]: a new array, or written "
    "into out,\n"
    "a float64 array of that shape, which is returned.";
constexpr const char* sigma_text =
    "sigma(out=None)\n--\n\nStandard deviations of what read() gives, to first order [SI], in the same way.";

void bind_block(py::module_& module) {
  py::class_<Block> block(module, "Block", "A block of a session's filter. Made by Session.block().");
  block.def_property_readonly("name", [](const Block& self) { return info_of(*self.open, self.id).name; })
      .def_property_readonly("outputs",
                             [](const Block& self) {
                               std::vector<std::string> names;
                               for (const auto& output : info_of(*self.open, self.id).declaration->outputs)
                                 names.push_back(output.name);
                               return names;
                             })
      .def_property_readonly("units",
                             [](const Block& self) {
                               std::vector<std::string> units;
                               for (const auto& output : info_of(*self.open, self.id).declaration->outputs)
                                 units.push_back(output.unit);
                               return units;
                             })
      .def(
          "covariance",
          [](const Block& self) {
            const Busy busy(*self.open);
            return matrix_of(self.open->session.covariance(self.id));
          },
          "Its part of P, (n, n): a row per estimated or considered error component [SI]. A copy.");
  static std::array methods{
      PyMethodDef{"read", reinterpret_cast<PyCFunction>(reinterpret_cast<void (*)()>(&read<Reading::outputs>)),
                  METH_FASTCALL | METH_KEYWORDS, read_text},
      PyMethodDef{"sigma", reinterpret_cast<PyCFunction>(reinterpret_cast<void (*)()>(&read<Reading::sigmas>)),
                  METH_FASTCALL | METH_KEYWORDS, sigma_text}};
  for (auto& method : methods) add_method(block, method);
}

// ---- channels

const SampleShape& shape_of(const Channel& channel) {
  return channel.open->shapes[static_cast<std::size_t>(channel.index)];
}

py::class_<Channel> bind_channel(py::module_& module) {
  py::class_<Channel> channel(module, "Channel",
                              "A channel of a session, to push samples on. Made by Session.channel().");
  channel.def_property_readonly("name", [](const Channel& self) { return shape_of(self).name; })
      .def_property_readonly("index", [](const Channel& self) { return self.index; })
      .def_property_readonly("fields", [](const Channel& self) { return shape_of(self).fields; })
      .def_property_readonly("row_fields", [](const Channel& self) { return shape_of(self).row_fields; })
      .def_property_readonly("covariance_of", [](const Channel& self) { return shape_of(self).covariance; })
      .def_property_readonly("units",
                             [](const Channel& self) {
                               py::dict units;
                               const auto& info = self.open->session.composition().channels();
                               for (const auto& field : info[static_cast<std::size_t>(self.index)].declaration->fields)
                                 units[py::str(field.name)] = field.unit;
                               return units;
                             })
      .def(
          "counts",
          [](const Channel& self) {
            const Busy busy(*self.open);
            const auto counts = self.open->session.counts(ChannelId{self.index});
            py::dict dict;
            dict["pushed"] = counts.pushed;
            dict["behind"] = counts.behind;
            return dict;
          },
          "{\"pushed\", \"behind\"}: samples since the session was made or reset, and those older than one before.");
  return channel;
}

// ---- filters

py::object time_or_none(Time t) { return t == no_time ? py::object(py::none()) : py::int_(t); }

py::array_t<double> state_of(const OpenSession& open, const std::string& filter) {
  const auto state = open.session.state(open.filter(filter));
  return to_array(std::vector<double>(state.begin(), state.end()));
}

/// "position.north" of each row of P.
std::vector<std::string> rows_of(const OpenSession& open, const std::string& filter) {
  const auto id = open.filter(filter);
  std::vector<std::string> names;
  for (const auto& block : open.session.composition().filters()[static_cast<std::size_t>(id.index)].blocks)
    for (const int component : block.active)
      names.push_back(block.name + "." + block.declaration->error[static_cast<std::size_t>(component)].name);
  return names;
}

py::dict counts_of(OpenSession& open, const std::string& measurement) {
  const auto counts = open.session.counts(open.measurement(measurement));
  py::dict dict;
  dict["offered"] = counts.offered;
  for (int i = 0; i < outcome_count; ++i)
    dict[results::outcome_names[static_cast<std::size_t>(i)]] = counts.by_outcome[i];
  dict["before_start"] = counts.before_start;
  dict["recoveries"] = counts.recoveries;
  dict["rows_used"] = counts.rows_used;
  dict["rows_left_out"] = counts.rows_left_out;
  dict["replayed"] = counts.replayed;
  dict["nis_mean"] = counts.nis_mean;
  dict["dof_mean"] = counts.dof_mean;
  dict["last_reason"] = counts.last_reason;
  return dict;
}

py::dict filter_counts_of(const OpenSession& open, const std::string& filter) {
  const auto counts = open.session.counts(open.filter(filter));
  py::dict dict;
  dict["steps"] = counts.steps;
  dict["input_gaps"] = counts.input_gaps;
  dict["seconds"] = counts.seconds;
  dict["longest_lag"] = seconds(counts.longest_lag);
  return dict;
}

// ---- snapshots

py::bytes snapshot_of(const OpenSession& open) {
  const auto size = open.session.snapshot_size();
  auto bytes = py::reinterpret_steal<py::bytes>(PyBytes_FromStringAndSize(nullptr, static_cast<py::ssize_t>(size)));
  if (!bytes) throw py::error_already_set();
  open.session.snapshot({reinterpret_cast<std::byte*>(PyBytes_AS_STRING(bytes.ptr())), size});
  return bytes;
}

void restore(OpenSession& open, const py::bytes& bytes) {
  open.session.restore({reinterpret_cast<const std::byte*>(PyBytes_AS_STRING(bytes.ptr())),
                        static_cast<std::size_t>(PyBytes_GET_SIZE(bytes.ptr()))});
}

/// A method that has the session to itself.
template <class Result, class Self, class... Arguments>
auto alone(Result (*call)(Self& open, Arguments...)) {
  return [call](OpenSession& open, std::decay_t<Arguments>... arguments) -> Result {
    const Busy busy(open);
    return call(open, std::move(arguments)...);
  };
}

template <class Class>
void bind_reading(Class& session) {
  const auto of_filter = [&](const char* name, auto&& read) {
    session.def(name, [read](OpenSession& open, const std::string& filter) {
      const Busy busy(open);
      return read(std::as_const(open.session), open.filter(filter));
    });
  };
  of_filter("_time", [](const Session& from, FilterId id) { return time_or_none(from.time(id)); });
  of_filter("_start_time", [](const Session& from, FilterId id) { return time_or_none(from.start_time(id)); });
  of_filter("_started", [](const Session& from, FilterId id) { return from.started(id); });
  of_filter("_healthy", [](const Session& from, FilterId id) { return from.healthy(id); });
  of_filter("_diagnosis", [](const Session& from, FilterId id) { return from.diagnosis(id); });
  of_filter("_notes", [](const Session& from, FilterId id) { return to_python(from.notes(id)); });
  of_filter("_verdict", [](const Session& from, FilterId id) { return std::string(verdict_name(from.verdict(id))); });
  of_filter("_reasons", [](const Session& from, FilterId id) { return to_python(from.doubts(id)); });
  of_filter("_covariance", [](const Session& from, FilterId id) { return matrix_of(from.covariance(id)); });
  session.def("_state", alone(&state_of))
      .def("_rows", alone(&rows_of))
      .def("_counts", alone(&counts_of))
      .def("_filter_counts", alone(&filter_counts_of));
}

}  // namespace

void bind_session(py::module_& module) {
  py::class_<OpenSession, Handle> session(module, "Session");
  session.def(py::init(&session_of), py::arg("loaded"), py::arg("seed"), py::arg("run"), py::arg("estimates"))
      .def("_channel",
           [](const Handle& open, const std::string& name) {
             return Channel{open, open->channel(name)};
           })
      .def("_block", &block_of)
      .def_property_readonly("_filters",
                             [](const OpenSession& open) {
                               std::vector<std::string> names;
                               for (const auto& filter : open.session.composition().filters())
                                 names.push_back(filter.name);
                               return names;
                             })
      .def("_commit",
           [](OpenSession& open, py::handle t) {
             const Busy busy(open);
             open.session.commit(to_instant(t, "t", false));
           })
      .def("_reset",
           [](OpenSession& open, std::uint64_t seed, int run) {
             check_run(run);
             const Busy busy(open);
             open.session.reset(seed, run);
           })
      .def("_snapshot", alone(&snapshot_of))
      .def("_restore", alone(&restore));
  bind_reading(session);
  bind_block(module);
  bind_push(session, bind_channel(module), module);
}

}  // namespace binnacle::python
