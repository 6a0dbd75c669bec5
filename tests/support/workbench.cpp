// SPDX-License-Identifier: Apache-2.0
#include "workbench.hpp"

#include <cstdlib>
#include <fstream>
#include <iterator>
#include <stdexcept>

#include <zlib.h>

namespace binnacle::test {

namespace fs = std::filesystem;

const char* const good_config = R"~({
  "binnacle": 1,
  "title": "A place that wanders",
  "sources": {
    "fix": { "type": "csv", "path": "fix.csv", "columns": { "z0": { "column": "place", "unit": "m" } } },
    "truth": { "type": "csv", "path": "truth.csv", "columns": { "x": { "column": "place", "unit": "m" } } }
  },
  "filters": {
    "walk": {
      "blocks": {
        "place": { "type": "vector", "size": 1, "unit": "m", "init": { "x": "0 m" }, "sigma": "1 m" }
      },
      "process": {
        "wander": { "type": "random_walk", "blocks": { "x": "place" }, "q": "0.1 m/sqrt(s)" }
      },
      "measurements": {
        "seen": {
          "type": "linear_measurement", "channel": "fix", "blocks": { "x": "place" }, "sigma": ["0.1 m"], "gate": 0.999
        }
      }
    }
  },
  "reference": [ { "channel": "truth", "blocks": { "walk/place": ["x"] } } ],
  "evaluate": { "windows": { "early": ["0 s", "2 s"], "late": ["2 s", "4 s"] } }
}
)~";

std::string read_file(const fs::path& path) {
  std::ifstream file(path, std::ios::binary);
  if (!file) throw std::runtime_error("cannot read " + path.string());
  return {std::istreambuf_iterator<char>(file), {}};
}

Workbench::Workbench() {
  std::string name = (fs::canonical(fs::temp_directory_path()) / "binnacle-XXXXXX").string();
  if (!mkdtemp(name.data())) throw std::runtime_error("no temporary folder");
  folder_ = name;
  write("good.json", good_config);
  write("fix.csv", "t,place\n0,0.1\n1,0.2\n2,0.15\n3,0.3\n4,0.25\n");
  write("truth.csv", "t,place\n1,0.2\n2,0.2\n4,0.3\n");
}

Workbench::~Workbench() {
  std::error_code ignored;
  fs::remove_all(folder_, ignored);
  for (const char* stream : {"stdout", "stderr"}) fs::remove(beside(stream), ignored);
}

void Workbench::write(const std::string& name, const std::string& text) const {
  std::ofstream(folder_ / name, std::ios::binary) << text;
}

void Workbench::write_gzip(const std::string& name, const std::string& text) const {
  const gzFile file = gzopen(path(name).c_str(), "wb");
  gzwrite(file, text.data(), static_cast<unsigned>(text.size()));
  gzclose(file);
}

void Workbench::spoil(const std::string& from, const std::string& to) const {
  std::string text = good_config;
  const auto at = text.find(from);
  if (at == std::string::npos) throw std::logic_error("the good config has no " + from);
  write("bad.json", text.replace(at, from.size(), to));
}

}  // namespace binnacle::test
