// SPDX-License-Identifier: Apache-2.0
// Text that is put into a page.
#pragma once

#include <string>
#include <string_view>

#include <nlohmann/json.hpp>

namespace binnacle::report {

/// As an element's text or a quoted attribute. What is no UTF-8 becomes U+FFFD.
std::string html(std::string_view text);

/// As what stands in a <script type="application/json">: no "<" that could end it or begin a comment.
std::string script_json(const nlohmann::ordered_json& json);

}  // namespace binnacle::report
