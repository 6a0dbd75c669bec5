// SPDX-License-Identifier: Apache-2.0
#include "linked.hpp"

namespace binnacle::python {

std::vector<std::shared_ptr<const LinkedPlugin>> linked_plugins() { return {}; }

}  // namespace binnacle::python
