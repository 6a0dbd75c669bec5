// SPDX-License-Identifier: Apache-2.0
// Sections of the config that others read: whose keys they are, and what their readers see of a composition under way.
#include "binnacle/section.hpp"

#include <algorithm>

#include "compose/composer.hpp"

namespace binnacle::compose {

/// The composer as readers of sections see it.
class Draft final : public CompositionDraft {
 public:
  explicit Draft(Composer& composer) : composer_(composer) {}

  Kind kind(const std::string& pointer) const override {
    const auto* value = at(pointer).json();
    if (!value) return Kind::absent;
    return value->is_object()   ? Kind::object
           : value->is_array()  ? Kind::list
           : value->is_string() ? Kind::text
                                : Kind::other;
  }
  std::vector<std::string> keys(const std::string& pointer) const override {
    std::vector<std::string> keys;
    if (kind(pointer) == Kind::object)
      for (const Reader& member : at(pointer).children()) keys.push_back(member.key());
    return keys;
  }
  std::size_t size(const std::string& pointer) const override {
    return kind(pointer) == Kind::list ? at(pointer).json()->size() : 0;
  }
  std::string shown(const std::string& pointer) const override { return abbreviated(*at(pointer).json()); }
  bool is_object(const std::string& pointer, std::string_view what) override { return at(pointer).is_object(what); }
  bool is_list(const std::string& pointer, std::string_view what) override { return at(pointer).is_list(what); }
  void check_keys(const std::string& pointer, const std::vector<std::string>& allowed, std::string_view what) override {
    at(pointer).check_keys(allowed, what);
  }
  bool require_key(const std::string& pointer, std::string_view key, std::string_view what,
                   std::string_view expected) override {
    return at(pointer).require(key, what, expected);
  }
  std::optional<std::string> text(const std::string& pointer) override { return at(pointer).text(); }
  std::optional<double> number(const std::string& pointer) override {
    const Reader place = at(pointer);
    if (!place) return std::nullopt;
    if (place.json()->is_number()) return place.json()->get<double>();
    place.error("B006", "'" + place.key() + "' is a number; found " + abbreviated(*place.json()));
    return std::nullopt;
  }
  std::optional<Time> time(const std::string& pointer) override { return at(pointer).time(); }
  std::optional<When> when(const std::string& pointer) override { return at(pointer).when(); }
  std::optional<TimeSpan> span(const std::string& pointer) override { return at(pointer).span(); }

  void error(const std::string& code, const std::string& pointer, const std::string& message) override {
    at(pointer).error(code, message);
  }
  void key_error(const std::string& code, const std::string& pointer, const std::string& message) override {
    at(pointer).key_error(code, message);
  }
  bool has_errors() const override { return composer_.diagnostics().has_errors(); }

  const std::vector<FilterInfo>& filters() const override { return composer_.plan().filter_infos; }
  const std::vector<ChannelInfo>& channels() const override { return composer_.plan().channel_infos; }
  int channel(const std::string& name, const std::string& pointer) override {
    return composer_.channel_named(name, at(pointer));
  }
  bool has_failed(std::string_view filter, std::string_view value) const override {
    return std::ranges::any_of(composer_.filters(), [&](const FilterComposer& composed) {
      return composed.at.key() == filter && composed.failed_values.contains(std::string(value));
    });
  }
  bool is_patched() const override { return composer_.plan().document.is_patched(); }
  void subscribe(int channel, const std::string& pointer) override {
    composer_.plan().subscriptions.push_back({channel, pointer});
  }

 private:
  Reader at(const std::string& pointer) const { return composer_.place(pointer); }

  Composer& composer_;
};

void Composer::check_section_keys(const Reader& at, std::vector<std::string> own, const std::string& what) {
  const std::vector<std::string> kernels = own;
  RenamedKeys renamed;
  for (const auto& section : sections_) {
    std::ranges::move(at.pointer().empty() ? section->keys() : section->filter_keys(), std::back_inserter(own));
    std::ranges::copy_if(section->renamed_keys(), std::back_inserter(renamed),
                         [&](const auto& names) { return index_of(own, names.second) >= 0; });
  }
  // Without readers the program may share its config with one that has some: only what looks misspelt is wrong.
  if (sections_.empty())
    for (const Reader& member : at.children())
      if (closest(member.key(), kernels).empty()) own.push_back(member.key());
  at.check_keys(own, what, renamed);
}

void Composer::read_sections() {
  Draft draft(*this);
  for (const auto& section : sections_) plan_->sections.push_back(section->read(draft));
}

}  // namespace binnacle::compose
