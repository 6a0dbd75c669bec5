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

}  // namespace binnacle::command
