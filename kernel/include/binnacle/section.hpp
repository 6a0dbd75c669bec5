// SPDX-License-Identifier: Apache-2.0
// Section: a part of the config that the kernel leaves to a library beside it, read while a composition is made; and Reader,
// through which both read a config.
#pragma once

#include <cstdint>
#include <filesystem>
#include <map>
#include <memory>
#include <optional>
#include <set>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "binnacle/config.hpp"
#include "binnacle/diagnostic.hpp"
#include "binnacle/parameters.hpp"
#include "binnacle/spec.hpp"
#include "binnacle/time.hpp"
#include "binnacle/unit.hpp"

namespace binnacle {

namespace internal::compose {
class Composer;
}
struct ChannelInfo;
struct FilterInfo;
class RunObserver;
class Session;

/// What the block on a port lends to parameters: unit of its error components, and how many there are.
struct PortMeasure {
  Dimension dimension;
  int dof = 0;
};

/// By port name; nothing for an unknown or open port. Then any unit and length is let through.
using PortUnits = std::map<std::string, PortMeasure, std::less<>>;

/// Keys that had another name in an earlier version: the former, and what it is called now.
using RenamedKeys = std::vector<std::pair<std::string, std::string>>;

/// A place of a config, what stands there, and where the errors about it go. Whatever reads a value gives nothing where
/// none stands, which is no error (require() makes it one), and where a wrong one does, which is reported.
///
///     for (const Reader& fix : Reader(document, diagnostics)["measurements"].members("'measurements'"))
///       sigma = fix["sigma"].number(parameter::number("sigma", "m").at_least(0));
class Reader {
 public:
  Reader(const internal::config::Document& document, Diagnostics& diagnostics, const std::string& pointer = {});

  /// The place of a member, whether it is there or not.
  Reader operator[](std::string_view key) const;
  /// The places of all members or elements.
  std::vector<Reader> children() const;

  explicit operator bool() const { return json_ != nullptr; }
  /// What stands here, in messages: `the text "abc"`, `an object`, `the number 3.5`; cut where it is long.
  std::string shown() const;
  const std::string& pointer() const { return pointer_; }
  /// The last token of the pointer.
  const std::string& key() const { return key_; }
  bool is_default() const { return is_default_; }
  Origin origin() const;
  /// Where its key stands.
  Origin key_origin() const;
  /// From which a relative path starts.
  std::filesystem::path folder() const;

  void error(const std::string& code, const std::string& message) const;
  void warning(const std::string& code, const std::string& message) const;
  /// At the key, not the value.
  void key_error(const std::string& code, const std::string& message) const;

  /// Whether an object (a list) stands here; with `what`, B006 where something else does: how the message calls it, quoted
  /// or not: "'evaluate'", "the config".
  bool is_object(std::string_view what = {}) const;
  bool is_list(std::string_view what = {}) const;
  std::vector<Reader> members(std::string_view what) const;
  std::vector<Reader> elements(std::string_view what) const;

  /// B012 for every key of the object that is not allowed: `unknown key of 'evaluate'; did you mean 'after'?`, with
  /// what `detail` has for the key that was meant. Returns the keys that were meant.
  std::set<std::string> check_keys(const std::vector<std::string>& allowed, std::string_view what,
                                   const RenamedKeys& renamed = {},
                                   const std::map<std::string, std::string>& detail = {}) const;
  /// B010 unless the object has the key: `missing key 'channel' of 'fix': name of a channel`. `what` is the name alone.
  bool require(std::string_view key, std::string_view what, std::string_view expected) const;

  /// All parameters of the object, defaults filled in. `type_name` is how messages call it ("unknown key of
  /// 'gauss_markov'"); `reserved` are the keys of its place ("type", "init", …), left alone. Use it only without errors.
  ParameterValue parameters(const std::vector<ParameterSpec>& specs, const std::string& type_name,
                            const std::vector<std::string>& reserved = {}, const PortUnits& ports = {}) const;
  /// One value against one spec; messages call it spec.name. Absent when it is wrong or not there. A number keeps its SI
  /// unit in ParameterValue::text; with the unit "*" any dimension will do, and a unit alone stands for one of it ("ms").
  ParameterValue value(const ParameterSpec& spec, const PortUnits& ports = {}) const;

