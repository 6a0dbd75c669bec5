// SPDX-License-Identifier: Apache-2.0
// JSON pointers and ratios are no paths.
const char* pointer = "/filters/work/tmp";
const char* drive = "/@home/somebody/drive.csv";  // bad
