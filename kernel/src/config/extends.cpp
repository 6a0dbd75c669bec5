// SPDX-License-Identifier: Apache-2.0
// Resolves `extends`: what a file or an object inside it inherits from others.
#include "config/extends.hpp"

#include <cerrno>
#include <cstring>
#include <fstream>
#include <iterator>
#include <system_error>
#include <utility>

#include "base/text.hpp"
#include "config/json_reader.hpp"
#include "config/pointer.hpp"

namespace binnacle::config {

namespace fs = std::filesystem;

namespace {

// A config that doubles itself in a few levels must not fill the memory.
constexpr std::size_t most_values = 1'000'000;

using base::in_quotes;

/// The text, or why it cannot be read.
std::pair<std::string, std::string> slurp(const fs::path& path) {
  std::error_code ignored;
  if (fs::is_directory(path, ignored)) return {"", "it is a folder"};
  errno = 0;
  std::ifstream stream(path, std::ios::binary);
  if (!stream) return {"", std::strerror(errno != 0 ? errno : ENOENT)};
  std::string text{std::istreambuf_iterator<char>(stream), std::istreambuf_iterator<char>()};
  if (stream.bad()) return {"", "reading it fails"};
  return {std::move(text), ""};
}

std::optional<Node> merged(std::optional<Node> base, std::optional<Node> over) {
  if (!base) return over;
  if (over) merge_patch(*base, *std::move(over));
  return base;
}

std::string with_pointer(const std::string& file, const std::string& pointer) {
  return pointer.empty() ? file : file + "#" + pointer;
}

}  // namespace

std::optional<Node> Extends::resolve(const fs::path& path, const std::string_view* text) {
  const ConfigFile& main = file(path, text, nullptr);
  if (!main.content) return std::nullopt;
  return whole(main, *main.content, "");
}

const ConfigFile& Extends::file(const fs::path& path, const std::string_view* text, const Statement* by) {
  const fs::path name = path.lexically_normal();
  std::unique_ptr<ConfigFile>& entry = files_[fs::absolute(name).lexically_normal()];
  if (entry) return *entry;
  entry = std::make_unique<ConfigFile>(ConfigFile{name.string(), std::nullopt});
  std::pair<std::string, std::string> read;
  if (!text) read = slurp(name);
  if (!read.second.empty()) {
    diagnostics_.error("B003", by ? by->node->origin : Origin{entry->name, 0, 0}, by ? by->pointer : "",
                       "cannot read " + in_quotes(entry->name) + ": " + read.second);
    return *entry;
  }
  const auto folder = std::make_shared<const fs::path>(fs::absolute(name).lexically_normal().parent_path());
  entry->content = read_json(text ? *text : read.first, entry->name, folder, diagnostics_);
  if (entry->content && !entry->content->json.is_object()) {
    diagnostics_.error("B006", entry->content->origin, "",
                       "a config is an object, found " + kind_name(*entry->content));
    entry->content.reset();
  }
  return *entry;
}

Node Extends::whole(const ConfigFile& config, const Node& node, const std::string& pointer) {
  Node own{node.json, node.origin, node.folder};
  for (std::size_t i = 0; i < node.elements.size(); ++i)
    own.elements.push_back(whole(config, node.elements[i], join_pointer(pointer, i)));
  for (const Member& member : node.members) {
    if (member.key == "extends") continue;
    own.members.push_back(
        {member.key, member.key_origin, whole(config, member.value, join_pointer(pointer, member.key))});
  }
  return *merged(inherited(config, node, pointer, {}), std::move(own));
}

std::optional<Node> Extends::inherited(const ConfigFile& config, const Node& node, const std::string& pointer,
                                       Tokens path) {
  std::optional<Node> result;
  for (const Node* statement : statements(node, pointer)) {
    Found layer = base(config, *statement, pointer, path);
    if (layer.hides) result.reset();
    result = merged(std::move(result), std::move(layer.node));
  }
  return result;
}

Extends::Found Extends::at(const ConfigFile& config, const Node& node, const std::string& pointer, Tokens path) {
  if (path.empty()) return {whole(config, node, pointer), !node.json.is_object()};
  const std::string child_pointer = join_pointer(pointer, path.front());
  if (!node.json.is_object()) {
    const auto index = index_in(node.elements.size(), path.front());
    if (!index) return {std::nullopt, true};
    return {at(config, node.elements[*index], child_pointer, path.subspan(1)).node, true};
  }
  std::optional<Node> result = inherited(config, node, pointer, path);
  const Member* member = path.front() == "extends" ? nullptr : node.find(path.front());
  if (!member) return {std::move(result), false};
  Found own = at(config, member->value, child_pointer, path.subspan(1));
  if (own.hides) return own;
  return {merged(std::move(result), std::move(own.node)), false};
}

std::vector<const Node*> Extends::statements(const Node& node, const std::string& pointer) {
  const Member* member = node.find("extends");
  if (!member || member->value.json.is_null()) return {};
  std::vector<const Node*> result;
  const auto take = [&](const Node& value) {
    if (value.json.is_string()) {
      result.push_back(&value);
    } else {
      diagnostics_.error("B004", value.origin, join_pointer(pointer, "extends"),
                         "expected a file name or a list of file names, found " + kind_name(value));
    }
  };
  if (!member->value.json.is_array()) take(member->value);
  for (const Node& element : member->value.elements) take(element);
  return result;
}

bool Extends::is_cycle(const Statement& statement) {
  for (std::size_t i = 0; i < open_.size(); ++i) {
    if (open_[i].node != statement.node) continue;
    std::string chain = open_[i].from;
    for (std::size_t j = i; j < open_.size(); ++j) chain += " -> " + open_[j].to;
    diagnostics_.error("B004", statement.node->origin, statement.pointer, "extends forms a cycle: " + chain);
    return true;
  }
  return false;
}

Extends::Found Extends::base(const ConfigFile& config, const Node& statement, const std::string& pointer, Tokens path) {
  const std::string here = join_pointer(pointer, "extends");
  const std::string text = statement.json.get<std::string>();
  const std::size_t hash = text.find('#');
  const std::string file_text = text.substr(0, hash);
  const std::string fragment = hash == std::string::npos ? "" : text.substr(hash + 1);
  const auto tokens = split_pointer(fragment);
  if (text.empty() || !tokens) {
    const std::string remedy = tokens ? "" : "; what follows '#' is a JSON pointer, '#/filters/ins' say";
    diagnostics_.error("B004", statement.origin, here, in_quotes(text) + " names no file" + remedy);
    return {};
  }
  const fs::path target = file_text.empty() ? fs::path(config.name) : fs::path(config.name).parent_path() / file_text;
  const Statement current{&statement, here, with_pointer(config.name, pointer),
                          with_pointer(target.lexically_normal().string(), fragment)};
  if (is_cycle(current)) return {};
  open_.push_back(current);
  const ConfigFile& other = file(target, nullptr, &current);
  Found found;
  if (other.content && copied_ < most_values) {
    std::vector<std::string> whole_path = *tokens;
    whole_path.insert(whole_path.end(), path.begin(), path.end());
    found = at(other, *other.content, "", whole_path);
    if (found.node) copied_ += node_count(*found.node);
    if (copied_ >= most_values) diagnostics_.error("B004", statement.origin, here, "extends multiplies without end");
    const bool is_whole_target = path.empty();
    if (is_whole_target && (!found.node || found.node->json.is_null())) {
      report_missing(other, *tokens, current);
      found = {};
    } else if (is_whole_target && !found.node->json.is_object()) {
      diagnostics_.error("B004", statement.origin, here,
                         in_quotes(current.to) + " is " + kind_name(*found.node) + ", not an object");
      found = {};
    }
  }
  open_.pop_back();
  return found;
}

void Extends::report_missing(const ConfigFile& other, const std::vector<std::string>& tokens,
                             const Statement& statement) {
  std::string message = "there is no " + in_quotes(statement.to);
  const Tokens parent = Tokens(tokens).first(tokens.size() - 1);
  const Found around = at(other, *other.content, "", parent);
  const std::string meant = around.node ? closest(tokens.back(), around.node->keys()) : "";
  if (!meant.empty()) {
    std::string suggestion;
    for (const std::string& token : parent) suggestion = join_pointer(suggestion, token);
    message += "; did you mean '#" + join_pointer(suggestion, meant) + "'?";
  }
  diagnostics_.error("B004", statement.node->origin, statement.pointer, message);
}

}  // namespace binnacle::config
