// SPDX-License-Identifier: Apache-2.0
// What plugins share does not know them.
#include "alpha/alpha.hpp"  // bad
