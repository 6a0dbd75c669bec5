// SPDX-License-Identifier: Apache-2.0
#include "dot.hpp"

#include <set>

#include <fmt/format.h>

#include "table.hpp"
#include "text_of.hpp"
#include "wording/wording.hpp"

namespace binnacle::command {

namespace {

/// A double-quoted DOT string; "\n" in it starts a new line.
std::string dot_string(const std::string& text) {
  std::string result = "\"";
  for (const char c : wording::visible(text, "\n")) {
    if (c == '\n') {
      result += "\\n";
      continue;
    }
    if (c == '"' || c == '\\') result += '\\';
    result += c;
  }
  return result + "\"";
}

std::string node(const std::string& id, const std::string& label, const std::string& style) {
  return fmt::format("{} [label={}, {}];\n", dot_string(id), dot_string(label), style);
}

std::string edge(const std::string& from, const std::string& to, const std::string& attributes) {
  return fmt::format("  {} -> {} [{}];\n", dot_string(from), dot_string(to), attributes);
}

std::string two_lines(const Json& component) { return text_of(component, "name") + "\n" + text_of(component, "type"); }

/// RFC 6901.
std::string escaped(const std::string& key) {
  std::string result;
  for (const char c : key) result += c == '~' ? std::string("~0") : c == '/' ? std::string("~1") : std::string(1, c);
  return result;
}

/// The component that a pointer lies in: a stack's part is its measurement, an `init` its block.
std::string owner(const std::string& pointer) {
  const bool is_in_filter = pointer.rfind("/filters/", 0) == 0;
  std::size_t end = 0;
  for (int keys = is_in_filter ? 4 : 2; keys > 0 && end != std::string::npos; --keys) end = pointer.find('/', end + 1);
  return pointer.substr(0, end);
}

// ---- a filter

class FilterGraph {
 public:
  explicit FilterGraph(const Json& filter) : filter_(filter), root_("/filters/" + escaped(text_of(filter, "name"))) {
    for (const auto& derived : filter.at("derived")) derived_.insert(text_of(derived, "name"));
  }

  std::string cluster(int index, bool is_heard) const {
    std::string text = fmt::format("  subgraph cluster_{} {{\n    label={};\n    style=rounded;\n", index,
                                   dot_string("filter " + text_of(filter_, "name")));
    for (const auto& block : filter_.at("blocks"))
      text +=
          "    " + node(at("blocks", block), block_label(block), "shape=box, style=\"filled\", fillcolor=\"#dce9f7\"");
    for (const auto& derived : filter_.at("derived"))
      text += "    " + node(at("derived", derived), two_lines(derived), "shape=box, style=\"dashed\"");
    for (const auto& process : filter_.at("process"))
      text += "    " + node(at("process", process), two_lines(process),
                            "shape=ellipse, style=\"filled\", fillcolor=\"#e3f2dc\"");
    for (const auto& measurement : filter_.at("measurements"))
      text += "    " + node(at("measurements", measurement), measurement_label(measurement),
                            "shape=hexagon, style=\"filled\", fillcolor=\"#f7ecd2\"");
    if (is_heard) text += "    " + node(root_, "estimates", "shape=plaintext");
    return text + "  }\n";
  }

  std::string edges() const {
    std::string text;
    for (const auto& derived : filter_.at("derived"))
      for (const auto& read : derived.at("reads")) text += edge(value(read), at("derived", derived), "style=dashed");
    for (const auto& process : filter_.at("process")) {
      for (const auto& block : process.at("advances")) text += edge(at("process", process), value(block), "penwidth=2");
      for (const auto& read : process.at("reads")) text += edge(value(read), at("process", process), "style=dashed");
    }
    for (const auto& measurement : filter_.at("measurements")) {
      std::set<std::string> seen;
      for (const auto& part : measurement.at("parts"))
        for (const auto& read : part.at("reads"))
          if (seen.insert(read).second)
            text += edge(at("measurements", measurement), value(read), "dir=both, arrowtail=none, color=\"#8a6d1f\"");
    }
    return text;
  }

 private:
  std::string at(const char* place, const Json& component) const {
    return root_ + "/" + place + "/" + escaped(text_of(component, "name"));
  }
  std::string value(const std::string& name) const {
    return root_ + (derived_.contains(name) ? "/derived/" : "/blocks/") + escaped(name);
  }
  static std::string block_label(const Json& block) {
    std::size_t rows = 0;
    for (const auto& component : block.at("components")) rows += component.contains("row") ? 1 : 0;
    return fmt::format("{}\n{} of {}", two_lines(block), rows, counted(block.at("components").size(), "row"));
  }
  static std::string measurement_label(const Json& measurement) {
    std::string label = text_of(measurement, "name");
    for (const auto& part : measurement.at("parts")) label += "\n" + text_of(part, "type");
    return label;
  }

  const Json& filter_;
  std::string root_;
  std::set<std::string> derived_;
};

// ---- channels

bool hears_filter(const Json& channels, const std::string& pointer) {
  for (const auto& channel : channels)
    if (text_of(channel, "from") == pointer && !channel.at("subscribers").empty()) return true;
  return false;
}

std::string channel_edges(const Json& channels, std::set<std::string>& unnamed) {
  std::string text;
  for (const auto& channel : channels) {
    std::set<std::string> seen;
    for (const auto& pointer : channel.at("subscribers")) {
      const std::string to = owner(pointer.get<std::string>());
      if (!seen.insert(to).second) continue;
      if (to == "/reference" || to.rfind("/sinks/", 0) == 0) unnamed.insert(to);
      text +=
          edge(owner(text_of(channel, "from")), to, "color=\"#30557f\", label=" + dot_string(text_of(channel, "name")));
    }
  }
  return text;
}

}  // namespace

std::string dot_text(const Json& explained) {
  std::string text =
      "digraph binnacle {\n  rankdir=LR;\n  node [fontname=\"sans-serif\", fontsize=10];\n"
      "  edge [fontname=\"sans-serif\", fontsize=9];\n";
  if (const std::string title = text_of(explained, "title"); !title.empty())
    text += "  label=" + dot_string(wording::visible(title)) + ";\n  labelloc=t;\n";
  for (const auto& source : explained.at("sources"))
    text += "  " + node("/sources/" + escaped(text_of(source, "name")), two_lines(source), "shape=cylinder");
  for (const auto& transform : explained.at("transforms"))
    text += "  " + node("/transforms/" + escaped(text_of(transform, "name")), two_lines(transform), "shape=cds");
  std::string edges;
  int index = 0;
  for (const auto& filter : explained.at("filters")) {
    const FilterGraph graph(filter);
    const std::string pointer = "/filters/" + escaped(text_of(filter, "name"));
    text += graph.cluster(index++, hears_filter(explained.at("channels"), pointer));
    edges += graph.edges();
  }
  std::set<std::string> unnamed;
  edges += channel_edges(explained.at("channels"), unnamed);
  for (const auto& id : unnamed) text += "  " + node(id, id.substr(id.rfind('/') + 1), "shape=note");
  return text + edges + "}\n";
}

}  // namespace binnacle::command
