// SPDX-License-Identifier: Apache-2.0
#include "inspect_sources.hpp"

#include <algorithm>
#include <filesystem>
#include <memory>
#include <set>
#include <utility>

#include "binnacle/composition.hpp"
#include "binnacle/diagnostic.hpp"
#include "binnacle/run.hpp"
#include "binnacle/section.hpp"
#include "binnacle/unit.hpp"
#include "inspect/file_kind.hpp"
#include "output.hpp"
#include "verbs.hpp"

namespace binnacle::command {

namespace {

/// Shows all channels of sources to the run's observer.
class AllSources final : public Section {
 public:
  std::vector<std::string> keys() const override {
    return {"reference", "evaluate", "record", "study", "covariance", "metrics", "tune"};
  }
  std::vector<std::string> filter_keys() const override { return {"implied_states", "smoother"}; }
  std::shared_ptr<const SectionData> read(CompositionDraft& draft) const override {
    for (std::size_t i = 0; i < draft.channels().size(); ++i)
      if (draft.channels()[i].pointer.starts_with("/sources/")) draft.subscribe(static_cast<int>(i), "inspect");
    return nullptr;
  }
};

class Collector final : public RunObserver {
 public:
  Collector(const Composition& composition, const GoesOn& goes_on) : goes_on_(goes_on) {
    for (const ChannelInfo& info : composition.channels()) {
      inspect::Channel& channel = channels.emplace_back();
      channel.name = info.name;
      channel.pointer = info.pointer;
      channel.time_unit = "s";
      auto& places = places_.emplace_back();
      for (std::size_t f = 0; f < info.declaration->fields.size(); ++f) {
        const FieldSpec& spec = info.declaration->fields[f];
        if (spec.is_per_row) {
          channel.has_rows = true;
          continue;
        }
        places.push_back(info.position[f]);
        inspect::Field& field = channel.fields.emplace_back();
        field.name = field.column = spec.name;
        field.unit = field.si = spec.unit;
        field.kind = spec.kind;
      }
    }
  }
  void sampled(int index, const SampleView& sample) override {
    const auto i = static_cast<std::size_t>(index);
    inspect::Channel& channel = channels[i];
    const double t = seconds(sample.t);
    if (channel.t.empty()) channel.first_label = t;
    channel.t.push_back(t - channel.first_label);
    for (std::size_t f = 0; f < places_[i].size(); ++f)
      channel.fields[f].values.push_back(sample.fields[places_[i][f]]);
  }
  bool progress(Time) override { return goes_on_(); }
  std::vector<inspect::Channel> channels;

