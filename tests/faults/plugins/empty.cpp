// SPDX-License-Identifier: Apache-2.0
// Nothing: stands for a library that lacks what is looked for in it.
