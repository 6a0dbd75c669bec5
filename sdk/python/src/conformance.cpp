// SPDX-License-Identifier: Apache-2.0
// The conformance suite on models in Python, in this process.
#include "conformance.hpp"

#include <algorithm>
#include <cerrno>
#include <filesystem>
#include <set>
#include <system_error>

#include <stdlib.h>

#include <pybind11/stl.h>

#include "allocations.hpp"
#include "attempt.hpp"
#include "fixture.hpp"
#include "miniature.hpp"
#include "models_adapters.hpp"

namespace binnacle::conform {

// Python allocates as it likes: nothing is counted.
bool allocations_are_counted() { return false; }
std::uint64_t allocations() { return 0; }
bool held_bytes_are_counted() { return false; }
std::int64_t held_bytes() { return 0; }

}  // namespace binnacle::conform

namespace binnacle::python {

namespace {

namespace fs = std::filesystem;

class Scratch {
 public:
  Scratch() {
    std::string name = (fs::temp_directory_path() / "binnacle-conform-XXXXXX").string();
    if (!::mkdtemp(name.data())) throw std::system_error(errno, std::generic_category(), name);
    path_ = name;
  }
  ~Scratch() {
    std::error_code ignored;
    fs::remove_all(path_, ignored);
  }
  Scratch(const Scratch&) = delete;
  const fs::path& path() const { return path_; }

 private:
  fs::path path_;
};

class Messages final : public conform::Report {
 public:
  void failed(const std::string& message) override { has_failed = true, lines.push_back(message); }
  void warned(const std::string& message) override { has_warned = true, lines.push_back(message); }
  void stage(const char* call) override { stage_ = call; }
  const std::string& stage() const { return stage_; }

  bool has_failed = false, has_warned = false;
  std::vector<std::string> lines;

 private:
  std::string stage_;
};

// ---- what only a model in Python can do wrong

/// The object of the class under test in a composition made of its example.
const PythonModel* object_under_test(const Composition& composition, const std::string& type) {
  const PythonModel* found = nullptr;
  const auto look_at = [&](const auto& info) {
    if (info.type && info.type->full_name() == type) found = dynamic_cast<const PythonModel*>(info.object.get());
  };
  for (const auto& filter : composition.filters()) {
    for (const auto& process : filter.processes) look_at(process);
    for (const auto& derived : filter.derived) look_at(derived);
    for (const auto& measurement : filter.measurements) {
      for (const auto& part : measurement.parts) look_at(part);
      look_at(measurement.noise);
    }
  }
  for (const auto& transform : composition.transforms()) look_at(transform);
  return found;
}

py::dict attributes_of(const PythonModel& model) {
  return py::module_::import("binnacle._models").attr("state_of")(model.object());
}

/// Attributes are what they were before it was called, also where nothing that it gives shows it yet.
void unchanged(conform::Trial& trial) {
  const auto composition = conform::compose_example(trial);
  const auto subject = conform::fixture(trial, composition);
  const PythonModel* const model = object_under_test(*composition, trial.type);
  if (!model) conform::Trial::skip("its object was not found");
  const auto before = in_python([&] { return Held(attributes_of(*model)); });
  auto memory = subject->fresh_memory();
  for (std::uint64_t k = 0; k < 5; ++k) subject->turn(k, memory.data(), testing::unwritten());
  const auto names = in_python([&] {
    return py::module_::import("binnacle._models")
        .attr("changed")(before.get(), attributes_of(*model))
        .cast<std::vector<std::string>>();
  });
  for (const auto& name : names)
    trial.fail("self.", name,
               " is changed by calls: what a model remembers is declared, binding.keeps({…}), or does not "
               "come back with a snapshot");
}

std::vector<conform::Check> checks() {
  auto all = conform::all_checks();
  all.push_back(
      {"python.unchanged",
       2,
       {Role::measurement_model, Role::process_model, Role::noise_estimator, Role::derived_block, Role::transform},
       {"life.calls"},
       "calls leave the object's attributes as they are",
       unchanged});
  return all;
}

struct CheckOutcome {
  std::string check, status, message;
};

/// What says something of a class of Python: neither that of a library, nor allocations and times.
bool applies(const conform::Check& check, Role role) {
  return std::find(check.roles.begin(), check.roles.end(), role) != check.roles.end() &&
         !check.id.starts_with("speed.") && check.id != "life.leaks";
}

CheckOutcome run(const conform::Check& check, conform::Trial& trial, Messages& messages) {
  CheckOutcome outcome{check.id, "pass", ""};
  conform::attempt(
      check, trial, [&] { return messages.stage(); },
      [&](const conform::Skip& skip) {
        outcome.status = skip.applies ? "skip" : "not applicable";
        messages.lines.push_back(skip.reason);
      });
  if (messages.has_warned) outcome.status = "warn";
  if (messages.has_failed) outcome.status = "fail";
  for (const auto& line : messages.lines) outcome.message += (outcome.message.empty() ? "" : "\n") + line;
  return outcome;
}

/// Without the GIL, but between two checks.
std::vector<CheckOutcome> run_all(const std::string& type, Role role, int level, std::uint64_t seed,
                                  const LoadOptions& options) {
  std::vector<CheckOutcome> outcomes;
  std::set<std::string> failed;
  for (const auto& check : checks()) {
    if (check.level > level || !applies(check, role)) continue;
    const auto blocked =
        std::find_if(check.needs.begin(), check.needs.end(), [&](const auto& id) { return failed.contains(id); });
    if (blocked != check.needs.end()) {
      outcomes.push_back({check.id, "skip", "prerequisite " + *blocked + " failed"});
      failed.insert(check.id);
      continue;
    }
    {
      const py::gil_scoped_release unlocked;
      const Scratch scratch;
      Messages messages;
      conform::Trial trial("", type, role, level, seed, scratch.path(), messages, options);
      outcomes.push_back(run(check, trial, messages));
    }
    if (outcomes.back().status == "fail") failed.insert(check.id);
    if (PyErr_CheckSignals() != 0) throw py::error_already_set();
  }
  return outcomes;
}

py::list conform_model(const std::string& name, int level, std::uint64_t seed,
                       const std::vector<std::string>& folders) {
  const ModelClasses all = all_models();
  const auto found = std::find_if(all.begin(), all.end(), [&](const auto& model) { return model->spec.type == name; });
  if (found == all.end()) throw py::key_error("no model is registered as '" + name + "'");
  LoadOptions options;
  for (const auto& folder : folders) options.plugin_folders.emplace_back(folder);
  link_models(options, all);
  py::list list;
  for (const auto& outcome : run_all(std::string(plugin_of_models) + "/" + name, (*found)->role, level, seed, options))
    list.append(py::make_tuple(outcome.check, outcome.status, outcome.message));
  return list;
}

}  // namespace

void bind_conform(py::module_& module) {
  module.def("conform_model", &conform_model, py::arg("name"), py::arg("level"), py::arg("seed"), py::arg("folders"));
}

}  // namespace binnacle::python
