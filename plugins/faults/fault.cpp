// SPDX-License-Identifier: Apache-2.0
// One fault: what it does to a sample, when, and to which of its fields.
#include "fault.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "binnacle/geodesy.hpp"
#include "random/normal.hpp"

namespace binnacle::faults {

namespace {

struct KindWords {
  const char* name;
  Kind kind;
  std::array<std::string_view, 2> keys;  // besides those that every kind takes; the first must be there
};

constexpr KindWords kinds[] = {
    {"step", Kind::step, {"by"}},
    {"ramp", Kind::ramp, {"by"}},
    {"noise", Kind::noise, {"sigma|factor"}},
    {"outliers", Kind::outliers, {"size", "tail"}},
    {"freeze", Kind::freeze, {}},
    {"drop", Kind::drop, {}},
    {"delay", Kind::delay, {"time"}},
    {"jitter", Kind::jitter, {"time"}},
    {"scale", Kind::scale, {"factor"}},
    {"swap", Kind::swap, {}},
    {"negate", Kind::negate, {}},
    {"nan", Kind::nan, {}},
    {"quantize", Kind::quantize, {"by"}},
    {"duplicate", Kind::duplicate, {}},
};

bool is_of_sample(Kind kind) {
  return kind == Kind::drop || kind == Kind::delay || kind == Kind::jitter || kind == Kind::duplicate;
}

const ParameterValue* member(const ParameterValue& object, std::string_view name) {
  for (const auto& [key, value] : object.members)
    if (key == name && value.type != ParameterValue::Type::absent) return &value;
  return nullptr;
}

std::string listed(const ChannelDeclaration& channel) {
  std::string names;
  for (const FieldSpec& field : channel.fields) names += (names.empty() ? "" : ", ") + field.name;
  return names;
}

/// Of a field among those that are per row, or those that are not.
int position(const ChannelDeclaration& channel, std::string_view name, bool is_per_row) {
  int index = 0;
  for (const FieldSpec& field : channel.fields) {
    if (field.is_per_row != is_per_row) continue;
    if (field.name == name) return index;
    ++index;
  }
  return -1;
}

/// Student's t with so many degrees of freedom.
double student(random::Philox& random, int dof) {
  double chi2 = 0;
  for (int i = 0; i < dof; ++i) {
    const double n = random::normal(random);
    chi2 += n * n;
  }
  return random::normal(random) / std::sqrt(chi2 / dof);
}

}  // namespace

// ---- what it is

ParameterSpec Fault::spec() {
  using namespace parameter;
  std::vector<std::string> names;
  for (const auto& kind : kinds) names.emplace_back(kind.name);
  std::vector<ParameterSpec> members;
  members.push_back(choice("kind", std::move(names)).required().about("kind of fault; see the plugin's README"));
  members.push_back(list("fields", text("field")).about("fields of the channel, or \"covariance\"; default: all"));
  members.push_back(
      number("by", "*").about("step, ramp, quantize: size of the fault; metres are accepted for lat and lon"));
  members.push_back(number("sigma", "*").about("noise: standard deviation"));
  members.push_back(number("size", "*").about("outliers: standard deviation, or size"));
  members.push_back(choice("tail", {"heavy", "normal", "fixed"})
                        .about("outliers: distribution: Student's t with 3 degrees of freedom, normal, or ± size"));
  members.push_back(
      number("factor", "1").about("scale: factor on the values; noise: standard deviation relative to the value"));
  members.push_back(time("time").about("delay: time added to the label; jitter: standard deviation of the added time"));
  members.push_back(time("from").about("start of the window, included; default: the first sample"));
  members.push_back(time("until").about("end of the window, not included; default: the last sample"));
  members.push_back(choice("since", {"zero", "start"})
                        .defaults("\"zero\"")
                        .about("start: 'from' and 'until' count from the first sample"));
  members.push_back(
      number("share", "1").at_least(0).at_most(1).defaults("1").about("fraction of the samples, chosen at random"));
  members.push_back(text("row_field").about("field that selects rows: only those with row_value in it"));
  members.push_back(number("row_value", "1").about("value of row_field in the selected rows"));
  return object("fault", std::move(members));
}

void Fault::refuse(const std::string& why, std::string_view key) const {
  throw ComponentError(why, key.empty() ? place_ : place_ + "/" + std::string(key));
}

Fault::Fault(const ParameterValue& element, const ChannelDeclaration& channel, const std::string& place)
    : place_(place) {
  const Parameters parameters(element);
  const std::string& name = parameters.text("kind");
  kind_ = std::ranges::find_if(kinds, [&](const auto& kind) { return kind.name == name; })->kind;
  check_keys(element);
  find_fields(parameters, channel);
  find_row_filter(parameters, channel);
  find_amount(element, channel);
  has_from_ = parameters.has("from");
  has_until_ = parameters.has("until");
  if (has_from_) from_ = parameters.time("from");
  if (has_until_) until_ = parameters.time("until");
  if (has_from_ && has_until_ && until_ <= from_) refuse("it ends before it begins", "until");
  if (kind_ == Kind::ramp && !(has_from_ && has_until_)) refuse("a ramp needs 'from' and 'until'");
  is_from_start_ = parameters.text("since") == "start";
  share_ = parameters.number("share");
  holds_ = kind_ == Kind::freeze;
  held_rows_ = std::max(1, channel.max_rows);
}

void Fault::check_keys(const ParameterValue& element) const {
  const auto& words = *std::ranges::find_if(kinds, [&](const auto& k) { return k.kind == kind_; });
  const auto takes = [&](std::string_view key) {
    return std::any_of(words.keys.begin(), words.keys.end(), [&](std::string_view keys) {
      return keys == key || keys.starts_with(std::string(key) + "|") || keys.ends_with("|" + std::string(key));
    });
  };
  for (const char* key : {"by", "sigma", "size", "tail", "factor", "time"})
    if (member(element, key) && !takes(key)) refuse(std::string("'") + words.name + "' has no '" + key + "'", key);
  if (is_of_sample(kind_))
    for (const char* key : {"fields", "row_field", "row_value"})
      if (member(element, key))
        refuse(std::string("'") + words.name + "' is of whole samples and has no '" + key + "'", key);
  if (words.keys.front().empty()) return;
  const bool is_noise = kind_ == Kind::noise;
  const int given = (member(element, "sigma") ? 1 : 0) + (member(element, "factor") ? 1 : 0);
  if (is_noise && given != 1) refuse("'noise' needs either 'sigma' or 'factor'");
  if (!is_noise && !member(element, words.keys.front()))
    refuse(std::string("'") + words.name + "' needs '" + std::string(words.keys.front()) + "'");
}

void Fault::find_fields(const Parameters& parameters, const ChannelDeclaration& channel) {
  if (is_of_sample(kind_)) return;
  if (!parameters.has("fields")) {
    if (kind_ == Kind::swap) refuse("'swap' needs two 'fields'");
    for (const FieldSpec& field : channel.fields)
      targets_.push_back({position(channel, field.name, field.is_per_row), field.is_per_row});
  } else {
    const auto& names = parameters.list("fields");
    for (std::size_t i = 0; i < names.size(); ++i) {
      const std::string key = "fields/" + std::to_string(i);
      const std::string& name = names[i].text;
      if (name == "covariance") {
        if (kind_ != Kind::scale || names.size() != 1) refuse("'covariance' can only be scaled, by itself", key);
        if (channel.covariance.empty()) refuse("the channel attaches no covariance", key);
        is_of_covariance_ = true;
        return;
      }
      const int per_row = position(channel, name, true), per_epoch = position(channel, name, false);
      if (per_row < 0 && per_epoch < 0)
        refuse("the channel has no field '" + name + "' (it has " + listed(channel) + ")", key);
      targets_.push_back({std::max(per_row, per_epoch), per_row >= 0});
    }
    if (kind_ == Kind::swap && (targets_.size() != 2 || targets_[0].is_per_row != targets_[1].is_per_row))
      refuse("'swap' needs two 'fields', both per row or neither", "fields");
  }
  if (targets_.empty()) refuse("it has no field to work on", parameters.has("fields") ? "fields" : "");
}

void Fault::find_row_filter(const Parameters& parameters, const ChannelDeclaration& channel) {
  if (parameters.has("row_field") != parameters.has("row_value")) refuse("'row_field' and 'row_value' need each other");
  if (!parameters.has("row_field")) return;
  row_field_ = position(channel, parameters.text("row_field"), true);
  row_value_ = parameters.number("row_value");
  if (row_field_ < 0) refuse("the channel has no such field with a value per row", "row_field");
}

/// The unit of an amount is that of every field that it goes to; metres will do for latitudes and longitudes. A plain
/// number is in the field's own SI unit.
void Fault::fit(const FieldSpec& field, const std::string& unit, std::string_view key, Target& target) const {
  if (unit == "1" || unit == field.unit) return;
  const bool is_lat = field.name == "lat", is_lon = field.name == "lon";
  if (unit != "m" || field.unit != "rad" || !(is_lat || is_lon))
    refuse("field '" + field.name + "' is in " + (field.unit.empty() ? "no unit" : field.unit) + ", not in " + unit,
           key);
  if (target.is_per_row || lat_ < 0) refuse("metres need the field 'lat' in the same sample", key);
  target.metres_along = is_lat ? 0 : 1;
}

void Fault::find_amount(const ParameterValue& element, const ChannelDeclaration& channel) {
  lat_ = position(channel, "lat", false);
  height_ = position(channel, "height", false);
  if (const auto* time = member(element, "time")) {
    by_ = static_cast<double>(time->integer);
    return;
  }
  if (const auto* tail = member(element, "tail"))
    tail_ = tail->text == "heavy" ? 3 : tail->text == "normal" ? 0 : -1;
  else
    tail_ = 3;
  if (const auto* factor = member(element, "factor")) {
    by_ = factor->number;
    is_factor_ = true;
    return;
  }
  for (const char* key : {"by", "sigma", "size"}) {
    const auto* amount = member(element, key);
    if (!amount) continue;
    by_ = amount->number;
    for (Target& target : targets_) {
      int index = 0;
      for (const FieldSpec& field : channel.fields)
        if (field.is_per_row == target.is_per_row && index++ == target.index) fit(field, amount->text, key, target);
    }
    if ((kind_ == Kind::quantize && !(by_ > 0)) || (kind_ == Kind::noise && !(by_ >= 0)))
      refuse(std::string("'") + key + "' must be positive", key);
  }
}

// ---- what it does

bool Fault::contains(Time t, Time first) const {
  const Time since = is_from_start_ ? first : 0;
  return (!has_from_ || t >= since + from_) && (!has_until_ || t < since + until_);
}

bool Fault::is_meant(const SampleWriter& out, int row) const {
  return row_field_ < 0 || out.row_view(row)[row_field_] == row_value_;
}

/// act(value, target, which of the held ones it is)
template <class Act>
void Fault::each_value(const SampleWriter& out, Act&& act) const {
  for (std::size_t i = 0; i < targets_.size(); ++i) {
    const Target& target = targets_[i];
    const std::size_t first = i * static_cast<std::size_t>(held_rows_);
    if (!target.is_per_row)
      act(out.fields[target.index], target, first);
    else
      for (int row = 0; row < out.rows; ++row)
        if (is_meant(out, row)) act(out.row_view(row)[target.index], target, first + static_cast<std::size_t>(row));
  }
}

double Fault::outlier(random::Philox& random) const {
  if (tail_ < 0) return random::uniform(random) < 0.5 ? -by_ : by_;
  return by_ * (tail_ == 0 ? random::normal(random) : student(random, tail_));
}

/// Keeps the latest sound values; while it is at work, these come again and again.
void Fault::hold(const SampleWriter& out, FaultMemory& memory, double* held, bool is_active) const {
  const bool is_played_back = is_active && memory.is_held != 0;
  each_value(out, [&](double& value, const Target&, std::size_t place) {
    (is_played_back ? value : held[place]) = is_played_back ? held[place] : value;
  });
  memory.is_held = 1;
}

void Fault::spoil_values(const SampleWriter& out, FaultMemory& memory, Time elapsed) const {
  // Where the sample says it is, before this fault.
  const double lat = lat_ >= 0 ? out.fields[lat_] : 0;
  const double height = height_ >= 0 && std::isfinite(out.fields[height_]) ? out.fields[height_] : 0;
  const auto amount = [&](const Target& target, double value) {
    if (target.metres_along < 0) return value;
    const auto radii = geodesy::radii(lat);
    return target.metres_along == 0 ? value / (radii.meridian + height)
                                    : value / ((radii.transverse + height) * std::cos(lat));
  };
  const double share_of_ramp = kind_ == Kind::ramp ? seconds(elapsed) / seconds(until_ - from_) : 1;
  each_value(out, [&](double& value, const Target& target, std::size_t) {
    switch (kind_) {
      case Kind::step: value += amount(target, by_); break;
      case Kind::ramp: value += amount(target, by_ * share_of_ramp); break;
      case Kind::noise: {
        const double deviate = by_ * random::normal(memory.random);
        value += is_factor_ ? value * deviate : amount(target, deviate);
        break;
      }
      case Kind::outliers: value += amount(target, outlier(memory.random)); break;
      case Kind::scale: value *= by_; break;
      case Kind::negate: value = -value; break;
      case Kind::nan: value = std::numeric_limits<double>::quiet_NaN(); break;
      case Kind::quantize: {
        const double unit = amount(target, by_);
        value = std::round(value / unit) * unit;
        break;
      }
      default: break;
    }
  });
}

void Fault::spoil(Spoilt& sample, FaultMemory& memory, double* held) const {
  SampleWriter& out = sample.out;
  const auto shift = [&](double nanoseconds) {
    const auto by = static_cast<Time>(std::llround(nanoseconds));
    out.t += by;
    if (out.t0 != no_time) out.t0 += by;
  };
  switch (kind_) {
    case Kind::drop: sample.is_dropped = true; return;
    case Kind::duplicate: sample.is_doubled = true; return;
    case Kind::delay: shift(by_); return;
    case Kind::jitter: shift(by_ * random::normal(memory.random)); return;
    case Kind::freeze: hold(out, memory, held, true); return;
    case Kind::swap:
      if (!targets_[0].is_per_row)
        std::swap(out.fields[targets_[0].index], out.fields[targets_[1].index]);
      else
        for (int row = 0; row < out.rows; ++row)
          if (is_meant(out, row)) std::swap(out.row_view(row)[targets_[0].index], out.row_view(row)[targets_[1].index]);
      return;
    default: break;
  }
  if (is_of_covariance_) {
    if (!out.has_covariance) return;
    const int size = out.covariance_dof * out.covariance_dof;
    for (int i = 0; i < size; ++i) out.covariance[i] *= by_;
    return;
  }
  spoil_values(out, memory, out.t - from_ - (is_from_start_ ? sample.first : 0));
}

void Fault::apply(Spoilt& sample, FaultMemory& memory, double* held) const {
  const bool is_active =
      contains(sample.out.t, sample.first) && (share_ >= 1 || random::uniform(memory.random) < share_);
  if (is_active)
    spoil(sample, memory, held);
  else if (holds_)
    hold(sample.out, memory, held, false);
}

}  // namespace binnacle::faults
