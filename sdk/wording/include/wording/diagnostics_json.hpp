// SPDX-License-Identifier: Apache-2.0
// Diagnostics as JSON, for programs.
#pragma once

#include <utility>

#include <nlohmann/json.hpp>

#include "binnacle/diagnostic.hpp"

namespace binnacle::wording {

inline nlohmann::ordered_json to_json(const Diagnostics& diagnostics) {
  auto list = nlohmann::ordered_json::array();
  for (const auto& item : diagnostics.sorted()) {
    nlohmann::ordered_json entry{{"severity", item.severity == Severity::error ? "error" : "warning"},
                                 {"code", item.code}};
    entry["file"] = item.origin.file;
    entry["line"] = item.origin.line;
    entry["column"] = item.origin.column;
    entry["pointer"] = item.pointer;
    entry["message"] = item.message;
    entry["text"] = to_string(item);
    list.push_back(std::move(entry));
  }
  return list;
}

}  // namespace binnacle::wording
