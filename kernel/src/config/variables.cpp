// SPDX-License-Identifier: Apache-2.0
// "${name}" in the texts of a config, from its "vars" and from --var.
#include <algorithm>
#include <set>
#include <utility>

#include "base/text.hpp"
#include "config/node.hpp"

namespace binnacle::internal::config {

namespace {

const Origin var_option{"--var", 0, 0};

using base::in_quotes;

bool is_name(std::string_view text) {
  return !text.empty() && std::ranges::all_of(text, [](char c) { return base::is_word(c, "_-."); });
}

class Variables {
 public:
  explicit Variables(Diagnostics& diagnostics) : diagnostics_(diagnostics) {}

  void declare(const Node& vars) {
    if (!vars.json.is_object()) return report("B006", vars, "/vars", "expected an object, found " + kind_name(vars));
    declared_ = vars;
    for (const auto& [name, origin, value] : vars.children)
      if (!value.json.is_string() && !value.json.is_number())
        report("B006", value, join_pointer("/vars", name), "expected a text or a number, found " + kind_name(value));
  }

  void give(const std::string& name, const std::string& text, const Folder& folder) {
    if (!is_name(name) || !is_utf8(text))
      return diagnostics_.error("B029", var_option, "", in_quotes("--var " + name) + " is not name=value");
    const Member* declared = declared_.find(name);
    std::optional<Node> number;
    if (declared && declared->value.json.is_number()) number = read_json_value(text, var_option.file, folder);
    const bool is_number = number && number->json.is_number();
    given_.emplace(name, is_number ? *std::move(number) : Node{text, var_option, folder});
    if (declared) used_.insert(name);
  }

  /// What --var gives is taken as it is, and stands under "vars" with the rest, so that the resolved config says
  /// everything that it was made of.
  void fill_in_all(Node& root) {
    Member* vars = root.find("vars");
    for (const auto& [name, value] : given_)
      if (Member* member = vars ? vars->value.find(name) : nullptr) member->value = Node{};
    fill_in(root, "");
    for (const auto& [name, value] : given_) {
      if (!used_.contains(name)) {
        diagnostics_.error("B029", var_option, "", "the config has no variable " + in_quotes(name) + suggestion(name));
        continue;
      }
      if (!vars) {
        root.children.push_back({"vars", var_option, {Json::object(), var_option, value.folder}});
        vars = &root.children.back();
      }
      if (Member* member = vars->value.find(name))
        member->value = value;
      else if (vars->value.json.is_object())
        vars->value.children.push_back({name, var_option, value});
    }
  }

 private:
  void fill_in(Node& node, const std::string& pointer) {
    if (node.json.is_string()) {
      const Origin origin = node.origin;
      node = filled(node, pointer);
      node.origin = origin;
    }
    for (Member& child : node.children) fill_in(child.value, join_pointer(pointer, child.key));
  }

  std::string suggestion(const std::string& name) {
    constexpr int most = 20;  // of thousands of errors the first ones will do
    return ++suggestions_ > most ? std::string() : base::suggestion(name, declared_.keys());
  }

  void report(const char* code, const Node& node, const std::string& pointer, std::string message) {
    diagnostics_.error(code, node.origin, pointer, std::move(message));
  }

  Node filled(const Node& node, const std::string& pointer) {
    const std::string text = node.json.get<std::string>();
    Node result = node;
    std::string output;
    for (std::size_t at = 0; at < text.size();) {
      const bool is_literal = text.compare(at, 3, "$${") == 0;
      if (is_literal || text.compare(at, 2, "${") != 0) {
        output += is_literal ? "${" : text.substr(at, 1);
        at += is_literal ? 3 : 1;
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
      if (!has_room_for(*value, node, pointer)) return node;
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
    const auto given = given_.find(name);
    const Member* declared = declared_.find(name);
    if (given == given_.end() && !declared) {
      const std::string remedy = suggestion(name);
      report("B005", user, pointer,
             "unknown variable " + in_quotes(name) +
                 (remedy.empty() ? "; define it under /vars or give --var " + name + "=VALUE" : remedy));
      return std::nullopt;
    }
    used_.insert(name);
    if (given != given_.end()) return given->second;
    if (const auto known = filled_.find(name); known != filled_.end()) return known->second;
    if (const auto first = std::ranges::find(open_, name); first != open_.end()) {
      std::string chain;
      for (auto open = first; open != open_.end(); ++open) chain += *open + " -> ";
      report("B005", user, pointer, "variables form a cycle: " + chain + name);
      return std::nullopt;
    }
    const Node& value = declared->value;
    if (value.json.is_number()) return value;
    if (!value.json.is_string()) return std::nullopt;  // reported by declare
    if (open_.size() >= deepest_chain) {
      report(too_large, user, pointer,
             "a chain of more than " + std::to_string(deepest_chain) + " variables that are made of others");
      return std::nullopt;
    }
    open_.push_back(name);
    Node result = filled(value, join_pointer("/vars", name));
    open_.pop_back();
    filled_.emplace(name, result);
    return result;
  }

  /// Variables that multiply must not fill the memory. Reported once.
  bool has_room_for(const Node& value, const Node& user, const std::string& pointer) {
    if (bytes_ > most_bytes) return false;
    bytes_ += value.json.is_string() ? value.json.get_ref<const std::string&>().size() : sizeof(double);
    if (bytes_ <= most_bytes) return true;
    report(too_large, user, pointer,
           "the texts that are made of variables have more than " + std::to_string(most_bytes >> 20U) + " MiB");
    return false;
  }

  Node declared_;
  Diagnostics& diagnostics_;
  std::map<std::string, Node> given_;
  std::map<std::string, Node> filled_;  // those made of others, once each
  std::size_t bytes_ = 0;               // that variables gave to texts
  int suggestions_ = 0;
  std::set<std::string> used_;
  std::vector<std::string> open_;
};

}  // namespace

void fill_in_variables(Node& root, const std::map<std::string, std::string>& given, const Folder& current_folder,
                       Diagnostics& diagnostics) {
  Variables variables(diagnostics);
  if (const Member* vars = root.find("vars")) variables.declare(vars->value);
  for (const auto& [name, text] : given) variables.give(name, text, current_folder);
  variables.fill_in_all(root);
}

}  // namespace binnacle::internal::config
