// SPDX-License-Identifier: Apache-2.0
// Resolves `extends`: what a file or an object inside it inherits from others.
#include <algorithm>
#include <cerrno>
#include <cstring>
#include <span>
#include <utility>
#include <vector>

#include <unistd.h>

#include "base/open_file.hpp"
#include "base/text.hpp"
#include "config/node.hpp"

namespace binnacle::internal::config {

namespace fs = std::filesystem;

namespace {

using base::in_quotes;

/// A file's text, or why it cannot be read and the code of that.
struct Slurped {
  std::string text;
  std::string problem = {};
  const char* code = "B003";
};

std::string mebibytes(std::size_t bytes) { return std::to_string(bytes >> 20U) + " MiB"; }

/// `is_main`: the config itself, which may also come through a pipe: /dev/stdin, <(…).
Slurped slurp(const fs::path& path, bool is_main) {
  const base::OpenFile file(path, is_main);
  if (!file.failure.empty()) return {"", file.failure};
  if (S_ISDIR(file.status.st_mode)) return {"", "it is a folder"};
  if (!S_ISREG(file.status.st_mode) && !is_main)
    return {"", "it is not a regular file; copy its contents to a regular file and name that"};
  std::string text;
  std::vector<char> piece(std::size_t{1} << 16);
  while (text.size() <= most_bytes) {
    const ssize_t count = ::read(file.id, piece.data(), piece.size());
    if (count < 0 && errno == EINTR) continue;
    if (count < 0) return {"", std::strerror(errno)};
    if (count == 0) return {std::move(text)};
    text.append(piece.data(), static_cast<std::size_t>(count));
  }
  return {"", "it has more than " + mebibytes(most_bytes), too_large};
}

std::optional<Node> merged(std::optional<Node> base, std::optional<Node> over) {
  if (!base) return over;
  if (over) merge_patch(*base, *std::move(over));
  return base;
}

std::string with_pointer(const std::string& file, const std::string& pointer) {
  return pointer.empty() ? file : file + "#" + pointer;
}

std::size_t node_count(const Node& node) {
  std::size_t count = 1;
  for (const Member& child : node.children) count += node_count(child.value);
  return count;
}

class Extends {
 public:
  explicit Extends(Diagnostics& diagnostics) : diagnostics_(diagnostics) {}

  std::optional<Node> resolve(const fs::path& path, std::optional<std::string_view> text) {
    const File& main = file(path, text, {{path.lexically_normal().string(), 0, 0}, ""});
    return main.content ? std::optional(whole({main, *main.content, ""})) : std::nullopt;
  }

 private:
  using Path = std::span<const std::string>;

  /// A file as it stands, before any `extends`.
  struct File {
    std::string name;             // as shown in messages: relative if the config was named so
    std::optional<Node> content;  // nothing if it cannot be read
  };
  struct Place {
    const File& file;
    const Node& node;
    std::string pointer;
    Place child(const Member& member) const { return {file, member.value, join_pointer(pointer, member.key)}; }
  };
  /// What stands at a place; it hides what the place inherits if it lies inside a list or replaces an object.
  struct Found {
    std::optional<Node> node;
    bool hides = false;
  };
  /// One of the calls within each other, however deep values and `extends` are nested.
  struct Level {
    explicit Level(std::size_t& depth) : of(depth) { ++of; }
    Level(const Level&) = delete;
    Level& operator=(const Level&) = delete;
    ~Level() { --of; }
    std::size_t& of;
  };
  static constexpr std::size_t deepest_level = 1500;

  struct Statement {
    Origin origin;
    std::string pointer;         // where it stands in its file
    const Node* node = nullptr;  // its text
    std::string from = {};       // "a.json#/filters/b"
    std::string to = {};
  };

  void report(const Statement& by, const std::string& message, const char* code = "B004") {
    diagnostics_.error(code, by.origin, by.pointer, message);
  }

  const File& file(const fs::path& path, std::optional<std::string_view> text, const Statement& by) {
    const fs::path name = path.lexically_normal();
    const fs::path absolute = fs::absolute(name).lexically_normal();
    const auto [entry, is_new] = files_.try_emplace(absolute, File{name.string(), std::nullopt});
    File& file = entry->second;
    if (!is_new) return file;
    const auto [read, problem, code] = text ? Slurped{std::string(*text)} : slurp(name, files_.size() == 1);
    if (!problem.empty()) {
      report(by, "cannot read " + in_quotes(file.name) + ": " + problem, code);
      return file;
    }
    bytes_ += read.size();
    if (bytes_ > most_bytes) {
      report(by, "the config and what it extends have more than " + mebibytes(most_bytes), too_large);
      return file;
    }
    file.content = read_json(read, file.name, std::make_shared<const fs::path>(absolute.parent_path()), diagnostics_);
    if (file.content && !file.content->json.is_object()) {
      diagnostics_.error("B006", file.content->origin, "", "a config is an object, found " + kind_name(*file.content));
      file.content.reset();
    }
    return file;
  }