  /// Without a name in their spec, values are called by their key.
  std::optional<double> number(const ParameterSpec& spec) const;
  std::optional<std::int64_t> integer(const ParameterSpec& spec) const;
  std::optional<std::string> text() const;
  std::optional<std::string> path() const;
  std::optional<bool> boolean() const;
  /// A duration or a channel's instant: "20 ms" or seconds, at most 146 years from zero.
  std::optional<Time> time(const ParameterSpec& spec = parameter::time("")) const;
  /// One name or a list of names.
  std::optional<std::vector<std::string>> names() const;
  std::optional<When> when() const;
  /// [from, to] with from < to where both count from the same.
  std::optional<TimeSpan> span() const;

 private:
  friend struct internal::config::JsonOf;
  const internal::config::Document* document_;
  Diagnostics* diagnostics_;
  std::string pointer_;
  std::string key_;
  const void* json_;
  bool is_default_ = false;
};

/// A composition under way, as the reader of a section sees it: the config, and what has been composed of it.
class CompositionDraft {
 public:
  explicit CompositionDraft(internal::compose::Composer& composer) : composer_(composer) {}

  /// The place with this JSON pointer.
  Reader at(const std::string& pointer) const;
  /// Whether anything is wrong so far; then parts may be missing in what follows.
  bool has_errors() const;
  const std::vector<FilterInfo>& filters() const;
  const std::vector<ChannelInfo>& channels() const;
  /// −1 where there is no such channel, which is then reported (once).
  int channel(const std::string& name, const Reader& at) const;
  /// Whether the filter has a value of this name whose own error is reported.
  bool has_failed(std::string_view filter, std::string_view value) const;
  /// Whether patches of the config's own were merged over it (LoadOptions::patches).
  bool is_patched() const;
  /// Runs show the channel's samples to their observer; `pointer` names the subscriber in messages and in ChannelInfo.
  void subscribe(int channel, const std::string& pointer);

 private:
  internal::compose::Composer& composer_;
};

/// What a section became: kept by the composition for whoever runs it.
class SectionData {
 public:
  virtual ~SectionData() = default;
  /// What `binnacle explain` adds to the filter: JSON text of an object, or nothing.
  virtual std::string explain(int /*filter*/) const { return {}; }
  /// What belongs to every run of the composition: begins before the run's own observer and sees each instant before it.
  /// It attaches its step observers with Session::attach_section(), and emits on channels of its section with
  /// Session::push_estimates() in after_instant() and finished(). Nothing: there is no such part.
  virtual std::shared_ptr<RunObserver> part() const { return {}; }
};

/// A reader of keys of the config that are not the kernel's own: it checks them, and may take part in runs.
class Section {
 public:
  virtual ~Section() = default;

  /// Keys of the config, and of each of its filters, that are this reader's.
  virtual std::vector<std::string> keys() const = 0;
  virtual std::vector<std::string> filter_keys() const { return {}; }
  /// Further channels of a filter, "smoothed" for NAME.smoothed: with the fields of its estimates. The section's part of a
  /// run emits on them.
  virtual std::vector<std::string> filter_channels(const Reader& /*filter*/) const { return {}; }
  /// Former names of such keys, and what they are called now.
  virtual RenamedKeys renamed_keys() const { return {}; }
  /// Where objects of merge patches stand, which keep their nulls until merged: "/variants"; `*` is any key.
  virtual std::vector<std::string> patches() const { return {}; }

  /// Called when sources, filters, transforms and sinks are composed, even if something is wrong with them.
  virtual std::shared_ptr<const SectionData> read(CompositionDraft& draft) const = 0;
};

}  // namespace binnacle
