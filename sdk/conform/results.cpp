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

namespace {

/// Of what could not be tried people are to know; that a check does not apply, or waits for another, is no news.
bool is_news(const Outcome& outcome) {
  if (outcome.status == Status::pass) return false;
  const bool is_blocked = outcome.message.rfind("prerequisite ", 0) == 0;
  return outcome.status != Status::skip || (outcome.applies && !is_blocked);
}

std::string last_line(const Verdict& verdict, const Options& options, bool strict) {
  const int others = verdict.not_applicable();
  const std::string counts = fmt::format("{} checks tried, {} skipped, {} failed{}", verdict.tried(), verdict.skipped(),
                                         verdict.failed(), others > 0 ? fmt::format(" ({} do not apply)", others) : "");
  if (verdict.passes(strict)) return "conforms: " + counts + "\n";
  return fmt::format("does not conform: {}; the same again: --level {} --reproduce {}\n", counts, options.level,
                     options.seed);
}

}  // namespace

std::string summary(const Verdict& verdict, const Options& options, bool strict, bool verbose) {
  std::string text;
  for (const auto& outcome : verdict.outcomes) {
    if (!verbose && !is_news(outcome)) continue;
    if (!verbose)
      text += one_line(outcome);
    else if (outcome.message.empty())
      continue;
    else
      text += fmt::format("  {} {} {}\n", status_name(outcome.status), subject_of(outcome), outcome.check);
    if (!outcome.message.empty()) text += indented(outcome.message);
    if (outcome.status == Status::crash)
      text += indented(fmt::format("in a debugger: --only '{}:{}' --level {} --seed {} --in-process", outcome.type,
                                   outcome.check, options.level, options.seed));
  }
  if (!verdict.enumeration.empty()) text += "  its components cannot be listed: " + verdict.enumeration + "\n";
  for (const auto& type : verdict.untried())
    text += fmt::format("  {}: none of its checks of numbers could be tried\n", type);
  text += fmt::format("{} components, {} checks: {} pass, {} warn, {} fail, {} crash, {} timeout, {} skip, {} n/a\n",
                      verdict.components.size(), verdict.outcomes.size(), verdict.count(Status::pass),
                      verdict.count(Status::warn), verdict.count(Status::fail), verdict.count(Status::crash),
                      verdict.count(Status::timeout), verdict.skipped(), verdict.not_applicable());
  return text + last_line(verdict, options, strict);
}

std::string to_json(const Verdict& verdict, const Options& options, bool strict) {
  nlohmann::ordered_json checks = nlohmann::ordered_json::array();
  for (const auto& outcome : verdict.outcomes)
    checks.push_back({{"component", outcome.type},
                      {"role", outcome.role},
                      {"check", outcome.check},
                      {"status", status_name(outcome.status)},
                      {"applies", outcome.applies},
                      {"message", outcome.message},
                      {"seconds", outcome.seconds}});
  const nlohmann::ordered_json all = {
      {"library", options.library.string()}, {"level", options.level},       {"seed", options.seed},
      {"conforms", verdict.passes(strict)},  {"tried", verdict.tried()},     {"skipped", verdict.skipped()},
      {"failed", verdict.failed()},          {"untried", verdict.untried()}, {"components", verdict.components.size()},
      {"enumeration", verdict.enumeration},  {"checks", std::move(checks)}};
  return all.dump(2, ' ', false, nlohmann::ordered_json::error_handler_t::replace) + "\n";
}

namespace {

std::string why_not(const Verdict& verdict) {
  std::string why = "does not conform. " + verdict.enumeration;
  for (const auto& type : verdict.untried()) why += "\nnone of the checks of numbers of " + type + " could be tried";
  return why;
}

}  // namespace

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
  // A verdict of its own, for it can be bad where no check is: nothing ran, or the components could not be found out.
  const bool passes = verdict.passes(strict);
  failures += !passes;
  cases += fmt::format("    <testcase classname=\"library\" name=\"verdict\">{}</testcase>\n",
                       passes ? "" : "<failure message=\"" + escaped(why_not(verdict)) + "\"/>");
  return fmt::format(
      "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n<testsuites>\n  <testsuite name=\"{}\" tests=\"{}\" failures=\"{}\" "
      "errors=\"{}\" skipped=\"{}\">\n"
      "{}  </testsuite>\n</testsuites>\n",
      escaped(options.library.filename().string()), verdict.outcomes.size() + 1, failures, errors, skipped, cases);
}

}  // namespace binnacle::conform
