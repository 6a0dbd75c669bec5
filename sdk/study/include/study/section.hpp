// SPDX-License-Identifier: Apache-2.0
// Reads a section of a config that the kernel leaves alone, and reports what is wrong as the kernel does.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include <nlohmann/json.hpp>

#include "binnacle/config.hpp"
#include "binnacle/diagnostic.hpp"

namespace binnacle::study {

using Json = nlohmann::ordered_json;

class Section {
 public:
  Section(const Config& config, Diagnostics& diagnostics)
      : config_(config), root_(Json::parse(config.text())), diagnostics_(diagnostics) {}

  /// Null where there is nothing.
  const Json* at(const std::string& pointer) const;
  /// B012 for every key that is not allowed: `unknown key of 'study'; did you mean 'runs'?`
  void check_keys(const std::string& pointer, const std::vector<std::string>& allowed, std::string_view what) const;
  /// Nothing where the value is not there, or of another type (B006).
  const Json* object(const std::string& pointer) const;
  const Json* list(const std::string& pointer) const;
  std::optional<std::string> text(const std::string& pointer) const;
  std::optional<bool> truth(const std::string& pointer) const;
  std::optional<std::int64_t> whole_number(const std::string& pointer, std::int64_t least) const;
  std::optional<std::string> choice(const std::string& pointer, const std::vector<std::string>& choices) const;

  void error(const std::string& code, const std::string& pointer, const std::string& message) const;
  void key_error(const std::string& code, const std::string& pointer, const std::string& message) const;

 private:
  void wrong_type(const std::string& pointer, const char* wanted) const;

  const Config& config_;
  const Json root_;
  Diagnostics& diagnostics_;
};

}  // namespace binnacle::study
