// SPDX-License-Identifier: Apache-2.0
#include "analyses.hpp"

#include <chrono>
#include <cstdint>
#include <optional>
#include <utility>

#include <pybind11/stl.h>

#include "allan_channel.hpp"
#include "covariance/analysis.hpp"
#include "covariance_text.hpp"
#include "errors.hpp"
#include "inspect/inspect.hpp"
#include "inspect_lever_arms.hpp"
#include "inspect_sources.hpp"
#include "inspect_text.hpp"
#include "interrupt.hpp"
#include "loaded.hpp"
#include "observability_text.hpp"
#include "observe/observe.hpp"
#include "results.hpp"
#include "score/run.hpp"
#include "score/sections.hpp"
#include "smoothers.hpp"
#include "study/study.hpp"
#include "study/summary.hpp"
#include "study/workers.hpp"
#include "study_results.hpp"
#include "study_text.hpp"
#include "table.hpp"
#include "tune_text.hpp"

namespace binnacle::python {

namespace {

using Clock = std::chrono::steady_clock;

double seconds_since(Clock::time_point begin) { return std::chrono::duration<double>(Clock::now() - begin).count(); }

py::dict figures_and_text(const Json& figures, const std::string& text) {
  py::dict dict;
  dict["figures"] = to_python(figures);
  dict["text"] = text;
  return dict;
}

int jobs_of(int jobs) { return jobs > 0 ? jobs : study::processors(); }

py::dict study_of(const Loaded& loaded, std::optional<int> runs, std::optional<std::uint64_t> seed, int jobs) {
  std::optional<study::Study> study;
  std::optional<results::StudyResults> all;
  Json timed;
  interruptibly([&](const GoesOn& goes_on) {
    const auto begin = Clock::now();
    study.emplace(study::Study::load(loaded.path, {loaded.options, runs, seed}));
    study::Results results(study->variants().size(), static_cast<std::size_t>(study->runs()));
    study::carry_out_all(*study, results, jobs_of(jobs), goes_on,
                         [](std::size_t, std::size_t, const study::Figures&) {});
    if (!goes_on()) return;
    const Json figures = study::summarize(*study, results);
    timed = figures;
    timed["wall_s"] = seconds_since(begin);
    const Json config = Json::parse(score::load_config(loaded.path, loaded.options).text());
    all = command::study_results(*study, results, figures, config, "binnacle.Composition.study() in Python");
  });
  py::dict dict = taken(std::move(*all));
  dict["figures"] = to_python(timed);
  dict["text"] = command::study_text(timed, *study) + command::study_end_text(timed, *study);
  dict["warnings"] = to_python(study->warnings());
  return dict;
}

py::dict covariance_of(const Loaded& loaded, bool has_budget) {
  std::optional<study::Study> study;
  Json summary;
  interruptibly([&](const GoesOn& goes_on) {
    const auto begin = Clock::now();
    study.emplace(covariance::load(loaded.path, loaded.options));
    summary = covariance::analyse(*study, loaded.path, loaded.options, goes_on);
    summary["wall_s"] = seconds_since(begin);
  });
  py::dict dict = figures_and_text(summary, command::covariance_text(summary, *study, has_budget));
  dict["warnings"] = to_python(study->warnings());
  return dict;
}

py::dict tuned(const Loaded& loaded, std::uint64_t seed, int run, int jobs) {
  std::string text;
  Json result;
  interruptibly([&](const GoesOn& goes_on) {
    const auto begin = Clock::now();
    const tune::Plan plan = tune::read_plan(loaded.path, loaded.options);
    tune::TuneOptions options;
    options.seed = seed;
    options.run = run;
    options.jobs = jobs_of(jobs);
    options.goes_on = goes_on;
    result = tune::tune(plan, options);
    result["wall_s"] = seconds_since(begin);
    text = command::tune_text(result, plan);
  });
  return figures_and_text(result, text);
}

/// Looks on for observability alone.
class ObservabilityWatch final : public score::RunObserver {
 public:
  ObservabilityWatch(const observe::Observability& observability, const GoesOn& goes_on)
      : observability_(observability), goes_on_(goes_on) {}
  bool wants_records() const override { return false; }
  StepObserver* step_observer(int filter) override { return observability_.step_observer(filter); }
  bool progress(Time) override { return goes_on_(); }

