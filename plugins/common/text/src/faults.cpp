// SPDX-License-Identifier: Apache-2.0
// Faults of a file: the first one ends the run, or they are left out, counted and reported.
#include "text/faults.hpp"

#include "binnacle/parameters.hpp"

namespace binnacle::text_file {

void Faults::add(const std::string& code, int line, const std::string& what, const std::string& message) {
  if (on_invalid_ == OnInvalid::error) throw ComponentError::in_data(message, path_, line, code);
  Kind& kind = kinds_[{code, what}];
  if (kind.count++ > 0) return;
  kind.first_line = line;
  kind.first_message = message;
}

void Faults::report() const {
  for (const auto& [key, kind] : kinds_) {
    const bool is_one = kind.count == 1;
    reporter_.warn(key.first, path_, kind.first_line,
                   std::to_string(kind.count) + " " + key.second + (is_one ? "" : "s") +
                       (is_one ? " skipped: " : " skipped, the first: ") + kind.first_message);
  }
}

}  // namespace binnacle::text_file
