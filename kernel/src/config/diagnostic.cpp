// SPDX-License-Identifier: Apache-2.0
// Diagnostics: printing, collecting, and the search for what was meant.
#include "binnacle/diagnostic.hpp"

#include <algorithm>
#include <cctype>
#include <iterator>
#include <tuple>

namespace binnacle {

namespace {

std::string place_text(const Origin& origin) {
  std::string text = origin.file;
  if (origin.line > 0) text += (text.empty() ? "line " : ":") + std::to_string(origin.line);
  if (origin.line > 0 && origin.column > 0) text += ":" + std::to_string(origin.column);
  return text;
}

/// Names come from files and may hold anything; a diagnostic stays one line.
std::string on_one_line(const std::string& text) {
  constexpr std::string_view digits = "0123456789abcdef";
  std::string result;
  for (const char c : text) {
    const auto byte = static_cast<unsigned char>(c);
    if (c == '\n') {
      result += "\\n";
    } else if (byte < 0x20 || byte == 0x7F) {
      result += {'\\', 'x', digits[byte >> 4U], digits[byte & 0xFU]};
    } else {
      result += c;
    }
  }
  return result;
}

}  // namespace

std::string to_string(const Diagnostic& diagnostic) {
  std::string text = place_text(diagnostic.origin);
  if (!text.empty()) text += ": ";
  text += diagnostic.severity == Severity::error ? "error" : "warning";
  if (!diagnostic.code.empty()) text += "[" + diagnostic.code + "]";
  if (!diagnostic.pointer.empty()) text += " " + diagnostic.pointer;
  return on_one_line(text + ": " + diagnostic.message);
}

void Diagnostics::add(Diagnostic diagnostic) {
  // Equal ones come close together, and of a hundred thousand none is looked for among all others.
  constexpr std::ptrdiff_t most = 300;
  const auto first = items_.end() - std::min<std::ptrdiff_t>(most, std::ssize(items_));
  if (std::find(first, items_.end(), diagnostic) == items_.end()) items_.push_back(std::move(diagnostic));
}

void Diagnostics::error(std::string code, Origin origin, std::string pointer, std::string message) {
  add({Severity::error, std::move(code), std::move(origin), std::move(pointer), std::move(message)});
}

void Diagnostics::warning(std::string code, Origin origin, std::string pointer, std::string message) {
  add({Severity::warning, std::move(code), std::move(origin), std::move(pointer), std::move(message)});
}

void Diagnostics::merge(const Diagnostics& other) {
  if (&other == this) return;
  for (const Diagnostic& item : other.items_) add(item);
}

bool Diagnostics::has_errors() const {
  return std::ranges::find(items_, Severity::error, &Diagnostic::severity) != items_.end();
}

std::vector<Diagnostic> Diagnostics::sorted() const {
  std::vector<Diagnostic> result = items_;
  std::ranges::stable_sort(result, {}, [](const Diagnostic& item) {
    return std::tie(item.origin.file, item.origin.line, item.origin.column);
  });
  return result;
}

std::string Diagnostics::text() const {
  std::string text;
  for (const Diagnostic& item : sorted()) text += (text.empty() ? "" : "\n") + to_string(item);
  return text;
}

Error::Error(int exit_status, Diagnostics diagnostics)
    : std::runtime_error(diagnostics.text()), exit_status_(exit_status), diagnostics_(std::move(diagnostics)) {}

namespace {

// Costs are in quarters of an edit, so that a transposition can be dearer than nothing and cheaper than an edit.
constexpr std::size_t edit = 4;
constexpr std::size_t transposition = 3;
constexpr std::size_t cut_short = 5;

std::string folded(std::string_view text) {
  std::string result(text);
  for (char& c : result) {
    c = c == '-' || c == ' ' ? '_' : static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
  }
  return result;
}

/// Damerau-Levenshtein in its restricted form (optimal string alignment).
std::size_t distance(const std::string& a, const std::string& b) {
  std::vector<std::size_t> before(b.size() + 1), last(b.size() + 1), now(b.size() + 1);
  for (std::size_t j = 0; j <= b.size(); ++j) last[j] = j * edit;
  for (std::size_t i = 1; i <= a.size(); ++i) {
    now[0] = i * edit;
    for (std::size_t j = 1; j <= b.size(); ++j) {
      now[j] = std::min({last[j] + edit, now[j - 1] + edit, last[j - 1] + (a[i - 1] == b[j - 1] ? 0 : edit)});
      if (i > 1 && j > 1 && a[i - 1] == b[j - 2] && a[i - 2] == b[j - 1]) {
        now[j] = std::min(now[j], before[j - 2] + transposition);
      }
    }
    std::swap(before, last);
    std::swap(last, now);
  }
  return last[b.size()];
}

/// Exact below `least`, and not below it otherwise.
std::size_t cost(const std::string& name, const std::string& candidate, std::size_t least) {
  const std::size_t shorter = std::min(name.size(), candidate.size()), longer = std::max(name.size(), candidate.size());
  const bool is_prefix = shorter >= 3 && (name.starts_with(candidate) || candidate.starts_with(name));
  const std::size_t at_least = (longer - shorter) * edit;  // names may be of any length
  const std::size_t edits = at_least >= least ? at_least : distance(name, candidate);
  return is_prefix ? std::min(edits, cut_short) : edits;
}

}  // namespace

std::string closest(std::string_view name, const std::vector<std::string>& candidates) {
  const std::string wanted = folded(name);
  std::string best;
  const std::size_t size = wanted.size();
  std::size_t least = 1 + (size < 2 ? 0 : size < 3 ? edit : size < 5 ? cut_short : size < 9 ? 2 * edit : 3 * edit);
  for (const std::string& candidate : candidates) {
    const std::size_t its_cost = cost(wanted, folded(candidate), least);
    if (its_cost < least) best = candidate;
    least = std::min(least, its_cost);
  }
  return best;
}

}  // namespace binnacle
