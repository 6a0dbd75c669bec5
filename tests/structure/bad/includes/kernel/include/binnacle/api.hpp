// SPDX-License-Identifier: Apache-2.0
// A public header that reaches into the kernel's own.
#include <vector>
#include <Eigen/Core>
#include "binnacle/other.hpp"
#include "filter/engine.hpp"  // bad
