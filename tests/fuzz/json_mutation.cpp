// SPDX-License-Identifier: Apache-2.0
// JSON that stays JSON: values replaced by hostile ones, keys dropped, renamed, doubled, parts moved to other places.
#include <algorithm>
#include <iterator>
#include <random>
#include <string>
#include <vector>

#include <nlohmann/json.hpp>

#include "target.hpp"

namespace binnacle::fuzz {

namespace {

using Json = nlohmann::ordered_json;

class Mutation {
 public:
  Mutation(Json& root, unsigned seed) : root_(root), random_(seed) {}

  void apply() {
    for (std::size_t changes = 1 + below(4); changes > 0; --changes) {
      std::vector<Json*> nodes;
      collect(root_, nodes);
      change(*nodes[below(nodes.size())], nodes);
    }
  }

 private:
  std::size_t below(std::size_t limit) { return random_() % limit; }

  static void collect(Json& node, std::vector<Json*>& nodes) {
    nodes.push_back(&node);
    if (node.is_structured())
      for (Json& child : node) collect(child, nodes);
  }

  void change(Json& node, const std::vector<Json*>& nodes) {
    switch (below(8)) {
      case 0:
      case 1: node = hostile(); break;
      case 2: node = Json(*nodes[below(nodes.size())]); break;
      case 3: erase(node); break;
      case 4: rename(node, nodes); break;
      case 5: insert(node, *nodes[below(nodes.size())]); break;
      case 6: scale(node); break;
      default: {
        const Json other = *nodes[below(nodes.size())];
        if (node.is_structured() && !node.empty()) *std::next(node.begin(), at(node)) = other;
      }
    }
  }

  std::ptrdiff_t at(const Json& node) { return static_cast<std::ptrdiff_t>(below(node.size())); }

  void erase(Json& node) {
    if (!node.is_structured() || node.empty()) return;
    if (below(4) == 0)
      node.clear();
    else
      node.erase(std::next(node.begin(), at(node)));
  }
  void rename(Json& node, const std::vector<Json*>& nodes) {
    if (!node.is_object() || node.empty()) return;
    const Json& other = *nodes[below(nodes.size())];
    if (!other.is_object() || other.empty()) return;
    const std::string name = std::next(other.begin(), at(other)).key();
    const auto place = std::next(node.begin(), at(node));
    const Json value = place.value();
    node.erase(place);
    node[name] = value;
  }
  void insert(Json& node, const Json& part) {
    const Json copy = part;
    if (node.is_array()) node.push_back(copy);
    if (node.is_object()) node["key" + std::to_string(below(4))] = copy;
  }
  void scale(Json& node) {
    static constexpr double factors[] = {-1, 1e-3, 1e3, 1e-9, 1e9, 0.5, 2};
    if (node.is_number()) node = node.get<double>() * factors[below(std::size(factors))];
    if (node.is_string()) {
      auto text = node.get<std::string>();
      const std::size_t first = text.find_first_not_of("0123456789.-+eE");
      node = std::to_string(factors[below(std::size(factors))]) + (first == text.npos ? "" : text.substr(first));
    }
  }
  Json hostile() {
    static const Json values[] = {nullptr,
                                  true,
                                  false,
                                  0,
                                  1,
                                  -1,
                                  -0.0,
                                  1e-300,
                                  1e300,
                                  -1e18,
                                  2147483648LL,
                                  9223372036854775807LL,
                                  Json(18446744073709551615ULL),
                                  0.9999,
                                  "",
                                  "start",
                                  "1e9 s",
                                  "-1 s",
                                  "0 Hz",
                                  "1e12 Hz",
                                  "NaN",
                                  "1e309 m",
                                  "5 furlong",
                                  "${x}",
                                  "a/b",
                                  "/",
                                  "\u0001",
                                  std::string(300, 'x'),
                                  Json::array(),
                                  Json::object(),
                                  Json::array({1, 2, 3}),
                                  Json::array({Json::array({1})})};
    return values[below(std::size(values))];
  }

  Json& root_;
  std::mt19937 random_;
};

}  // namespace

std::size_t mutate(std::string_view bytes, unsigned seed, char* out, std::size_t capacity) {
  if (seed % 8 == 0) return 0;  // the reader of JSON is a target too
  Json root = Json::parse(bytes, nullptr, false, true);
  if (root.is_discarded()) return 0;
  Mutation(root, seed).apply();
  const std::string made = root.dump(-1, ' ', false, Json::error_handler_t::replace);
  if (made.size() > capacity) return 0;
  std::copy(made.begin(), made.end(), out);
  return made.size();
}

}  // namespace binnacle::fuzz
