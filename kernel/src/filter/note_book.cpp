// SPDX-License-Identifier: Apache-2.0
#include "filter/note_book.hpp"

#include <cstring>

namespace binnacle::filter {

void NoteBook::keep(const std::string& type, const std::string& pointer, const char* call, Time t, const char* text) {
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

void NoteBook::clear() {
  notes_.clear();
  left_out_ = 0;
}

}  // namespace binnacle::filter
