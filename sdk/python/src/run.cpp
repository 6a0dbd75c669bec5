// SPDX-License-Identifier: Apache-2.0
#include "run.hpp"

#include <utility>

#include <pybind11/stl.h>

#include "collector.hpp"
#include "errors.hpp"
#include "interrupt.hpp"
#include "loaded.hpp"
#include "provenance.hpp"
#include "study/study.hpp"
#include "summary_text.hpp"
#include "verbs.hpp"

namespace binnacle::python {

namespace {

struct RunArguments {
  std::uint64_t seed;
  int run;
  bool keeps_records, keeps_updates;
  std::map<std::string, std::vector<std::string>> logs;  // by filter: wants
  std::map<std::string, py::object> observers;           // by filter
  std::optional<std::string> out;
};

/// What makes the results again: the command's line, where the config is a file.
std::string origin_of(const Loaded& loaded, const RunArguments& arguments) {
  const std::string which = " --seed " + std::to_string(arguments.seed) + " --run " + std::to_string(arguments.run);
  if (loaded.options.text) return "binnacle.parse(…, name='" + loaded.path.string() + "') in Python," + which;
  std::string line = "binnacle run " + command::shell_quoted(loaded.path.string());
  for (const auto& [name, value] : loaded.options.vars) line += " --var " + command::shell_quoted(name + "=" + value);
  for (const auto& set : loaded.options.sets) line += " --set " + command::shell_quoted(set);
  return line + which;
}

Json provenance_of(const Loaded& loaded, const RunArguments& arguments) {
  Json all = command::provenance(loaded.composed()->catalog(), origin_of(loaded, arguments));
  all["seed"] = arguments.seed;
  all["run"] = arguments.run;
  all["created"] = command::now_in_words();
  return all;
}

Kept kept_by(const RunArguments& arguments) {
  Kept kept{arguments.keeps_records, arguments.keeps_updates, {}};
  for (const auto& [filter, wants] : arguments.logs) kept.logs[filter] = wants_of(wants);
  return kept;
}

void add_observers(const Loaded& loaded, const RunArguments& arguments, Collector& collector) {
  const auto& filters = loaded.composed()->filters();
  for (std::size_t f = 0; f < filters.size(); ++f)
    if (const auto observer = arguments.observers.find(filters[f].name); observer != arguments.observers.end())
      collector.observe(f, observer->second);
}

score::RunResult carried_out(const Loaded& loaded, const RunArguments& arguments, Collector& collector,
                             command::RunRecorder* recorder) {
  const py::gil_scoped_release unlocked;
  study::refuse_misspelt_metrics(*loaded.composed(), loaded.path, loaded.options);
  score::RunOptions options;
  options.seed = arguments.seed;
  options.run = arguments.run;
  options.observer = &collector;
  score::RunResult result = score::run(loaded.composed(), options);
  if (recorder) recorder->commit(result.summary, Json::parse(loaded.composed()->config()));
  return result;
}

py::dict run(const Loaded& loaded, const RunArguments& arguments) {
  std::unique_ptr<command::RunRecorder> recorder;
  if (arguments.out)
    recorder =
        std::make_unique<command::RunRecorder>(*arguments.out, *loaded.composed(), provenance_of(loaded, arguments));
  Collector collector(*loaded.composed(), kept_by(arguments), SignalWatch(), recorder.get());
  add_observers(loaded, arguments, collector);
  const score::RunResult result = carried_out(loaded, arguments, collector, recorder.get());
  py::dict dict;
  dict["summary"] = to_python(result.summary);
  dict["text"] = command::summary_text(result.summary, *loaded.composed());
  dict["verdict"] = verdict_name(result.verdict);
  dict["warnings"] = to_python(result.warnings);
  dict["failures"] = to_python(result.failures);
  dict["doubts"] = to_python(result.doubts);
  dict["filters"] = collector.taken();
  return dict;
}

}  // namespace

void bind_run(py::module_& module) {
  module.def(
      "run",
      [](const Loaded& loaded, std::uint64_t seed, int run_number, bool records, bool innovations,
         std::map<std::string, std::vector<std::string>> logs, std::map<std::string, py::object> observers,
         std::optional<std::string> out) {
        return run(loaded,
                   {seed, run_number, records, innovations, std::move(logs), std::move(observers), std::move(out)});
      },
      py::arg("loaded"), py::arg("seed"), py::arg("run"), py::arg("records"), py::arg("innovations"), py::arg("logs"),
      py::arg("observers"), py::arg("out"));
}

}  // namespace binnacle::python
