// SPDX-License-Identifier: Apache-2.0
#include "references.hpp"

#include <algorithm>
#include <utility>

#include "binnacle/config.hpp"
#include "binnacle/diagnostic.hpp"
#include "binnacle/unit.hpp"
#include "wording/wording.hpp"

namespace binnacle::score {

using namespace wording;

namespace {

using Kind = CompositionDraft::Kind;

bool is_there(const CompositionDraft& draft, const std::string& pointer) { return draft.kind(pointer) != Kind::absent; }

// ---- implied states

/// The block or measurement that an implied state names; −1 where it does not.
int named_part(CompositionDraft& draft, const std::string& filter_pointer, const std::string& pointer,
               const std::string& key, const std::vector<std::string>& names) {
  const std::string implied_state = pointer.substr(pointer.rfind('/') + 1);
  if (!draft.require_key(pointer, key, implied_state, "a " + key + " of the filter")) return -1;
  const std::string at_pointer = join_pointer(pointer, key);
  const auto name = draft.text(at_pointer);
  if (!name) return -1;
  const int index = index_of(names, *name);
  const std::string other = join_pointer(join_pointer(filter_pointer, key + "s"), *name);
  if (index < 0 && !is_there(draft, other))  // else it was refused and that is reported
    draft.error(key == "block" ? "B015" : "B027", at_pointer,
                "the filter has no " + key + " '" + *name + "'" + suggestion(*name, names) + " (" + key +
                    "s: " + listed(names) + ")");
  return index;
}

void read_implied_state(CompositionDraft& draft, const FilterInfo& filter, const std::string& filter_pointer,
                        const std::string& name, std::vector<ImpliedStatePlan>& implied_states) {
  const std::string pointer = join_pointer(join_pointer(filter_pointer, "implied_states"), name);
  if (!draft.is_object(pointer, "an implied state")) return;
  draft.check_keys(pointer, {"measurement", "block"}, "an implied state");
  if (index_of(names_of(filter.blocks), name) >= 0 || index_of(names_of(filter.derived), name) >= 0)
    draft.key_error("B002", pointer, "a block is called '" + name + "' already");
  ImpliedStatePlan implied_state;
  implied_state.measurement = named_part(draft, filter_pointer, pointer, "measurement", names_of(filter.measurements));
  implied_state.block = named_part(draft, filter_pointer, pointer, "block", names_of(filter.blocks));
  if (implied_state.measurement < 0 || implied_state.block < 0) return;
  const auto& measurement = filter.measurements[as_size(implied_state.measurement)];
  implied_state.value = filter.blocks[as_size(implied_state.block)];
  const int rows = static_cast<int>(implied_state.value.active.size());
  const auto& seen = measurement.blocks;
  if (std::find(seen.begin(), seen.end(), implied_state.block) == seen.end() || rows > measurement.max_rows) {
    draft.error("B015", pointer,
                "measurement '" + measurement.name + "' does not determine block '" + implied_state.value.name +
                    "': it must see all " + std::to_string(rows) + " of its components");
    return;
  }
  implied_state.value.name = name;
  implied_state.value.first_row = 0;
  implied_states.push_back(std::move(implied_state));
}

// ---- references

void add_withheld(CompositionDraft& draft, const std::string& pointer, ScorePlan& plan) {
  draft.check_keys(pointer, {"withheld", "filter"}, "a reference");
  const std::string withheld_pointer = join_pointer(pointer, "withheld");
  const auto wanted = draft.text(withheld_pointer);
  if (!wanted) return;
  std::string only_filter;
  if (is_there(draft, join_pointer(pointer, "filter")))
    only_filter = draft.text(join_pointer(pointer, "filter")).value_or("");
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
    return is_there(draft, join_pointer(join_pointer(join_pointer("/filters", filter.name), "measurements"), *wanted));
  });
  if (!is_found && !was_refused)
    draft.error("B027", withheld_pointer,
                "there is no measurement '" + *wanted + "'" + suggestion(*wanted, names) +
                    " (measurements: " + listed(names) + ")");
}

/// The block or implied state that is called FILTER/NAME.
bool find_scored_block(CompositionDraft& draft, const ScorePlan& plan, const std::string& key,
                       const std::string& pointer, ReferencePlan& reference) {
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
    draft.key_error("B027", pointer,
                    "there is no block '" + key + "' (FILTER/BLOCK)" + suggestion(key, names) +
                        " (blocks: " + listed(names) + ")");
  return false;
}

/// Which fields of a channel are the outputs of a block.
class FieldFinder {
 public:
  FieldFinder(CompositionDraft& draft, const ChannelInfo& channel, const StateBlockDeclaration& block, std::string key)
      : draft_(draft), channel_(channel), outputs_(block.outputs), key_(std::move(key)) {}

  /// False where the reference is of no use.
  bool find(const std::string& pointer, std::vector<int>& fields) {
    fields.assign(outputs_.size(), -1);
    switch (draft_.kind(pointer)) {
      case Kind::list: return find_in_order(pointer, fields);
      case Kind::object: find_by_name(pointer, fields); break;
      default:
        draft_.error("B006", pointer,
                     "the reference of '" + key_ + "' is a list of fields, or {output: field}; found " +
                         draft_.shown(pointer));
    }
    return true;
  }

