// SPDX-License-Identifier: Apache-2.0
// Comma-separated columns, chosen by name, angles in degrees.
#include <algorithm>
#include <functional>

#include "binnacle/diagnostic.hpp"
#include "format.hpp"
#include "local_frame.hpp"
#include "text.hpp"

namespace binnacle::convert {

namespace {

using results::Estimate;
using results::FilterResults;

struct Column {
  std::string name, unit;
  std::function<double(std::size_t)> value;  // by the record's index in the results
};

/// "rad/s" is shown as "deg/s".
std::string shown_unit(const std::string& unit) {
  return unit == "rad" || unit.starts_with("rad/") ? "deg" + unit.substr(3) : unit;
}

Column column_of(const Estimate& estimate, bool is_sigma) {
  const double scale = shown_unit(estimate.unit) == estimate.unit ? 1 : degrees(1);
  const auto& values = is_sigma ? estimate.sigma : estimate.values;
  return {estimate.block + "." + estimate.output + (is_sigma ? ".sigma" : ""), shown_unit(estimate.unit),
          [&values, scale](std::size_t i) { return i < values.size() ? values[i] * scale : Record::unknown; }};
}

/// Every column that there is, in the order of the file: outputs, then their sigma.
class Columns {
 public:
  Columns(const FilterResults& filter, const std::vector<std::size_t>& indices, const std::optional<Place>& origin) {
    if (origin) local_.emplace(track_of(filter, indices, origin), *origin);
    for (const bool is_sigma : {false, true})
      for (const Estimate& estimate : filter.estimates) {
        if (!local_ || estimate.block != local_->track.block)
          columns_.push_back(column_of(estimate, is_sigma));
        else if (is_first_of_block(filter, estimate))
          add_local(is_sigma);
      }
  }

  /// A name, or a block for all of its outputs. Throws Refusal.
  std::vector<Column> chosen(const std::vector<std::string>& names) const {
    std::vector<Column> list;
    for (const Column& column : columns_)
      if (names.empty() && !column.name.ends_with(".sigma")) list.push_back(column);
    std::vector<std::string> known{"utc"};
    for (const Column& column : columns_) known.push_back(column.name);
    for (const std::string& name : names) {
      if (name == "t" || name == "utc") continue;
      const std::size_t before = list.size();
      for (const Column& column : columns_)
        if (column.name == name || (column.name.starts_with(name + ".") && !column.name.ends_with(".sigma")))
          list.push_back(column);
      if (list.size() != before) continue;
      std::vector<std::string> candidates = known;
      for (const std::string& each : known) candidates.push_back(each.substr(0, each.find('.')));
      const std::string near = closest(name, candidates);
      throw Refusal("there is no column '" + name + "'" + (near.empty() ? "." : "; did you mean '" + near + "'?") +
                    " There are: " + joined(known));
    }
    return list;
  }

 private:
  struct Local {
    Local(Track all, const Place& origin) : track(std::move(all)), frame(origin) {
      for (std::size_t i = 0; i < track.records.size(); ++i) {
        if (track.records[i].index >= place.size()) place.resize(track.records[i].index + 1, none);
        place[track.records[i].index] = i;
      }
    }
    const Record* record(std::size_t index) const {
      return index < place.size() && place[index] != none ? &track.records[place[index]] : nullptr;
    }
    static constexpr std::size_t none = static_cast<std::size_t>(-1);
    Track track;
    LocalFrame frame;
    std::vector<std::size_t> place;  // of a record, by its index
  };

  static bool is_first_of_block(const FilterResults& filter, const Estimate& estimate) {
    return &*std::find_if(filter.estimates.begin(), filter.estimates.end(),
                          [&](const Estimate& other) { return other.block == estimate.block; }) == &estimate;
  }

  static std::string joined(const std::vector<std::string>& names) {
    std::string text;
    for (const auto& name : names) text += (text.empty() ? "" : ", ") + name;
    return text;
  }

  void add_local(bool is_sigma) {
    const bool is_ecef = local_->track.kind == PositionKind::ecef;
    if (is_sigma && is_ecef) return;  // along x, y and z; turning them takes the covariance, which is not recorded
    for (int axis = 0; axis < (local_->track.has_vertical ? 3 : 2); ++axis) {
      constexpr const char* names[] = {"north", "east", "down"};
      columns_.push_back({local_->track.block + "." + names[axis] + (is_sigma ? ".sigma" : ""), "m",
                          [this, axis, is_sigma](std::size_t i) {
                            const Record* record = local_->record(i);
                            if (!record) return Record::unknown;
                            if (is_sigma) return record->sigma[axis];
                            return local_->frame.ned({record->ecef[0], record->ecef[1], record->ecef[2]})[axis];
                          }});
    }
  }

  std::optional<Local> local_;
  std::vector<Column> columns_;
};

}  // namespace

bool csv_needs_time(const Request& request) {
  return std::find(request.columns.begin(), request.columns.end(), "utc") != request.columns.end();
}

std::string csv(const FilterResults& filter, const std::vector<std::size_t>& indices, const Request& request,
                const std::optional<TimeBase>& time, const std::optional<Place>& origin) {
  const Columns all(filter, indices, origin);
  const auto columns = all.chosen(request.columns);
  const auto t = times_of(filter);
  std::string text = time ? "t[s],utc" : "t[s]";
  for (const Column& column : columns) text += "," + column.name + (column.unit == "1" ? "" : "[" + column.unit + "]");
  text += '\n';
  for (const std::size_t i : indices) {
    append_exact(text, filter.t[i]);
    if (time) text += "," + iso(time->clock.utc(t[i]), 6);
    for (const Column& column : columns) {
      text += ',';
      append_exact(text, column.value(i));
    }
    text += '\n';
  }
  return text;
}

}  // namespace binnacle::convert
