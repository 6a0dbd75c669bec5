// SPDX-License-Identifier: Apache-2.0
// Compositions: loading, and what there is in one.
#include <algorithm>
#include <atomic>
#include <utility>

#include "binnacle/state_block.hpp"
#include "binnacle/version.hpp"
#include "handles.hpp"
#include "score/sections.hpp"

namespace binnacle::c {

namespace {

std::vector<std::string> texts(const char* const* list, std::uint64_t count, const char* name) {
  if (count > 0) not_null(list, name);
  std::vector<std::string> all;
  for (std::uint64_t i = 0; i < count; ++i) all.emplace_back(&not_null(list[i], name));
  return all;
}

LoadOptions load_options_of(const binnacle_load_options* given) {
  LoadOptions options;
  if (!given) return options;
  const binnacle_load_options known = taken(given, "options");
  for (const std::string& text : texts(known.vars, known.var_count, "options->vars")) {
    const auto at = text.find('=');
    if (at == std::string::npos || at == 0) throw UsageError("options->vars takes NAME=VALUE; found '" + text + "'");
    options.vars[text.substr(0, at)] = text.substr(at + 1);
  }
  options.sets = texts(known.sets, known.set_count, "options->sets");
  return options;
}

binnacle_composition* handle_of(std::shared_ptr<const Composition> composition) {
  static std::atomic<std::uint64_t> number = 0;
  auto loaded = std::make_unique<LoadedComposition>();
  loaded->warnings = composition->warnings().text();
  loaded->warnings_json = json_text(composition->warnings());
  loaded->composition = std::move(composition);
  loaded->number = ++number;
  return reinterpret_cast<binnacle_composition*>(&slots<LoadedComposition>().take(std::move(loaded)));
}

const auto& item_at(const auto& list, std::uint64_t index, const char* what) {
  if (index >= list.size())
    throw UsageError(std::string("there is no ") + what + " " + std::to_string(index) + " (of " +
                     std::to_string(list.size()) + ")");
  return list[static_cast<std::size_t>(index)];
}

const ChannelInfo& channel_info(const LoadedComposition& in, binnacle_id channel) {
  return item_at(in.composition->channels(), static_cast<std::uint64_t>(channel_of(in.number, channel).index),
                 "channel");
}

const FilterInfo& filter_info(const LoadedComposition& in, FilterId filter) {
  return item_at(in.composition->filters(), static_cast<std::uint64_t>(filter.index), "filter");
}

const BlockInfo& block_info(const LoadedComposition& in, binnacle_id id) {
  const BlockId block = block_of(in.number, id);
  return item_at(filter_info(in, block.filter).blocks, static_cast<std::uint64_t>(block.index), "block");
}

/// Of a channel's fields per epoch, or per row, in the order of a sample.
void give_field(const LoadedComposition& in, binnacle_id channel, bool is_per_row, std::uint64_t index,
                const char** name, const char** unit, binnacle_kind* kind) {
  const ChannelInfo& info = channel_info(in, channel);
  const auto& fields = info.declaration->fields;
  not_null(name, "name"), not_null(unit, "unit"), not_null(kind, "kind");
  for (std::size_t f = 0; f < fields.size(); ++f)
    if (fields[f].is_per_row == is_per_row && static_cast<std::uint64_t>(info.position[f]) == index) {
      *name = fields[f].name.c_str();
      *unit = fields[f].unit.c_str();
      *kind = static_cast<binnacle_kind>(fields[f].kind);
      return;
    }
  throw UsageError("channel '" + info.name + "' has no field " + std::to_string(index) + " per " +
                   (is_per_row ? "row" : "epoch") + " (of " + std::to_string(info.declaration->count(is_per_row)) +
                   ")");
}

void give_named(const auto& named, const char** name, const char** unit) {
  not_null(name, "name"), not_null(unit, "unit");
  *name = named.name.c_str();
  *unit = named.unit.c_str();
}

std::uint64_t count_of(auto number) { return static_cast<std::uint64_t>(number); }

}  // namespace

}  // namespace binnacle::c

