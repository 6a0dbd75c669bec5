// SPDX-License-Identifier: Apache-2.0
// Leans on the file before it in a batch: no header brings std::string.
std::string name() { return "bad"; }  // bad
