// SPDX-License-Identifier: Apache-2.0
// Another plugin.
#include "binnacle/api.hpp"
