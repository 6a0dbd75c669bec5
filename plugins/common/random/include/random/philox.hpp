// SPDX-License-Identifier: Apache-2.0
// The random engine, from where it is public.
#pragma once

#include "binnacle/random.hpp"
