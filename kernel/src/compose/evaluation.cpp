// SPDX-License-Identifier: Apache-2.0
// "reference", "evaluate", "record": what a run is judged by.
#include <algorithm>

#include "compose/composer.hpp"
#include "run/metric.hpp"

namespace binnacle {

namespace {

std::size_t as_size(int i) { return static_cast<std::size_t>(i); }

}  // namespace

void Composer::read_evaluation() {
  if (const auto* reference = at("/reference")) {
    // One reference may stand without the list around it.
    if (reference->is_object()) {
      add_reference("/reference");
    } else if (const auto* list = array_at(document(), "/reference", "'reference'", diagnostics_)) {
      for (std::size_t i = 0; i < list->size(); ++i) add_reference(join_pointer("/reference", i));
    }
  }
  auto& evaluation = plan_->evaluation;
  if (object_at(document(), "/evaluate", "'evaluate'", diagnostics_)) {
    check_keys(document(), "/evaluate", {"after", "until", "windows", "metrics"}, "'evaluate'", diagnostics_);
    if (at("/evaluate/after"))
      if (const auto after = read_when(document(), "/evaluate/after", diagnostics_)) {
        evaluation.span.from = after->time;
        evaluation.span.from_is_relative = after->from_start;
      }
    if (at("/evaluate/until"))
      if (const auto until = read_when(document(), "/evaluate/until", diagnostics_)) {
        evaluation.span.to = until->time;
        evaluation.span.to_is_relative = until->from_start;
      }
    if (const auto* windows = object_at(document(), "/evaluate/windows", "'windows'", diagnostics_))
      for (const auto& [name, value] : windows->items()) {
        const std::string pointer = join_pointer("/evaluate/windows", name);
        NamedWindow window;
        window.name = name;
        std::string span_pointer = pointer;
        if (value.is_object()) {
          check_keys(document(), pointer, {"filter", "span"}, "a window", diagnostics_);
          span_pointer = join_pointer(pointer, "span");
          if (!require_key(document(), pointer, "span", name, "[from, to]", diagnostics_)) continue;
          const std::string filter_pointer = join_pointer(pointer, "filter");
          if (at(filter_pointer))
            if (const auto filter = read_string(document(), filter_pointer, diagnostics_)) {
              std::vector<std::string> names;
              for (const auto& candidate : plan_->filters) names.push_back(candidate.name);
              const auto found = std::find(names.begin(), names.end(), *filter);
              if (found == names.end())
                error("B027", filter_pointer, "there is no filter '" + *filter + "'" + suggestion(*filter, names));
              else
                window.filter = static_cast<int>(found - names.begin());
            }
        }
        if (const auto span = read_window(document(), span_pointer, diagnostics_)) {
          window.span = TimeSpan{span->from.time, span->to.time, span->from.from_start, span->to.from_start};
          evaluation.windows.push_back(std::move(window));
        }
      }
  }
  if (object_at(document(), "/record", "'record'", diagnostics_)) {
    check_keys(document(), "/record", {"every"}, "'record'", diagnostics_);
    if (at("/record/every"))
      if (const auto every = read_time(document(), "/record/every", diagnostics_)) plan_->record_every = *every;
  }
}

// A name, or {"metric": name, "unit": "mil"}, or a list of these. A variant of a study may lack what others have, so that
// an unknown metric of a patched config is kept for whoever sees all of them.
void Composer::read_metrics() {
  const auto* metrics = at("/evaluate/metrics");
  if (!metrics) return;
  const auto add = [&](const std::string& pointer) {
    const auto* value = at(pointer);
    const std::string name_pointer = value->is_object() ? join_pointer(pointer, "metric") : pointer;
    if (value->is_object()) {
      check_keys(document(), pointer, {"metric", "unit"}, "a metric", diagnostics_);
      if (!require_key(document(), pointer, "metric", "metric", "FILTER/BLOCK.OUTPUT/STATISTIC", diagnostics_)) return;
    }
    const auto name = read_string(document(), name_pointer, diagnostics_);
    if (!name) return;
    auto metric = read_metric(*plan_, *name);
    if (!metric) {
      if (document().is_patched())
        plan_->evaluation.unknown_metrics.push_back(
            {*name, {Severity::error, "B027", document().origin(name_pointer), name_pointer, metric.error()}});
      else
        error("B027", name_pointer, metric.error());
      return;
    }
    Metric shown = *metric;
    const std::string unit_pointer = join_pointer(pointer, "unit");
    if (value->is_object() && at(unit_pointer))
      if (const auto unit = read_string(document(), unit_pointer, diagnostics_))
        if (const auto wrong = show_in(shown, *unit); !wrong.empty())
          error(read_unit(*unit) ? "B007" : "B008", unit_pointer, wrong);
    plan_->evaluation.metrics.push_back(std::move(shown));
  };
  if (!metrics->is_array()) return add("/evaluate/metrics");
  for (std::size_t i = 0; i < metrics->size(); ++i) add(join_pointer("/evaluate/metrics", i));
}

void Composer::add_reference(const std::string& pointer) {
  const auto* entry = object_at(document(), pointer, "a reference", diagnostics_);
  if (!entry) return;
  auto& references = plan_->evaluation.references;

  if (entry->contains("withheld")) {
    check_keys(document(), pointer, {"withheld", "filter"}, "a reference", diagnostics_);
    const std::string withheld_pointer = join_pointer(pointer, "withheld");
    const auto wanted = read_string(document(), withheld_pointer, diagnostics_);
    if (!wanted) return;
    std::string only_filter;
    if (at(join_pointer(pointer, "filter")))
      if (const auto text = read_string(document(), join_pointer(pointer, "filter"), diagnostics_)) only_filter = *text;
    std::vector<std::string> names;
    bool is_found = false;
    for (std::size_t f = 0; f < plan_->filters.size(); ++f) {
      const auto& filter = plan_->filters[f];
      if (!only_filter.empty() && filter.name != only_filter) continue;
      for (std::size_t m = 0; m < filter.measurements.size(); ++m) {
        const auto& measurement = filter.measurements[m];
        names.push_back(measurement.name);
        if (*wanted != measurement.name && *wanted != filter.name + "/" + measurement.name) continue;
        is_found = true;
        ReferencePlan reference;
        reference.filter = static_cast<int>(f);
        reference.measurement = static_cast<int>(m);
        reference.label = "withheld " + measurement.name;
        references.push_back(std::move(reference));
      }
    }
    const bool was_refused = std::any_of(builds_.begin(), builds_.end(), [&](const FilterBuild& build) {
      return at(join_pointer(join_pointer(build.pointer, "measurements"), *wanted)) != nullptr;
    });
    if (!is_found && !was_refused)
      error("B027", withheld_pointer,
            "there is no measurement '" + *wanted + "'" + suggestion(*wanted, names) +
                " (measurements: " + listed(names) + ")");
    return;
  }

  check_keys(document(), pointer, {"channel", "blocks", "invalid", "withheld"}, "a reference", diagnostics_);
  if (!require_key(document(), pointer, "channel", "reference", "name of a channel", diagnostics_) ||
      !require_key(document(), pointer, "blocks", "reference", "{\"filter/block\": [fields]}", diagnostics_))
    return;
  const std::string channel_pointer = join_pointer(pointer, "channel");
  const auto channel_name = read_string(document(), channel_pointer, diagnostics_);
  if (!channel_name) return;
  bool is_told = false;
  const int channel_index = channel_named(*channel_name, channel_pointer, is_told);
  if (channel_index < 0) return;
  const auto& channel = plan_->channels[as_size(channel_index)];
  std::optional<double> invalid;
  if (const auto* value = at(join_pointer(pointer, "invalid"))) {
    if (value->is_number())
      invalid = value->get<double>();
    else
      error("B006", join_pointer(pointer, "invalid"), "'invalid' is a number; found " + abbreviated(*value));
  }
  const std::string blocks_pointer = join_pointer(pointer, "blocks");
  const auto* blocks = object_at(document(), blocks_pointer, "'blocks'", diagnostics_);
  if (!blocks) return;
  for (const auto& [key, value] : blocks->items()) {
    const std::string block_pointer = join_pointer(blocks_pointer, key);
    ReferencePlan reference;
    reference.channel = channel_index;
    reference.invalid = invalid;
    reference.label = *channel_name;
    std::vector<std::string> names;
    bool is_found = false;
    const auto look_at = [&](std::size_t filter, const std::string& name, int block, int implied_state) {
      names.push_back(plan_->filters[filter].name + "/" + name);
      if (names.back() != key) return;
      is_found = true;
      reference.filter = static_cast<int>(filter);
      reference.block = block;
      reference.implied_state = implied_state;
    };
    for (std::size_t f = 0; f < plan_->filters.size(); ++f) {
      const auto& filter = plan_->filters[f];
      for (std::size_t b = 0; b < filter.blocks.size(); ++b) look_at(f, filter.blocks[b].name, static_cast<int>(b), -1);
      for (std::size_t r = 0; r < filter.implied_states.size(); ++r)
        look_at(f, filter.implied_states[r].value.name, filter.implied_states[r].block, static_cast<int>(r));
    }
    if (!is_found) {
      const auto slash = key.find('/');
      const bool has_failed = std::any_of(builds_.begin(), builds_.end(), [&](const FilterBuild& build) {
        return slash != std::string::npos && build.failed_values.contains(key.substr(slash + 1));
      });
      if (!has_failed)
        key_error("B027", block_pointer,
                  "there is no block '" + key + "' (FILTER/BLOCK)" + suggestion(key, names) +
                      " (blocks: " + listed(names) + ")");
      continue;
    }
    const auto& declaration = plan_->filters[as_size(reference.filter)].blocks[as_size(reference.block)].declaration();
    reference.fields.assign(declaration.outputs.size(), -1);
    const auto find_field = [&](std::size_t output, const std::string& field, const std::string& at_pointer) {
      std::vector<std::string> fields;
      for (std::size_t i = 0; i < channel.declaration.fields.size(); ++i) {
        fields.push_back(channel.declaration.fields[i].name);
        if (fields.back() != field) continue;
        const auto have = parse_unit(channel.declaration.fields[i].unit);
        const auto need = parse_unit(declaration.outputs[output].unit);
        if (have && need && !(have->dimension == need->dimension))
          error("B021", at_pointer,
                "field '" + field + "' of channel '" + channel.name + "' is " + dimension_name(have->dimension) +
                    "; '" + declaration.outputs[output].name + "' of '" + key + "' is " +
                    dimension_name(need->dimension));
        reference.fields[output] = channel.position[i];
        return;
      }
      error("B021", at_pointer,
            "channel '" + channel.name + "' has no field '" + field + "'" + suggestion(field, fields) + " (it has " +
                listed(fields) + ")");
    };
    if (value.is_array()) {
      if (value.size() != declaration.outputs.size()) {
        std::vector<std::string> outputs;
        for (const auto& output : declaration.outputs) outputs.push_back(output.name);
        error("B013", block_pointer,
              "the reference of '" + key + "' names " + std::to_string(declaration.outputs.size()) + " fields, for " +
                  listed(outputs) + "; found " + std::to_string(value.size()));
        continue;
      }
      for (std::size_t i = 0; i < value.size(); ++i)
        if (const auto field = read_string(document(), join_pointer(block_pointer, i), diagnostics_))
          find_field(i, *field, join_pointer(block_pointer, i));
    } else if (value.is_object()) {
      for (const auto& [output, field_value] : value.items()) {
        const std::string output_pointer = join_pointer(block_pointer, output);
        std::vector<std::string> outputs;
        for (const auto& candidate : declaration.outputs) outputs.push_back(candidate.name);
        const auto position = std::find(outputs.begin(), outputs.end(), output);
        if (position == outputs.end())
          key_error("B025", output_pointer,
                    "'" + key + "' has no output '" + output + "'" + suggestion(output, outputs) + " (" +
                        listed(outputs) + ")");
        else if (const auto field = read_string(document(), output_pointer, diagnostics_))
          find_field(static_cast<std::size_t>(position - outputs.begin()), *field, output_pointer);
      }
    } else {
      error("B006", block_pointer,
            "the reference of '" + key + "' is a list of fields, or {output: field}; found " + abbreviated(value));
    }
    references.push_back(std::move(reference));
  }
}

}  // namespace binnacle