  Node whole(const Place& place) {
    const Level level(depth_);
    Node own{place.node.json, place.node.origin, place.node.folder};
    for (const Member& member : place.node.children)
      if (member.key != "extends") own.children.push_back({member.key, member.key_origin, whole(place.child(member))});
    return *merged(inherited(place, {}), std::move(own));
  }

  Found at(const Place& place, Path path) {
    const Level level(depth_);
    const bool is_object = place.node.json.is_object();
    if (path.empty()) return {whole(place), !is_object};
    std::optional<Node> result = inherited(place, path);
    const Member* member = path.front() == "extends" ? nullptr : place.node.find(path.front());
    if (!member) return {std::move(result), !is_object};
    Found own = at(place.child(*member), path.subspan(1));
    if (own.hides) return own;
    return {merged(std::move(result), std::move(own.node)), !is_object};
  }

  /// What the place gets from others at the path below it.
  std::optional<Node> inherited(const Place& place, Path path) {
    const Member* extends = place.node.find("extends");
    if (!extends || extends->value.json.is_null()) return std::nullopt;
    std::optional<Node> result;
    const auto take = [&](const Node& text) {
      Statement statement{text.origin, join_pointer(place.pointer, "extends"), &text};
      if (!text.json.is_string())
        return report(statement, "expected a file name or a list of file names, found " + kind_name(text));
      Found layer = base(place, std::move(statement), path);
      if (layer.hides) result.reset();
      result = merged(std::move(result), std::move(layer.node));
    };
    if (extends->value.json.is_array()) {
      for (const Member& element : extends->value.children) take(element.value);
    } else {
      take(extends->value);
    }
    return result;
  }

  Found base(const Place& place, Statement statement, Path path) {
    const std::string& name = place.file.name;
    const auto text = statement.node->json.get<std::string>();
    const std::size_t hash = text.find('#');
    const std::string file_text = text.substr(0, hash);
    const std::string fragment = hash == std::string::npos ? "" : text.substr(hash + 1);
    auto tokens = split_pointer(fragment);
    if (text.empty() || !tokens) {
      const std::string remedy = tokens ? "" : "; what follows '#' is a JSON pointer, '#/filters/ins' say";
      report(statement, in_quotes(text) + " names no file" + remedy);
      return {};
    }
    const fs::path target = file_text.empty() ? fs::path(name) : fs::path(name).parent_path() / file_text;
    statement.from = with_pointer(name, place.pointer);
    statement.to = with_pointer(target.lexically_normal().string(), fragment);
    if (const auto first = std::ranges::find(open_, statement.node, &Statement::node); first != open_.end()) {
      std::string chain = first->from;
      for (auto open = first; open != open_.end(); ++open) chain += " -> " + open->to;
      report(statement, "extends forms a cycle: " + chain);
      return {};
    }
    if (open_.size() >= deepest_chain || depth_ > deepest_level) {
      report(statement, "a chain of more than " + std::to_string(deepest_chain) + " extends", too_large);
      return {};
    }
    if (++followed_ > most_extends) {
      if (followed_ == most_extends + 1)
        report(statement, "more than " + std::to_string(most_extends) + " extends are to be followed", too_large);
      return {};
    }
    open_.push_back(statement);
    const File& other = file(target, std::nullopt, statement);
    Found found;
    if (other.content && copied_ < most_values) {
      const Place root{other, *other.content, ""};
      tokens->insert(tokens->end(), path.begin(), path.end());
      found = at(root, *tokens);
      if (found.node) copied_ += node_count(*found.node);
      if (copied_ >= most_values) report(statement, "extends multiplies without end", too_large);
      if (path.empty() && !is_object(found, root, *tokens, statement)) found = {};
    }
    open_.pop_back();
    return found;
  }

  /// Reports what a statement leads to, unless it is an object.
  bool is_object(const Found& found, const Place& root, Path path, const Statement& statement) {
    if (found.node && found.node->json.is_object()) return true;
    if (found.node && !found.node->json.is_null()) {
      report(statement, in_quotes(statement.to) + " is " + kind_name(*found.node) + ", not an object");
      return false;
    }
    const Path parent = path.first(path.size() - 1);
    const Found around = at(root, parent);
    const std::string meant = around.node ? closest(path.back(), around.node->keys()) : "";
    std::string pointer;
    for (const std::string& token : parent) pointer = join_pointer(pointer, token);
    report(statement, "there is no " + in_quotes(statement.to) +
                          (meant.empty() ? "" : "; did you mean '#" + join_pointer(pointer, meant) + "'?"));
    return false;
  }

  Diagnostics& diagnostics_;
  std::map<fs::path, File> files_;  // by absolute names
  std::vector<Statement> open_;
  std::size_t copied_ = 0;    // values
  std::size_t followed_ = 0;  // extends
  std::size_t bytes_ = 0;     // of all files
  std::size_t depth_ = 0;
};

}  // namespace

std::optional<Node> resolve_extends(const fs::path& path, std::optional<std::string_view> text,
                                    Diagnostics& diagnostics) {
  return Extends(diagnostics).resolve(path, text);
}

}  // namespace binnacle::internal::config
