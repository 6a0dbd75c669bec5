// SPDX-License-Identifier: Apache-2.0
#include "references.hpp"

#include <algorithm>
#include <utility>

#include <nlohmann/json.hpp>

#include "binnacle/diagnostic.hpp"
#include "binnacle/state_block.hpp"
#include "binnacle/unit.hpp"
#include "wording/wording.hpp"

namespace binnacle::score {

using namespace wording;

namespace {

// ---- implied states

/// The block or measurement that an implied state names; −1 where it does not.
int named_part(const Reader& filter_at, const Reader& at, const std::string& key,
               const std::vector<std::string>& names) {
  if (!at.require(key, at.key(), "a " + key + " of the filter")) return -1;
  const auto name = at[key].text();
  if (!name) return -1;
  const int index = index_of(names, *name);
  if (index < 0 && !filter_at[key + "s"][*name])  // else it was refused and that is reported
    at[key].error(key == "block" ? "B015" : "B027", "the filter has no " + key + " '" + *name + "'" +
                                                        suggestion(*name, names) + " (" + key + "s: " + listed(names) +
                                                        ")");
  return index;
}

void read_implied_state(const FilterInfo& filter, const Reader& filter_at, const Reader& at,
                        std::vector<ImpliedStatePlan>& implied_states) {
  const std::string& name = at.key();
  if (!at.is_object("an implied state")) return;
  at.check_keys({"measurement", "block"}, "an implied state");
  if (index_of(names_of(filter.blocks), name) >= 0 || index_of(names_of(filter.derived), name) >= 0)
    at.key_error("B002", "a block is called '" + name + "' already");
  ImpliedStatePlan implied_state;
  implied_state.measurement = named_part(filter_at, at, "measurement", names_of(filter.measurements));
  implied_state.block = named_part(filter_at, at, "block", names_of(filter.blocks));
  if (implied_state.measurement < 0 || implied_state.block < 0) return;
  const auto& measurement = filter.measurements[as_size(implied_state.measurement)];
  implied_state.value = filter.blocks[as_size(implied_state.block)];
  const int rows = static_cast<int>(implied_state.value.active.size());
  const auto& seen = measurement.blocks;
  if (std::find(seen.begin(), seen.end(), implied_state.block) == seen.end() || rows > measurement.max_rows) {
    at.error("B015", "measurement '" + measurement.name + "' does not determine block '" + implied_state.value.name +
                         "': it must see all " + std::to_string(rows) + " of its components");
    return;
  }
  implied_state.value.name = name;
  implied_state.value.first_row = 0;
  implied_states.push_back(std::move(implied_state));
}

// ---- references

void add_withheld(const CompositionDraft& draft, const Reader& at, ScorePlan& plan) {
  at.check_keys({"withheld", "filter"}, "a reference");
  const auto wanted = at["withheld"].text();
  if (!wanted) return;
  const std::string only_filter = at["filter"].text().value_or("");
  std::vector<std::string> names;
  bool is_found = false;
  for (std::size_t f = 0; f < plan.filters.size(); ++f) {
    const auto& filter = plan.filters[f];
    if (!only_filter.empty() && filter.name != only_filter) continue;
    for (std::size_t m = 0; m < filter.measurements.size(); ++m) {
      const auto& measurement = filter.measurements[m];
      names.push_back(measurement.name);
      if (*wanted != measurement.name && *wanted != filter.name + "/" + measurement.name) continue;
      is_found = true;
      ReferencePlan reference;
      reference.filter = static_cast<int>(f);
      reference.measurement = static_cast<int>(m);
      plan.references.push_back(std::move(reference));
    }
  }
  const bool was_refused = std::any_of(plan.filters.begin(), plan.filters.end(), [&](const FilterInfo& filter) {
    return bool(draft.at("/filters")[filter.name]["measurements"][*wanted]);
  });
  if (!is_found && !was_refused)
    at["withheld"].error("B027", "there is no measurement '" + *wanted + "'" + suggestion(*wanted, names) +
                                     " (measurements: " + listed(names) + ")");
}

/// The block or implied state that is called FILTER/NAME.
bool find_scored_block(const CompositionDraft& draft, const ScorePlan& plan, const Reader& at,
                       ReferencePlan& reference) {
  const std::string& key = at.key();
  std::vector<std::string> names;
  bool is_found = false;
  const auto look_at = [&](std::size_t filter, const std::string& name, int block, int implied_state) {
    names.push_back(plan.filters[filter].name + "/" + name);
    if (names.back() != key) return;
    is_found = true;
    reference.filter = static_cast<int>(filter);
    reference.block = block;
    reference.implied_state = implied_state;
  };
  for (std::size_t f = 0; f < plan.filters.size(); ++f) {
    const auto& blocks = plan.filters[f].blocks;
    for (std::size_t b = 0; b < blocks.size(); ++b) look_at(f, blocks[b].name, static_cast<int>(b), -1);
    const auto& implied_states = plan.implied_states[f];
    for (std::size_t r = 0; r < implied_states.size(); ++r)
      look_at(f, implied_states[r].value.name, implied_states[r].block, static_cast<int>(r));
  }
  if (is_found) return true;
  const auto slash = key.find('/');
  if (slash == std::string::npos || !draft.has_failed(key.substr(0, slash), key.substr(slash + 1)))
    at.key_error("B027", "there is no block '" + key + "' (FILTER/BLOCK)" + suggestion(key, names) +
                             " (blocks: " + listed(names) + ")");
  return false;
}

/// Which fields of a channel are the outputs of a block.
class FieldFinder {
 public:
  FieldFinder(const ChannelInfo& channel, const StateBlockDeclaration& block, const Reader& at)
      : channel_(channel), outputs_(block.outputs), at_(at) {}

