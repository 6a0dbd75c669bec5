// SPDX-License-Identifier: Apache-2.0
// Source rinex: what it reads, and what it says of files that are broken.
#include "../../plugins/rinex/rinex_source.hpp"
#include "binnacle/testing.hpp"

#include <unistd.h>

#include <cmath>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <functional>
#include <string>
#include <vector>

#include "../plugins/bind.hpp"
#include "catch.hpp"
#include "gnss/channels.hpp"

namespace rinex_test {

using namespace binnacle;
using namespace binnacle::rinex;
using nlohmann::json;

namespace {

std::string line(const std::string& content, const std::string& label) {
  std::string text = content;
  text.resize(60, ' ');
  return text + label + "\n";
}

std::string printed(const char* format, auto... values) {
  char text[256];
  std::snprintf(text, sizeof text, format, values...);
  return text;
}

/// Blanks between the exponent's letter and its sign are FORTRAN's affair; here it is always D+00.
std::string number(double value) {
  std::string text = printed("%19.12E", value);
  text[text.find('E')] = 'D';
  return text;
}

struct Orbit {
  std::string satellite = "G05";
  double toe = 14400;  // s of the week, on 2021-11-09 (day 2)
  double sent = 7200;  // transmission
  double health = 0;
  double iode = 1;
};
constexpr double tuesday = 2 * 86400.0;

/// A message in the form of version 2 or 3.
std::string message(const Orbit& o, int version) {
  const int toc = static_cast<int>(o.toe);
  std::string text =
      version == 2
          ? o.satellite.substr(1) + printed(" 21 11  9 %2d %2d %4.1f", toc / 3600, toc / 60 % 60, toc % 60 * 1.0)
          : o.satellite + printed(" 2021 11 09 %02d %02d %02d", toc / 3600, toc / 60 % 60, toc % 60);
  text += number(-6.04419e-05) + number(-1.25056e-12) + number(0) + "\n";
  const double orbit[] = {o.iode,
                          -108.5625,
                          4.320894268e-09,
                          2.202212030,
                          -5.707144737e-06,
                          6.0007086722e-03,
                          9.629875422e-06,
                          5153.619016769,
                          tuesday + o.toe,
                          -5.587935448e-09,
                          0.83860246341,
                          -9.685754776e-08,
                          0.95822938409,
                          194.34375,
                          1.015982021,
                          -7.843183840e-09,
                          2.078658013e-10,
                          517,
                          2183,
                          0,
                          2,
                          o.health,
                          -1.117587090e-08,
                          2e-9,
                          tuesday + o.sent,
                          4,
                          0,
                          0};
  for (int i = 0; i < 28; ++i) {
    if (i % 4 == 0) text += version == 2 ? "   " : "    ";
    text += number(orbit[i]);
    if (i % 4 == 3) text += "\n";
  }
  return text;
}

std::string navigation(const std::vector<Orbit>& orbits, int version = 2) {
  std::string text = version == 2
                         ? line("     2.11           N: GPS NAV DATA", "RINEX VERSION / TYPE") +
                               line("    1.1180D-08  1.4900D-08 -5.9600D-08 -5.9600D-08", "ION ALPHA") +
                               line("    8.8060D+04  1.6380D+04 -1.9660D+05 -1.3110D+05", "ION BETA")
                         : line("     3.04           N: GNSS NAV DATA    M: Mixed", "RINEX VERSION / TYPE") +
                               line("GPSA    .1118D-07   .7451D-08  -.5960D-07  -.5960D-07", "IONOSPHERIC CORR") +
                               line("GPSB    .9011D+05   .0000D+00  -.1966D+06  -.6554D+05", "IONOSPHERIC CORR");
  text += line("", "END OF HEADER");
  for (const auto& orbit : orbits) text += message(orbit, version);
  return text;
}

/// An epoch of four satellites 3:30:00 + s; `jump` [m] is added to every pseudorange.
std::string epoch(double s, int version, double jump = 0, int flag = 0) {
  std::string text = version == 2 ? printed(" 21 11  9  3 30%11.7f  %d  4G05G10G13G15", s, flag) + "\n"
                                  : printed("> 2021 11 09 03 30%11.7f  %d  5", s, flag) + "\n";
  for (const int prn : {5, 10, 13, 15}) {
    const double range = 2.2e7 + 1e5 * prn + 100 * s, phase = range / 0.19029367279836;
    std::string cells = printed("%14.3f  %14.3f  %14.3f  ", range + jump, phase, -500.0 + prn);
    if (version == 3) {
      cells += printed("%14.3f  ", 40.0 + prn);
      text += printed("G%02d", prn);
    }
    text += cells + "\n";
  }
  if (version == 3) text += "R01  20000000.000\n";
  return text;
}

std::string observations(int version, const std::vector<std::string>& epochs) {
  std::string text = version == 2 ? line("     2.11           OBSERVATION DATA    G (GPS)", "RINEX VERSION / TYPE") +
                                        line("     3    C1    L1    D1", "# / TYPES OF OBSERV")
                                  : line("     3.04           OBSERVATION DATA    M", "RINEX VERSION / TYPE") +
                                        line("G    4 C1C L1C D1C S1C", "SYS / # / OBS TYPES") +
                                        line("R    1 C1C", "SYS / # / OBS TYPES");
  text += line("", "END OF HEADER");
  for (const auto& e : epochs) text += e;
  return text;
}

class Reports final : public Reporter {
 public:
  void warn(const std::string& code, const std::string& file, int at, const std::string& text) override {
    all += code + " " + std::filesystem::path(file).filename().string() + ":" + std::to_string(at) + " " + text + "\n";
  }
  std::string all;
};

struct Sample {
  int channel;
  double t;
  std::vector<std::vector<double>> rows;
  std::vector<double> fields;
};

/// Two files, read as the kernel does it.
struct Recording {
  std::string reports;
  std::vector<Sample> samples;

