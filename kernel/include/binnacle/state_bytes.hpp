// SPDX-License-Identifier: Apache-2.0
// State as bytes and back, by one function for both: exchange(bytes) names what belongs to it, in order.
#pragma once

#include <cstddef>
#include <cstdint>
#include <cstring>
#include <span>
#include <string>
#include <type_traits>
#include <vector>

namespace binnacle {

/// Counts the bytes, writes them, or reads them back. Bytes are of this machine's kind.
///
///     void exchange(StateBytes& bytes) {
///       bytes.value(newest_);
///       bytes.list(values_);
///     }
class StateBytes {
 public:
  /// Only counts.
  StateBytes() = default;
  static StateBytes write(std::span<std::byte> to) { return {to.data(), nullptr, to.size()}; }
  static StateBytes read(std::span<const std::byte> from) { return {nullptr, from.data(), from.size()}; }

  std::size_t size() const { return size_; }
  bool is_reading() const { return from_; }
  bool is_writing() const { return to_; }
  /// False once there were fewer bytes than what was asked for, or not what was expected; what was read then is of no use.
  bool holds() const { return holds_; }
  /// Of what has been read. Whoever uses a number of it as an index or a count looks at it first.
  void expect(bool is_right) { holds_ = holds_ && (!is_reading() || is_right); }

  void exchange(std::byte* data, std::size_t bytes) {
    if ((to_ || from_) && bytes > limit_ - size_) holds_ = false;
    if (!holds_) return;
    if (bytes > 0 && to_) std::memcpy(to_ + size_, data, bytes);
    if (bytes > 0 && from_) std::memcpy(data, from_ + size_, bytes);
    size_ += bytes;
  }
  template <class T>
  void value(T& item) {
    static_assert(std::is_trivially_copyable_v<T>, "it is a copy of bytes");
    exchange(reinterpret_cast<std::byte*>(&item), sizeof item);
  }
  /// Of a byte that is neither 0 nor 1 there is no bool.
  void value(bool& item) {
    unsigned char byte = item;
    value(byte);
    expect(byte <= 1);
    if (is_reading() && holds_) item = byte == 1;
  }
  /// An Eigen matrix or array of fixed size.
  template <class Matrix>
  void matrix(Matrix& item) {
    exchange(reinterpret_cast<std::byte*>(item.data()), static_cast<std::size_t>(item.size()) * sizeof(*item.data()));
  }
  /// Of any length.
  template <class T>
  void list(std::vector<T>& items) {
    static_assert(std::is_trivially_copyable_v<T>, "it is a copy of bytes");
    if (resize(items, sizeof(T))) exchange(reinterpret_cast<std::byte*>(items.data()), items.size() * sizeof(T));
  }
  void text(std::string& text) {
    if (resize(text, 1)) exchange(reinterpret_cast<std::byte*>(text.data()), text.size());
  }
  /// Of any length, each by each(item), of a byte at least.
  template <class Item, class Each>
  void list(std::vector<Item>& items, Each&& each) {
    if (!resize(items, 1)) return;
    for (Item& item : items) each(item);
  }

 private:
  StateBytes(std::byte* to, const std::byte* from, std::size_t limit) : to_(to), from_(from), limit_(limit) {}

  /// To the length that was written; false where there are not bytes enough for it.
  template <class Container>
  bool resize(Container& items, std::size_t least) {
    std::uint64_t count = items.size();
    value(count);
    if (is_reading() && holds_ && count > (limit_ - size_) / least) holds_ = false;
    if (is_reading() && holds_) items.resize(count);
    return holds_;
  }

  std::byte* to_ = nullptr;
  const std::byte* from_ = nullptr;
  std::size_t limit_ = 0, size_ = 0;
  bool holds_ = true;
};

}  // namespace binnacle
