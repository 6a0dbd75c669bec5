// SPDX-License-Identifier: Apache-2.0
// Columns of a text file as fields: by their names, else by how they behave.
#include <algorithm>
#include <cctype>
#include <cmath>
#include <optional>
#include <regex>

#include "binnacle/diagnostic.hpp"
#include "inspect/channel.hpp"
#include "statistics.hpp"
#include "text_table.hpp"

namespace binnacle::inspect {

namespace {

struct Name {
  const char* field;
  const char* pattern;
  const char* unit;  // SI, and guessed where the name states none
};

/// Names as loggers write them, without unit, in small letters.
constexpr Name known_names[] = {
    {"wx", "(g|w|gyro?|gyr|omega|rate|angular_?(rate|velocity))[_.]?x|roll_?rate|p", "rad/s"},
    {"wy", "(g|w|gyro?|gyr|omega|rate|angular_?(rate|velocity))[_.]?y|pitch_?rate|q", "rad/s"},
    {"wz", "(g|w|gyro?|gyr|omega|rate|angular_?(rate|velocity))[_.]?z|yaw_?rate|r", "rad/s"},
    {"fx", "(a|f|acc|accel|accelerometer|force|linear_?acceleration|specific_?force)[_.]?x", "m/s^2"},
    {"fy", "(a|f|acc|accel|accelerometer|force|linear_?acceleration|specific_?force)[_.]?y", "m/s^2"},
    {"fz", "(a|f|acc|accel|accelerometer|force|linear_?acceleration|specific_?force)[_.]?z", "m/s^2"},
    {"lat", "lat|latitude", "deg"},
    {"lon", "lon|lng|long|longitude", "deg"},
    {"height", "h|alt|altitude|height|h_ell|ellipsoidal_height|hae", "m"},
    {"vn", "vn|v_n|vel_?n|v_?north|vel_?north|velocity_?n(orth)?", "m/s"},
    {"ve", "ve|v_e|vel_?e|v_?east|vel_?east|velocity_?e(ast)?", "m/s"},
    {"vd", "vd|v_d|vel_?d|v_?down|vel_?down|velocity_?d(own)?", "m/s"},
    {"vd", "vu|v_u|vel_?u|v_?up|vel_?up|velocity_?u(p)?", "-1 m/s"},
    {"position_sd_n", "(pos|position)_?(std|sd|sigma)_?n(orth)?", "m"},
    {"position_sd_e", "(pos|position)_?(std|sd|sigma)_?e(ast)?", "m"},
    {"position_sd_d", "(pos|position)_?(std|sd|sigma)_?d(own)?", "m"},
    {"velocity_sd_n", "(vel|velocity)_?(std|sd|sigma)_?n(orth)?", "m/s"},
    {"velocity_sd_e", "(vel|velocity)_?(std|sd|sigma)_?e(ast)?", "m/s"},
    {"velocity_sd_d", "(vel|velocity)_?(std|sd|sigma)_?d(own)?", "m/s"},
    {"roll", "roll", "rad"},
    {"pitch", "pitch", "rad"},
    {"yaw", "yaw|heading|hdg", "rad"},
    {"course", "course|cog|track", "rad"},
    {"speed", "speed|sog|ground_?speed", "m/s"},
    {"t", "t|time|times?tamp|stamp|sec|seconds|tow|gps_?time|unix_?time|utc_?time|epoch", "s"},
};

/// How units are written in names.
constexpr std::pair<const char*, const char*> unit_names[] = {
    {"rad/s", "rad/s|radps|rad_s|rads"},
    {"deg/s", "deg/s|degps|deg_s|dps|degs"},
    {"m/s^2", "m/s\\^?2|mps2|m_s2|ms2|m/s/s"},
    {"m/s", "m/s|mps|m_s"},
    {"km/h", "km/h|kmh|kph|kmph"},
    {"kn", "kn|kt|kts|knots"},
    {"deg", "deg|degrees"},
    {"rad", "rad|radians"},
    {"mg", "mg"},
    {"g", "g"},
    {"m", "m|metres|meters"},
    {"ft", "ft|feet"},
    {"s", "s|sec|seconds"},
    {"ms", "ms|msec"},
    {"us", "us|usec"},
    {"ns", "ns|nsec|nanoseconds"},
};

struct Meaning {
  std::string field, unit;
  bool is_guessed = true;
};

const std::vector<std::pair<std::string, std::regex>>& compiled_units() {
  static const auto all = [] {
    std::vector<std::pair<std::string, std::regex>> list;
    for (const auto& [unit, pattern] : unit_names) list.emplace_back(unit, std::regex(pattern));
    return list;
  }();
  return all;
}

std::optional<Name> name_of(const std::string& text) {
  for (const Name& name : known_names)
    if (std::regex_match(text, std::regex(name.pattern))) return name;
  return std::nullopt;
}

/// The unit of a column that counts the other way, upward, is negative.
std::string signed_as(const Name& name, const std::string& unit) {
  return std::string_view(name.unit).starts_with('-') ? "-1 " + unit : unit;
}

/// "gx_radps", "ax [m/s^2]", "lat(deg)".
std::optional<Meaning> meaning_of(std::string text) {
  std::ranges::transform(text, text.begin(), [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  std::ranges::replace(text, ' ', '_');
  if (const auto name = name_of(text)) return Meaning{name->field, name->unit, true};
  std::smatch match;
  if (std::regex_match(text, match, std::regex(R"((.*?)_*[\[\(](.*)[\]\)])")) ||
      std::regex_match(text, match, std::regex(R"((.*?)_([a-z/0-9^]+(_s2?)?))")))
    if (const auto name = name_of(match[1]))
      for (const auto& [unit, pattern] : compiled_units())
        if (std::regex_match(match[2].str(), pattern)) return Meaning{name->field, signed_as(*name, unit), false};
  // pos_std_n_m, vel_std_n_mps: the unit is the last word.
  const auto cut = text.rfind('_');
  if (cut == std::string::npos) return std::nullopt;
  if (const auto name = name_of(text.substr(0, cut)))
    for (const auto& [unit, pattern] : compiled_units())
      if (std::regex_match(text.substr(cut + 1), pattern)) return Meaning{name->field, signed_as(*name, unit), false};
  return std::nullopt;
}

bool increases(const std::vector<double>& values) {
  std::size_t up = 0, all = 0;
  for (std::size_t i = 1; i < values.size(); ++i) {
    if (!std::isfinite(values[i]) || !std::isfinite(values[i - 1])) continue;
    ++all;
    up += values[i] > values[i - 1];
  }
  return all > 10 && static_cast<double>(up) > 0.95 * static_cast<double>(all);
}

/// Length of the mean of a triad, against how the length scatters: large for an accelerometer, small for gyros.
double steadiness(const TextTable& table, std::size_t first) {
  std::vector<double> lengths;
  const auto& c = table.columns;
  for (std::size_t i = 0; i < c[first].values.size(); ++i)
    lengths.push_back(std::hypot(c[first].values[i], c[first + 1].values[i], c[first + 2].values[i]));
  const double centre = median(lengths);
  return centre / std::max(1e-12, robust_sigma(lengths));
}

/// Latitude, longitude [deg] and height without names: two columns within their ranges that stay within 5 deg and creep, by less
/// than 1e-3 deg (100 m) from row to row, away from zero. A sensor's have noise, are near zero, or have gravity in them: 1 g.
bool is_geodetic(const TextTable& table, std::size_t first) {
  for (std::size_t k = 0; k < 2; ++k) {
    const auto& values = table.columns[first + k].values;
    std::vector<double> steps;
    double low = 1e300, high = -1e300;
    for (std::size_t i = 0; i < values.size(); ++i) {
      if (!std::isfinite(values[i])) return false;
      low = std::min(low, values[i]);
      high = std::max(high, values[i]);
      if (i > 0) steps.push_back(std::abs(values[i] - values[i - 1]));
    }
    if (steps.empty() || low < (k == 0 ? -90 : -180) || high > (k == 0 ? 90 : 360) || high - low > 5) return false;
    if (std::min(std::abs(low), std::abs(high)) < 0.5 || quantile(steps, 0.9) > 1e-3) return false;
  }
  const auto& c = table.columns;
  const double g = std::hypot(c[first].values[0], c[first + 1].values[0], c[first + 2].values[0]);
  return g < 0.9 || g > 1.1;
}

/// Columns beside time without names: a position, or two triads of which the steadier one has gravity in it. Where lines are of
/// several kinds they say nothing.
std::vector<std::optional<Meaning>> by_behaviour(const TextTable& table, std::size_t time) {
  std::vector<std::optional<Meaning>> meanings(table.columns.size());
  meanings[time] = Meaning{"t", "s", true};
  if (10 * table.cut_rows > static_cast<std::int64_t>(table.columns[time].values.size())) return meanings;
  if (table.columns.size() >= time + 4 && is_geodetic(table, time + 1)) {
    meanings[time + 1] = Meaning{"lat", "deg", true};
    meanings[time + 2] = Meaning{"lon", "deg", true};
    meanings[time + 3] = Meaning{"height", "m", true};
    return meanings;
  }
  // After the time, or before it where it stands last.
  const std::size_t first = table.columns.size() >= time + 7 ? time + 1 : 0;
  if (table.columns.size() < first + 6 || (first == 0 && time < 6)) return meanings;
  const bool force_first = steadiness(table, first) > steadiness(table, first + 3);
  const char* const order[] = {"wx", "wy", "wz", "fx", "fy", "fz"};
  for (std::size_t i = 0; i < 6; ++i) {
    const std::size_t which = force_first ? (i + 3) % 6 : i;
    meanings[first + i] = Meaning{order[which], which < 3 ? "rad/s" : "m/s^2", true};
  }
  return meanings;
}

std::size_t time_column(const TextTable& table, const std::vector<std::optional<Meaning>>& meanings) {
  for (std::size_t i = 0; i < meanings.size(); ++i)
    if (meanings[i] && meanings[i]->field == "t") return i;
  for (std::size_t i = 0; i < table.columns.size(); ++i)
    if (table.columns[i].instants > table.columns[i].bad) return i;
  for (std::size_t i = 0; i < table.columns.size(); ++i)
    if (increases(table.columns[i].values)) return i;
  return 0;
}

void take_times(Channel& channel, const TextColumn& column, double scale, double offset) {
  channel.t = column.values;
  for (const double label : channel.t)
    if (std::isfinite(label)) {
      channel.first_label = label * scale + offset;
      break;
    }
  for (double& label : channel.t) label = label * scale + offset - channel.first_label;
}

}  // namespace

Unit file_unit(const std::string& text) {
  if (const auto unit = parse_unit(text)) return *unit;
  const auto quantity = parse_quantity(text);
  return {quantity->value, quantity->dimension};
}

Channel read_bare_file(const std::string& path, const std::string& name) {
  TextTable table = read_text_table(path);
  std::vector<std::optional<Meaning>> meanings;
  for (const auto& column : table.columns)
    meanings.push_back(table.has_header ? meaning_of(column.name) : std::nullopt);
  const std::size_t time = time_column(table, meanings);
  if (std::ranges::none_of(meanings, [](const auto& each) { return each && each->field != "t"; }))
    meanings = by_behaviour(table, time);
  Channel channel;
  channel.name = name;
  channel.path = path;
  channel.type = "csv";
  channel.delimiter = table.delimiter;
  channel.comment = table.comment;
  channel.has_header = table.has_header;
  channel.has_decimal_commas = table.has_decimal_commas;
  channel.cut_rows = table.cut_rows;
  channel.time_column = table.columns[time].name;
  channel.has_dates = table.columns[time].instants > 0;
  channel.bad_labels = table.columns[time].bad + table.columns[time].empty;
  const bool is_stated = meanings[time] && !meanings[time]->is_guessed;
  channel.time_unit = is_stated && !channel.has_dates ? meanings[time]->unit : "s";
  channel.time_is_guessed = !is_stated && !channel.has_dates;
  take_times(channel, table.columns[time], file_unit(channel.time_unit).scale, 0);
  for (std::size_t i = 0; i < table.columns.size(); ++i) {
    if (i == time) continue;
    TextColumn& column = table.columns[i];
    Field& field = channel.fields.emplace_back();
    field.column = column.name;
    field.name = meanings[i] && !channel.find(meanings[i]->field) ? meanings[i]->field : column.name;
    if (meanings[i]) field.unit = meanings[i]->unit;
    field.is_guessed = !meanings[i] || meanings[i]->is_guessed;
    const Unit unit = field.unit.empty() ? Unit{} : file_unit(field.unit);
    field.scale = unit.scale;
    field.si = field.unit.empty() ? "" : si_unit(unit.dimension);
    field.kind = field.name[0] == 'w' || field.name[0] == 'f' ? FieldKind::rate : FieldKind::level;
    field.empty = column.empty;
    field.bad = column.bad;
    field.spoilt = column.spoilt;
    field.values = std::move(column.values);
    for (double& value : field.values) value *= field.scale;
  }
  return channel;
}

Channel read_stated_file(const StatedFile& file, const std::string& name) {
  TextTable table = read_text_table(file.path, {file.delimiter, file.comment, file.has_header ? 1 : 0});
  Channel channel;
  channel.name = name;
  channel.path = file.path;
  channel.type = "csv";
  channel.delimiter = file.delimiter;
  channel.has_header = file.has_header;
  channel.cut_rows = table.cut_rows;
  const auto column_of = [&](const std::string& wanted) -> TextColumn& {
    for (auto& column : table.columns)
      if (column.name == wanted) return column;
    throw DataError(
        Diagnostic{binnacle::Severity::error, "B062", {file.path, 0, 0}, "", "there is no column '" + wanted + "'"});
  };
  channel.time_column = file.time_column.empty() ? table.columns.front().name : file.time_column;
  channel.time_unit = file.time_unit;
  channel.time_offset = file.time_offset;
  take_times(channel, column_of(channel.time_column), file.time_scale, file.time_offset);
  for (const StatedColumn& stated : file.columns) {
    const TextColumn& column = column_of(stated.column);
    Field& field = channel.fields.emplace_back();
    field.name = stated.field;
    field.column = stated.column;
    field.unit = stated.unit;
    field.si = stated.si;
    field.scale = stated.scale;
    field.kind = stated.kind;
    field.values = column.values;
    const bool empty_is_missing = std::ranges::find(stated.missing, "") != stated.missing.end();
    field.empty = empty_is_missing ? 0 : column.empty;
    field.bad = stated.missing.empty() ? column.bad : 0;
    field.spoilt = stated.missing.empty() ? column.spoilt : 0;
    for (double& value : field.values) {
      double number = 0;
      for (const auto& text : stated.missing)
        if (std::sscanf(text.c_str(), "%lf", &number) == 1 && value == number)
          value = std::numeric_limits<double>::quiet_NaN();
      value *= field.scale;
    }
  }
  return channel;
}

}  // namespace binnacle::inspect
