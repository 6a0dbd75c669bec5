// SPDX-License-Identifier: Apache-2.0
// Section: a part of the config that the kernel leaves to a library beside it, read while a composition is made.
#pragma once

#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "binnacle/time.hpp"

namespace binnacle {

struct ChannelInfo;
struct FilterInfo;

/// A composition under way, as the reader of a section sees it: the config, what has been composed of it, and a place for
/// what is wrong. JSON pointers name places of the config; a reader reports nothing where nothing stands, and an error at
/// its place where something else stands than it was asked for.
class CompositionDraft {
 public:
  virtual ~CompositionDraft() = default;

  enum class Kind { absent, object, list, text, other };
  virtual Kind kind(const std::string& pointer) const = 0;
  /// Keys of an object, in order; elements of a list.
  virtual std::vector<std::string> keys(const std::string& pointer) const = 0;
  virtual std::size_t size(const std::string& pointer) const = 0;
  /// The value in messages: `the text "abc"`, `an object`.
  virtual std::string shown(const std::string& pointer) const = 0;
  /// Whether it is an object (a list); `what` is how the message calls it: "'evaluate'" (B006).
  virtual bool is_object(const std::string& pointer, std::string_view what) = 0;
  virtual bool is_list(const std::string& pointer, std::string_view what) = 0;
  /// B012 for every key of the object that is not allowed.
  virtual void check_keys(const std::string& pointer, const std::vector<std::string>& allowed,
                          std::string_view what) = 0;
  /// B010 unless the object has the key: `missing key 'channel' of 'fix': name of a channel`.
  virtual bool require_key(const std::string& pointer, std::string_view key, std::string_view what,
                           std::string_view expected) = 0;
  virtual std::optional<std::string> text(const std::string& pointer) = 0;
  virtual std::optional<double> number(const std::string& pointer) = 0;
  /// A duration: "20 ms" or seconds.
  virtual std::optional<Time> time(const std::string& pointer) = 0;
  virtual std::optional<When> when(const std::string& pointer) = 0;
  /// [from, to]
  virtual std::optional<TimeSpan> span(const std::string& pointer) = 0;

  virtual void error(const std::string& code, const std::string& pointer, const std::string& message) = 0;
  /// At the key, not the value.
  virtual void key_error(const std::string& code, const std::string& pointer, const std::string& message) = 0;
  /// Whether anything is wrong so far; then parts may be missing in what follows.
  virtual bool has_errors() const = 0;

  virtual const std::vector<FilterInfo>& filters() const = 0;
  virtual const std::vector<ChannelInfo>& channels() const = 0;
  /// −1 where there is no such channel, which is then reported (once).
  virtual int channel(const std::string& name, const std::string& pointer) = 0;
  /// Whether the filter has a value of this name whose own error is reported.
  virtual bool has_failed(std::string_view filter, std::string_view value) const = 0;
  /// Whether patches of the config's own were merged over it (LoadOptions::patches).
  virtual bool is_patched() const = 0;
  /// Runs show the channel's samples to their observer; `pointer` names the subscriber in messages and in ChannelInfo.
  virtual void subscribe(int channel, const std::string& pointer) = 0;
};

/// What a section became: kept by the composition for whoever runs it.
class SectionData {
 public:
  virtual ~SectionData() = default;
  /// What `binnacle explain` adds to the filter: JSON text of an object, or nothing.
  virtual std::string explain(int /*filter*/) const { return {}; }
};

class Section {
 public:
  virtual ~Section() = default;

  /// Keys of the config, and of each of its filters, that are this reader's.
  virtual std::vector<std::string> keys() const = 0;
  virtual std::vector<std::string> filter_keys() const { return {}; }
  /// Former names of such keys, and what they are called now.
  virtual std::vector<std::pair<std::string, std::string>> renamed_keys() const { return {}; }
  /// Where objects of merge patches stand, which keep their nulls until they are merged: "/study/variants", with `*` for
  /// any key.
  virtual std::vector<std::string> patches() const { return {}; }

  /// Called when sources, filters, transforms and sinks are composed, even if something is wrong with them.
  virtual std::shared_ptr<const SectionData> read(CompositionDraft& draft) const = 0;
};

}  // namespace binnacle