  Recording(const std::string& obs, const std::string& nav, json parameters = json::object()) {
    const auto folder = std::filesystem::temp_directory_path() / ("binnacle_rinex_" + std::to_string(::getpid()));
    std::filesystem::create_directories(folder);
    struct Removed {
      std::filesystem::path folder;
      ~Removed() { std::filesystem::remove_all(folder); }
    } removed{folder};
    parameters["week"] = 2183;
    const auto write = [&](const char* key, const char* name, const std::string& text) {
      if (text.empty()) return;
      std::ofstream(folder / name) << text;
      parameters[key] = (folder / name).string();
    };
    write("observations", "site.obs", obs);
    write("navigation", "site.nav", nav);
    const auto source = test::bind<RinexSource>({parameters, {}, {}});
    Reports collected;
    source->open(collected);
    reports = collected.all;
    read(*source);
  }
  std::vector<double> times(int channel) const {
    std::vector<double> list;
    for (const auto& sample : samples)
      if (sample.channel == channel) list.push_back(sample.t - start);
    return list;
  }
  const Sample& first(int channel) const {
    for (const auto& sample : samples)
      if (sample.channel == channel) return sample;
    throw std::logic_error("no sample");
  }
  bool has_reported(const std::string& text) const { return reports.find(text) != std::string::npos; }

  static constexpr double start = tuesday + 3.5 * 3600;

