// SPDX-License-Identifier: Apache-2.0
// Observations, messages, or both in one input, with a line of '%' between: a source without one of the files reads the other.
#include "../reader.hpp"
#include "rinex/rinex_source.hpp"

void binnacle::fuzz::try_bytes(std::string_view bytes) {
  static const test::Folder folder;
  const std::size_t at = bytes.rfind("%\n", 0) == 0 ? 0 : bytes.find("\n%\n");
  nlohmann::json parameters{{"signals", {{"galileo", "1C"}, {"beidou", "2I"}}}};
  if (at == bytes.npos) return read_file<rinex::RinexSource>("site.obs", bytes, parameters, "observations");
  const std::string_view messages = bytes.substr(at + (at == 0 ? 2 : 3));
  if (at > 0) parameters["observations"] = folder.write("site.obs", std::string(bytes.substr(0, at + 1)));
  read_file<rinex::RinexSource>("site.nav", messages, parameters, "navigation");
}
