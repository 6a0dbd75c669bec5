// SPDX-License-Identifier: Apache-2.0
// Stands for all faulty plugins where their common header is compiled ahead.
#include "faulty.hpp"
