// SPDX-License-Identifier: Apache-2.0  // bad
#include <string>

namespace other_test { // bad
} // bad
