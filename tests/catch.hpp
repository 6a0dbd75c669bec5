// SPDX-License-Identifier: Apache-2.0
// Catch2 v2 (Debian 12) or v3 (Debian 13), whichever is installed, and the names that differ.
#pragma once

#if __has_include(<catch2/catch_all.hpp>)
#include <catch2/catch_all.hpp>

using Catch::Approx;
namespace binnacle::test {
inline auto Contains(const std::string& text) { return Catch::Matchers::ContainsSubstring(text); }
}  // namespace binnacle::test
#else
#define CATCH_CONFIG_FAST_COMPILE  // an exception in REQUIRE is reported with its case, not with its expression
#include <catch2/catch.hpp>

namespace binnacle::test {
using Catch::Matchers::Contains;
}  // namespace binnacle::test
#endif
