// SPDX-License-Identifier: Apache-2.0
// "${name}" in the texts of a config, from its "vars" and from --var.
#include "config/variables.hpp"

#include <algorithm>
#include <cstddef>
#include <optional>
#include <set>
#include <string_view>
#include <utility>
#include <vector>

#include "base/text.hpp"
#include "config/json_reader.hpp"
#include "config/pointer.hpp"

namespace binnacle::config {

namespace {

const Origin command_line{"--var", 0, 0};

using base::in_quotes;

bool is_name(std::string_view text) {
  return !text.empty() && std::all_of(text.begin(), text.end(), [](char c) { return base::is_word(c, "_-."); });
}

class Variables {
 public:
  Variables(const Node& root, Diagnostics& diagnostics) : diagnostics_(diagnostics) {
    if (const Member* vars = root.find("vars")) declare(vars->value);
  }

  void take(const std::map<std::string, std::string>& given, const Folder& folder) {
    for (const auto& [name, text] : given) {
      if (!is_name(name) || !is_utf8(text)) {
        diagnostics_.error("B029", command_line, "", in_quotes("--var " + name) + " does not read name=value");
        continue;
      }
      const Member* declared = declared_.find(name);
      std::optional<Node> number;
      if (declared && declared->value.json.is_number()) number = read_json_value(text, "--var", folder);
      const bool is_number = number && number->json.is_number();
      given_.emplace(name, is_number ? *std::move(number) : Node{text, command_line, folder});
      if (declared) used_.insert(name);
    }
  }

  /// What --var gives is taken as it is, and stands under "vars" with the rest, so that the resolved config says
  /// everything that it was made of.
  void fill_in_all(Node& root) {
    Member* vars = root.find("vars");
    for (const auto& [name, value] : given_)
      if (Member* member = vars ? vars->value.find(name) : nullptr) member->value = Node{};
    fill_in(root, "");
    for (const auto& [name, value] : given_) {
      if (!used_.contains(name)) continue;
      if (!root.find("vars"))
        root.members.push_back({"vars", command_line, {Json::object(), command_line, value.folder}});
      Node& all = root.find("vars")->value;
      if (Member* member = all.find(name))
        member->value = value;
      else if (all.json.is_object())
        all.members.push_back({name, command_line, value});
    }
  }

  void check_given() {
    for (const auto& [name, value] : given_) {
      if (used_.contains(name)) continue;
      diagnostics_.error("B029", command_line, "", "the config has no variable " + in_quotes(name) + suggestion(name));
    }
  }

 private:
  void declare(const Node& vars) {
    if (!vars.json.is_object()) {
      report("B006", vars, "/vars", "expected an object, found " + kind_name(vars));
      return;
    }
    declared_ = vars;
    for (const Member& member : vars.members) {
      if (member.value.json.is_string() || member.value.json.is_number()) continue;
      report("B006", member.value, join_pointer("/vars", member.key),
             "expected a text or a number, found " + kind_name(member.value));
    }
  }

  void fill_in(Node& node, const std::string& pointer) {
    if (node.json.is_string()) {
      const Origin origin = node.origin;
      node = filled(node, pointer);
      node.origin = origin;
    }
    for (std::size_t i = 0; i < node.elements.size(); ++i) fill_in(node.elements[i], join_pointer(pointer, i));
    for (Member& member : node.members) fill_in(member.value, join_pointer(pointer, member.key));
  }

  const Node* variable(const std::string& name) const {
    if (const auto found = given_.find(name); found != given_.end()) return &found->second;
    const Member* member = declared_.find(name);
    return member ? &member->value : nullptr;
  }

  std::string suggestion(const std::string& name) const { return base::suggestion(name, declared_.keys()); }

  void report(const char* code, const Node& node, const std::string& pointer, std::string message) {
    diagnostics_.error(code, node.origin, pointer, std::move(message));
  }

  Node filled(const Node& node, const std::string& pointer) {
    const std::string text = node.json.get<std::string>();
    Node result = node;
    std::string output;
    for (std::size_t at = 0; at < text.size();) {
      if (text.compare(at, 3, "$${") == 0) {
        output += "${";
        at += 3;
        continue;
      }
      if (text.compare(at, 2, "${") != 0) {
        output += text[at++];
        continue;
      }
      const std::size_t close = text.find('}', at);
      const std::string name = text.substr(at + 2, close == std::string::npos ? close : close - at - 2);
      if (close == std::string::npos || !is_name(name)) {
        report("B005", node, pointer, in_quotes(text) + ": expected '${name}'; a literal '${' is written '$${'");
        return node;
      }
      std::optional<Node> value = value_of(name, node, pointer);
      if (!value) return node;
      if (at == 0) result.folder = value->folder;
      if (at == 0 && close + 1 == text.size()) return *std::move(value);
      output += value->json.is_string() ? value->json.get<std::string>() : value->json.dump();
      at = close + 1;
    }
    result.json = output;
    return result;
  }

  /// Filled in itself: a variable may be made of others.
  std::optional<Node> value_of(const std::string& name, const Node& user, const std::string& pointer) {
    const Node* declared = variable(name);
    if (!declared) {
      const std::string remedy = suggestion(name);
      report("B005", user, pointer,
             "unknown variable " + in_quotes(name) +
                 (remedy.empty() ? "; define it under /vars or give --var " + name + "=VALUE" : remedy));
      return std::nullopt;
    }
    used_.insert(name);
    if (const auto first = std::find(open_.begin(), open_.end(), name); first != open_.end()) {
      std::string chain;
      for (auto open = first; open != open_.end(); ++open) chain += *open + " -> ";
      report("B005", user, pointer, "variables form a cycle: " + chain + name);
      return std::nullopt;
    }
    if (declared->json.is_number()) return *declared;
    if (!declared->json.is_string()) return std::nullopt;  // reported by declare
    open_.push_back(name);
    Node value = given_.contains(name) ? *declared : filled(*declared, join_pointer("/vars", name));
    open_.pop_back();
    return value;
  }

  Node declared_;
  Diagnostics& diagnostics_;
  std::map<std::string, Node> given_;
  std::set<std::string> used_;
  std::vector<std::string> open_;
};

}  // namespace

void fill_in_variables(Node& root, const std::map<std::string, std::string>& given, const Folder& current_folder,
                       Diagnostics& diagnostics) {
  Variables variables(root, diagnostics);
  variables.take(given, current_folder);
  variables.fill_in_all(root);
  variables.check_given();
}

}  // namespace binnacle::config
