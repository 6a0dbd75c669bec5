// SPDX-License-Identifier: Apache-2.0
#include "results.hpp"

#include <fmt/format.h>
#include <nlohmann/json.hpp>

namespace binnacle::conform {

namespace {

std::string subject_of(const Outcome& outcome) { return outcome.type.empty() ? "library" : outcome.type; }

std::string indented(const std::string& text) {
  std::string all = "      ";
  for (const char c : text) all += c == '\n' ? std::string("\n      ") : std::string(1, c);
  return all + "\n";
}

std::string escaped(const std::string& text) {
  std::string all;
  for (const char c : text) {
    switch (c) {
      case '&': all += "&amp;"; break;
      case '<': all += "&lt;"; break;
      case '>': all += "&gt;"; break;
      case '"': all += "&quot;"; break;
      case '\n': all += "&#10;"; break;
      default: all += static_cast<unsigned char>(c) < 0x20 ? '?' : c;
    }
  }
  return all;
}

}  // namespace

std::string one_line(const Outcome& outcome) {
  return fmt::format("  {:<8} {:<36} {:<32} {:6.0f} ms\n", status_name(outcome.status), subject_of(outcome),
                     outcome.check, 1e3 * outcome.seconds);
}

std::string summary(const Verdict& verdict, const Options& options, bool strict, bool verbose) {
  std::string text;
  for (const auto& outcome : verdict.outcomes) {
    const bool is_quiet = outcome.status == Status::pass || outcome.status == Status::skip;
    if (is_quiet && !verbose) continue;
    if (!verbose)
      text += one_line(outcome);
    else if (outcome.message.empty())
      continue;
    else
      text += fmt::format("  {} {} {}\n", status_name(outcome.status), subject_of(outcome), outcome.check);
    if (!outcome.message.empty()) text += indented(outcome.message);
  }
  if (!verdict.enumeration.empty()) text += "  its components could not be told: " + verdict.enumeration + "\n";
  text += fmt::format("{} components, {} checks: {} pass, {} warn, {} fail, {} crash, {} timeout, {} skip\n",
                      verdict.components.size(), verdict.outcomes.size(), verdict.count(Status::pass),
                      verdict.count(Status::warn), verdict.count(Status::fail), verdict.count(Status::crash),
                      verdict.count(Status::timeout), verdict.count(Status::skip));
  if (verdict.passes(strict)) return text + "conforms\n";
  return text +
         fmt::format("does not conform; the same again: --level {} --reproduce {}\n", options.level, options.seed);
}

std::string to_json(const Verdict& verdict, const Options& options, bool strict) {
  nlohmann::ordered_json checks = nlohmann::ordered_json::array();
  for (const auto& outcome : verdict.outcomes)
    checks.push_back({{"component", outcome.type},
                      {"role", outcome.role},
                      {"check", outcome.check},
                      {"status", status_name(outcome.status)},
                      {"message", outcome.message},
                      {"seconds", outcome.seconds}});
  const nlohmann::ordered_json all = {{"library", options.library.string()},
                                      {"level", options.level},
                                      {"seed", options.seed},
                                      {"conforms", verdict.passes(strict)},
                                      {"components", verdict.components.size()},
                                      {"enumeration", verdict.enumeration},
                                      {"checks", std::move(checks)}};
  return all.dump(2, ' ', false, nlohmann::ordered_json::error_handler_t::replace) + "\n";
}

std::string to_junit(const Verdict& verdict, const Options& options, bool strict) {
  std::string cases;
  int failures = 0, errors = 0, skipped = 0;
  for (const auto& outcome : verdict.outcomes) {
    std::string inside;
    const auto element = [&](const char* name) {
      inside = fmt::format("<{} message=\"{}\"/>", name, escaped(outcome.message));
    };
    if (outcome.status == Status::fail || (strict && outcome.status == Status::warn)) element("failure"), ++failures;
    if (outcome.status == Status::crash || outcome.status == Status::timeout) element("error"), ++errors;
    if (outcome.status == Status::skip) element("skipped"), ++skipped;
    if (outcome.status == Status::warn && !strict) inside = "<system-out>" + escaped(outcome.message) + "</system-out>";
    cases += fmt::format("    <testcase classname=\"{}\" name=\"{}\" time=\"{:.3f}\">{}</testcase>\n",
                         escaped(subject_of(outcome) + (outcome.role.empty() ? "" : " (" + outcome.role + ")")),
                         escaped(outcome.check), outcome.seconds, inside);
  }
  // A verdict of its own, for it can be bad where no check is: nothing ran, or the components could not be told.
  const bool passes = verdict.passes(strict);
  failures += !passes;
  cases +=
      fmt::format("    <testcase classname=\"library\" name=\"verdict\">{}</testcase>\n",
                  passes ? "" : "<failure message=\"" + escaped("does not conform. " + verdict.enumeration) + "\"/>");
  return fmt::format(
      "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n<testsuites>\n  <testsuite name=\"{}\" tests=\"{}\" failures=\"{}\" "
      "errors=\"{}\" skipped=\"{}\">\n"
      "{}  </testsuite>\n</testsuites>\n",
      escaped(options.library.filename().string()), verdict.outcomes.size() + 1, failures, errors, skipped, cases);
}

}  // namespace binnacle::conform
