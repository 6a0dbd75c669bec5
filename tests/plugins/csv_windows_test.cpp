// SPDX-License-Identifier: Apache-2.0
// A csv file in pieces: whatever the windows, the blocks and what stays in memory, the same samples, warnings and faults.
#include <algorithm>
#include <bit>
#include <charconv>
#include <cmath>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <random>
#include <string>
#include <thread>
#include <vector>

#include "../recorded_data.hpp"
#include "catch.hpp"
#include "csv/gaps.hpp"
#include "csv/plain_rows.hpp"
#include "csv_files.hpp"
#include "text/text_file.hpp"

namespace csv_windows_test {

using namespace binnacle;
using namespace binnacle::csv_files;
using csv::Limits;

namespace {

using Random = std::mt19937_64;

std::size_t below(Random& random, std::size_t count) { return static_cast<std::size_t>(random() % count); }

/// Small ones; nothing stays in memory.
Limits pieces(std::size_t window, std::size_t block) { return {window, block, 0, 2}; }

/// All that a sample is, to the bit.
std::string text_of(const binnacle::testing::Emitted& sample) {
  std::string text = std::to_string(sample.t) + " " + std::to_string(sample.t0) + " " + std::to_string(sample.rows);
  for (const auto* numbers : {&sample.fields, &sample.row_fields})
    for (const double value : *numbers) text += " " + std::to_string(std::bit_cast<std::uint64_t>(value));
  return text;
}

struct Reading {
  std::vector<std::string> samples;
  std::string said;  // warnings, then the fault

