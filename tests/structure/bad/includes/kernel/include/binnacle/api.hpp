// SPDX-License-Identifier: Apache-2.0
// A public header that reaches into the kernel's own.
#include <Eigen/Core>
#include <vector>
#include "binnacle/other.hpp"
#include "filter/engine.hpp"  // bad
