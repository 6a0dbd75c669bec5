// SPDX-License-Identifier: Apache-2.0
// Names in a file: what every tool takes as a name, made of what a config may call things.
#pragma once

#include <set>
#include <string>
#include <string_view>

namespace binnacle::results {

/// Letters, digits and '_', as CF recommends and MATLAB and Python want: "position.lat" becomes "position_lat".
std::string identifier(std::string_view text);

/// Of one group: "fix", and "fix_2" for the second thing of that name.
class Names {
 public:
  std::string take(std::string_view text);

 private:
  std::set<std::string> taken_;
};

}  // namespace binnacle::results
