// SPDX-License-Identifier: Apache-2.0
// A header of the kernel's own.
#include "binnacle/api.hpp"
