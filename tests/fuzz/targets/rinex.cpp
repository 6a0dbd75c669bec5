// SPDX-License-Identifier: Apache-2.0
// Observations and messages in one input, with a line of '%' between.
#include "../reader.hpp"
#include "rinex/rinex_source.hpp"

void binnacle::fuzz::try_bytes(std::string_view bytes) {
  static const test::Folder folder;
  const std::size_t middle = bytes.find("\n%\n");
  const std::string messages(middle == bytes.npos ? "" : bytes.substr(middle + 3));
  const nlohmann::json parameters{{"navigation", folder.write("site.nav", messages)},
                                  {"signals", {{"galileo", "1C"}, {"beidou", "2I"}}}};
  read_file<rinex::RinexSource>("site.obs", bytes.substr(0, middle), parameters, "observations");
}
