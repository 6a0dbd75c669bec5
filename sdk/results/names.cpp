// SPDX-License-Identifier: Apache-2.0
#include "names.hpp"

namespace binnacle::results {

std::string identifier(std::string_view text) {
  std::string name;
  for (const char c : text) {
    const bool is_plain = (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9');
    name += is_plain ? c : '_';
  }
  // MATLAB and Python take no digit in front.
  if (name.empty() || (name[0] >= '0' && name[0] <= '9')) name.insert(0, "_");
  return name;
}

std::string Names::take(std::string_view text) {
  const std::string wanted = identifier(text);
  std::string name = wanted;
  for (int n = 2; !taken_.insert(name).second; ++n) name = wanted + "_" + std::to_string(n);
  return name;
}

}  // namespace binnacle::results
