// SPDX-License-Identifier: Apache-2.0
// Samples that wait: on their way to where they arrive, or to be worked on again.
#pragma once

#include <compare>
#include <cstdint>
#include <vector>

#include "binnacle/state_bytes.hpp"
#include "compose/composition_plan.hpp"

namespace binnacle::internal::runtime {

using namespace compose;

/// What samples are in order by, and a sample's name: no two have the same place and sequence.
struct SampleKey {
  Time first = no_time;       // of arrival, where they are in order of that; else of the sample
  Time second = no_time;      // of the sample
  std::int32_t place = 0;     // of its source in the config; then filters
  std::int64_t sequence = 0;  // among the samples of the place, as it emits them

  auto operator<=>(const SampleKey&) const = default;
  bool is_with(const SampleKey& other) const { return first == other.first && second == other.second; }
};

/// In order of their keys. Its memory grows to the most samples that ever wait together, and is kept.
class SampleStore {
 public:
  struct Item {
    SampleKey key;
    SampleHead head;
    std::int32_t channel = 0;
    std::int32_t slot = 0;  // of its numbers
    Time late = 0;          // how much older it was than what had come
    // Worked on: by the owner, in order; or by the live way of a history.
    bool is_done = false, is_live = false;
  };

  explicit SampleStore(const std::vector<ChannelPlan>& channels) : channels_(channels), pools_(channels.size()) {}

  void clear();
  bool empty() const { return begin_ == items_.size(); }
  std::size_t size() const { return items_.size() - begin_; }
  Item& operator[](std::size_t index) { return items_[begin_ + index]; }
  const Item& operator[](std::size_t index) const { return items_[begin_ + index]; }
  SampleView view(const Item& item) const;
  /// No other has its times.
  bool is_alone(std::size_t index) const {
    return index + 1 == size() || !(*this)[index + 1].key.is_with((*this)[index].key);
  }
  /// Where it stands then. O(1) where it is the last.
  std::size_t insert(const SampleKey& key, int channel, const SampleView& sample);
  void drop_front(std::size_t count);
  void erase(std::size_t index);
  /// The first whose key.first is beyond t.
  std::size_t after(Time t) const;
  std::size_t bytes() const;
  /// Read back, it is refused where an index of it leads out of it.
  void exchange(StateBytes& bytes);

 private:
  /// Numbers of one channel's samples.
  struct Pool {
    std::vector<double> numbers;
    std::vector<std::int32_t> free;
  };
  bool is_intact() const;
  void release(const Item& item) { pools_[base::as_size(item.channel)].free.push_back(item.slot); }

  const std::vector<ChannelPlan>& channels_;
  std::vector<Pool> pools_;
  std::vector<Item> items_;  // those before begin_ are gone
  std::size_t begin_ = 0;
};

}  // namespace binnacle::internal::runtime
