// SPDX-License-Identifier: Apache-2.0
#include "record_options.hpp"

namespace binnacle::command {

void RecordOptions::add_to(CLI::App& command, CLI::Option* out) {
  command.add_option("--only", only_, "Only these formats of --out, as nc,csv,page")->type_name("FORMATS")->needs(out);
  command.add_option("--compress", compression_, "Compression of run.nc of --out: 1 (fast) to 9 (small); 0: none")
      ->type_name("N")
      ->check(CLI::Range(0, 9))
      ->capture_default_str()
      ->needs(out);
}

RecordFormats RecordOptions::formats() const {
  RecordFormats formats;
  if (!only_.empty()) formats.keep_only(only_);
  formats.compression = compression_;
  return formats;
}

}  // namespace binnacle::command