  bool operator==(const Reading&) const = default;
};

Reading outcome_of(const Json& value, const Limits& limits = {}) {
  Reading outcome;
  Warnings warnings;
  try {
    const auto bound = binnacle::testing::bind<CsvSource>({value}, limits);
    CsvSource& source = *bound;
    source.open(warnings);
    const binnacle::testing::SourceCaller caller(source);
    auto memory = caller.fresh_memory(1);
    for (auto next = caller.next(memory.data()); next.status == SourceStatus::sample; next = caller.next(memory.data()))
      outcome.samples.push_back(text_of(next.sample));
  } catch (const ComponentError& error) {
    outcome.said = error.code() + " " + std::to_string(error.line()) + " " + error.what();
  }
  for (const auto& each : warnings.all)
    outcome.said += each.code + " " + std::to_string(each.line) + " " + each.message + "\n";
  return outcome;
}

void require_same(const Json& value, const std::string& content) {
  const Reading whole = outcome_of(value);
  INFO(content << "\nwhole: " << whole.said);
  for (const std::size_t window : {1U, 2U, 3U, 5U, 8U, 13U, 31U, 64U, 200U})
    for (const std::size_t block : {1U, 150U, 1000U}) {
      INFO("windows of " << window << ", blocks of " << block);
      const Reading in_pieces = outcome_of(value, pieces(window, block));
      REQUIRE(in_pieces.said == whole.said);
      REQUIRE(in_pieces.samples == whole.samples);
    }
}

/// A cell that is a number, in one of the ways that they are written.
std::string number(Random& random) {
  std::string text = random() % 3 == 0 ? "-" : "";
  const auto digits = [&](std::size_t most) {
    for (std::size_t i = 0, count = below(random, most); i < count; ++i)
      text += static_cast<char>('0' + below(random, 10));
  };
  text += static_cast<char>('0' + below(random, 10));
  digits(random() % 8 == 0 ? 20 : 4);
  if (random() % 4 != 0) {
    text += '.';
    digits(random() % 4 == 0 ? 22 : 10);
  }
  if (random() % 5 == 0)
    text += (random() % 2 ? "e" : "E") + std::string(random() % 2 ? "-" : "") + std::to_string(below(random, 30));
  return text;
}

/// A row that is somehow other than the others.
std::string odd_row(Random& random, const std::string& time) {
  switch (below(random, 14)) {
    case 0: return "";
    case 1: return "# a comment, with a \" in it";
    case 2: return "  \t";
    case 3: return time + ",\"1,5\",2,x";
    case 4: return time + ", 1.5 ,\t-2 ,x";
    case 5: return "\"" + time + "\",1,2,\"a \"\"b\"\" c\"";
    case 6: return time + ",1,2";
    case 7: return time + ",1,2,x,y";
    case 8: return time + ",nan,2,x";
    case 9: return time + ",,2,x";
    case 10: return time + ",1e999,2,x";
    case 11: return "0.5,1,2,x";
    case 12: return time + ",-9999,2,x";
    default: return time + ",+1.5,.5,\"\"";
  }
}

/// Some thirty rows of time, two numbers and a text; odd rows are faults, too, where there may be some.
std::string some_rows(Random& random, bool may_be_odd) {
  const std::string end = random() % 2 ? "\r\n" : "\n";
  std::string text = random() % 3 == 0 ? "\xEF\xBB\xBF" : "";
  text += "t,w,a,note" + end;
  double t = 1;
  for (std::size_t i = 0, count = below(random, 40); i < count; ++i) {
    t += random() % 12 == 0 ? 1.5 : 0.01 * static_cast<double>(1 + below(random, random() % 2 ? 1 : 5));
    char time[40];
    std::snprintf(time, sizeof time, random() % 5 ? "%.2f" : "%.12f", t);
    if (may_be_odd && random() % 6 == 0)
      text += odd_row(random, time) + end;
    else
      text += std::string(time) + "," + number(random) + "," + number(random) + ",some text" + end;
  }
  if (random() % 3 == 0 && text.size() > end.size()) text.resize(text.size() - end.size());
  return text;
}

Json layout(Random& random, const std::string& path, bool may_skip) {
  auto value = parameters(path, {{"w", with_member(column("w", unit("rad/s", random() % 2 ? 1 : 0.1),
                                                          random() % 3 ? "rate" : "increment"),
                                                   "missing", Json::array({"-9999", ""}))},
                                 {"a", column("a", unit("m"))},
                                 {"again", column("a", unit("m"))}});
  if (random() % 4 == 0) value = with_member(value, "columns", object({{"a", column("a", unit("m"))}}));
  if (random() % 3 == 0) value = with_member(value, "every", static_cast<int>(1 + below(random, 6)));
  if (random() % 4 == 0) value = with_member(value, "max_gap", 0.5);
  if (random() % 4 == 0) value = with_member(value, "window", Json::array({1.1, 2}));
  if (may_skip && random() % 3 != 0) value = with_member(value, "invalid_rows", "skip");
  return value;
}

}  // namespace

TEST_CASE("csv: the same outcome by windows and blocks of any size") {
  Random random(22);
  for (int i = 0; i < 60; ++i) {
    const bool may_be_odd = i % 2;
    const std::string content = some_rows(random, may_be_odd);
    const TemporaryFile file(content);
    require_same(layout(random, file.path(), may_be_odd), content);
  }
}

TEST_CASE("csv: plain rows are what rows of quoted cells are, cell by cell") {
  Random random(23);
  std::size_t samples = 0;
  for (int i = 0; i < 400; ++i) {
    const std::string content = some_rows(random, i % 2);
    std::string with_quotes;
    std::size_t begin = 0;
    while (begin < content.size()) {
      std::size_t end = content.find('\n', begin);
      if (end == content.npos) end = content.size();
      std::string line = content.substr(begin, end - begin);
      const std::size_t note = line.find(",some text");
      if (note != line.npos) line = line.substr(0, note) + ",\"some text\"" + (line.back() == '\r' ? "\r" : "");
      with_quotes += line + (end < content.size() ? "\n" : "");
      begin = end + 1;
    }
    const TemporaryFile plain(content), odd(with_quotes);
    Random same = random;
    const Reading of_plain = outcome_of(layout(random, plain.path(), true));
    const Reading of_odd = outcome_of(layout(same, odd.path(), true));
    INFO(content << "\n" << of_plain.said << "\n" << of_odd.said);
    REQUIRE(of_plain == of_odd);
    samples += of_plain.samples.size();
  }
  REQUIRE(samples > 2000);
}

TEST_CASE("csv: a plain number is the nearest double, or is left to others") {
  Random random(24);
  std::size_t converted = 0;
  for (int i = 0; i < 200000; ++i) {
    const std::string cell = number(random);
    std::string bytes = cell + "," + std::string(8, '7');
    csv::PlainNumber plain;
    const char* const end = plain.scan(bytes.data());
    double value = 0;
    if (!end || !plain.convert(value)) continue;
    INFO(cell);
    REQUIRE(*end == ',');
    REQUIRE(std::bit_cast<std::uint64_t>(value) == std::bit_cast<std::uint64_t>(std::strtod(cell.c_str(), nullptr)));
    ++converted;
  }
  REQUIRE(converted > 100000);
}

TEST_CASE("csv: rows of one sample across windows and blocks") {
  Random random(25);
  for (int i = 0; i < 30; ++i) {
    std::string content = "t,key,a\n";
    double t = 1;
    for (int k = 0; k < 15; ++k) {
      t += static_cast<double>(below(random, 3));
      for (std::size_t r = 0, count = below(random, 5); r < count; ++r)
        content += std::to_string(t) + "," + (random() % 15 ? std::to_string(r) : "0") + "," + number(random) + "\n";
    }
    const TemporaryFile file(content);
    auto value = parameters(file.path(), {{"key", column("key")}, {"a", column("a")}});
    value = with_member(value, "rows", object({{"key", "key"}, {"max_rows", 6}}));
    if (random() % 2) value = with_member(value, "invalid_rows", "skip");
    if (random() % 3 == 0) value = with_member(value, "every", 2);
    require_same(value, content);
  }
}

TEST_CASE("csv: gzip by windows, in members and damaged, as the plain file") {
  Random random(26);
  std::string content = "t,w,a,note\n";
  for (int i = 0; i < 60000; ++i)
    content += std::to_string(0.01 * i) + "," + number(random) + "," + number(random) + ",some text\n";
  const TemporaryFile plain(content);
  const std::size_t cut = content.size() / 3;
  const std::string packed = gzipped(content.substr(0, cut)) + gzipped(content.substr(cut));
  const TemporaryFile file(packed, "data.csv.gz");
  const Reading whole = outcome_of(rate_and_level(plain.path()));
  REQUIRE(whole.samples.size() == 60000);
  REQUIRE(outcome_of(rate_and_level(file.path())) == whole);
  REQUIRE(outcome_of(rate_and_level(file.path()), {1000, 20000, 0, 2}) == whole);

  const TemporaryFile cut_off(packed.substr(0, packed.size() - 1000), "data.csv.gz");
  const std::string fault = outcome_of(rate_and_level(cut_off.path())).said;
  REQUIRE(fault.starts_with("B061 0 gzip data are cut off at byte " + std::to_string(packed.size() - 1000) + "; "));
  REQUIRE(outcome_of(rate_and_level(cut_off.path()), {1000, 20000, 0, 2}).said == fault);
}

TEST_CASE("csv: samples are read again from anywhere, by several threads") {
  Random random(27);
  std::string content = "t,w,a,note\n";
  for (int i = 0; i < 30000; ++i)
    content += std::to_string(0.01 * i) + "," + number(random) + "," + number(random) + ",some text\n";
  const bool is_packed = GENERATE(false, true);
  const int every = GENERATE(1, 7);
  const TemporaryFile file(is_packed ? gzipped(content) : content, "data.csv");
  const auto value = with_member(rate_and_level(file.path()), "every", every);
  const Reading whole = outcome_of(value);
  const auto bound = binnacle::testing::bind<CsvSource>({value}, Limits{3000, 10000, 40000, 2});
  CsvSource& source = *bound;
  Warnings warnings;
  source.open(warnings);
  const binnacle::testing::SourceCaller caller(source);
  const auto read_in_jumps = [&](std::uint64_t seed, bool& is_same) {
    Random own(seed);
    for (int jump = 0; jump < 25; ++jump) {
      auto memory = caller.fresh_memory(1);
      const std::uint64_t start = below(own, whole.samples.size());
      std::memcpy(memory.data(), &start, sizeof start);
      for (std::size_t i = start; i < std::min<std::size_t>(start + 300, whole.samples.size()); ++i)
        is_same &= text_of(caller.next(memory.data()).sample) == whole.samples[i];
    }
  };
  bool same[4] = {true, true, true, true};
  std::vector<std::thread> threads;
  for (std::uint64_t i = 0; i < 4; ++i) threads.emplace_back([&, i] { read_in_jumps(i, same[i]); });
  for (auto& thread : threads) thread.join();
  for (const bool each : same) REQUIRE(each);
}

TEST_CASE("csv: a file that has changed since it was opened is a fault") {
  std::string content = "t,w,a\n";
  for (int i = 0; i < 2000; ++i) content += std::to_string(i) + ",1,2\n";
  const TemporaryFile file(content);
  const auto bound = binnacle::testing::bind<CsvSource>({rate_and_level(file.path())}, pieces(100, 1000));
  CsvSource& source = *bound;
  Warnings warnings;
  source.open(warnings);
  content[content.rfind("1,2")] = '3';
  std::ofstream(file.path(), std::ios::binary) << content;
  std::uint64_t next = 0;
  double fields[2] = {};
  SampleWriter writer;
  writer.fields = fields;
  writer.field_count = 2;
  SourceOutput out(&writer);
  const MemoryView memory(reinterpret_cast<std::byte*>(&next));
  try {
    while (source.next(memory, out) == SourceStatus::sample) continue;
    FAIL("nothing was said");
  } catch (const ComponentError& error) {
    REQUIRE(error.code() == "B061");
    REQUIRE(error.line() > 1900);
    REQUIRE(std::string(error.what()) == "the file has changed since it was opened: it has other rows now");
  }
}

TEST_CASE("csv: a reader that is left early leaves no thread behind") {
  const auto threads = [] {
    return std::distance(std::filesystem::directory_iterator("/proc/self/task"), std::filesystem::directory_iterator());
  };
  std::string content;
  for (int i = 0; i < 1'000'000; ++i) content += "0,1,2\n";
  const TemporaryFile file(gzipped(content), "data.csv.gz");
#ifdef __SANITIZE_THREAD__
  std::thread([] {}).join();  // with the first, the sanitizer starts one of its own, for good
  while (threads() > 2) std::this_thread::yield();
#endif
  const auto before = threads();
  for (const int lines : {1, 50000, 200000}) {
    text_file::LineReader reader(file.path());
    std::string_view line;
    for (int i = 0; i < lines; ++i) REQUIRE(reader.next(line));
    REQUIRE(threads() == before + (lines == 1 ? 0 : 1));
  }
  REQUIRE(threads() == before);
}

TEST_CASE("csv: the median step is exact, however many lengths there are") {
  Random random(28);
  for (int i = 0; i < 200; ++i) {
    std::vector<Time> lengths(1 + below(random, 300));
    const Time scale = Time{1} << below(random, 50);
    for (Time& each : lengths)
      each = 1 + static_cast<Time>(below(random, static_cast<std::size_t>(scale) * (random() % 2 ? 1 : 3)));
    const auto pass = [&](const csv::StepVisitor& visit) {
      for (const Time each : lengths) visit({0, each, 0});
    };
    auto sorted = lengths;
    std::ranges::sort(sorted);
    for (const std::size_t most : {1U, 2U, 40U, 1000U}) {
      csv::StepCounts counts(most);
      for (const Time each : lengths) counts.add({0, each, 0});
      REQUIRE(counts.median(pass) == sorted[sorted.size() / 2]);
    }
  }
}

TEST_CASE("csv: recorded drives by windows as in memory", "[data]") {
  const auto drives = test::recorded_data("drives");
  if (!drives) return;
  std::size_t samples = 0;
  for (const auto& folder : std::filesystem::directory_iterator(*drives)) {
    const auto imu = folder.path() / "imu.csv.gz";
    if (!std::filesystem::exists(imu)) continue;
    const auto rate = [](const char* name) { return column(name, unit("1"), "rate"); };
    auto value = parameters(imu.string(), {{"wx", rate("gx_radps")}, {"fz", rate("az_mps2")}});
    value = with_member(value, "time", object({{"column", "t_s"}, {"unit", unit("s")}}));
    const Reading whole = outcome_of(value);
    INFO(imu << whole.said);
    REQUIRE(whole.samples.size() > 1000);
    REQUIRE(outcome_of(value, {70000, 50000, 0, 100}) == whole);
    samples += whole.samples.size();
  }
  REQUIRE(samples > 10000);
}

}  // namespace csv_windows_test
