// SPDX-License-Identifier: Apache-2.0
// Sections of the config that others read: whose keys they are, and what their readers see of a composition under way.
#include "binnacle/section.hpp"

#include <algorithm>

#include "compose/composer.hpp"

namespace binnacle::compose {

/// The composer as readers of sections see it.
class Draft final : public CompositionDraft {
 public:
  explicit Draft(Composer& composer)
      : composer_(composer), filters_(filter_infos(*composer.plan_)), channels_(channel_infos(*composer.plan_)) {}

  Kind kind(const std::string& pointer) const override {
    const auto* value = composer_.at(pointer);
    if (!value) return Kind::absent;
    return value->is_object()   ? Kind::object
           : value->is_array()  ? Kind::list
           : value->is_string() ? Kind::text
                                : Kind::other;
  }
  std::vector<std::string> keys(const std::string& pointer) const override {
    std::vector<std::string> keys;
    if (kind(pointer) != Kind::object) return keys;
    for (const auto& item : composer_.at(pointer)->items()) keys.push_back(item.key());
    return keys;
  }
  std::size_t size(const std::string& pointer) const override {
    return kind(pointer) == Kind::list ? composer_.at(pointer)->size() : 0;
  }
  std::string shown(const std::string& pointer) const override { return abbreviated(*composer_.at(pointer)); }
  bool is_object(const std::string& pointer, std::string_view what) override {
    return object_at(document(), pointer, what, diagnostics()) != nullptr;
  }
  bool is_list(const std::string& pointer, std::string_view what) override {
    return array_at(document(), pointer, what, diagnostics()) != nullptr;
  }
  void check_keys(const std::string& pointer, const std::vector<std::string>& allowed, std::string_view what) override {
    spec::check_keys(document(), pointer, allowed, what, diagnostics());
  }
  bool require_key(const std::string& pointer, std::string_view key, std::string_view what,
                   std::string_view expected) override {
    return spec::require_key(document(), pointer, key, what, expected, diagnostics());
  }
  std::optional<std::string> text(const std::string& pointer) override {
    return read_string(document(), pointer, diagnostics());
  }
  std::optional<double> number(const std::string& pointer) override {
    const auto* value = composer_.at(pointer);
    if (!value) return std::nullopt;
    if (value->is_number()) return value->get<double>();
    error("B006", pointer,
          "'" + pointer.substr(pointer.rfind('/') + 1) + "' is a number; found " + abbreviated(*value));
    return std::nullopt;
  }
  std::optional<Time> time(const std::string& pointer) override {
    return composer_.at(pointer) ? read_time(document(), pointer, diagnostics()) : std::nullopt;
  }
  std::optional<When> when(const std::string& pointer) override {
    return composer_.at(pointer) ? read_when(document(), pointer, diagnostics()) : std::nullopt;
  }
  std::optional<TimeSpan> span(const std::string& pointer) override {
    const auto window = read_window(document(), pointer, diagnostics());
    if (!window) return std::nullopt;
    return TimeSpan{window->from.time, window->to.time, window->from.from_start, window->to.from_start};
  }

  void error(const std::string& code, const std::string& pointer, const std::string& message) override {
    composer_.error(code, pointer, message);
  }
  void key_error(const std::string& code, const std::string& pointer, const std::string& message) override {
    composer_.key_error(code, pointer, message);
  }
  bool has_errors() const override { return composer_.diagnostics_.has_errors(); }

  const std::vector<FilterInfo>& filters() const override { return filters_; }
  const std::vector<ChannelInfo>& channels() const override { return channels_; }
  int channel(const std::string& name, const std::string& pointer) override {
    bool is_told = false;
    return composer_.channel_named(name, pointer, is_told);
  }
  bool has_failed(std::string_view filter, std::string_view value) const override {
    return std::any_of(composer_.builds_.begin(), composer_.builds_.end(), [&](const FilterBuild& build) {
      return build.pointer == join_pointer("/filters", filter) && build.failed_values.contains(std::string(value));
    });
  }
  bool is_patched() const override { return document().is_patched(); }
  void subscribe(int channel, const std::string& pointer) override {
    composer_.plan_->subscriptions.push_back({channel, pointer});
  }

 private:
  const Document& document() const { return composer_.document(); }
  Diagnostics& diagnostics() { return composer_.diagnostics_; }

  Composer& composer_;
  std::vector<FilterInfo> filters_;
  std::vector<ChannelInfo> channels_;
};

void Composer::check_section_keys(const std::string& pointer, std::vector<std::string> own, const std::string& what) {
  const std::size_t kernels = own.size();
  RenamedKeys renamed;
  for (const auto& section : sections_) {
    for (auto& key : pointer.empty() ? section->keys() : section->filter_keys()) own.push_back(std::move(key));
    for (auto& names : section->renamed_keys())
      if (std::find(own.begin(), own.end(), names.second) != own.end()) renamed.push_back(std::move(names));
  }
  // Without readers the program may share its config with one that has some: only what looks misspelt is wrong.
  if (sections_.empty()) {
    const std::vector<std::string> known(own.begin(), own.begin() + static_cast<std::ptrdiff_t>(kernels));
    for (const auto& [key, value] : at(pointer)->items())
      if (closest(key, known).empty()) own.push_back(key);
  }
  check_keys(document(), pointer, own, what, diagnostics_, renamed);
}

void Composer::read_sections() {
  Draft draft(*this);
  for (const auto& section : sections_) plan_->sections.push_back(section->read(draft));
}

}  // namespace binnacle::compose
