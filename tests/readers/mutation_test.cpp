// SPDX-License-Identifier: Apache-2.0
// Readers under damage: bytes of good files are flipped, cut, repeated, swapped. Whatever comes of it, there is no crash, no
// hang, no sample that goes back in time, and a message that is lost is one that was reported. BINNACLE_MUTATIONS=1000000 says how many for each
// reader; the seed is fixed, so that each failure can be seen again. BINNACLE_MUTATION_SEED is another one.
#include <cstdlib>
#include <cstring>
#include <ctime>
#include <random>
#include <string>

#include "catch.hpp"
#include "kitti/oxts_record.hpp"
#include "kitti/oxts_source.hpp"
#include "mutator.hpp"
#include "nmea/nmea_source.hpp"
#include "reading.hpp"
#include "rinex/rinex_source.hpp"
#include "rtklib/pos_source.hpp"
#include "ublox/recording.hpp"
#include "ublox/ublox_source.hpp"
#include "ubx_bytes.hpp"

namespace mutation_test {

using namespace binnacle;
using namespace binnacle::test;
using nlohmann::json;

namespace {

/// Each of many mutants is read to its end; an error with a message is an answer, too.
template <class SourceType>
void read_mutants(const std::vector<std::string>& seeds, const std::string& name, const json& parameters,
                  bool with_checksums = false) {
  Mutator mutate(mutation_seed());
  const Folder folder;
  const std::string file = folder.file(name);
  json with_path = parameters;
  with_path["path"] = file;
  std::size_t read = 0, refused = 0, reported = 0, samples = 0;
  const int count = mutations();
  for (int i = 0; i < count; ++i) {
    std::string bytes = mutate(seeds[static_cast<std::size_t>(i) % seeds.size()]);
    if (with_checksums && i % 2 == 0) bytes = ubx_with_right_checksums(bytes);
    std::ofstream(file, std::ios::binary | std::ios::trunc) << bytes;
    const std::clock_t begin = std::clock();  // of the processor: a machine that is busy is no hang
    try {
      const Recorded<SourceType> r(with_path);
      ++read;
      reported += !r.reports.empty();
      samples += r.samples.size();
    } catch (const ComponentError&) {
      ++refused;
    }
    const double took = static_cast<double>(std::clock() - begin) / CLOCKS_PER_SEC;
    INFO("mutation " << i);
    REQUIRE(took < 20.0);
  }
  INFO(name << ": " << read << " read, " << reported << " with a report, " << refused << " refused, " << samples
            << " samples");
  if (std::getenv("BINNACLE_MUTATIONS"))
    std::printf("%s: %d mutations, %zu read, %zu with a report, %zu refused, %zu samples\n", name.c_str(), count, read,
                reported, refused, samples);
  CHECK(read + refused == static_cast<std::size_t>(count));
  CHECK(read > 0);
}

/// A few messages of each kind that is read.
std::string ubx_seed() {
  std::mt19937_64 random(7);
  const auto noise = [&](Content p, std::size_t from) {
    for (std::size_t at = from; at < p.bytes().size(); ++at) p.u1(at, static_cast<unsigned>(random() & 0xFF));
    return p;
  };
  std::string bytes = ubx(0x0107, pvt(pvt_itow, pvt_second).bytes());
  for (unsigned i = 1; i < 4; ++i) {
    const std::uint32_t itow = pvt_itow + 250 * i;
    bytes += ubx(0x0107, pvt(itow, pvt_second).put(16, static_cast<std::int32_t>(250000000 * i)).bytes());
    bytes += ubx(0x0102, Content(28).u4(0, itow).u4(20, 20).bytes());
    bytes += ubx(0x0112, Content(36).u4(0, itow).u4(28, 20).bytes());
    bytes += ubx(0x0114, Content(36).u4(4, itow).u4(28, 20).bytes());
    bytes += ubx(0x013C, Content(64).u1(0, 1).u4(4, itow).u4(60, 0x105).bytes());
    bytes += ubx(0x1002,
                 Content(16).u4(0, 1000 + 250 * i).u2(4, 2 << 11).u4(8, 14u << 24 | 77).u4(12, 16u << 24 | 99).bytes());
    bytes += ubx(0x1003,
                 Content(20).u4(4, 14u << 24 | 77).u4(8, 256 * i).u4(12, 16u << 24 | 99).u4(16, 256 * i + 128).bytes());
    bytes += ubx(0x1015, Content(36).u4(0, 1 | 0x3F << 8).u4(8, itow).bytes());
    bytes += ubx(0x0213, noise(Content(48).u1(0, 0).u1(1, 7).u1(4, 10).u1(6, 2), 8).bytes());
    bytes += ubx(0x0213, noise(Content(40).u1(0, 2).u1(1, 7).u1(2, 1).u1(4, 8).u1(6, 2), 8).bytes());
    Content raw(16 + 2 * 32);
    raw.put(0, itow * 1e-3).u2(8, 2381).i1(10, 18).u1(11, 2).u1(12, 1).u1(13, 1);
    for (unsigned k = 0; k < 2; ++k)
      raw.put(16 + 32 * k, 2.1e7 + k)
          .put(24 + 32 * k, 1.1e8)
          .put(32 + 32 * k, 1000.0f)
          .u1(36 + 32 * k, 2 * k)
          .u1(37 + 32 * k, 5 + k)
          .u1(42 + 32 * k, 40)
          .u1(46 + 32 * k, 3);
    bytes += ubx(0x0215, raw.bytes());
  }
  return bytes;
}

const char* const nmea_seed =
    "$GPGGA,120000.00,4807.0380,N,01131.0000,E,1,08,0.9,545.4,M,46.9,M,,*67\r\n"
    "$GPRMC,120000.00,A,4807.0380,N,01131.0000,E,022.4,084.4,231121,,,A*51\r\n"
    "$GPGSA,A,3,04,05,,09,12,,,24,,,,,2.5,1.3,2.1*39\r\n$HEHDT,101.1,T*2D\r\n"
    "$GPGGA,120001.00,4807.0381,N,01131.0160,E,1,08,0.9,545.4,M,46.9,M,,*60\r\n"
    "$GPRMC,120001.00,A,4807.0381,N,01131.0160,E,022.4,084.4,231121,,,A*56\r\n";

const char* const pos_seed =
    "% ref pos   : 40.09 -105.15 1590.0\n"
    "% (lat/lon/height=WGS84/ellipsoidal,Q=1:fix)\n"
    "%  GPST latitude(deg) longitude(deg) height(m) Q ns sdn(m) sde(m) sdu(m) sdne(m) sdeu(m) sdun(m) age(s) ratio\n"
    "2025/08/28 17:30:40.000 40.096691600 -105.147166500 1601.4350 1 25 0.0099 0.0099 0.0100 0.0010 -0.0020 0.0000 "
    "0.00 3.0\n"
    "2381 408641.000 40.096691700 -105.147166400 1601.4400 2 25 0.0099 0.0099 0.0100 0.0010 -0.0020 0.0000 0.00 3.0\n"
    "2025/08/28 17:30:42.000 40.096691600 -105.147166500 1601.4350 1 25 0.0099 0.0099 0.0100 0.0010 -0.0020 0.0000 "
    "0.00 3.0\n";

}  // namespace

TEST_CASE("mutations of UBX") {
  read_mutants<ublox::UbloxSource>({ubx_seed()}, "log.ubx",
                                   {{"week", 2381}, {"signals", {{"gps", "1C"}, {"galileo", "1C"}}}}, true);
}

TEST_CASE("mutations of NMEA") { read_mutants<nmea::NmeaSource>({nmea_seed}, "log.nmea", json::object()); }

TEST_CASE("mutations of solution files") {
  const std::string ecef =
      "%  UTC x-ecef(m) y-ecef(m) z-ecef(m) Q ns sdx(m) sdy(m) sdz(m) sdxy(m) sdyz(m) sdzx(m) age(s) ratio\n"
      "2381 408622.000 -1276965.2487 -4717231.7278 4087230.1460 5 9 1.1 2.2 3.3 0.4 -0.5 0.6 0.0 0.0\n";
  const std::string baseline =
      "% ref pos   : 40 05 24.0 -105 09 00.0 1590.0\n"
      "%  JST e-baseline(m) n-baseline(m) u-baseline(m) Q ns sde(m) sdn(m) sdu(m) sden(m) sdnu(m) sdue(m) age(s) "
      "ratio\n"
      "2025/08/29 02:30:22.000 1.5 2.5 -0.5 1 9 0.1 0.2 0.3 0.04 -0.05 0.06 0.0 9.9\n";
  // Most of the bytes are lines of solutions: a damaged header refuses all of them.
  std::string longer = pos_seed;
  for (int i = 43; i < 60; ++i)
    longer += "2025/08/28 17:30:" + std::to_string(i) +
              ".000 40.096691600 -105.147166500 1601.4350 1 25 0.0099 0.0099 0.0100 0.0010 -0.0020 0.0000 0.00 3.0\n";
  read_mutants<rtklib::PosSource>({longer, ecef, baseline, longer}, "track.pos", {{"week", 2381}});
}

namespace {

/// The files of a folder of OXTS data change together.
struct OxtsMutants {
  std::string stamps = "2011-09-30 12:40:59.000000001\n2011-09-30 12:40:59.010000000\n";
  std::string row =
      "49.015 8.434 115.25 0.01 -0.02 2.5 8.5 -0.5 8.4 0.1 0.25 0.5 0.75 9.75 0.4 0.7 9.8 0.001 0.002 0.003 0.0011 "
      "0.0021 "
      "0.0031 0.125 0.0625 4 9 5 6 7\n";
};

}  // namespace

TEST_CASE("mutations of OXTS folders") {
  const OxtsMutants good;
  Mutator mutate(mutation_seed());
  const Folder folder;
  std::size_t read = 0, refused = 0;
  const int count = mutations();
  for (int i = 0; i < count; ++i) {
    folder.write("oxts/timestamps.txt", i % 2 == 0 ? mutate(good.stamps) : good.stamps);
    folder.write("oxts/data/0000000000.txt", i % 2 == 1 ? mutate(good.row) : good.row);
    folder.write("oxts/data/0000000001.txt", good.row);
    try {
      const Recorded<kitti::OxtsSource> r(json{{"path", folder.file("")}});
      ++read;
    } catch (const ComponentError&) {
      ++refused;
    }
  }
  if (std::getenv("BINNACLE_MUTATIONS"))
    std::printf("oxts: %d mutations, %zu read, %zu refused\n", count, read, refused);
  CHECK(read + refused == static_cast<std::size_t>(count));
  CHECK(read > 0);
}

namespace {

const char* const rinex_observations =
    R"(     3.04           OBSERVATION DATA    M: Mixed            RINEX VERSION / TYPE
site                                                        MARKER NAME
 -3962108.6730  3381309.5740  3668678.6380                  APPROX POSITION XYZ
G    3 C1C D1C S1C                                          SYS / # / OBS TYPES
C    3 C2I D2I S2I                                          SYS / # / OBS TYPES
  2021    11     9     3    30    0.0000000     GPS         TIME OF FIRST OBS
                                                            END OF HEADER
> 2021 11 09 03 30 00.0000000  0  4
C01  36785178.664        -188.948          45.000  
C35  22632604.654        2136.520          45.000  
G02  21425594.385        1607.020          45.000  
R05  21425594.385        1607.020          45.000  
> 2021 11 09 03 30 01.0000000  0  4
C01  36785214.951        -188.962          45.000  
C35  22632194.396        2136.121          45.000  
G02  21425288.605        1606.742          45.000  
R05  21425288.605        1606.742          45.000  
)";

const char* const rinex_messages = R"(     3.04           N: GNSS NAV DATA    M: Mixed            RINEX VERSION / TYPE
                                                            END OF HEADER
C01 2021 11 09 03 30 00-1.000000000000D-05-2.000000000000D-11 0.000000000000D+00
     1.000000000000D+00-7.000000000000D+01 4.100000000000D-09 2.043460952792D+00
    -2.000000000000D-06 4.000000000000D-04 7.000000000000D-06 6.493396645824D+03
     1.854000000000D+05-6.000000000000D-08 1.351958121000D+01-8.000000000000D-08
     9.075712110371D-02 1.800000000000D+02 4.000000000000D-01-7.600000000000D-09
    -3.000000000000D-10 0.000000000000D+00 8.270000000000D+02 0.000000000000D+00
     2.000000000000D+00 0.000000000000D+00-5.000000000000D-09 9.000000000000D-09
     1.818000000000D+05 0.000000000000D+00 0.000000000000D+00 0.000000000000D+00
G02 2021 11 09 04 00 00 1.200000000000D-04 2.000000000000D-11 0.000000000000D+00
     1.000000000000D+00 7.000000000000D+01 4.210000000000D-09-5.280244880340D-02
     2.000000000000D-06 9.000000000000D-03 7.000000000000D-06 5.153700000000D+03
     1.872000000000D+05 6.000000000000D-08 1.469803710582D+01-8.000000000000D-08
     9.599310885969D-01 1.910000000000D+02 1.100000000000D+00-7.710000000000D-09
     3.000000000000D-10 0.000000000000D+00 2.183000000000D+03 0.000000000000D+00
     2.000000000000D+00 0.000000000000D+00 5.000000000000D-09 1.000000000000D+00
     1.836000000000D+05 0.000000000000D+00 0.000000000000D+00 0.000000000000D+00
E02 2021 11 09 04 00 00 1.200000000000D-04 2.000000000000D-11 0.000000000000D+00
     1.000000000000D+00 7.000000000000D+01 4.210000000000D-09-5.280244880340D-02
     2.000000000000D-06 9.000000000000D-03 7.000000000000D-06 5.153700000000D+03
     1.872000000000D+05 6.000000000000D-08 1.469803710582D+01-8.000000000000D-08
     9.599310885969D-01 1.910000000000D+02 1.100000000000D+00-7.710000000000D-09
     3.000000000000D-10 5.170000000000D+02 2.183000000000D+03 0.000000000000D+00
     2.000000000000D+00 0.000000000000D+00 5.000000000000D-09 1.000000000000D+00
     1.836000000000D+05 0.000000000000D+00 0.000000000000D+00 0.000000000000D+00
)";

