// SPDX-License-Identifier: Apache-2.0
#include "report/page.hpp"

#include <stdexcept>

#include "assets.hpp"
#include "escape.hpp"
#include "payload.hpp"

namespace binnacle::report {

namespace {

/// "{{name}}" in the template is replaced by what `value(name)` returns, once, from left to right.
template <class Value>
std::string filled(std::string_view text, Value value) {
  std::string page;
  for (;;) {
    const auto open = text.find("{{");
    page += text.substr(0, open);
    if (open == std::string_view::npos) return page;
    const auto close = text.find("}}", open);
    page += value(text.substr(open + 2, close - open - 2));
    text.remove_prefix(close + 2);
  }
}

std::string page_of(const Json& data, const std::string& otherwise, const std::string& policy,
                    std::string_view more_script = {}) {
  std::string title = data["title"].get<std::string>();
  if (title.empty()) title = otherwise;
  return filled(assets::page_html, [&](std::string_view name) -> std::string {
    if (name == "title") return html(title);
    if (name == "policy") return policy;
    if (name == "dygraph.css") return std::string(assets::dygraph_css);
    if (name == "page.css") return std::string(assets::page_css);
    if (name == "dygraph.license") return std::string(assets::dygraph_license);
    if (name == "dygraph.js") return std::string(assets::dygraph_js);
    if (name == "page.js") return std::string(assets::page_js).append(more_script).append(assets::start_js);
    if (name == "payload") return script_json(data);
    throw std::logic_error("the page's template asks for an unknown '" + std::string(name) + "'");
  });
}

}  // namespace

std::string page(const results::Results& results, const Limits& limits) {
  return page_of(payload(results, limits), results.study && !results.run ? "Study" : "Run", "");
}

std::string page_of(const results::Results& results, const std::vector<const DrawnFilter*>& drawn,
                    const Limits& limits) {
  return page_of(payload(results, drawn, limits), "Run", "");
}

std::string Comparison::page(const Limits& limits) const {
  return page_of(comparison_payload(runs_, json_, limits), "Runs compared", "", assets::comparison_js);
}

std::string live_page(const results::RunResults& run) {
  return page_of(thinned_payload(run, "waits", {}), "Run", "; connect-src 'self'");
}

std::string live_payload(const results::RunResults& run, bool is_over, const Limits& limits) {
  return script_json(thinned_payload(run, is_over ? "over" : "goes on", limits));
}

}  // namespace binnacle::report
