// SPDX-License-Identifier: Apache-2.0
#include "json_source.hpp"

#include <limits>

#include <nlohmann/json.hpp>

namespace binnacle::stream {

/// Collects the numbers of an object; those of an object in it are KEY.KEY.
class JsonSource::Reader {
 public:
  using number_integer_t = nlohmann::json::number_integer_t;
  using number_unsigned_t = nlohmann::json::number_unsigned_t;
  using number_float_t = nlohmann::json::number_float_t;
  using string_t = nlohmann::json::string_t;
  using binary_t = nlohmann::json::binary_t;

  struct Number {
    std::string key, text;
    double value = 0;
  };
  std::vector<Number> numbers;
  std::string channel;
  bool has_channel = false, is_object = false;

  const Number* find(std::string_view key) const {
    for (const auto& number : numbers)
      if (number.key == key) return &number;
    return nullptr;
  }

  bool null() { return add(std::numeric_limits<double>::quiet_NaN(), "null"); }
  bool boolean(bool value) { return add(value ? 1 : 0, value ? "1" : "0"); }
  bool number_integer(number_integer_t value) { return add(static_cast<double>(value), std::to_string(value)); }
  bool number_unsigned(number_unsigned_t value) { return add(static_cast<double>(value), std::to_string(value)); }
  bool number_float(number_float_t value, const string_t& text) { return add(value, text); }
  bool string(string_t& value) {
    if (key_ == "channel") {
      channel = value;
      has_channel = true;
    }
    return true;
  }
  bool binary(binary_t&) { return true; }
  bool start_object(std::size_t) {
    if (++depth_ == 1) return is_object = arrays_ == 0;
    prefix_.push_back(key_ + ".");
    return true;
  }
  bool key(string_t& name) {
    key_ = prefix_.empty() ? name : prefix_.back() + name;
    return true;
  }
  bool end_object() {
    if (--depth_ > 0) prefix_.pop_back();
    return true;
  }
  bool start_array(std::size_t) {
    ++arrays_;
    return depth_ > 0;
  }
  bool end_array() {
    --arrays_;
    return true;
  }
  bool parse_error(std::size_t, const std::string&, const nlohmann::detail::exception&) { return false; }

 private:
  bool add(double value, std::string text) {
    if (depth_ == 0) return false;
    if (arrays_ == 0) numbers.push_back({key_, std::move(text), value});
    return true;
  }

  int depth_ = 0, arrays_ = 0;
  std::string key_;
  std::vector<std::string> prefix_;
};

ComponentSpec JsonSource::spec() {
  ComponentSpec spec;
  spec.type = "json";
  spec.summary = "live samples, one JSON object per line";
  spec.source = "RFC 8259 (JSON), JSON Lines";
  add_parameters(spec);
  const auto fields = [] {
    return parameter::map(
        "fields",
        field_spec("key",
                   "name of the number in the object, for nested objects \"gyro.x\"; default: the field's name"));
  };
  spec.parameters.push_back(fields().about("fields of the only channel, which has the source's name"));
  spec.parameters.push_back(
      parameter::map("channels", parameter::object("channel", {fields().required().about("fields of the channel")}))
          .about("several channels, NAME.CHANNEL, selected by \"channel\" of a line"));
  spec.example = R"json({
  "from": "file:live.jsonl",
  "fields": { "wx": { "key": "gyro.x", "unit": "deg/s", "kind": "rate" } }
})json";
  spec.surroundings =
      R"json({ "files": { "live.jsonl": "{\"t\": 0.0, \"gyro\": {\"x\": 0.1}}\n{\"t\": 0.01, \"gyro\": {\"x\": 0.2}}\n{\"t\": 0.02, \"gyro\": {\"x\": 0.1}}\n" } })json";
  return spec;
}

JsonSource::JsonSource(const Binding& binding) : LineSource(binding) {
  const Parameters& parameters = binding.parameters();
  if (parameters.has("fields") == parameters.has("channels"))
    throw ComponentError("\"fields\" of one channel, or \"channels\", is needed, and not both");
  if (parameters.has("fields")) {
    add_channel("", parameters.members("fields"), "key");
    return;
  }
  for (const auto& [name, value] : parameters.members("channels"))
    for (const auto& [key, fields] : value.members)
      if (key == "fields") add_channel(name, fields.members, "key");
}

bool JsonSource::parse(std::string_view line, LineSample& sample) const {
  Reader reader;
  if (!nlohmann::json::sax_parse(line.begin(), line.end(), &reader) || !reader.is_object)
    throw BadLine{"it is not a JSON object"};
  sample.channel = 0;
  if (!channels_.front().name.empty()) {
    if (!reader.has_channel) throw BadLine{"its \"channel\" is missing"};
    while (sample.channel < channels_.size() && channels_[sample.channel].name != reader.channel) ++sample.channel;
    if (sample.channel == channels_.size()) throw BadLine{"there is no channel '" + reader.channel.substr(0, 40) + "'"};
  }
  if (const auto* t = reader.find(time_key_)) sample.t = time_of(t->text);
  if (const auto* t0 = reader.find("t0")) sample.t0 = time_of(t0->text);
  if (sample.t0 != no_time && sample.t0 >= sample.t) throw BadLine{"its interval ends before it begins"};
  sample.values.clear();
  for (const auto& field : channels_[sample.channel].fields) {
    const auto* number = reader.find(field.key);
    sample.values.push_back(number ? number->value : std::numeric_limits<double>::quiet_NaN());
  }
  return true;
}

}  // namespace binnacle::stream