 private:
  bool find_in_order(const std::string& pointer, std::vector<int>& fields) {
    const std::size_t count = draft_.size(pointer);
    if (count != outputs_.size()) {
      draft_.error("B013", pointer,
                   "the reference of '" + key_ + "' names " + std::to_string(outputs_.size()) + " fields, for " +
                       listed(names_of(outputs_)) + "; found " + std::to_string(count));
      return false;
    }
    for (std::size_t i = 0; i < count; ++i)
      if (const auto field = draft_.text(join_pointer(pointer, i)))
        fields[i] = find_field(i, *field, join_pointer(pointer, i));
    return true;
  }

  void find_by_name(const std::string& pointer, std::vector<int>& fields) {
    const auto outputs = names_of(outputs_);
    for (const auto& output : draft_.keys(pointer)) {
      const std::string output_pointer = join_pointer(pointer, output);
      const int index = index_of(outputs, output);
      if (index < 0)
        draft_.key_error("B025", output_pointer,
                         "'" + key_ + "' has no output '" + output + "'" + suggestion(output, outputs) + " (" +
                             listed(outputs) + ")");
      else if (const auto field = draft_.text(output_pointer))
        fields[as_size(index)] = find_field(as_size(index), *field, output_pointer);
    }
  }

  int find_field(std::size_t output, const std::string& field, const std::string& pointer) {
    const auto& declared = channel_.declaration->fields;
    const auto fields = names_of(declared);
    const int index = index_of(fields, field);
    if (index < 0) {
      draft_.error("B021", pointer,
                   "channel '" + channel_.name + "' has no field '" + field + "'" + suggestion(field, fields) +
                       " (it has " + listed(fields) + ")");
      return -1;
    }
    const auto have = parse_unit(declared[as_size(index)].unit);
    const auto need = parse_unit(outputs_[output].unit);
    if (have && need && !(have->dimension == need->dimension))
      draft_.error("B021", pointer,
                   "field '" + field + "' of channel '" + channel_.name + "' is " + dimension_name(have->dimension) +
                       "; '" + outputs_[output].name + "' of '" + key_ + "' is " + dimension_name(need->dimension));
    return channel_.position[as_size(index)];
  }

  CompositionDraft& draft_;
  const ChannelInfo& channel_;
  const decltype(StateBlockDeclaration::outputs)& outputs_;
  std::string key_;
};

void add_of_channel(CompositionDraft& draft, const std::string& pointer, ScorePlan& plan) {
  draft.check_keys(pointer, {"channel", "blocks", "invalid", "withheld"}, "a reference");
  if (!draft.require_key(pointer, "channel", "reference", "name of a channel") ||
      !draft.require_key(pointer, "blocks", "reference", "{\"filter/block\": [fields]}"))
    return;
  const std::string channel_pointer = join_pointer(pointer, "channel");
  const auto channel_name = draft.text(channel_pointer);
  if (!channel_name) return;
  ReferencePlan common;
  common.channel = draft.channel(*channel_name, channel_pointer);
  if (common.channel < 0) return;
  common.invalid = draft.number(join_pointer(pointer, "invalid"));
  const std::string blocks_pointer = join_pointer(pointer, "blocks");
  if (!draft.is_object(blocks_pointer, "'blocks'")) return;
  for (const auto& key : draft.keys(blocks_pointer)) {
    const std::string block_pointer = join_pointer(blocks_pointer, key);
    ReferencePlan reference = common;
    if (!find_scored_block(draft, plan, key, block_pointer, reference)) continue;
    const auto& block = plan.filters[as_size(reference.filter)].blocks[as_size(reference.block)];
    FieldFinder finder(draft, draft.channels()[as_size(common.channel)], *block.declaration, key);
    if (!finder.find(block_pointer, reference.fields)) continue;
    draft.subscribe(reference.channel, "/reference");
    plan.references.push_back(std::move(reference));
  }
}

void add_reference(CompositionDraft& draft, const std::string& pointer, ScorePlan& plan) {
  if (!draft.is_object(pointer, "a reference")) return;
  if (is_there(draft, join_pointer(pointer, "withheld")))
    add_withheld(draft, pointer, plan);
  else
    add_of_channel(draft, pointer, plan);
}

}  // namespace

void read_implied_states(CompositionDraft& draft, ScorePlan& plan) {
  for (const auto& filter : plan.filters) {
    auto& implied_states = plan.implied_states.emplace_back();
    const std::string filter_pointer = join_pointer("/filters", filter.name);
    const std::string section = join_pointer(filter_pointer, "implied_states");
    if (!draft.is_object(section, "'implied_states'")) continue;
    for (const auto& name : draft.keys(section))
      read_implied_state(draft, filter, filter_pointer, name, implied_states);
  }
}

void read_references(CompositionDraft& draft, ScorePlan& plan) {
  // One reference may stand without the list around it.
  if (draft.kind("/reference") == Kind::object) return add_reference(draft, "/reference", plan);
  if (!draft.is_list("/reference", "'reference'")) return;
  for (std::size_t i = 0; i < draft.size("/reference"); ++i) add_reference(draft, join_pointer("/reference", i), plan);
}

}  // namespace binnacle::score
