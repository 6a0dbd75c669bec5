// SPDX-License-Identifier: Apache-2.0
#include "block_store.hpp"

#include <algorithm>
#include <bit>
#include <utility>

namespace binnacle::csv {

std::uint64_t Block::checksum() const {
  std::uint64_t sum = 0x9E3779B97F4A7C15;
  const auto add = [&](std::uint64_t word) {
    sum = (sum ^ word) * 0xD6E8FEB86659FD93;
    sum ^= sum >> 32;
  };
  add(static_cast<std::uint64_t>(before));
  for (const Time t : times) add(static_cast<std::uint64_t>(t));
  for (const std::uint32_t row : begins) add(row);
  for (const double value : values) add(std::bit_cast<std::uint64_t>(value));
  return sum;
}

void BlockStore::add(Block block) {
  ++count_;
  if (!is_whole_) return;
  bytes_ += block.bytes();
  kept_.push_back(std::make_shared<const Block>(std::move(block)));
}

void BlockStore::let_go() {
  is_whole_ = false;
  kept_ = {};
}

std::shared_ptr<const Block> BlockStore::get(std::size_t k) {
  if (is_whole_) return kept_[k];
  {
    const std::lock_guard lock(mutex_);
    if (const auto found = cache_.find(k); found != cache_.end()) {
      found->second.used = ++uses_;
      return found->second.block;
    }
  }
  auto made = std::make_shared<const Block>(make_(k));  // by two threads at once, perhaps
  const std::lock_guard lock(mutex_);
  auto& cached = cache_[k];
  if (!cached.block) {
    cached.block = std::move(made);
    cached_bytes_ += cached.block->bytes();
  }
  cached.used = ++uses_;
  const auto block = cached.block;
  make_room();
  return block;
}

void BlockStore::make_room() {
  while (cached_bytes_ > most_ && cache_.size() > 1) {
    const auto oldest = std::ranges::min_element(cache_, {}, [](const auto& each) { return each.second.used; });
    cached_bytes_ -= oldest->second.block->bytes();
    cache_.erase(oldest);
  }
}

}  // namespace binnacle::csv
