// SPDX-License-Identifier: Apache-2.0
// A target over files, without libFuzzer: `replay_NAME FILE|FOLDER …`. Fails where one takes more than two seconds of the
// processor (a sanitizer's factor on top), and says which; a crash is the test's own failure.
#include <algorithm>
#include <cstdio>
#include <ctime>
#include <filesystem>
#include <fstream>
#include <sstream>
#include <string>
#include <vector>

#include "target.hpp"

namespace {

namespace fs = std::filesystem;

std::vector<fs::path> files_of(int count, char** arguments) {
  std::vector<fs::path> files;
  for (int i = 1; i < count; ++i) {
    const fs::path path = arguments[i];
    if (!fs::is_directory(path)) {
      files.push_back(path);
      continue;
    }
    for (const auto& entry : fs::directory_iterator(path))
      if (entry.is_regular_file()) files.push_back(entry.path());
  }
  std::sort(files.begin(), files.end());
  return files;
}

}  // namespace

int main(int count, char** arguments) {
  const auto files = files_of(count, arguments);
  int slow = 0;
  for (const fs::path& file : files) {
    std::ostringstream bytes;
    bytes << std::ifstream(file, std::ios::binary).rdbuf();
    std::printf("%s\n", file.c_str());
    std::fflush(stdout);  // so that the last line names the file that crashes
    const std::clock_t begin = std::clock();
    binnacle::fuzz::try_bytes(bytes.str());
    const double took = static_cast<double>(std::clock() - begin) / CLOCKS_PER_SEC;
    if (took <= 2.0 * BINNACLE_SANITIZER_FACTOR) continue;
    std::printf("%s: took %.1f s\n", file.c_str(), took);
    ++slow;
  }
  std::printf("%zu inputs, %d too slow\n", files.size(), slow);
  return files.empty() || slow > 0 ? 1 : 0;
}
