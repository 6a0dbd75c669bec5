// SPDX-License-Identifier: Apache-2.0
#include <vector>
namespace binnacle {
struct Node {
  std::vector<Node> elements;
};
std::size_t count(const std::vector<Node>& nodes) { return nodes.size(); }
}  // namespace binnacle
