// SPDX-License-Identifier: Apache-2.0
// Strict JSON with comments, read with the place of every key and value. What is inside a text or a number is left to
// nlohmann's parser, which knows escapes, UTF-8 and the nearest double.
#include <utility>

#include "base/text.hpp"
#include "config/node.hpp"

namespace binnacle::internal::config {

namespace {

struct SyntaxStop {};

using base::in_quotes;

std::string place_text(const Origin& origin) {
  return "line " + std::to_string(origin.line) + ", column " + std::to_string(origin.column);
}

bool is_continuation(char c) { return (static_cast<unsigned char>(c) & 0xC0U) == 0x80U; }

/// What nlohmann has against a text: "forbidden character after backslash".
std::string reason_in(const Json::parse_error& error) {
  constexpr std::string_view before = "invalid string: ";
  const std::string message = error.what();
  const std::size_t start = message.find(before);
  if (start == std::string::npos) return message;
  const std::string reason = message.substr(start + before.size());
  return reason.substr(0, reason.find("; last read"));
}

class JsonReader {
 public:
  /// Without places, as on the command line, there are no comments either.
  JsonReader(std::string_view text, const std::string& file_name, const Folder& folder, bool has_places,
             Diagnostics& diagnostics)
      : text_(text), file_name_(file_name), folder_(folder), has_places_(has_places), diagnostics_(diagnostics) {
    if (text_.starts_with("\xEF\xBB\xBF")) at_ = 3;
  }

  std::optional<Node> read() {
    try {
      skip_blank();
      Node node = value("", 0);
      skip_blank();
      if (at_ < text_.size()) stop("expected the end of the text after the last value, found " + found());
      return node;
    } catch (const SyntaxStop&) {
      return std::nullopt;
    }
  }

 private:
  static constexpr int deepest = 200;

  [[noreturn]] void stop(const std::string& message, const char* code = "B001") {
    report(message, here(), code);
    throw SyntaxStop{};
  }

  void report(const std::string& message, const Origin& origin, const char* code = "B001") {
    diagnostics_.error(code, origin, "", message);
  }

  Origin here() const { return has_places_ ? Origin{file_name_, line_, column_} : Origin{file_name_, 0, 0}; }

  char peek(std::size_t ahead = 0) const { return at_ + ahead < text_.size() ? text_[at_ + ahead] : '\0'; }

  void advance(std::size_t count = 1) {
    for (; count > 0; --count) {
      const char c = text_[at_++];
      if (c == '\n') {
        ++line_;
        column_ = 1;
      } else if (!is_continuation(c)) {
        ++column_;
      }
    }
  }

  /// What stands here, for messages: a word, a character or the end.
  std::string found() const {
    if (at_ >= text_.size()) return "the end of the text";
    if (const std::string_view w = word(); !w.empty()) return in_quotes(w.substr(0, 40));
    if (peek() == '\'') return "a single quote; texts stand in double quotes";
    if (static_cast<unsigned char>(peek()) < 0x20) return "a control character";
    std::size_t size = 1;
    while (is_continuation(peek(size))) ++size;
    return in_quotes(text_.substr(at_, size));
  }

  std::string_view word() const {
    std::size_t size = 0;
    while (base::is_word(peek(size), "_.+-")) ++size;
    return text_.substr(at_, size);
  }

  void skip_blank() {
    while (at_ < text_.size()) {
      const char c = peek();
      if (c == ' ' || c == '\t' || c == '\r' || c == '\n') {
        advance();
      } else if (has_places_ && c == '/' && peek(1) == '/') {
        while (at_ < text_.size() && peek() != '\n') advance();
      } else if (has_places_ && c == '/' && peek(1) == '*') {
        const std::size_t end = text_.find("*/", at_ + 2);
        if (end == std::string_view::npos) stop("the comment is never closed; expected '*/'");
        advance(end + 2 - at_);
      } else {
        return;
      }
    }
  }

  /// A mark, and the blanks behind it.
  void pass() {
    advance();
    skip_blank();
  }

  Node value(const std::string& pointer, int depth) {
    if (depth > deepest) stop("nested more than " + std::to_string(deepest) + " deep");
    if (++values_ > most_values)
      stop("more than " + std::to_string(most_values) + " values; large tables belong into a file of data", too_large);
    Node node{nullptr, here(), folder_};
    if (peek() == '{' || peek() == '[')
      fill(node, pointer, depth);
    else
      node.json = peek() == '"' ? Json(string()) : word_value();
    return node;
  }

