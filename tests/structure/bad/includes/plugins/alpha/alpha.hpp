// SPDX-License-Identifier: Apache-2.0
// A plugin, well behaved but for three lines.
#include <zlib.h>
#include "binnacle/api.hpp"
#include "detail.hpp"
#include "alpha/detail.hpp"
#include "math/vector.hpp"
#include "../beta/beta.hpp"      // bad
#include "beta/beta.hpp"         // bad
#include "filter/engine.hpp"     // bad
