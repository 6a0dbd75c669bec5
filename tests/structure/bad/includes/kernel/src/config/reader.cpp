// SPDX-License-Identifier: Apache-2.0
// The kernel reaches out.
#include <fmt/format.h>  // bad
#include <sys/stat.h>
#include <boost/dll.hpp>
#include <math/vector.hpp>  // bad
#include <nlohmann/json.hpp>
#include "../../../plugins/alpha/alpha.hpp"  // bad
#include "../filter/engine.hpp"  // bad
#include "alpha/alpha.hpp"    // bad
#include "command/verbs.hpp"  // bad
#include "filter/engine.hpp"  // bad
#include "sdk/command/verbs.hpp"  // bad
