// SPDX-License-Identifier: Apache-2.0
#include "target.hpp"

namespace binnacle::fuzz {

std::size_t mutate(std::string_view, unsigned, char*, std::size_t) { return 0; }

}  // namespace binnacle::fuzz
