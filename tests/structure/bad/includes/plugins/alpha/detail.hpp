// SPDX-License-Identifier: Apache-2.0
// A header of the plugin's own.
