// SPDX-License-Identifier: Apache-2.0
// A target over inputs, without libFuzzer: `replay_NAME FILE|FOLDER|ARCHIVE.tar …`; an archive is one of tests/fuzz/run.
// Fails where one takes more than two seconds of the processor (a sanitizer's factor on top), and says which; a crash is the
// test's own failure.
#include <algorithm>
#include <cstdio>
#include <ctime>
#include <filesystem>
#include <fstream>
#include <sstream>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include "target.hpp"

namespace {

namespace fs = std::filesystem;

struct Input {
  std::string name, bytes;
};

std::string contents_of(const fs::path& file) {
  std::ostringstream bytes;
  bytes << std::ifstream(file, std::ios::binary).rdbuf();
  return bytes.str();
}

/// The files of a ustar archive (POSIX.1, pax): blocks of 512 bytes, a head and then the content of each, zeros at the end.
std::vector<Input> inputs_in(const fs::path& archive) {
  constexpr std::size_t block = 512, size_at = 124, type_at = 156, magic_at = 257;
  const std::string bytes = contents_of(archive);
  std::vector<Input> inputs;
  std::size_t at = 0;
  for (; at + block <= bytes.size() && bytes[at] != '\0'; at += block) {
    const std::string head = bytes.substr(at, block);
    if (head.compare(magic_at, 5, "ustar") != 0 || head[type_at] != '0') break;
    const std::size_t size = std::stoul(head.substr(size_at, 11), nullptr, 8);
    if (size > bytes.size() - at - block) break;
    inputs.push_back({archive.string() + ":" + head.c_str(), bytes.substr(at + block, size)});
    at += (size + block - 1) / block * block;
  }
  // After the last one come zeros to the end, at least two blocks.
  if (at + 2 * block <= bytes.size() && bytes.find_first_not_of('\0', at) == bytes.npos) return inputs;
  throw std::runtime_error(archive.string() + " is damaged");
}

std::vector<Input> inputs_of(int count, char** arguments) {
  std::vector<Input> inputs;
  const auto add = [&](const fs::path& file) { inputs.push_back({file.string(), contents_of(file)}); };
  for (int i = 1; i < count; ++i) {
    const fs::path path = arguments[i];
    if (fs::is_directory(path)) {
      for (const auto& entry : fs::directory_iterator(path))
        if (entry.is_regular_file()) add(entry.path());
    } else if (path.extension() == ".tar") {
      for (Input& input : inputs_in(path)) inputs.push_back(std::move(input));
    } else {
      add(path);
    }
  }
  std::sort(inputs.begin(), inputs.end(), [](const Input& a, const Input& b) { return a.name < b.name; });
  return inputs;
}

}  // namespace

int main(int count, char** arguments) {
  const auto inputs = inputs_of(count, arguments);
  int slow = 0;
  for (const auto& [name, bytes] : inputs) {
    std::printf("%s\n", name.c_str());
    std::fflush(stdout);  // so that the last line names the input that crashes
    const std::clock_t begin = std::clock();
    binnacle::fuzz::try_bytes(bytes);
    const double took = static_cast<double>(std::clock() - begin) / CLOCKS_PER_SEC;
    if (took <= 2.0 * BINNACLE_SANITIZER_FACTOR) continue;
    std::printf("%s: took %.1f s\n", name.c_str(), took);
    ++slow;
  }
  std::printf("%zu inputs, %d too slow\n", inputs.size(), slow);
  return inputs.empty() || slow > 0 ? 1 : 0;
}
