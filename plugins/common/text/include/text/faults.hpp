// SPDX-License-Identifier: Apache-2.0
// Faults of a file: the first one ends the run, or they are left out, counted and reported.
#pragma once

#include <map>
#include <string>

#include "binnacle/source.hpp"

namespace binnacle::text_file {

enum class OnInvalid { error, skip };

class Faults {
 public:
  Faults(std::string path, OnInvalid on_invalid, Reporter& reporter)
      : path_(std::move(path)), on_invalid_(on_invalid), reporter_(reporter) {}

  /// `what` was left out: "record", "epoch", "observation". Throws ComponentError::in_data where faults are errors.
  void add(const std::string& code, int line, const std::string& what, const std::string& message);
  /// Worth a note, and no fault.
  void note(const std::string& code, int line, const std::string& message) {
    reporter_.warn(code, path_, line, message);
  }
  /// One warning for each code and kind of thing left out.
  void report() const;

  const std::string& path() const noexcept { return path_; }

 private:
  struct Kind {
    std::size_t count = 0;
    int first_line = 0;
    std::string first_message;
  };

  std::string path_;
  OnInvalid on_invalid_;
  Reporter& reporter_;
  std::map<std::pair<std::string, std::string>, Kind> kinds_;
};

}  // namespace binnacle::text_file
