// SPDX-License-Identifier: Apache-2.0
// SharedFeed: what sources and transforms give in one run, made once for several runtimes that have them in common.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <exception>
#include <memory>
#include <string>
#include <vector>

#include "binnacle/source.hpp"
#include "compose/composition_plan.hpp"

namespace binnacle::internal::runtime {

using namespace compose;

class Runtime;

/// What one source or transform gave, in order, from the oldest that somebody has not taken yet.
class SharedStream {
 public:
  /// Of a source one for each call. Of a transform one for each time that it emitted, and `over` for each call.
  struct Item {
    enum class Kind : unsigned char { answered, emitted, again, over } kind = Kind::over;
    SourceStatus status = SourceStatus::sample;
    int channel = -1;  // among its own; −1: none
    SampleHead head = {};
  };

  /// Made by the stage of this plan, with its memory in that arena.
  template <class Stage>
  SharedStream(const CompositionPlan& plan, const Stage& stage, std::byte* arena)
      : identity_(stage.identity), memory_(stage.memory.in(arena)) {
    for (const int channel : stage.channels) doubles_.push_back(plan.channels[as_size(channel)].doubles());
    for (const std::size_t doubles : doubles_) width_ = std::max(width_, doubles);
  }

  const std::string& identity() const { return identity_; }
  std::byte* memory() const { return memory_; }
  bool has(std::size_t place) const { return place < first_ + items_.size(); }
  const Item& at(std::size_t place) const { return items_[place - first_]; }
  /// Where the next item comes to stand, and where the first is.
  std::size_t end() const { return first_ + items_.size(); }
  std::size_t begin() const { return first_; }
  /// Calls what adds the next items; what that throws is thrown by every call from then on.
  template <class Make>
  auto make(Make&& make) {
    if (thrown_) std::rethrow_exception(thrown_);
    const std::size_t before = items_.size();
    try {
      return make();
    } catch (...) {
      items_.resize(before);
      thrown_ = std::current_exception();
      throw;
    }
  }
  /// With what lies in the slot, where the item has a channel.
  void add(Item item, const SampleWriter* slot = nullptr);
  /// An item's sample, to the slot of its channel.
  void copy(std::size_t place, SampleWriter& slot) const;
  /// What stands before is not wanted any more.
  void forget(std::size_t place);

 private:
  std::string identity_;
  std::byte* memory_;
  std::vector<std::size_t> doubles_;  // by own channel
  std::size_t width_ = 0;             // of an item's numbers
  std::size_t first_ = 0;
  std::vector<Item> items_;
  std::vector<double> numbers_;
  std::exception_ptr thrown_;
};

/// How far one runtime is.
struct Tap {
  SharedStream* stream = nullptr;  // null: not shared
  std::size_t place = 0;           // of what it takes next
};
struct Taps {
  std::vector<Tap> sources, transforms;
  std::int64_t taken = 0;  // from all sources
};

class SharedFeed {
 public:
  /// For a runtime that has been reset, and lives as long as the feed. What it has first, it makes for all, in its arena.
  Taps& add(Runtime& runtime);
  /// It takes no more.
  void remove(const Taps& taps);
  void forget_taken();

 private:
  template <class Stage>
  Tap tap_of(Runtime& runtime, const Stage& stage);

  std::vector<std::unique_ptr<SharedStream>> streams_;
  std::vector<std::unique_ptr<Taps>> taps_;
};

}  // namespace binnacle::internal::runtime
