// SPDX-License-Identifier: Apache-2.0
#include "provenance.hpp"

#include <cstdlib>
#include <ctime>

#include "binnacle/version.hpp"

namespace binnacle::command {

Json provenance(const Catalog& catalog, const std::string& command) {
  Json plugins = Json::array();
  for (const auto& plugin : catalog.plugins())
    plugins.push_back({{"name", plugin.name}, {"version", plugin.version}, {"path", plugin.file.string()}});
  return {{"version", BINNACLE_VERSION}, {"command", command}, {"plugins", std::move(plugins)}};
}

std::string now_in_words() {
  const char* const epoch = std::getenv("SOURCE_DATE_EPOCH");
  const std::time_t now =
      epoch && *epoch ? static_cast<std::time_t>(std::strtoll(epoch, nullptr, 10)) : std::time(nullptr);
  std::tm utc{};
  gmtime_r(&now, &utc);
  char text[32];
  std::strftime(text, sizeof text, "%Y-%m-%dT%H:%M:%SZ", &utc);
  return text;
}

}  // namespace binnacle::command
