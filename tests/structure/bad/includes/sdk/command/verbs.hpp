// SPDX-License-Identifier: Apache-2.0
// The command is a client of the public headers.
#include <CLI/CLI.hpp>
#include "../../kernel/src/filter/engine.hpp"  // bad
#include "alpha/alpha.hpp"                     // bad
#include "binnacle/api.hpp"
#include "filter/engine.hpp"  // bad
#include "math/vector.hpp"