 private:
  const observe::Observability& observability_;
  const GoesOn& goes_on_;
};

std::vector<observe::Window> windows_of(const Composition& composition, const std::vector<std::string>& texts) {
  if (texts.empty()) return {observe::whole_run()};
  std::vector<observe::Window> windows;
  for (const auto& text : texts) {
    const auto window = observe::read_window(composition, text);
    if (!window) throw py::value_error("windows: " + window.error());
    windows.push_back(*window);
  }
  return windows;
}

py::dict observed(const Loaded& loaded, const std::vector<std::string>& texts, std::uint64_t seed, int run) {
  const auto windows = windows_of(*loaded.composed(), texts);
  Json filters;
  score::RunResult result;
  interruptibly([&](const GoesOn& goes_on) {
    const observe::Observability observability(*loaded.composed(), windows);
    ObservabilityWatch watch(observability, goes_on);
    score::RunOptions options;
    options.seed = seed;
    options.run = run;
    options.observer = &watch;
    options.feeds_sinks = false;
    result = score::run(loaded.composed(), options);
    if (goes_on()) filters = observability.figures(loaded.path, loaded.options, {seed, run, goes_on});
  });
  py::dict dict = figures_and_text({{"filters", filters}},
                                   command::heading(loaded.composed()->title()) + command::observability_text(filters));
  dict["warnings"] = to_python(result.warnings);
  dict["failures"] = to_python(result.failures);
  return dict;
}

py::dict allan_of(const Loaded& loaded, const std::string& channel_name, double overlap, std::uint64_t seed) {
  command::AllanChannel channel;
  interruptibly([&](const GoesOn& goes_on) {
    channel = command::allan_channel(loaded.path.string(), loaded.options, channel_name, overlap, seed, goes_on);
  });
  if (channel.samples == 0) {
    Diagnostics diagnostics;
    diagnostics.error("", {loaded.path.string(), 0, 0}, "", "no sample came on '" + channel_name + "'");
    throw DataError(diagnostics);
  }
  py::dict dict = figures_and_text(command::allan_json(channel), command::allan_text(channel));
  dict["svg"] = command::allan_svg(channel);
  dict["warnings"] = to_python(channel.warnings);
  return dict;
}

py::dict inspected(const std::function<std::vector<inspect::Channel>(const GoesOn&)>& channels,
                   const std::vector<inspect::StatedLeverArm>& stated = {}) {
  std::optional<inspect::Inspection> inspection;
  interruptibly([&](const GoesOn& goes_on) {
    auto all = channels(goes_on);
    if (goes_on()) inspection = inspect::inspect(std::move(all));
  });
  inspect::compare_lever_arms(stated, *inspection);
  return figures_and_text(inspect::to_json(*inspection), command::inspection_text(*inspection));
}

py::dict inspected_files(const std::vector<std::string>& files, const Loaded& loaded) {
  return inspected([&](const GoesOn& goes_on) { return command::channels_of(files, loaded.options, goes_on); });
}

py::dict inspected_config(const Loaded& loaded) {
  const auto channels = [&](const GoesOn& goes_on) {
    return command::channels_of_config(loaded.path.string(), loaded.options, goes_on);
  };
  return inspected(channels, command::stated_lever_arms(loaded.path.string(), loaded.options));
}

Loaded smoothed(const Loaded& loaded) {
  const py::gil_scoped_release unlocked;
  Loaded other = loaded;
  command::add_smoothers(loaded.path, other.options);
  other.composition = score::load(other.path, other.options);
  return other;
}

/// What is wrong with a command's arguments is wrong with a call's.
void translate_errors() {
  py::register_exception_translator([](std::exception_ptr thrown) {
    try {
      if (thrown) std::rethrow_exception(thrown);
    } catch (const command::UsageError& error) {
      PyErr_SetString(PyExc_ValueError, error.what());
    } catch (const command::OutputError& error) {
      PyErr_SetString(PyExc_OSError, error.what());
    }
  });
}

}  // namespace

void bind_analyses(py::module_& module) {
  translate_errors();
  module.def("study", &study_of, py::arg("loaded"), py::arg("runs"), py::arg("seed"), py::arg("jobs"));
  module.def("covariance", &covariance_of, py::arg("loaded"), py::arg("budget"));
  module.def("tune", &tuned, py::arg("loaded"), py::arg("seed"), py::arg("run"), py::arg("jobs"));
  module.def("observe", &observed, py::arg("loaded"), py::arg("windows"), py::arg("seed"), py::arg("run"));
  module.def("allan", &allan_of, py::arg("loaded"), py::arg("channel"), py::arg("overlap"), py::arg("seed"));
  module.def("inspect_files", &inspected_files, py::arg("files"), py::arg("loaded"));
  module.def("inspect_config", &inspected_config, py::arg("loaded"));
  module.def("smoothed", &smoothed, py::arg("loaded"));
}

}  // namespace binnacle::python