 private:
  const GoesOn& goes_on_;
  std::vector<std::vector<int>> places_;
};

/// A csv source of plain columns and labels: its file is read as it is. Others are read by the source.
bool is_text(const Json& source) {
  const std::string type = source.at("type");
  if (type != "csv" && type != "csv/csv") return false;
  for (const char* key : {"rows", "where", "local", "decimal", "every"})
    if (source.contains(key)) return false;
  const Json time = source.value("time", Json::object());
  for (const char* key : {"format", "date_column", "week_column"})
    if (time.contains(key)) return false;
  return std::ranges::none_of(source.at("columns"), [](const Json& column) { return column.contains("offset"); });
}

/// What stands under a csv source of the resolved config.
inspect::StatedFile stated_file(const Json& source) {
  inspect::StatedFile file;
  file.path = source.at("path");
  if (const auto time = source.find("time"); time != source.end()) {
    file.time_column = time->value("column", "");
    file.time_unit = time->value("unit", "s");
    file.time_scale = inspect::file_unit(file.time_unit).scale;
    if (const auto offset = time->find("offset"); offset != time->end())
      file.time_offset = offset->is_number() ? offset->get<double>() : seconds(*parse_time(offset->get<std::string>()));
  }
  file.delimiter = source.value("delimiter", ",")[0];
  file.comment = source.value("comment", "#");
  file.has_header = source.value("header", true);
  for (const auto& [field, column] : source.at("columns").items()) {
    inspect::StatedColumn& stated = file.columns.emplace_back();
    stated.field = field;
    stated.column = column.value("column", field);
    stated.unit = column.at("unit");
    const Unit unit = inspect::file_unit(stated.unit);
    stated.scale = unit.scale * column.value("scale", 1.0);
    stated.si = si_unit(unit.dimension);
    const std::string kind = column.value("kind", "level");
    stated.kind = kind == "rate" ? FieldKind::rate : kind == "increment" ? FieldKind::increment : FieldKind::level;
    if (const auto missing = column.find("missing"); missing != column.end())
      stated.missing = missing->get<std::vector<std::string>>();
  }
  return file;
}

/// What sources emit, other than text files.
std::vector<inspect::Channel> emitted(const std::shared_ptr<const Composition>& composition, const GoesOn& goes_on) {
  Collector collector(*composition, goes_on);
  RunOptions run_options;
  run_options.observer = &collector;
  run_options.feeds_sinks = false;
  std::string fault;
  try {
    run(composition, run_options);
  } catch (const DataError& error) {
    fault = error.what();
  }
  auto channels = std::move(collector.channels);
  for (auto& channel : channels) channel.fault = fault;
  return channels;
}

/// Files of receivers are read by their sources; null: a text file with columns. By content first, by name else: a file that is
/// damaged from its begin on is for the source to report.
Json receiver_source(const std::string& path) {
  std::string stem = path;
  if (stem.ends_with(".gz")) stem.resize(stem.size() - 3);
  const auto kind = inspect::kind_of_file(path);
  const char* type = nullptr;
  if (kind == inspect::FileKind::ublox || stem.ends_with(".ubx"))
    type = "ublox";
  else if (kind == inspect::FileKind::rtklib_pos || stem.ends_with(".pos"))
    type = "rtklib_pos";
  else if (kind == inspect::FileKind::nmea || stem.ends_with(".nmea"))
    type = "nmea";
  const auto refuse = [&](const char* why) {
    throw DataError(Diagnostic{Severity::error, "B066", {path, 0, 0}, "", why});
  };
  if (!type && kind == inspect::FileKind::rinex)
    refuse("is a RINEX file, which inspect does not support: the source 'rinex' reads it");
  if (!type && kind == inspect::FileKind::binary) refuse("is neither text nor UBX");
  if (!type) return nullptr;
  return {{"type", type}, {"path", std::filesystem::absolute(path).string()}};
}

void add_receiver(const std::string& path, const Json& source, const std::string& name, LoadOptions load,
                  const GoesOn& goes_on, std::vector<inspect::Channel>& channels) {
  load.sections = {std::make_shared<AllSources>()};
  const Json config = {{"binnacle", 1}, {"sources", {{name, source}}}, {"filters", Json::object()}};
  const std::string type = source.at("type");
  for (auto& channel : emitted(Composition::parse(config.dump(), path, load), goes_on)) {
    if (channel.t.empty()) continue;
    channel.path = path;
    channel.type = type;
    channel.pointer.clear();
    channels.push_back(std::move(channel));
  }
}

/// "imu" of "/data/imu.csv.gz"; with a number where it is taken.
std::string name_of(const std::string& path, const std::vector<inspect::Channel>& others) {
  std::string stem = std::filesystem::path(path).filename().string();
  stem = stem.substr(0, stem.find('.'));
  for (char& c : stem)
    if (!std::isalnum(static_cast<unsigned char>(c))) c = '_';
  std::string name = stem;
  for (int i = 2; std::ranges::any_of(others, [&](const auto& each) { return each.name == name; }); ++i)
    name = stem + std::to_string(i);
  return name;
}

}  // namespace

std::vector<inspect::Channel> channels_of_config(const std::string& path, LoadOptions load, const GoesOn& goes_on) {
  load.sections = {std::make_shared<AllSources>()};
  load.sets.insert(load.sets.end(), {"/filters={}", "/sinks={}", "/transforms={}"});
  const auto composition = Composition::load(path, load);
  const Json config = Json::parse(composition->config());
  std::vector<inspect::Channel> channels;
  std::set<std::string> read;
  for (const auto& [name, source] : config.at("sources").items()) {
    if (!is_text(source)) continue;
    channels.push_back(inspect::read_stated_file(stated_file(source), name));
    channels.back().pointer = "/sources/" + name;
    read.insert(channels.back().pointer);
  }
  if (read.size() == config.at("sources").size()) return channels;
  for (auto& channel : emitted(composition, goes_on))
    if (channel.pointer.starts_with("/sources/") && !read.contains(channel.pointer))
      channels.push_back(std::move(channel));
  return channels;
}

std::vector<inspect::Channel> channels_of(const std::vector<std::string>& files, const LoadOptions& options,
                                          const GoesOn& goes_on) {
  if (files.size() == 1 && is_config(files.front())) return channels_of_config(files.front(), options, goes_on);
  std::vector<inspect::Channel> channels;
  for (const auto& file : files) {
    if (is_config(file)) throw UsageError("inspect takes one config, or data files");
    if (const Json source = receiver_source(file); !source.is_null())
      add_receiver(file, source, name_of(file, channels), options, goes_on, channels);
    else
      channels.push_back(inspect::read_bare_file(file, name_of(file, channels)));
  }
  return channels;
}

}  // namespace binnacle::command
