// SPDX-License-Identifier: Apache-2.0
// Resolves `extends`: what a file or an object inside it inherits from others.
#pragma once

#include <cstddef>
#include <filesystem>
#include <map>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "binnacle/diagnostic.hpp"
#include "config/node.hpp"

namespace binnacle::config {

/// A file as it stands, before any `extends`.
struct ConfigFile {
  std::string name;             ///< as shown in messages: relative if the config was named so
  std::optional<Node> content;  ///< nothing if it cannot be read
};

/// An object that extends "other.json#/a/b" is what resolving other.json gives at /a/b, merged over by the
/// object. Only what is asked for is resolved, so one part of a file may extend another part of the same
/// file.
class Extends {
 public:
  explicit Extends(Diagnostics& diagnostics) : diagnostics_(diagnostics) {}

  /// The file with everything that it extends; deleted members are still there as null. With `text` given,
  /// that is read instead of the file.
  std::optional<Node> resolve(const std::filesystem::path& path, const std::string_view* text = nullptr);

 private:
  using Tokens = std::span<const std::string>;

  /// What stands at a place; it hides what the place inherits if it lies inside a list or replaces an object.
  struct Found {
    std::optional<Node> node;
    bool hides = false;
  };
  struct Statement {
    const Node* node;     ///< the text of the `extends`
    std::string pointer;  ///< where that stands in its file
    std::string from;     ///< "a.json#/filters/b"
    std::string to;
  };

  const ConfigFile& file(const std::filesystem::path& path, const std::string_view* text, const Statement* by);
  Found at(const ConfigFile& file, const Node& node, const std::string& pointer, Tokens path);
  Node whole(const ConfigFile& file, const Node& node, const std::string& pointer);
  std::optional<Node> inherited(const ConfigFile& file, const Node& node, const std::string& pointer, Tokens path);
  Found base(const ConfigFile& file, const Node& statement, const std::string& pointer, Tokens path);
  std::vector<const Node*> statements(const Node& node, const std::string& pointer);
  bool is_cycle(const Statement& statement);
  void report_missing(const ConfigFile& file, const std::vector<std::string>& tokens, const Statement& statement);

  Diagnostics& diagnostics_;
  std::map<std::filesystem::path, std::unique_ptr<ConfigFile>> files_;
  std::vector<Statement> open_;
  std::size_t copied_ = 0;
};

}  // namespace binnacle::config