  /// False where the reference is of no use.
  bool find(std::vector<int>& fields) {
    fields.assign(outputs_.size(), -1);
    if (at_.is_list()) return find_in_order(fields);
    if (at_.is_object())
      find_by_name(fields);
    else
      at_.error("B006",
                "the reference of '" + at_.key() + "' is a list of fields, or {output: field}; found " + at_.shown());
    return true;
  }

 private:
  bool find_in_order(std::vector<int>& fields) {
    const std::vector<Reader> elements = at_.children();
    if (elements.size() != outputs_.size()) {
      at_.error("B013", "the reference of '" + at_.key() + "' names " + std::to_string(outputs_.size()) +
                            " fields, for " + listed(names_of(outputs_)) + "; found " +
                            std::to_string(elements.size()));
      return false;
    }
    for (std::size_t i = 0; i < elements.size(); ++i)
      if (const auto field = elements[i].text()) fields[i] = find_field(i, *field, elements[i]);
    return true;
  }

  void find_by_name(std::vector<int>& fields) {
    const auto outputs = names_of(outputs_);
    for (const Reader& output : at_.children()) {
      const int index = index_of(outputs, output.key());
      if (index < 0)
        output.key_error("B025", "'" + at_.key() + "' has no output '" + output.key() + "'" +
                                     suggestion(output.key(), outputs) + " (" + listed(outputs) + ")");
      else if (const auto field = output.text())
        fields[as_size(index)] = find_field(as_size(index), *field, output);
    }
  }

  int find_field(std::size_t output, const std::string& field, const Reader& at) {
    const auto& declared = channel_.declaration->fields;
    const auto fields = names_of(declared);
    const int index = index_of(fields, field);
    if (index < 0) {
      at.error("B021", "channel '" + channel_.name + "' has no field '" + field + "'" + suggestion(field, fields) +
                           " (it has " + listed(fields) + ")");
      return -1;
    }
    const auto have = parse_unit(declared[as_size(index)].unit);
    const auto need = parse_unit(outputs_[output].unit);
    if (have && need && !(have->dimension == need->dimension))
      at.error("B021", "field '" + field + "' of channel '" + channel_.name + "' is " +
                           dimension_name(have->dimension) + "; '" + outputs_[output].name + "' of '" + at_.key() +
                           "' is " + dimension_name(need->dimension));
    return channel_.position[as_size(index)];
  }

  const ChannelInfo& channel_;
  const decltype(StateBlockDeclaration::outputs)& outputs_;
  const Reader at_;
};

void add_of_channel(CompositionDraft& draft, const Reader& at, ScorePlan& plan) {
  at.check_keys({"channel", "blocks", "invalid", "withheld"}, "a reference");
  if (!at.require("channel", "reference", "name of a channel") ||
      !at.require("blocks", "reference", "{\"filter/block\": [fields]}"))
    return;
  const auto channel_name = at["channel"].text();
  if (!channel_name) return;
  ReferencePlan common;
  common.channel = draft.channel(*channel_name, at["channel"]);
  if (common.channel < 0) return;
  if (const auto invalid = at["invalid"].number(parameter::number("", "1"))) common.invalid = *invalid;
  for (const Reader& block_at : at["blocks"].members("'blocks'")) {
    ReferencePlan reference = common;
    if (!find_scored_block(draft, plan, block_at, reference)) continue;
    const auto& block = plan.filters[as_size(reference.filter)].blocks[as_size(reference.block)];
    FieldFinder finder(draft.channels()[as_size(common.channel)], *block.declaration, block_at);
    if (!finder.find(reference.fields)) continue;
    draft.subscribe(reference.channel, "/reference");
    plan.references.push_back(std::move(reference));
  }
}

void add_reference(CompositionDraft& draft, const Reader& at, ScorePlan& plan) {
  if (!at.is_object("a reference")) return;
  if (at["withheld"])
    add_withheld(draft, at, plan);
  else
    add_of_channel(draft, at, plan);
}

}  // namespace

void read_implied_states(const CompositionDraft& draft, ScorePlan& plan) {
  for (const auto& filter : plan.filters) {
    auto& implied_states = plan.implied_states.emplace_back();
    const Reader filter_at = draft.at("/filters")[filter.name];
    for (const Reader& state : filter_at["implied_states"].members("'implied_states'"))
      read_implied_state(filter, filter_at, state, implied_states);
  }
}

void read_references(CompositionDraft& draft, ScorePlan& plan) {
  const Reader references = draft.at("/reference");
  // One reference may stand without the list around it.
  if (references.is_object()) return add_reference(draft, references, plan);
  for (const Reader& reference : references.elements("'reference'")) add_reference(draft, reference, plan);
}

}  // namespace binnacle::score
