// SPDX-License-Identifier: Apache-2.0
// What the models of a filter noted in a run: equal notes of one component once, with place and time of the first.
#pragma once

#include <cstdint>
#include <cstring>
#include <string>
#include <vector>

#include "binnacle/time.hpp"

namespace binnacle::filter {

struct KeptNote {
  const std::string* type = nullptr;
  const std::string* pointer = nullptr;
  const char* call = nullptr;
  Time first = no_time;  // of the sample or step
  std::int64_t count = 0;
  char text[120] = {};
};

/// Allocates in its constructor only.
class NoteBook {
 public:
  /// Of so many different notes; others are counted.
  static constexpr std::size_t most = 64;

  NoteBook() { notes_.reserve(most); }
  void keep(const std::string& type, const std::string& pointer, const char* call, Time t, const char* text) {
    constexpr std::size_t longest = sizeof(KeptNote::text) - 1;
    for (KeptNote& note : notes_)
      if (note.pointer == &pointer && std::strncmp(note.text, text, longest) == 0) {
        ++note.count;
        return;
      }
    if (notes_.size() == most) {
      ++left_out_;
      return;
    }
    notes_.push_back({&type, &pointer, call, t, 1, {}});
    std::strncpy(notes_.back().text, text, longest);
  }
  void clear() {
    notes_.clear();
    left_out_ = 0;
  }
  const std::vector<KeptNote>& notes() const { return notes_; }
  std::int64_t left_out() const { return left_out_; }

 private:
  std::vector<KeptNote> notes_;
  std::int64_t left_out_ = 0;
};

}  // namespace binnacle::filter