 private:
  void read(const RinexSource& source) {
    const binnacle::testing::SourceCaller caller(source);
    auto memory = caller.fresh_memory(0);
    for (auto next = caller.next(memory.data()); next.status == SourceStatus::sample;
         next = caller.next(memory.data())) {
      REQUIRE(next.damage.empty());
      Sample sample{next.sample.channel, seconds(next.sample.t), {}, next.sample.fields};
      const auto count = static_cast<std::size_t>(next.sample.rows);
      const std::size_t width = count == 0 ? 0 : next.sample.row_fields.size() / count;
      for (std::size_t i = 0; i < count; ++i) {
        const auto begin = next.sample.row_fields.begin() + static_cast<std::ptrdiff_t>(width * i);
        sample.rows.emplace_back(begin, begin + static_cast<std::ptrdiff_t>(width));
      }
      samples.push_back(std::move(sample));
    }
  }
};

enum Channel { obs, eph, iono };
const std::vector<Orbit> four{{"G05"}, {"G10"}, {"G13"}, {"G15"}};

}  // namespace

TEST_CASE("observations and messages of versions 2 and 3") {
  for (const int version : {2, 3}) {
    INFO("version " << version);
    const Recording r(observations(version, {epoch(0, version), epoch(1, version)}), navigation(four, version));
    CHECK(r.reports == (version == 2 ? "" : "B065 site.obs:10 2 observations of GLONASS left out: it is not read\n"));
    REQUIRE(r.times(obs) == std::vector<double>{0, 1});
    REQUIRE(r.times(eph) == std::vector<double>{0});
    REQUIRE(r.times(iono) == std::vector<double>{0});
    CHECK(r.samples.back().channel == obs);  // at one instant the messages come first
    CHECK(r.samples[2].channel == obs);
    const auto& row = r.first(obs).rows.at(1);
    CHECK(r.first(obs).rows.size() == 4);
    CHECK(row[gnss::observation::satellite] == 110);
    CHECK(row[gnss::observation::pseudorange] == 2.3e7);
    CHECK(std::abs(row[gnss::observation::range_rate] - 490 * 0.19029367279836) < 1e-9);  // receding: a negative shift
    CHECK((version == 2 ? std::isnan(row[gnss::observation::cn0]) : row[gnss::observation::cn0] == 50));
    const gnss::Ephemeris e = gnss::read_ephemeris(r.first(eph).rows.at(0).data());
    CHECK(e.satellite == 105);
    CHECK(e.toe == tuesday + 14400);
    CHECK(e.toc == e.toe);
    CHECK(e.crs == -108.5625);
    CHECK(std::abs(e.semi_major_axis - 5153.619016769 * 5153.619016769) < 1e-6);
    CHECK(e.group_delay == -1.117587090e-08);
    CHECK(e.accuracy == 2);
    CHECK(std::abs(r.first(iono).fields[0] - 1.118e-8) < 1e-12);
    CHECK(std::abs(r.first(iono).fields[7] - (version == 2 ? -1.311e5 : -6.554e4)) < 1e-6);
  }
}

TEST_CASE("which message is used: upload time, nearest toe, age, health") {
  const std::string o = observations(2, {epoch(0, 2), epoch(30, 2)});
  const auto issue = [](const Recording& r, std::size_t set) {
    std::vector<double> list;
    std::size_t k = 0;
    for (const auto& sample : r.samples)
      if (sample.channel == eph && k++ == set)
        for (const auto& row : sample.rows) list.push_back(row[gnss::ephemeris_field_count - 1]);
    return list;
  };
  // At 3:30:00 = 12600 s: an older one near in toe, one that comes at 12610 s, one that is superseded.
  const std::vector<Orbit> three{{"G05", 12600, 5000, 0, 1}, {"G05", 12584, 9000, 0, 2}, {"G05", 16000, 12610, 0, 3}};
  {
    const Recording r(o, navigation(three), {{"choose", "upload"}});
    CHECK(r.times(eph) == std::vector<double>{0, 10});
    CHECK(issue(r, 0) == std::vector<double>{2});
    CHECK(issue(r, 1) == std::vector<double>{3});
  }
  {
    const Recording r(o, navigation(three), {{"choose", "nearest_toe"}});
    CHECK(r.times(eph) == std::vector<double>{0});
    CHECK(issue(r, 0) == std::vector<double>{1});
  }
  {
    const Recording r(o, navigation({{"G05", 12600 - 1190, 5000, 0, 1}, {"G05", 12600 + 1215, 5000, 0, 2}}),
                      {{"choose", "nearest_toe"}, {"max_age", 1200}});
    CHECK(issue(r, 0) == std::vector<double>{1});
    REQUIRE(r.times(eph).size() == 3);
    CHECK(std::abs(r.times(eph)[1] - 10 - 1e-9) < 5e-10);  // the first is too old, the second not near enough yet
    CHECK(issue(r, 1).empty());
    CHECK(r.times(eph)[2] == 15);
  }
  {
    const std::vector<Orbit> sick{{"G05", 12600, 5000, 0, 1}, {"G05", 12600, 6000, 63, 2}};
    CHECK(issue(Recording(o, navigation(sick)), 0).empty());
    CHECK(issue(Recording(o, navigation(sick), {{"unhealthy", true}}), 0) == std::vector<double>{2});
  }
}

namespace {

struct Word {
  double sources = 517;  // of data: bits 0 and 2 I/NAV, bit 1 F/NAV; bit 8 the clock of E5a, bit 9 of E5b
  double sent = 7200;
  double health = 0;
  double issue = 1;
};

/// Messages of E05 that have BGD(E1, E5a) −1.117587090e-08 s and BGD(E1, E5b) 2e-9 s.
std::string galileo_navigation(const std::vector<Word>& words) {
  std::string nav = navigation({}, 3);
  for (const Word& word : words) {
    std::string one = message({"E05", 14400, word.sent, word.health, word.issue}, 3);
    one.replace(one.find(number(517)), 19, number(word.sources));
    nav += one;
  }
  return nav;
}

const std::string galileo_observations = line("     3.04           OBSERVATION DATA    M", "RINEX VERSION / TYPE") +
                                         line("E    2 C1X S1X", "SYS / # / OBS TYPES") + line("", "END OF HEADER") +
                                         "> 2021 11 09 03 30  0.0000000  0  1\nE05  25000000.000          44.000  \n";

Recording galileo(const std::vector<Word>& words) {
  return Recording(galileo_observations, galileo_navigation(words), {{"signals", {{"galileo", "1X"}}}});
}

}  // namespace

TEST_CASE("Galileo: which clock a message has, its group delay, and rows where they are asked for") {
  const auto delay = [](double sources) {
    const Recording r = galileo({{sources}});
    CHECK(r.reports.empty());
    CHECK(r.first(obs).rows.at(0)[0] == 205);
    return gnss::read_ephemeris(r.first(eph).rows.at(0).data()).group_delay;
  };
  const double to_E5a = -1.117587090e-08, to_E5b = 2e-9;
  for (const double sources : {513, 516, 517, 1, 4, 5, 512 + 256 + 5, 512 + 2}) CHECK(delay(sources) == to_E5b);
  for (const double sources : {256 + 1, 256 + 4, 256 + 5, 256 + 2, 2}) CHECK(delay(sources) == to_E5a);
  CHECK(galileo({{512}}).has_reported("its data sources, 512, name neither I/NAV nor F/NAV"));
}

TEST_CASE("Galileo: an I/NAV message is preferred to one of F/NAV, which serves where there is no other") {
  const auto issues = [](const Recording& r) {
    std::vector<double> list;
    for (const auto& sample : r.samples)
      if (sample.channel == eph)
        for (const auto& row : sample.rows) list.push_back(row[gnss::ephemeris_field_count - 1]);
    return list;
  };
  const double inav = 517, fnav = 258;
  CHECK(issues(galileo({{fnav, 9000, 0, 1}, {inav, 8000, 0, 2}})) == std::vector<double>{2});
  CHECK(issues(galileo({{inav, 8000, 0, 2}, {fnav, 9000, 0, 1}})) == std::vector<double>{2});
  CHECK(issues(galileo({{fnav, 9000, 0, 1}})) == std::vector<double>{1});
  // One that states E1 to be unwell is no reason to ask the other, which does not know E1's health.
  CHECK(issues(galileo({{fnav, 9000, 0, 1}, {inav, 8000, 1, 2}})).empty());
  CHECK(issues(galileo({{fnav, 9000, 8, 1}})).empty());  // E5a's validity: bit 3
  CHECK(issues(galileo({{fnav, 9000, 7, 1}})) == std::vector<double>{1});
  // Until an I/NAV message has come.
  CHECK(issues(galileo({{fnav, 9000, 0, 1}, {inav, 20000, 0, 2}})) == std::vector<double>{1});
}

TEST_CASE("a truncated file: the epochs before are kept, no number is taken that was cut, and it is reported") {
  for (const int version : {2, 3}) {
    const std::string whole = observations(version, {epoch(0, version), epoch(1, version), epoch(2, version)});
    const std::string last = epoch(2, version);
    const auto full = Recording(whole, navigation(four, version)).samples.back().rows;
    for (std::size_t less = 1; less + 5 < last.size(); ++less) {
      INFO("version " << version << ", " << less << " bytes less");
      const Recording r(whole.substr(0, whole.size() - less), navigation(four, version));
      const auto times = r.times(obs);
      REQUIRE(times.size() >= 2);
      // An epoch with its last line begun is there, with what of it can be trusted.
      if (times.size() == 3)
        for (std::size_t i = 0; i < r.samples.back().rows.size(); ++i)
          for (std::size_t j = 0; j < full[i].size(); ++j) {
            const double read = r.samples.back().rows[i][j];
            CHECK((std::isnan(read) || read == full[i][j]));
          }
      if (times.size() == 2) CHECK((r.has_reported("B061") || r.has_reported("B062")));
    }
    const std::size_t half = last.size() / 2;
    CHECK(Recording(whole.substr(0, whole.size() - half), navigation(four, version)).times(obs) ==
          std::vector<double>{0, 1});
    const std::string nav = navigation(four, version);
    const Recording r(whole, nav.substr(0, nav.size() - 100));
    CHECK(r.has_reported("B061 site.nav"));
    CHECK(r.has_reported("the file ends inside the message of G15"));
    CHECK(r.has_reported("no usable broadcast message for G15 (3 epochs)"));
    CHECK(r.first(eph).rows.size() == 3);
    REQUIRE_THROWS_AS(Recording(whole.substr(0, whole.size() - 30), nav, {{"invalid_records", "error"}}),
                      ComponentError);
    REQUIRE_THROWS_AS(Recording(whole.substr(0, 100), nav), ComponentError);  // inside the header: no epoch at all
  }
}

TEST_CASE("an epoch out of order is left out and reported") {
  for (const int version : {2, 3}) {
    const auto at = [&](std::vector<double> seconds_of) {
      std::vector<std::string> epochs;
      for (const double s : seconds_of) epochs.push_back(epoch(s, version));
      return Recording(observations(version, epochs), navigation(four, version));
    };
    const auto back = at({0, 1, 0.5, 2, 3});
    CHECK(back.times(obs) == std::vector<double>{0, 1, 2, 3});
    CHECK(back.has_reported("B063 site.obs"));
    CHECK(back.has_reported("1 epoch skipped"));
    // One that is far ahead is the one that is wrong, and not all those after it.
    CHECK(at({0, 1, 50, 2, 3}).times(obs) == std::vector<double>{0, 1, 2, 3});
    CHECK(at({0, 1, 1, 2}).times(obs) == std::vector<double>{0, 1, 2});
  }
}

TEST_CASE("corrupted lines cost what is on them, and no more") {
  for (const int version : {2, 3}) {
    INFO("version " << version);
    const std::string whole = observations(version, {epoch(0, version), epoch(1, version), epoch(2, version)});
    const auto with = [&](const std::string& what, const std::string& instead) {
      std::string text = whole;
      const auto at = text.find(what, text.rfind('\n', text.find("30  1.0000000")));
      REQUIRE(at != std::string::npos);
      text.replace(at, what.size(), instead);
      return Recording(text, navigation(four, version));
    };
    const auto rows = [](const Recording& r) {
      std::vector<std::size_t> list;
      for (const auto& sample : r.samples)
        if (sample.channel == obs) list.push_back(sample.rows.size());
      return list;
    };
    const auto number_gone = with("23000100.000", "2300x100.000");
    CHECK(rows(number_gone) == std::vector<std::size_t>{4, 3, 4});
    CHECK(number_gone.has_reported("B062 site.obs:"));
    CHECK(number_gone.has_reported("1 observation skipped"));
    const auto time_gone = with(version == 2 ? " 21 11  9  3 30  1.0" : "> 2021 11 09 03 30  1.0",
                                version == 2 ? " 21 13  9  3 30  1.0" : "> 2021 13 09 03 30  1.0");
    CHECK(time_gone.has_reported("is not a time"));
    CHECK(rows(time_gone) == std::vector<std::size_t>{4, 4});
  }
  // Messages: a number that is none, a line that is missing, an orbit that is none.
  const std::string good = observations(2, {epoch(0, 2)});
  std::string nav = navigation(four);
  const auto second = nav.find("10 21 11");
  std::string broken = nav;
  broken.replace(broken.find("5.153619016769D+03", second), 18, "5.1536190xx769D+03");
  CHECK(Recording(good, broken).has_reported("G10: number 8 of the orbit, in line 15, is none"));
  broken = nav;
  broken.replace(broken.find("5.153619016769D+03", second), 18, "0.000000000000D+00");
  CHECK(Recording(good, broken).has_reported("G10: the orbit or clock is not plausible for a satellite"));
  broken = nav;
  broken.erase(second, broken.find('\n', second) + 1 - second);
  const Recording r(good, broken);
  CHECK(r.first(eph).rows.size() == 2);  // its lines have become G05's
  CHECK(r.has_reported("the message of G05 has 15 lines instead of 8"));
}

TEST_CASE("events and power failures") {
  const std::string comment = "                            4  1\n" + line("a comment", "COMMENT");
  const std::string change =
      "                            4  2\n" + line("     1    C1", "# / TYPES OF OBSERV") + line("", "COMMENT");
  const std::string other = " 21 11  9  3 30  2.0000000  0  1G05\n  22500200.000\n";
  const Recording r(observations(2, {epoch(0, 2), comment, epoch(1, 2, 0, 1), change, other}), navigation(four));
  CHECK(r.reports.empty());
  CHECK(r.times(obs) == std::vector<double>{0, 1, 2});
  std::vector<double> events;
  for (const auto& sample : r.samples)
    if (sample.channel == obs) events.push_back(sample.fields[0]);
  CHECK(events == std::vector<double>{0, 1, 0});
}

TEST_CASE("a jump of the receiver's clock is found from code and phase") {
  const double millisecond = 299792.458;
  const Recording r(observations(2, {epoch(0, 2), epoch(1, 2, millisecond), epoch(2, 2, millisecond)}),
                    navigation(four));
  CHECK(r.has_reported("the receiver's clock jumps 1 time"));
  std::vector<double> jumps;
  for (const auto& sample : r.samples)
    if (sample.channel == obs) jumps.push_back(sample.fields[2]);
  REQUIRE(jumps.size() == 3);
  CHECK(jumps[0] == 0);
  CHECK(std::abs(jumps[1] - millisecond) < 1);
  CHECK(jumps[2] == 0);
}

TEST_CASE("files that are none are refused, with name and line") {
  const auto refusal = [](const std::string& o, const std::string& nav) {
    try {
      Recording(o, nav);
    } catch (const ComponentError& error) {
      return std::string(error.what());
    }
    return std::string("nothing");
  };
  const std::string o = observations(2, {epoch(0, 2)}), nav = navigation(four);
  CHECK(refusal("hello\n", nav).find("not a RINEX file") != std::string::npos);
  CHECK(refusal(nav, o).find("is no file of observations") != std::string::npos);
  std::string newer = o;
  newer.replace(5, 4, "4.00");
  CHECK(refusal(newer, nav).find("version 4.00 cannot be read") != std::string::npos);
  std::string other = o;
  other.replace(other.find("    C1"), 6, "    P2");
  CHECK(refusal(other, nav).find("no pseudoranges") != std::string::npos);
  CHECK(refusal(o, nav) == "nothing");
  REQUIRE_THROWS_AS(test::bind<RinexSource>({json::object(), {}, {}}), ComponentError);
}

}  // namespace rinex_test
