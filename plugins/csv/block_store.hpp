// SPDX-License-Identifier: Apache-2.0
// Blocks of samples: all of them in memory where they are few, else those that were used last.
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <mutex>
#include <vector>

#include "block.hpp"

namespace binnacle::csv {

/// Filled by one thread; get() is for several. What was made once can be made again, with the same content.
class BlockStore {
 public:
  using Maker = std::function<Block(std::size_t)>;

  /// `most`: bytes of blocks that stay; of more than that none do, but for a cache of as many.
  BlockStore(std::size_t most, Maker maker) : most_(most), make_(std::move(maker)) {}

  void add(Block block);
  std::size_t count() const { return count_; }
  /// All are in memory.
  bool is_whole() const { return is_whole_; }
  bool has_room_for(const Block& block) const { return bytes_ + block.bytes() <= most_; }
  /// From now on none is kept.
  void let_go();

  /// Of a store that is whole, for as long as it is.
  const Block& kept(std::size_t k) const { return *kept_[k]; }
  std::shared_ptr<const Block> get(std::size_t k);

 private:
  struct Cached {
    std::shared_ptr<const Block> block;
    std::uint64_t used = 0;
  };

  void make_room();

  std::size_t most_;
  Maker make_;
  std::size_t count_ = 0, bytes_ = 0;
  bool is_whole_ = true;
  std::vector<std::shared_ptr<const Block>> kept_;

  std::mutex mutex_;
  std::map<std::size_t, Cached> cache_;
  std::size_t cached_bytes_ = 0;
  std::uint64_t uses_ = 0;
};

}  // namespace binnacle::csv
