// SPDX-License-Identifier: Apache-2.0
// A config, read and composed: everything that `binnacle check` does.
#include "../composing.hpp"

void binnacle::fuzz::try_bytes(std::string_view bytes) { composed(bytes); }
