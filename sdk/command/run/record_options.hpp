// SPDX-License-Identifier: Apache-2.0
// Options of `run` that say how it is recorded.
#pragma once

#include <string>

#include <CLI/CLI.hpp>

#include "record_formats.hpp"

namespace binnacle::command {

/// --only and --compress, both of --out.
class RecordOptions {
 public:
  void add_to(CLI::App& command, CLI::Option* out);
  RecordFormats formats() const;

 private:
  std::string only_;
  int compression_ = 0;
};

}  // namespace binnacle::command
