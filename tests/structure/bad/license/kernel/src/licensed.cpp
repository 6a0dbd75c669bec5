// SPDX-License-Identifier: Apache-2.0
// A file with one.
