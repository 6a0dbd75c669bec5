// SPDX-License-Identifier: Apache-2.0
// The WGS-84 earth under the name that the strapdown library and those who use it know.
#pragma once

#include "binnacle/geodesy.hpp"

namespace binnacle::strapdown {

using namespace geodesy;

}  // namespace binnacle::strapdown
