// SPDX-License-Identifier: Apache-2.0
// The files under page/ and dygraphs, as they were when this was built.
#pragma once

#include <string_view>

namespace binnacle::report::assets {

extern const std::string_view page_html;
extern const std::string_view page_css;
extern const std::string_view page_js;        // what a page does, and
extern const std::string_view comparison_js;  // what else one of several runs does, before
extern const std::string_view start_js;       // it begins
extern const std::string_view dygraph_js;
extern const std::string_view dygraph_css;
extern const std::string_view dygraph_license;

}  // namespace binnacle::report::assets
