// SPDX-License-Identifier: Apache-2.0
// A plugin, well behaved but for three lines.
#include <zlib.h>
#include "../beta/beta.hpp"  // bad
#include "alpha/detail.hpp"
#include "beta/beta.hpp"  // bad
#include "binnacle/api.hpp"
#include "detail.hpp"
#include "filter/engine.hpp"  // bad
#include "math/vector.hpp"
