// SPDX-License-Identifier: Apache-2.0
// The command is a client of the public headers.
#include "binnacle/api.hpp"
#include <CLI/CLI.hpp>
#include "filter/engine.hpp"                     // bad
#include "../../kernel/src/filter/engine.hpp"    // bad
#include "alpha/alpha.hpp"                       // bad