/// Version 2 as the component's example has it, version 3 of three systems.
std::vector<std::pair<std::string, std::string>> rinex_seeds() {
  const json files = json::parse(rinex::RinexSource::spec().surroundings).at("files");
  return {{files.at("site.obs"), files.at("site.nav")}, {rinex_observations, rinex_messages}};
}

}  // namespace

TEST_CASE("mutations of RINEX") {
  const auto seeds = rinex_seeds();
  Mutator mutate(mutation_seed());
  const Folder folder;
  std::size_t read = 0, refused = 0, reported = 0, samples = 0;
  const int count = mutations();
  for (int i = 0; i < count; ++i) {
    const auto& [observations, messages] = seeds[static_cast<std::size_t>(i) % seeds.size()];
    folder.write("site.obs", i / 2 % 2 == 0 ? mutate(observations) : observations);
    folder.write("site.nav", i / 2 % 2 == 1 ? mutate(messages) : messages);
    const std::clock_t begin = std::clock();
    try {
      const Recorded<rinex::RinexSource> r(json{{"observations", folder.file("site.obs")},
                                                {"navigation", folder.file("site.nav")},
                                                {"signals", {{"galileo", "1C"}, {"beidou", "2I"}}}});
      ++read;
      reported += !r.reports.empty();
      samples += r.samples.size();
    } catch (const ComponentError&) {
      ++refused;
    }
    INFO("mutation " << i);
    REQUIRE(static_cast<double>(std::clock() - begin) / CLOCKS_PER_SEC < 20.0);
  }
  if (std::getenv("BINNACLE_MUTATIONS"))
    std::printf("rinex: %d mutations, %zu read, %zu with a report, %zu refused, %zu samples\n", count, read, reported,
                refused, samples);
  CHECK(read + refused == static_cast<std::size_t>(count));
  CHECK(read > 0);
}

TEST_CASE("of a damaged stream each lost message is in a count") {
  Mutator mutate(99);
  const std::string good = ubx_seed();
  for (int i = 0; i < 2000; ++i) {
    const std::string bytes = mutate(good);
    ublox::Framer framer;
    ublox::Frame frame;
    framer.append(bytes);
    framer.finish();
    while (framer.next(frame)) {
    }
    const auto& c = framer.counts();
    REQUIRE(c.frame_bytes + c.garbage.count + c.text.count + c.cut.count == bytes.size());
  }
}

}  // namespace mutation_test
