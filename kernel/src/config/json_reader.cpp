// SPDX-License-Identifier: Apache-2.0
// Strict JSON with comments, read with the place of every key and value.
#include "config/json_reader.hpp"

#include <charconv>
#include <cstdint>
#include <utility>

#include "base/text.hpp"
#include "config/pointer.hpp"

namespace binnacle::config {

namespace {

using nlohmann::ordered_json;

struct SyntaxStop {};

using base::in_quotes;

std::string place_text(const Origin& origin) {
  return "line " + std::to_string(origin.line) + ", column " + std::to_string(origin.column);
}

bool is_continuation(char c) { return (static_cast<unsigned char>(c) & 0xC0U) == 0x80U; }

bool is_word_character(char c) {
  return (c >= '0' && c <= '9') || (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || c == '_' || c == '.' ||
         c == '+' || c == '-';
}

void append_utf8(std::string& text, std::uint32_t code_point) {
  const auto put = [&](std::uint32_t byte) { text += static_cast<char>(byte); };
  if (code_point < 0x80) {
    put(code_point);
  } else if (code_point < 0x800) {
    put(0xC0U | code_point >> 6);
    put(0x80U | (code_point & 0x3FU));
  } else if (code_point < 0x10000) {
    put(0xE0U | code_point >> 12);
    put(0x80U | (code_point >> 6 & 0x3FU));
    put(0x80U | (code_point & 0x3FU));
  } else {
    put(0xF0U | code_point >> 18);
    put(0x80U | (code_point >> 12 & 0x3FU));
    put(0x80U | (code_point >> 6 & 0x3FU));
    put(0x80U | (code_point & 0x3FU));
  }
}

/// RFC 8259, section 6: -?(0|[1-9][0-9]*)(.[0-9]+)?([eE][+-]?[0-9]+)?
bool is_json_number(std::string_view text) {
  std::size_t at = 0;
  const auto is = [&](char c) { return at < text.size() && text[at] == c; };
  const auto digits = [&] {
    const std::size_t start = at;
    while (at < text.size() && text[at] >= '0' && text[at] <= '9') ++at;
    return at - start;
  };
  if (is('-')) ++at;
  const bool leading_zero = is('0');
  const std::size_t whole = digits();
  if (whole == 0 || (leading_zero && whole > 1)) return false;
  if (is('.')) {
    ++at;
    if (digits() == 0) return false;
  }
  if (is('e') || is('E')) {
    ++at;
    if (is('+') || is('-')) ++at;
    if (digits() == 0) return false;
  }
  return at == text.size();
}

class JsonReader {
 public:
  struct Mode {
    bool comments;
    bool places;
  };

  JsonReader(std::string_view text, const std::string& file_name, std::shared_ptr<const std::filesystem::path> folder,
             Mode mode, Diagnostics& diagnostics)
      : text_(text), file_name_(file_name), folder_(std::move(folder)), mode_(mode), diagnostics_(diagnostics) {
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

  [[noreturn]] void stop(const std::string& message) { stop(message, here()); }
  [[noreturn]] void stop(const std::string& message, const Origin& origin) {
    diagnostics_.error("B001", origin, "", message);
    throw SyntaxStop{};
  }

  Origin here() const { return mode_.places ? Origin{file_name_, line_, column_} : Origin{file_name_, 0, 0}; }

  char peek(std::size_t ahead = 0) const { return at_ + ahead < text_.size() ? text_[at_ + ahead] : '\0'; }

  void advance() {
    const char c = text_[at_++];
    if (c == '\n') {
      ++line_;
      column_ = 1;
    } else if (!is_continuation(c)) {
      ++column_;
    }
  }

  void advance(std::size_t count) {
    while (count-- > 0) advance();
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
    while (is_word_character(peek(size))) ++size;
    return text_.substr(at_, size);
  }

  void skip_blank() {
    while (at_ < text_.size()) {
      const char c = peek();
      if (c == ' ' || c == '\t' || c == '\r' || c == '\n') {
        advance();
      } else if (c == '/' && (peek(1) == '/' || peek(1) == '*') && mode_.comments) {
        skip_comment();
      } else {
        return;
      }
    }
  }

  void skip_comment() {
    if (peek(1) == '/') {
      while (at_ < text_.size() && peek() != '\n') advance();
      return;
    }
    const Origin start = here();
    const std::size_t end = text_.find("*/", at_ + 2);
    if (end == std::string_view::npos) stop("the comment is never closed; expected '*/'", start);
    advance(end + 2 - at_);
  }

  Node value(const std::string& pointer, int depth) {
    if (depth > deepest) stop("nested more than " + std::to_string(deepest) + " deep");
    if (peek() == '{') return object(pointer, depth);
    if (peek() == '[') return array(pointer, depth);
    const Origin origin = here();
    if (peek() == '"') return scalar_node(string(), origin, folder_);
    return scalar_node(word_value(), origin, folder_);
  }

  ordered_json word_value() {
    const std::string_view text = word();
    if (text == "true") return advance(4), ordered_json(true);
    if (text == "false") return advance(5), ordered_json(false);
    if (text == "null") return advance(4), ordered_json(nullptr);
    if (is_json_number(text)) return number(text);
    const char first = peek();
    if ((first >= '0' && first <= '9') || first == '+' || first == '-' || first == '.') {
      stop("bad number " + found() + "; a number reads like -0.5 or 1e-3, one with a unit stands in double quotes");
    }
    stop("expected a value, found " + found());
  }

  ordered_json number(std::string_view text) {
    const char* first = text.data();
    const char* end = first + text.size();
    const bool whole = text.find_first_of(".eE") == std::string_view::npos;
    std::int64_t integer = 0;
    if (whole && std::from_chars(first, end, integer).ec == std::errc()) return advance(text.size()), integer;
    std::uint64_t natural = 0;
    if (whole && std::from_chars(first, end, natural).ec == std::errc()) return advance(text.size()), natural;
    double real = 0.0;
    if (std::from_chars(first, end, real).ec != std::errc()) stop("number " + in_quotes(text) + " is out of range");
    advance(text.size());
    return real;
  }

  std::string string() {
    const Origin start = here();
    advance();
    std::string result;
    while (peek() != '"' || at_ >= text_.size()) {
      if (at_ >= text_.size() || peek() == '\n') stop("the text is never closed; expected '\"'", start);
      if (static_cast<unsigned char>(peek()) < 0x20)
        stop("control character in a text; write it as an escape, \\t say");
      if (peek() == '\\') {
        escape(result);
      } else {
        result += peek();
        advance();
      }
    }
    advance();
    if (!is_utf8(result)) stop("the text is not UTF-8", start);
    return result;
  }

  void escape(std::string& result) {
    constexpr std::string_view names = "\"\\/bfnrt";
    constexpr std::string_view meanings = "\"\\/\b\f\n\r\t";
    const std::size_t which = peek(1) == '\0' ? std::string_view::npos : names.find(peek(1));
    if (which != std::string_view::npos) {
      result += meanings[which];
      advance(2);
    } else if (peek(1) == 'u') {
      append_utf8(result, code_point());
    } else {
      stop("unknown escape in a text; a backslash itself is written '\\\\'");
    }
  }

  std::uint32_t code_point() {
    const Origin start = here();
    const std::uint32_t high = four_digits();
    if (high < 0xD800 || high > 0xDFFF) return high;
    if (high > 0xDBFF || peek() != '\\' || peek(1) != 'u') stop("half of a surrogate pair in a text", start);
    const std::uint32_t low = four_digits();
    if (low < 0xDC00 || low > 0xDFFF) stop("half of a surrogate pair in a text", start);
    return 0x10000 + ((high - 0xD800) << 10) + (low - 0xDC00);
  }

  std::uint32_t four_digits() {
    const std::string_view digits = text_.substr(at_ + 2, 4);
    std::uint32_t result = 0;
    const auto [last, status] = std::from_chars(digits.data(), digits.data() + digits.size(), result, 16);
    if (status != std::errc() || last != digits.data() + 4) stop("expected four hexadecimal digits after '\\u'");
    advance(6);
    return result;
  }

  Node container(Node::Kind kind) const {
    Node node;
    node.kind = kind;
    node.origin = here();
    node.folder = folder_;
    return node;
  }

  Node object(const std::string& pointer, int depth) {
    Node node = container(Node::Kind::object);
    advance();
    skip_blank();
    while (peek() != '}') {
      if (peek() != '"') stop("expected a key in double quotes or '}', found " + found() + opened(node));
      member(node, pointer, depth);
      separator(node, '}');
    }
    advance();
    return node;
  }

  void member(Node& node, const std::string& pointer, int depth) {
    const Origin key_origin = here();
    std::string key = string();
    skip_blank();
    if (peek() != ':') stop("expected ':' after the key " + in_quotes(key) + ", found " + found());
    advance();
    skip_blank();
    const std::string child = join_pointer(pointer, key);
    Node child_value = value(child, depth + 1);
    if (const Member* first = node.find(key)) {
      diagnostics_.error("B002", key_origin, child,
                         "duplicate key " + in_quotes(key) + "; it already stands at " + place_text(first->key_origin));
      return;
    }
    node.members.push_back({std::move(key), key_origin, std::move(child_value)});
  }

  Node array(const std::string& pointer, int depth) {
    Node node = container(Node::Kind::array);
    advance();
    skip_blank();
    while (peek() != ']') {
      node.elements.push_back(value(join_pointer(pointer, node.elements.size()), depth + 1));
      separator(node, ']');
    }
    advance();
    return node;
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
      diagnostics_.error("B001", after_value, "", wanted + found());
      return;
    }
    const Origin comma = here();
    advance();
    skip_blank();
    if (peek() != close) return;
    diagnostics_.error("B001", comma, "", std::string("trailing comma before '") + close + "'; delete it");
  }

  std::string opened(const Node& node) const {
    if (at_ < text_.size() || !mode_.places) return {};
    return std::string("; '") + (node.kind == Node::Kind::object ? '{' : '[') + "' was opened at " +
           place_text(node.origin);
  }

  std::string_view text_;
  const std::string& file_name_;
  std::shared_ptr<const std::filesystem::path> folder_;
  Mode mode_;
  Diagnostics& diagnostics_;
  std::size_t at_ = 0;
  int line_ = 1;
  int column_ = 1;
};

}  // namespace

std::optional<Node> read_json(std::string_view text, const std::string& file_name,
                              std::shared_ptr<const std::filesystem::path> folder, Diagnostics& diagnostics) {
  return JsonReader(text, file_name, std::move(folder), {.comments = true, .places = true}, diagnostics).read();
}

std::optional<Node> read_json_value(std::string_view text, const std::string& origin_name,
                                    std::shared_ptr<const std::filesystem::path> folder) {
  Diagnostics problems;
  std::optional<Node> node =
      JsonReader(text, origin_name, std::move(folder), {.comments = false, .places = false}, problems).read();
  return problems.empty() ? node : std::nullopt;
}

bool is_utf8(std::string_view text) {
  for (std::size_t at = 0; at < text.size();) {
    const auto first = static_cast<unsigned char>(text[at]);
    const std::size_t size = first < 0x80   ? 1
                             : first < 0xC2 ? 0
                             : first < 0xE0 ? 2
                             : first < 0xF0 ? 3
                             : first < 0xF5 ? 4
                                            : 0;
    if (size == 0 || at + size > text.size()) return false;
    for (std::size_t i = 1; i < size; ++i) {
      if (!is_continuation(text[at + i])) return false;
    }
    if (size > 2) {  // overlong forms, surrogates and what lies beyond U+10FFFF (RFC 3629, section 4)
      const auto second = static_cast<unsigned char>(text[at + 1]);
      if ((first == 0xE0 && second < 0xA0) || (first == 0xED && second > 0x9F) || (first == 0xF0 && second < 0x90) ||
          (first == 0xF4 && second > 0x8F)) {
        return false;
      }
    }
    at += size;
  }
  return true;
}

}  // namespace binnacle::config
