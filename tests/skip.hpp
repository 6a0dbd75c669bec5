// SPDX-License-Identifier: Apache-2.0
// A test that can not run here: ctest shows it as skipped.
#pragma once

#include <string>

namespace binnacle::test {

/// The exit status of a test executable whose tests were all skipped, of those that ran; ctest's SKIP_RETURN_CODE.
inline constexpr int exit_skipped = 77;

/// Counts the running test as skipped, for this reason, unless a check of it failed. Under Catch2 v3 the test ends here;
/// under v2 this returns, and the test does: `return skip("no data");`
void skip(const std::string& reason);

}  // namespace binnacle::test
