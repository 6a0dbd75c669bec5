// SPDX-License-Identifier: Apache-2.0
#include "study/journal.hpp"

#include <cerrno>
#include <cstdint>
#include <cstdio>
#include <optional>
#include <string>
#include <string_view>
#include <system_error>
#include <utility>

#include <fcntl.h>
#include <sys/file.h>
#include <unistd.h>
#include <nlohmann/json.hpp>

#include "figures_json.hpp"
#include "wording/checksum.hpp"

namespace binnacle::study {

namespace {

using Json = nlohmann::ordered_json;

[[noreturn]] void fail(const std::filesystem::path& path) {
  throw std::filesystem::filesystem_error("journal", path, std::error_code(errno, std::generic_category()));
}

std::string hexadecimal(std::uint64_t value) {
  char text[17];
  std::snprintf(text, sizeof(text), "%016llx", static_cast<unsigned long long>(value));
  return text;
}

std::string checksum(std::string_view text) {
  wording::Checksum sum;
  sum.add(text.data(), text.size());
  return hexadecimal(sum.value());
}

std::string signed_line(const Json& json) {
  const std::string text = line_of(json);
  return text + "\t" + checksum(text) + "\n";
}

/// The JSON of a whole line whose checksum is right.
std::optional<Json> read_line(std::string_view line) {
  const auto tab = line.rfind('\t');
  if (tab == std::string_view::npos || line.substr(tab + 1) != checksum(line.substr(0, tab))) return std::nullopt;
  Json json = Json::parse(line.substr(0, tab), nullptr, false);
  return json.is_discarded() ? std::nullopt : std::optional(std::move(json));
}

Json head_of(const Study& study) {
  return {{"binnacle study", 2}, {"hash", hexadecimal(study.hash())}, {"seed", study.seed()}};
}

[[noreturn]] void refuse(const std::filesystem::path& path, int line, const std::string& message) {
  Diagnostics diagnostics;
  diagnostics.error("B092", Origin{path.string(), line, 0}, "", message);
  throw Error(2, diagnostics);
}

}  // namespace

Journal::Journal(const std::filesystem::path& path, const Study& study, Results& results) : path_(path) {
  file_ = ::open(path.c_str(), O_RDWR | O_CREAT | O_CLOEXEC | O_NONBLOCK, 0666);
  if (file_ < 0) fail(path_);
  try {
    if (!std::filesystem::is_regular_file(path_)) refuse(path_, 0, "it is not a regular file");
    if (::flock(file_, LOCK_EX | LOCK_NB) != 0) refuse(path_, 0, "another study is running in this folder");
    restore(study, results);
  } catch (...) {
    ::close(file_);
    throw;
  }
}

Journal::~Journal() {
  ::fsync(file_);
  ::close(file_);
}

void Journal::restore(const Study& study, Results& results) {
  std::string text;
  char buffer[1 << 16];
  for (ssize_t count; (count = ::read(file_, buffer, sizeof(buffer))) != 0;) {
    if (count < 0 && errno == EINTR) continue;
    if (count < 0) fail(path_);
    text.append(buffer, static_cast<std::size_t>(count));
  }
  const std::string head = signed_line(head_of(study));
  std::size_t good = 0;  // end of the last line that counts
  for (std::size_t at = 0, end; (end = text.find('\n', at)) != std::string::npos; at = end + 1) {
    const auto line = read_line(std::string_view(text).substr(at, end - at));
    if (at == 0) {
      if (!line || !line->is_object() || !line->contains("binnacle study"))
        refuse(path_, 1, "this is not a journal of a study; give another --out, or delete the file");
      if (text.substr(0, end + 1) != head) {
        const bool is_seed = line->value("seed", Json()) != Json(study.seed());
        refuse(path_, 1,
               std::string("this journal is of a study with another ") +
                   (is_seed ? "seed" : "config, program or plugin") +
                   "; give another --out, or delete the file to start again");
      }
      good = end + 1;
      continue;
    }
    if (!line) continue;
    auto entry = read_entry(*line, study.metrics().size());
    if (!entry || entry->first.variant >= study.variants().size()) continue;
    const auto [variant, run] = entry->first;
    good = end + 1;
    if (run >= results.runs()) continue;  // of a study with more runs
    auto& place = results.at(variant, run);
    if (place.state == Figures::State::open) ++restored_;
    place = std::move(entry->second);
  }
  if (::ftruncate(file_, static_cast<off_t>(good)) != 0 || ::lseek(file_, 0, SEEK_END) < 0) fail(path_);
  if (good == 0) write(head);
}

void Journal::write(const std::string& line) {
  for (std::size_t at = 0; at < line.size();) {
    const auto written = ::write(file_, line.data() + at, line.size() - at);
    if (written < 0 && errno == EINTR) continue;
    if (written <= 0) fail(path_);
    at += static_cast<std::size_t>(written);
  }
}

void Journal::add(std::size_t variant, std::size_t run, const Figures& figures) {
  write(signed_line(entry_of({variant, run}, figures)));
  const auto now = std::chrono::steady_clock::now();
  if (now - synced_ < std::chrono::seconds(5)) return;
  sync();
  synced_ = now;
}

void Journal::sync() {
  if (::fsync(file_) != 0 && errno != EINVAL) fail(path_);
}

}  // namespace binnacle::study
