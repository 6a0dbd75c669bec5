// SPDX-License-Identifier: Apache-2.0
// What is laid out as .clang-format says is no offence.
int sum(int a, int b) { return a + b; }
int difference(int a,int b) { return a - b; }  // bad
int* pointer = nullptr;
int *other = nullptr;  // bad