  Json word_value() {
    const std::string_view text = word();
    try {
      Json value = Json::parse(text);
      const auto digits = text.substr(0, text.find_first_of("eE"));
      if (value.is_number() && value == 0 && digits.find_first_of("123456789") != text.npos)
        stop("number " + in_quotes(text) + " is out of range");  // it would become 0
      advance(text.size());
      return value;
    } catch (const Json::out_of_range&) {
      stop("number " + in_quotes(text) + " is out of range");
    } catch (const Json::parse_error&) {
      const char first = peek();
      if (base::is_digit(first) || first == '+' || first == '-' || first == '.')
        stop("bad number " + found() + "; a number reads like -0.5 or 1e-3, one with a unit needs double quotes");
      stop("expected a value, found " + found());
    }
  }

  std::string string() {
    std::size_t end = at_ + 1;
    while (end < text_.size() && text_[end] != '"' && text_[end] != '\n') end += text_[end] == '\\' ? 2 : 1;
    if (end >= text_.size() || text_[end] == '\n') stop("the text is never closed; expected '\"'");
    const std::string_view text = text_.substr(at_, end + 1 - at_);
    if (!is_utf8(text)) stop("the text is not UTF-8");
    try {
      auto result = Json::parse(text).get<std::string>();
      advance(text.size());
      return result;
    } catch (const Json::parse_error& error) {
      advance(error.byte - 1);
      const std::string reason = reason_in(error);
      stop("bad text: " + reason + (reason.ends_with("backslash") ? "; a backslash itself is written '\\\\'" : ""));
    }
  }

  void fill(Node& node, const std::string& pointer, int depth) {
    const bool is_object = peek() == '{';
    const char close = is_object ? '}' : ']';
    node.json = is_object ? Json::object() : Json::array();
    pass();
    while (peek() != close) {
      if (is_object && peek() != '"') stop("expected a key in double quotes or '}', found " + found() + opened(node));
      child(node, pointer, depth);
      separator(node, close);
    }
    advance();
  }

  void child(Node& node, const std::string& pointer, int depth) {
    const bool is_member = node.json.is_object();
    const Origin origin = here();
    std::string key = is_member ? string() : std::to_string(node.children.size());
    if (is_member) {
      skip_blank();
      if (peek() != ':') stop("expected ':' after the key " + in_quotes(key) + ", found " + found());
      pass();
    }
    const std::string own_pointer = join_pointer(pointer, key);
    pointers_ += own_pointer.size();
    if (pointers_ > most_pointers) stop(pointers_too_long, too_large);
    Node own = value(own_pointer, depth + 1);
    const Member* first = is_member ? node.find(key) : nullptr;
    if (first)
      diagnostics_.error("B002", origin, own_pointer,
                         "duplicate key " + in_quotes(key) + "; the first is at " + place_text(first->key_origin));
    else
      node.children.push_back({std::move(key), origin, std::move(own)});
  }

  /// The comma after a value, or the end of its container. What is nearly right is reported and passed.
  void separator(const Node& node, char close) {
    const Origin after_value = here();
    skip_blank();
    if (peek() == close) return;
    if (peek() != ',') {
      const bool forgotten = peek() == '"' || (close == ']' && (peek() == '{' || peek() == '['));
      const std::string wanted = std::string("expected ',' or '") + close + "' after the value, found ";
      if (!forgotten) stop(wanted + found() + opened(node));
      report(wanted + found(), after_value);
      return;
    }
    const Origin comma = here();
    pass();
    if (peek() == close) report(std::string("trailing comma before '") + close + "'; delete it", comma);
  }

  std::string opened(const Node& node) const {
    if (at_ < text_.size() || !has_places_) return {};
    return std::string("; '") + (node.json.is_object() ? '{' : '[') + "' was opened at " + place_text(node.origin);
  }

  std::string_view text_;
  const std::string& file_name_;
  const Folder& folder_;
  bool has_places_;
  Diagnostics& diagnostics_;
  std::size_t at_ = 0;
  std::size_t values_ = 0, pointers_ = 0;  // how many, and bytes
  int line_ = 1;
  int column_ = 1;
};

}  // namespace

std::optional<Node> read_json(std::string_view text, const std::string& file_name, const Folder& folder,
                              Diagnostics& diagnostics) {
  return JsonReader(text, file_name, folder, true, diagnostics).read();
}

std::optional<Node> read_json_value(std::string_view text, const std::string& origin_name, const Folder& folder) {
  Diagnostics problems;
  std::optional<Node> node = JsonReader(text, origin_name, folder, false, problems).read();
  return problems.empty() ? node : std::nullopt;
}

bool is_utf8(std::string_view text) {
  try {
    return !Json(text).dump().empty();
  } catch (const Json::type_error&) {
    return false;
  }
}

}  // namespace binnacle::internal::config
