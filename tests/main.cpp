// SPDX-License-Identifier: Apache-2.0
// The entry point of a test executable under Catch2 v2; v3 brings its own.
#if !__has_include(<catch2/catch_all.hpp>)
#define CATCH_CONFIG_MAIN
#endif
#include "catch.hpp"