using namespace binnacle;
using namespace binnacle::c;

std::uint32_t binnacle_interface_version() { return BINNACLE_INTERFACE_MAJOR << 16 | BINNACLE_INTERFACE_MINOR; }

const char* binnacle_version() { return BINNACLE_VERSION; }

binnacle_status binnacle_load(const char* path, const binnacle_load_options* options,
                              binnacle_composition** composition) {
  return guarded(__func__, [&] {
    not_null(path, "path"), not_null(composition, "composition");
    *composition = handle_of(score::load(path, load_options_of(options)));
  });
}

binnacle_status binnacle_parse(const char* text, const char* name, const binnacle_load_options* options,
                               binnacle_composition** composition) {
  return guarded(__func__, [&] {
    not_null(text, "text"), not_null(name, "name"), not_null(composition, "composition");
    *composition = handle_of(score::parse(text, name, load_options_of(options)));
  });
}

binnacle_status binnacle_warnings(const binnacle_composition* composition, const char** text) {
  return guarded(__func__, [&] { not_null(text, "text") = content_of(composition).warnings.c_str(); });
}

binnacle_status binnacle_warnings_json(const binnacle_composition* composition, const char** json) {
  return guarded(__func__, [&] { not_null(json, "json") = content_of(composition).warnings_json.c_str(); });
}

binnacle_status binnacle_release(binnacle_composition* composition) {
  return guarded(__func__, [&] { close(composition); });
}

binnacle_status binnacle_channel_count(const binnacle_composition* composition, uint64_t* count) {
  return guarded(__func__, [&] { not_null(count, "count") = content_of(composition).composition->channels().size(); });
}

binnacle_status binnacle_filter_count(const binnacle_composition* composition, uint64_t* count) {
  return guarded(__func__, [&] { not_null(count, "count") = content_of(composition).composition->filters().size(); });
}

binnacle_status binnacle_channel_at(const binnacle_composition* composition, uint64_t index, binnacle_id* channel) {
  return guarded(__func__, [&] {
    const auto& in = content_of(composition);
    item_at(in.composition->channels(), index, "channel");
    not_null(channel, "channel") = id_of(in.number, IdKind::channel, 0, static_cast<int>(index));
  });
}

binnacle_status binnacle_filter_at(const binnacle_composition* composition, uint64_t index, binnacle_id* filter) {
  return guarded(__func__, [&] {
    const auto& in = content_of(composition);
    item_at(in.composition->filters(), index, "filter");
    not_null(filter, "filter") = id_of(in.number, IdKind::filter, 0, static_cast<int>(index));
  });
}

binnacle_status binnacle_block_at(const binnacle_composition* composition, binnacle_id filter, uint64_t index,
                                  binnacle_id* block) {
  return guarded(__func__, [&] {
    const auto& in = content_of(composition);
    const FilterId of = filter_of(in.number, filter);
    item_at(filter_info(in, of).blocks, index, "block");
    not_null(block, "block") = id_of(in.number, IdKind::block, of.index, static_cast<int>(index));
  });
}

binnacle_status binnacle_measurement_at(const binnacle_composition* composition, binnacle_id filter, uint64_t index,
                                        binnacle_id* measurement) {
  return guarded(__func__, [&] {
    const auto& in = content_of(composition);
    const FilterId of = filter_of(in.number, filter);
    item_at(filter_info(in, of).measurements, index, "measurement");
    not_null(measurement, "measurement") = id_of(in.number, IdKind::measurement, of.index, static_cast<int>(index));
  });
}

binnacle_status binnacle_describe_channel(const binnacle_composition* composition, binnacle_id channel,
                                          binnacle_channel_info* info) {
  return guarded(__func__, [&] {
    check_size(info, "info");
    const ChannelInfo& of = channel_info(content_of(composition), channel);
    binnacle_channel_info content{};
    content.name = of.name.c_str();
    content.fields = count_of(of.declaration->count(false));
    content.row_fields = count_of(of.declaration->count(true));
    content.max_rows = count_of(of.declaration->max_rows);
    content.covariance_rows = of.declaration->covariance.size();
    give(info, content);
  });
}

