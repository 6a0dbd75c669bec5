// SPDX-License-Identifier: Apache-2.0
// The json_writer sink: each sample of a channel as one line of JSON.
#include "json_writer.hpp"

#include <cmath>
#include <set>
#include <string_view>

#include "text/numbers.hpp"

namespace binnacle::stream {

namespace {

std::string json_string(const std::string& name) {
  static constexpr char hex[] = "0123456789abcdef";
  std::string text = "\"";
  for (const char c : name) {
    if (c == '"' || c == '\\') text += '\\';
    if (static_cast<unsigned char>(c) >= ' ')
      text += c;
    else
      text += {'\\', 'u', '0', '0', hex[c >> 4], hex[c & 15]};
  }
  return text + "\"";
}

void append(std::string& text, double value) {
  if (std::isfinite(value))
    numbers::append_number(text, value);
  else
    text += "null";
}

/// Keys of one object; each may be there once.
class Keys {
 public:
  void take(const std::string& key, const char* pointer) {
    if (!taken_.insert(key).second)
      throw ComponentError("a line would have two values '" + key + "'; " + remedy(key, pointer), pointer);
  }

 private:
  static const char* remedy(const std::string& key, std::string_view pointer) {
    if (pointer == "/covariance") return "leave it out with \"none\"";
    return key == "channel" ? "a field cannot have this name" : "give the time another name";
  }

  std::set<std::string> taken_;
};

}  // namespace

ComponentSpec JsonWriter::spec() {
  using namespace parameter;
  ComponentSpec spec;
  spec.type = "json_writer";
  spec.summary =
      "samples of any channel, one line of JSON each: {\"channel\": \"ins\", \"t\": 12.5, \"position.lat\": 0.84, …}";
  spec.source = "RFC 8259 (JSON); one object a line";
  spec.parameters = text_output::TextOutput::parameters();
  spec.parameters.push_back(text("channel").about("value of \"channel\" in the lines; default: the sink's name"));
  spec.parameters.push_back(text("time").defaults("\"t\"").about("key of the time, in seconds"));
  spec.parameters.push_back(
      choice("covariance", {"none", "sigma", "full"})
          .defaults("\"sigma\"")
          .about("output of a channel's covariance: sigma: standard deviations by error component, under \"sigma\"; "
                 "full: also the matrix, by rows under \"covariance\""));
  spec.inputs = {input("input", {field::level("height", "m").about("an example")})
                     .whole()
                     .about("channel to be written: all fields by their own names, in SI")};
  spec.example = R"json({"input": "ins", "to": "udp://127.0.0.1:9870"})json";
  return spec;
}

JsonWriter::JsonWriter(const Binding& binding) : output_(binding.parameters()) {
  const Parameters& parameters = binding.parameters();
  const Input input = binding.input("input");
  const std::string& time = parameters.text("time");
  const std::string& kind = parameters.text("covariance");
  covariance_ = kind == "none" ? Covariance::none : kind == "sigma" ? Covariance::sigma : Covariance::full;

  Keys taken;
  taken.take("channel", "/time");
  taken.take(time, "/time");
  head_ = "{\"channel\":" + json_string(parameters.has("channel") ? parameters.text("channel") : binding.name()) + "," +
          json_string(time) + ":";
  const ChannelDeclaration& channel = binding.channel(input);
  for (const FieldSpec& field : channel.fields) {
    taken.take(field.name, field.name == "channel" ? "" : "/time");
    (field.is_per_row ? row_keys_ : keys_).push_back("," + json_string(field.name) + ":");
  }
  for (const NamedUnit& component : binding.covariance(input)) sigma_keys_.push_back(json_string(component.name) + ":");
  if (sigma_keys_.empty()) covariance_ = Covariance::none;
  if (covariance_ != Covariance::none) taken.take("sigma", "/covariance");
  if (covariance_ == Covariance::full) taken.take("covariance", "/covariance");

  constexpr std::size_t number = 26;  // with its comma; the longest double has 24 characters
  const auto rows = static_cast<std::size_t>(channel.max_rows);
  const std::size_t n = covariance_ == Covariance::none ? 0 : sigma_keys_.size();
  std::size_t longest = head_.size() + 64 + number * (keys_.size() + row_keys_.size() * rows + 2 * n);
  if (covariance_ == Covariance::full) longest += n * (n * number + 3);
  for (const auto* keys : {&keys_, &row_keys_, &sigma_keys_})
    for (const auto& key : *keys) longest += key.size() + 3;
  line_.reserve(longest);
}

void JsonWriter::on(Input /*from*/, const SampleView& sample) {
  line_ = head_;
  numbers::append_seconds(line_, sample.t);
  for (std::size_t i = 0; i < keys_.size(); ++i) {
    line_ += keys_[i];
    append(line_, sample.fields[i]);
  }
  if (!row_keys_.empty()) append_rows(sample);
  if (sample.covariance && covariance_ != Covariance::none) append_covariance(sample.covariance);
  line_ += "}\n";
  output_.write(line_);
}

void JsonWriter::append_rows(const SampleView& sample) {
  const std::size_t width = row_keys_.size();
  for (std::size_t i = 0; i < width; ++i) {
    line_ += row_keys_[i];
    line_ += '[';
    for (std::size_t row = 0; row < static_cast<std::size_t>(sample.rows); ++row) {
      if (row > 0) line_ += ',';
      append(line_, sample.row_fields[row * width + i]);
    }
    line_ += ']';
  }
}

void JsonWriter::append_covariance(const double* P) {
  const std::size_t n = sigma_keys_.size();
  line_ += ",\"sigma\":{";
  for (std::size_t i = 0; i < n; ++i) {
    if (i > 0) line_ += ',';
    line_ += sigma_keys_[i];
    append(line_, std::sqrt(P[i * n + i]));
  }
  line_ += '}';
  if (covariance_ != Covariance::full) return;
  line_ += ",\"covariance\":[";
  for (std::size_t i = 0; i < n; ++i) {
    line_ += i > 0 ? ",[" : "[";
    for (std::size_t j = 0; j < n; ++j) {
      if (j > 0) line_ += ',';
      append(line_, P[j * n + i]);
    }
    line_ += ']';
  }
  line_ += ']';
}

}  // namespace binnacle::stream
