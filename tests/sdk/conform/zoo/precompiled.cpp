// SPDX-License-Identifier: Apache-2.0
// Stands for all animals where their common header is compiled ahead.
#include "animal.hpp"
