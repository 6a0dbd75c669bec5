// SPDX-License-Identifier: Apache-2.0
// A public header.
#include <cstdint>
