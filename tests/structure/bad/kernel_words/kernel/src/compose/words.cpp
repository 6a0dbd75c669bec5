// SPDX-License-Identifier: Apache-2.0
const char* section = "/study/variants";   // bad
const char* kind = "attitude";             // bad
bool is_plain(const char* family);
bool plain = is_plain("vector");           // bad
const char* place = "/covariance/outputs"; // bad
const char* key = "covariance";
std::vector<double> numbers;