binnacle_status binnacle_describe_filter(const binnacle_composition* composition, binnacle_id filter,
                                         binnacle_filter_info* info) {
  return guarded(__func__, [&] {
    check_size(info, "info");
    const auto& in = content_of(composition);
    const FilterInfo& of = filter_info(in, filter_of(in.number, filter));
    binnacle_filter_info content{};
    content.name = of.name.c_str();
    content.blocks = of.blocks.size();
    content.measurements = of.measurements.size();
    content.state_size = count_of(of.stored_size);
    content.rows = count_of(of.dof);
    content.input = of.input_channel < 0 ? 0 : id_of(in.number, IdKind::channel, 0, of.input_channel);
    give(info, content);
  });
}

binnacle_status binnacle_describe_block(const binnacle_composition* composition, binnacle_id block,
                                        binnacle_block_info* info) {
  return guarded(__func__, [&] {
    check_size(info, "info");
    const BlockInfo& of = block_info(content_of(composition), block);
    binnacle_block_info content{};
    content.name = of.name.c_str();
    content.type = of.type.c_str();
    content.outputs = of.declaration->outputs.size();
    content.state_offset = count_of(of.stored_offset);
    content.state_size = count_of(of.declaration->stored_size);
    content.first_row = count_of(of.first_row);
    content.rows = of.active.size();
    give(info, content);
  });
}

binnacle_status binnacle_describe_measurement(const binnacle_composition* composition, binnacle_id measurement,
                                              binnacle_measurement_info* info) {
  return guarded(__func__, [&] {
    check_size(info, "info");
    const auto& in = content_of(composition);
    const MeasurementId id = measurement_of(in.number, measurement);
    const MeasurementInfo& of =
        item_at(filter_info(in, id.filter).measurements, static_cast<std::uint64_t>(id.index), "measurement");
    binnacle_measurement_info content{};
    content.name = of.name.c_str();
    content.channel = of.channel < 0 ? 0 : id_of(in.number, IdKind::channel, 0, of.channel);
    content.max_rows = count_of(of.max_rows);
    give(info, content);
  });
}

binnacle_status binnacle_field(const binnacle_composition* composition, binnacle_id channel, uint64_t index,
                               const char** name, const char** unit, binnacle_kind* kind) {
  return guarded(__func__, [&] { give_field(content_of(composition), channel, false, index, name, unit, kind); });
}

binnacle_status binnacle_row_field(const binnacle_composition* composition, binnacle_id channel, uint64_t index,
                                   const char** name, const char** unit, binnacle_kind* kind) {
  return guarded(__func__, [&] { give_field(content_of(composition), channel, true, index, name, unit, kind); });
}

binnacle_status binnacle_covariance_row(const binnacle_composition* composition, binnacle_id channel, uint64_t index,
                                        const char** name, const char** unit) {
  return guarded(__func__, [&] {
    const ChannelInfo& of = channel_info(content_of(composition), channel);
    give_named(item_at(of.declaration->covariance, index, "row of the covariance"), name, unit);
  });
}

binnacle_status binnacle_output(const binnacle_composition* composition, binnacle_id block, uint64_t index,
                                const char** name, const char** unit) {
  return guarded(__func__, [&] {
    const BlockInfo& of = block_info(content_of(composition), block);
    give_named(item_at(of.declaration->outputs, index, "output"), name, unit);
  });
}

binnacle_status binnacle_row(const binnacle_composition* composition, binnacle_id block, uint64_t index,
                             const char** name, const char** unit) {
  return guarded(__func__, [&] {
    const BlockInfo& of = block_info(content_of(composition), block);
    const int component = item_at(of.active, index, "row");
    give_named(of.declaration->error[static_cast<std::size_t>(component)], name, unit);
  });
}
