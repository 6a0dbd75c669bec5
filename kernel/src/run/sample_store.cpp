// SPDX-License-Identifier: Apache-2.0
#include "run/sample_store.hpp"

#include <algorithm>
#include <cstring>

#include "base/time_range.hpp"
#include "filter/intact.hpp"

namespace binnacle::internal::runtime {

using base::as_size;

namespace {

/// Of memory that was copied: another byte than 0 or 1 must not be read as one.
bool is_bool(const bool& item) {
  unsigned char byte = 0;
  std::memcpy(&byte, &item, 1);
  return byte <= 1;
}

}  // namespace

void SampleStore::clear() {
  drop_front(size());
  items_.clear();
  begin_ = 0;
}

SampleView SampleStore::view(const Item& item) const {
  const auto& channel = channels_[as_size(item.channel)];
  return unpack(channel, item.head,
                pools_[as_size(item.channel)].numbers.data() + as_size(item.slot) * channel.doubles());
}

std::size_t SampleStore::insert(const SampleKey& key, int channel, const SampleView& sample) {
  Pool& pool = pools_[as_size(channel)];
  const std::size_t doubles = channels_[as_size(channel)].doubles();
  if (pool.free.empty()) {
    pool.free.push_back(static_cast<std::int32_t>(doubles == 0 ? 0 : pool.numbers.size() / doubles));
    pool.numbers.resize(pool.numbers.size() + doubles);
  }
  Item item{key, {}, channel, pool.free.back()};
  pool.free.pop_back();
  item.head = pack(channels_[as_size(channel)], sample, pool.numbers.data() + as_size(item.slot) * doubles);
  if (empty() || items_.back().key < key) {
    items_.push_back(item);
    return size() - 1;
  }
  const auto at = std::upper_bound(items_.begin() + static_cast<std::ptrdiff_t>(begin_), items_.end(), key,
                                   [](const SampleKey& a, const Item& b) { return a < b.key; });
  const auto index = static_cast<std::size_t>(at - items_.begin()) - begin_;
  items_.insert(at, item);
  return index;
}

void SampleStore::drop_front(std::size_t count) {
  for (std::size_t i = 0; i < count; ++i) release((*this)[i]);
  begin_ += count;
  if (begin_ < 1024 && begin_ < items_.size()) return;
  items_.erase(items_.begin(), items_.begin() + static_cast<std::ptrdiff_t>(begin_));
  begin_ = 0;
}

void SampleStore::erase(std::size_t index) {
  if (index == 0) return drop_front(1);
  release((*this)[index]);
  items_.erase(items_.begin() + static_cast<std::ptrdiff_t>(begin_ + index));
}

std::size_t SampleStore::after(Time t) const {
  const auto at = std::upper_bound(items_.begin() + static_cast<std::ptrdiff_t>(begin_), items_.end(), t,
                                   [](Time time, const Item& item) { return time < item.key.first; });
  return static_cast<std::size_t>(at - items_.begin()) - begin_;
}

void SampleStore::exchange(StateBytes& bytes) {
  bytes.list(items_);
  bytes.value(begin_);
  for (Pool& pool : pools_) {
    bytes.list(pool.numbers);
    bytes.list(pool.free);
  }
  if (!bytes.is_reading()) return;
  if (bytes.holds()) bytes.expect(is_intact());
  if (!bytes.holds()) begin_ = items_.size();  // none, until what was before is read back
}

/// Each place of a pool belongs to one sample that waits, or is free.
bool SampleStore::is_intact() const {
  if (begin_ > items_.size()) return false;
  std::vector<std::vector<bool>> is_taken;
  for (std::size_t c = 0; c < pools_.size(); ++c) {
    const std::size_t doubles = channels_[c].doubles(), numbers = pools_[c].numbers.size();
    if (doubles == 0 ? numbers > 0 : numbers % doubles != 0) return false;
    is_taken.emplace_back(doubles == 0 ? 0 : numbers / doubles, false);
  }
  const auto take = [&](std::size_t channel, std::int32_t slot) -> bool {
    if (channels_[channel].doubles() == 0) return slot == 0;
    auto& taken = is_taken[channel];
    if (slot < 0 || as_size(slot) >= taken.size() || taken[as_size(slot)]) return false;
    taken[as_size(slot)] = true;
    return true;
  };
  for (std::size_t i = 0; i < size(); ++i) {
    const Item& item = (*this)[i];
    if (item.channel < 0 || as_size(item.channel) >= channels_.size()) return false;
    if (!is_bool(item.is_done) || !is_bool(item.is_live)) return false;
    if (!base::is_near(item.key.first) || !filter::is_time(item.key.second) || !filter::is_count(item.key.place) ||
        !filter::is_count(item.key.sequence) || !base::is_near(item.late) || !base::is_near(item.head.t))
      return false;
    if (i > 0 && !((*this)[i - 1].key < item.key)) return false;
    if (!filter::is_intact(item.head, channels_[as_size(item.channel)])) return false;
    if (!take(as_size(item.channel), item.slot)) return false;
  }
  for (std::size_t c = 0; c < pools_.size(); ++c)
    for (const std::int32_t slot : pools_[c].free)
      if (!take(c, slot)) return false;
  return true;
}

std::size_t SampleStore::bytes() const {
  std::size_t bytes = items_.capacity() * sizeof(Item);
  for (const Pool& pool : pools_) bytes += pool.numbers.capacity() * sizeof(double);
  return bytes;
}

}  // namespace binnacle::internal::runtime
