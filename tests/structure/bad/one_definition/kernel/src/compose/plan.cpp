// SPDX-License-Identifier: Apache-2.0
#include <vector>
namespace binnacle {
struct Node {
  int kind = 0;
  int index = 0;
};
int last(const std::vector<Node>& nodes) { return nodes.back().index; }
}  // namespace binnacle
