// SPDX-License-Identifier: Apache-2.0
// The kernel reaches out.
#include "filter/engine.hpp"
#include "../filter/engine.hpp"
#include <nlohmann/json.hpp>
#include <boost/dll.hpp>
#include <sys/stat.h>
#include "../../../plugins/alpha/alpha.hpp"  // bad
#include "alpha/alpha.hpp"                   // bad
#include <math/vector.hpp>                   // bad
#include "sdk/command/verbs.hpp"             // bad
  #  include "command/verbs.hpp"             // bad
#include <fmt/format.h>                      // bad
