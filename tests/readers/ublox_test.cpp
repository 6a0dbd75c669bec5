// SPDX-License-Identifier: Apache-2.0
// Source ublox: each message by its documented places, time, what is left out and what is said of it.
#include "ublox/ublox_source.hpp"

#include <cmath>
#include <numbers>

#include "catch.hpp"
#include "reading.hpp"
#include "ubx_bytes.hpp"

namespace ublox_test {

using namespace binnacle;
using namespace binnacle::test;
using namespace binnacle::ublox;
using nlohmann::json;
using Ubx = Recorded<UbloxSource>;

namespace {

constexpr double degree = std::numbers::pi / 180;
constexpr std::int64_t week = 2381;

Ubx read(const std::string& bytes, json parameters = json::object()) {
  const Folder folder;
  parameters["path"] = folder.write("log.ubx", bytes);
  if (!parameters.contains("epoch") && !parameters.contains("week")) parameters["week"] = week;
  return Ubx(parameters);
}

double fraction_of(const Sample& sample) { return seconds(sample.t) - 4 * 86400 - 17 * 3600 - 30 * 60 - 40; }

bool near(double a, double b) { return std::abs(a - b) <= 1e-12 * std::max(1.0, std::abs(b)); }

std::string header_pvt() { return ubx(nav_pvt, pvt(pvt_itow, pvt_second).bytes()); }

}  // namespace

TEST_CASE("NAV-PVT: fields, units and GPS time") {
  const Ubx r = read(header_pvt());
  CHECK(r.reports.empty());
  REQUIRE(r.samples.size() == 1);
  const Sample& s = r.samples[0];
  CHECK(s.channel.empty());
  CHECK(s.t == (4 * 86400 + 17 * 3600 + 30 * 60 + 40) * nanoseconds_per_second);
  CHECK(near(s["lat"], 40.0966916 * degree));
  CHECK(near(s["lon"], -105.1471665 * degree));
  CHECK(near(s["height"], 1580.048));
  CHECK(near(s["height_msl"], 1601.435));
  CHECK(near(s["vn"], 1.5));
  CHECK(near(s["ve"], -2.5));
  CHECK(near(s["vd"], 0.3));
  CHECK(near(s["speed"], 2.915));
  CHECK(near(s["course"], 300.96376 * degree));
  CHECK(near(s["position_sd_n"], 0.014));
  CHECK(near(s["position_sd_d"], 0.010));
  CHECK(near(s["velocity_sd_d"], 0.07));
  CHECK(near(s["course_sd"], 12.34567 * degree));
  CHECK(near(s["time_sd"], 25e-9));
  CHECK(near(s["pdop"], 1.23));
  CHECK(s["satellites"] == 17);
  CHECK(s["fix_type"] == 3);
  CHECK(s["carrier"] == 2);
  CHECK(s["differential"] == 1);
  CHECK(std::isnan(s["yaw"]));
  CHECK(std::isnan(s["declination"]));
}

TEST_CASE("NAV-PVT without a fix is left out, counted and said") {
  std::string bytes = header_pvt();
  bytes += ubx(nav_pvt, pvt(pvt_itow + 1000, pvt_second + 1).u1(21, 0x00).bytes());               // gnssFixOK
  bytes += ubx(nav_pvt, pvt(pvt_itow + 2000, pvt_second + 2).u1(20, 5).bytes());                  // time only
  bytes += ubx(nav_pvt, pvt(pvt_itow + 3000, pvt_second + 3).put(78, std::uint16_t{1}).bytes());  // invalidLlh
  const Ubx r = read(bytes);
  CHECK(r.samples.size() == 1);
  CHECK(
      r.has_reported("B065 log.ubx:0 2 × NAV-PVT without a fix (gnssFixOK, fixType), left out, the first at byte 100"));
  CHECK(r.has_reported("1 × NAV-PVT of which the position is invalid (invalidLlh)"));
}

TEST_CASE("NAV-POSLLH, -VELNED and -HPPOSLLH: places, high precision") {
  Content llh(28), velned(36), hp(36);
  llh.u4(0, pvt_itow).i4(4, -1051471665).i4(8, 400966916).i4(12, 1580048).i4(16, 1601435).u4(20, 20).u4(24, 30);
  velned.u4(0, pvt_itow).i4(4, 150).i4(8, -250).i4(12, 30).u4(16, 293).u4(20, 292).i4(24, 9000000).u4(28, 7);
  velned.u4(32, 100000);
  hp.u4(4, pvt_itow).i4(8, -1051471665).i4(12, 400966916).i4(16, 1580048).i4(20, 1601435);
  hp.i1(24, -32).i1(25, 31).i1(26, -4).i1(27, 5).u4(28, 140).u4(32, 100);
  const Ubx r = read(header_pvt() + ubx(nav_posllh, llh.bytes()) + ubx(nav_velned, velned.bytes()) +
                     ubx(nav_hpposllh, hp.bytes()));
  CHECK(r.reports.empty());
  const Sample p = r.of("posllh").at(0), v = r.of("velned").at(0), h = r.of("hpposllh").at(0);
  for (const auto& s : {p, v, h}) CHECK(s.t == r.samples[0].t);
  CHECK(near(p["lat"], 40.0966916 * degree));
  CHECK(near(p["position_sd_d"], 0.03));
  CHECK(near(v["vn"], 1.5));
  CHECK(near(v["ve"], -2.5));
  CHECK(near(v["vd"], 0.3));
  CHECK(near(v["speed"], 2.92));
  CHECK(near(v["course"], 90 * degree));
  CHECK(near(v["velocity_sd_n"], 0.07));
  CHECK(near(v["course_sd"], degree));
  CHECK(near(h["lat"], 40.096691631 * degree));
  CHECK(near(h["lon"], -105.147166532 * degree));
  CHECK(near(h["height"], 1580.0476));
  CHECK(near(h["height_msl"], 1601.4355));
  CHECK(near(h["position_sd_n"], 0.014));
}

TEST_CASE("NAV-RELPOSNED: places, high precision, heading") {
  Content p(64);
  p.u1(0, 1).u2(2, 7).u4(4, pvt_itow).i4(8, 100).i4(12, -50).i4(16, 3).i4(20, 112).i4(24, 33343000);
  p.i1(32, 25).i1(33, -12).i1(34, 0).i1(35, 9).u4(36, 100).u4(40, 110).u4(44, 120).u4(48, 90).u4(52, 50000);
  p.u4(60, 1 | 2 | 4 | 2 << 3 | 1 << 8);
  const Ubx r = read(header_pvt() + ubx(nav_relposned, p.bytes()));
  const Sample rel = r.of("relposned").at(0);
  CHECK(rel.t == r.samples[0].t);
  CHECK(near(rel["relative_n"], 1.0025));
  CHECK(near(rel["relative_e"], -0.5012));
  CHECK(near(rel["relative_d"], 0.03));
  CHECK(near(rel["length"], 1.1209));
  CHECK(near(rel["length_sd"], 0.009));
  CHECK(near(rel["relative_sd_e"], 0.011));
  CHECK(near(rel["yaw"], 333.43 * degree));
  CHECK(near(rel["yaw_sd"], 0.5 * degree));
  CHECK(rel["carrier"] == 2);
  CHECK(rel["station"] == 7);
}

TEST_CASE("RELPOSNED: no heading, normalized, version 0") {
  const auto relative = [](std::uint32_t flags) {
    return ubx(nav_relposned, Content(64).u1(0, 1).u4(4, pvt_itow).i4(8, 100).u4(60, flags).bytes());
  };
  CHECK(std::isnan(read(header_pvt() + relative(1 | 4)).of("relposned").at(0)["yaw"]));
  CHECK(read(header_pvt() + relative(1 | 4 | 1 << 9)).has_reported("vector is normalized"));
  CHECK(read(header_pvt() + relative(1)).has_reported("without a solution"));
  const Ubx old = read(
      header_pvt() +
      ubx(nav_relposned,
          Content(40).u4(4, pvt_itow).i4(8, 100).i4(12, 7).i4(16, -9).i1(20, 50).u4(24, 100).u4(36, 1 | 4).bytes()));
  const Sample s = old.of("relposned").at(0);
  CHECK(near(s["relative_n"], 1.005));
  CHECK(near(s["relative_d"], -0.09));
  CHECK(near(s["relative_sd_n"], 0.01));
  CHECK(std::isnan(s["yaw"]));
}

TEST_CASE("positions while NAV-STATUS or NAV-PVT has no fix are left out") {
  const std::string position = ubx(nav_posllh, Content(28).u4(0, pvt_itow).u4(20, 20).bytes());
  const std::string lost = ubx(nav_status, Content(16).u4(0, pvt_itow).u1(4, 0).u1(5, 0).bytes());
  const Ubx r = read(header_pvt() + lost + position);
  CHECK(r.of("posllh").empty());
  CHECK(r.has_reported("NAV-POSLLH without a fix (NAV-PVT or NAV-STATUS says so)"));
}

TEST_CASE("time: week roll, before the first week, time going back, UTC") {
  const auto posllh = [](std::uint32_t itow) { return ubx(nav_posllh, Content(28).u4(0, itow).u4(20, 20).bytes()); };
  // Saturday 2025-08-30 23:59:41.5 UTC is the last half second of GPS week 2381.
  const int last = 23 * 3600 + 59 * 60 + 41;
  const auto saturday = pvt(604799500, last).u1(7, 30).put(16, std::int32_t{500000000});
  const Ubx roll =
      read(posllh(604799000) + ubx(nav_pvt, saturday.bytes()) + posllh(604799500) + posllh(0) + posllh(500));
  const auto list = roll.of("posllh");
  REQUIRE(list.size() == 4);  // the one before the date too: the file is read whole
  CHECK(seconds(list[0].t) == 604799.0);
  CHECK(seconds(list[1].t) == 604799.5);
  CHECK(seconds(list[2].t) == 604800.0);
  CHECK(seconds(list[3].t) == 604800.5);
  CHECK(seconds(roll.of("").at(0).t) == 604799.5);

  const Ubx none = read(header_pvt() + posllh(pvt_itow) + posllh(pvt_itow + 500) + posllh(pvt_itow));
  CHECK(none.of("posllh").size() == 2);
  CHECK(none.has_reported("B063 log.ubx:0 1 × samples of 'posllh' that are not younger than the one before"));

  CHECK_THROWS_AS(read(posllh(1000)), ComponentError);  // nothing says the week

  const Ubx utc = read(header_pvt(), {{"epoch", "2025-08-28T17:30:00Z"}});
  CHECK(utc.samples.at(0).t == 22 * nanoseconds_per_second);
  // A date for which the receiver does not vouch, or that contradicts iTOW, is none.
  CHECK_THROWS_AS(read(ubx(nav_pvt, pvt(pvt_itow, pvt_second).u1(11, 0).bytes())), ComponentError);
  CHECK_THROWS_AS(read(ubx(nav_pvt, pvt(pvt_itow + 7200000, pvt_second).bytes())), ComponentError);
}

TEST_CASE("garbage, a wrong checksum, text of NMEA and a cut end are counted, and no byte is lost") {
  const std::string one = header_pvt(), two = ubx(nav_pvt, pvt(pvt_itow + 1000, pvt_second + 1).bytes()),
                    three = ubx(nav_pvt, pvt(pvt_itow + 2000, pvt_second + 2).bytes());
  std::string damaged = two;
  damaged[50] = static_cast<char>(damaged[50] ^ 1);
  const Ubx r = read(
      "garb\xB5"
      "age" +
      one + "$GNTXT,01,01,02,u-blox*00\r\n" + damaged + three + three.substr(0, 60));
  CHECK(r.samples.size() == 2);
  CHECK(r.has_reported("B061 log.ubx:0 108 bytes between messages belong to none, the first at byte 0"));
  CHECK(r.has_reported("B061 log.ubx:0 1 message of which the checksum is wrong, the first at byte 135"));
  CHECK(r.has_reported("B061 log.ubx:0 the data end inside a message, 60 bytes, the first at byte 335"));
  CHECK(r.has_reported("B065 log.ubx:0 1 line of text, like those of NMEA, are not read, the first at byte 108"));
  // A message inside one that claims to be longer is found.
  const std::string claim("\xB5\x62\x01\x07\xFF\x0F", 6);
  CHECK(read(claim + one + three).samples.size() == 2);
  CHECK_THROWS_AS(read(one + damaged, {{"on_error", "stop"}}), ComponentError);
}

TEST_CASE("the framer accounts for every byte, whatever the blocks in which they come") {
  const std::string one = header_pvt();
  const std::string bytes = "xx" + one + "\xB5\x62\x01" + one.substr(0, 40) + one + "$text\r\n!" + one.substr(0, 99);
  for (const std::size_t block : {1U, 3U, 64U, 1000U}) {
    Framer framer;
    Frame frame;
    std::size_t frames = 0;
    for (std::size_t at = 0; at < bytes.size(); at += block) {
      framer.append(std::string_view(bytes).substr(at, block));
      while (framer.next(frame)) ++frames;
    }
    framer.finish();
    while (framer.next(frame)) ++frames;
    const auto& c = framer.counts();
    CHECK(frames == 2);
    CHECK(c.frame_bytes + c.garbage.count + c.text.count + c.cut.count == bytes.size());
  }
}

TEST_CASE("messages that are not read, unknown lengths, messages that are missing") {
  const std::string unknown = ubx(0x0A09, std::string(20, 'x')), longer = ubx(nav_velned, std::string(40, 'x'));
  const Ubx r = read(header_pvt() + unknown + longer + unknown);
  CHECK(r.has_reported("messages that are not read: 0A-09 (2)"));
  CHECK(r.has_reported("B062 log.ubx:0 1 × NAV-VELNED of unknown length or version, left out, at byte 128"));
  CHECK(read(header_pvt(), {{"messages", {"NAV-PVT", "RXM-RAWX"}}}).has_reported("B066 log.ubx:0 holds no RXM-RAWX"));
  CHECK_THROWS_AS(read(header_pvt(), {{"messages", {"NAV-PTV"}}}), ComponentError);
  CHECK_THROWS_AS(read(header_pvt(), {{"messages", {"RXM-RAWX"}}, {"epoch", "2025-08-28"}}), ComponentError);
  CHECK_THROWS_AS(read(header_pvt(), {{"signals", {{"beidou", "2I"}}}}),
                  ComponentError);  // rinex reads it, this does not
}

TEST_CASE("sensors: axes, signs, scales, ticks, and times by the order of messages") {
  const auto datum = [](unsigned type, int value) {
    return type << 24 | (static_cast<std::uint32_t>(value) & 0xFFFFFF);
  };
  const auto meas = [&](std::uint32_t tag, std::vector<std::uint32_t> data) {
    Content p(8 + 4 * data.size());
    p.u4(0, tag).u2(4, static_cast<unsigned>(data.size()) << 11);
    for (std::size_t i = 0; i < data.size(); ++i) p.u4(8 + 4 * i, data[i]);
    return ubx(esf_meas, p.bytes());
  };
  std::string bytes = header_pvt();
  bytes += meas(5000, {datum(14, 4096), datum(13, -8192), datum(5, 2048)});
  bytes += meas(5000, {datum(16, 1024), datum(17, -2048), datum(18, 10240), datum(12, 2500)});
  bytes += meas(5100, {datum(14, 0), datum(8, 100), datum(9, 0x800000 | 50), datum(11, -1500)});
  bytes += meas(5200, {datum(14, 4096)});
  bytes += ubx(esf_raw, Content(20).u4(4, datum(14, 4096)).u4(8, 25600).u4(12, datum(14, -4096)).u4(16, 25856).bytes());
  bytes +=
      ubx(esf_ins,
          Content(36).u4(0, 1 | 0x3F << 8).u4(8, pvt_itow).i4(12, 1500).i4(16, -10).i4(24, 123).i4(32, -5).bytes());
  const Ubx r = read(bytes);
  const auto imu = r.of("imu"), wheels = r.of("wheels"), raw = r.of("imu_raw");
  REQUIRE(imu.size() == 3);
  CHECK(near(imu[0]["wx"], degree));
  CHECK(near(imu[0]["wy"], -2 * degree));
  CHECK(near(imu[0]["wz"], 0.5 * degree));
  CHECK(near(imu[0]["fx"], 1));
  CHECK(near(imu[0]["fy"], -2));
  CHECK(near(imu[0]["fz"], 10));
  CHECK(near(imu[0]["temperature"], 298.15));
  CHECK(fraction_of(imu[0]) == 0);  // the first after the epoch
  CHECK(imu[0].t0 == no_time);
  CHECK(imu[1].t - imu[0].t == 100'000'000);
  CHECK(imu[1].t0 == imu[0].t);
  CHECK(std::isnan(imu[1]["fx"]));
  CHECK(imu[2].t - imu[0].t == 200'000'000);
  REQUIRE(wheels.size() == 1);
  CHECK(wheels[0]["rear_left"] == 100);
  CHECK(wheels[0]["rear_right"] == -50);
  CHECK(near(wheels[0]["speed"], -1.5));
  REQUIRE(raw.size() == 2);
  CHECK(near(raw[1]["wx"], -degree));
  CHECK(std::abs(fraction_of(raw[1]) - 0.01) < 1e-5);
  const Sample ins = r.of("ins").at(0);
  CHECK(near(ins["wx"], 1.5 * degree));
  CHECK(near(ins["ax"], 1.23));
  CHECK(near(ins["az"], -0.05));
  CHECK(r.has_reported("times of ESF-MEAS are converted to GPS time by their order among the epochs"));
}

TEST_CASE("gzipped, and what is cut there") {
  const std::string path = std::string(BINNACLE_TEST_PROJECT);
  const Folder folder;
  std::string bytes;
  for (int i = 0; i < 200; ++i)
    bytes += ubx(nav_pvt, pvt(pvt_itow + 1000u * static_cast<unsigned>(i), pvt_second + i).bytes());
  const std::string file = folder.write("log.ubx", bytes);
  REQUIRE(std::system(("gzip -k '" + file + "'").c_str()) == 0);
  CHECK(Ubx({{"path", file + ".gz"}, {"week", week}}).samples.size() == 200);
  const std::string packed = bytes_of(file + ".gz");
  const std::string cut = folder.write("cut.ubx.gz", packed.substr(0, packed.size() / 2));
  const Ubx r({{"path", cut}, {"week", week}});
  CHECK(r.samples.size() > 10);
  CHECK(r.samples.size() < 200);
  CHECK(r.has_reported("B061 cut.ubx.gz:0"));
}

TEST_CASE("live: the same samples from the same bytes, and the same complaints") {
  const Folder folder;
  std::string bytes = "garbage";
  for (unsigned i = 0; i < 50; ++i) {
    bytes += ubx(nav_pvt, pvt(pvt_itow + 1000u * i, pvt_second + static_cast<int>(i)).bytes());
    Content raw(48);
    raw.put(0, (pvt_itow + 1000u * i) * 1e-3).u2(8, week).i1(10, 18).u1(11, 1).u1(12, 1).u1(13, 1);
    raw.put(16, 2.1e7 + i).put(24, 1.1e8).put(32, 1000.0f).u1(37, 5).u1(42, 40).u1(46, 3);
    bytes += ubx(rxm_rawx, raw.bytes());
  }
  bytes += ubx(0x0A09, "x") + ubx(nav_velned, "short");
  const std::string file = folder.write("log.ubx", bytes);
  const Ubx recorded({{"path", file}, {"week", week}}), live({{"from", "file:" + file}, {"week", week}});
  for (const std::string channel : {"", "obs"}) {
    const auto a = recorded.of(channel), b = live.of(channel);
    REQUIRE(a.size() == 50);
    REQUIRE(b.size() == a.size());
    for (std::size_t i = 0; i < a.size(); ++i) {
      CHECK(a[i].t == b[i].t);
      CHECK(a[i].rows == b[i].rows);
      for (const auto& [name, value] : a[i].fields) {
        const double other = b[i][name];
        CHECK((other == value || (std::isnan(value) && std::isnan(other))));
      }
    }
  }
  CHECK(live.of("obs")[7].rows.at(0).at("pseudorange") == 2.1e7 + 7);
  CHECK(live.of("obs")[7].rows.at(0).at("range_rate") < -190);
  INFO(live.reports);
  CHECK(live.has_reported("7 bytes between messages belong to none so far"));
  CHECK(live.has_reported("messages that are not read: 0A-09 (1) so far"));
  CHECK(live.has_reported("NAV-VELNED of unknown length or version, left out"));
}

}  // namespace ublox_test
