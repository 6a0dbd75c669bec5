// SPDX-License-Identifier: Apache-2.0
// The names of one file are seen by the next.
#include <string>

#define SHARED 1 // bad

using namespace std; // bad

namespace beta_test {

using namespace std;

namespace {
int helper() { return 1; }
}  // namespace

}  // namespace beta_test

namespace { // bad
int other() { return 2; } // bad
} // bad
