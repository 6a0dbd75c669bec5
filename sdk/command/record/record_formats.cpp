// SPDX-License-Identifier: Apache-2.0
#include "record_formats.hpp"

#include <string_view>

#include "output.hpp"
#include "wording/wording.hpp"

namespace binnacle::command {

void RecordFormats::keep_only(const std::string& list) {
  nc = csv = page = false;
  std::string_view rest = list;
  for (bool is_more = true; is_more;) {
    const auto comma = rest.find(',');
    const std::string word(rest.substr(0, comma));
    is_more = comma != rest.npos;
    if (is_more) rest.remove_prefix(comma + 1);
    if (word == "nc")
      nc = true;
    else if (word == "csv")
      csv = true;
    else if (word == "page")
      page = true;
    else
      throw UsageError(
          "--only: " +
          (word.empty() ? "a format is missing in '" + list + "'" : wording::in_quotes(word) + " is not a format") +
          "; expected some of nc, csv, page, with commas between them" +
          wording::suggestion(word, {"nc", "csv", "page"}));
  }
}

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
