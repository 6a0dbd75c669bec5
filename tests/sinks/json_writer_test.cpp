// SPDX-License-Identifier: Apache-2.0
// stream/json_writer: what its lines say, and a run beside a client that does not read.
#include "stream/json_writer.hpp"

#include <cmath>
#include <fstream>
#include <functional>
#include <iterator>
#include <limits>

#include <nlohmann/json.hpp>

#include "allocations.hpp"
#include "binnacle/sample.hpp"
#include "binnacle/unit.hpp"
#include "catch.hpp"
#include "command.hpp"
#include "receivers.hpp"

namespace json_writer_test {

using namespace binnacle;
using namespace binnacle::receivers;
using nlohmann::json;
using stream::JsonWriter;

namespace {

ChannelDeclaration satellites() {
  ChannelDeclaration channel("sky");
  channel.fields = {field::level("lat", "rad"), field::level("pseudo\"range", "m").per_row(), field::level("odd", "1"),
                    field::level("cn0", "1").per_row()};
  channel.max_rows = 3;
  channel.covariance = {{"north", "m"}, {"east", "m"}};
  return channel;
}

ParameterValue text_value(const std::string& text) {
  ParameterValue value;
  value.type = ParameterValue::Type::text;
  value.text = text;
  return value;
}

using Texts = std::vector<std::pair<std::string, std::string>>;

struct Written {
  Folder folder;
  std::unique_ptr<JsonWriter> writer;

  explicit Written(const Texts& parameters = {}) {
    const ComponentSpec spec = JsonWriter::spec();
    const ChannelDeclaration channel = satellites();
    ParameterValue all;
    all.type = ParameterValue::Type::object;
    const auto add = [&](const std::string& name, const std::string& otherwise) {
      for (const auto& [key, value] : parameters)
        if (key == name) return all.members.emplace_back(name, text_value(value)), void();
      if (!otherwise.empty()) all.members.emplace_back(name, text_value(otherwise));
    };
    add("to", "file:" + (folder / "out.jsonl"));
    add("channel", "");
    add("time", "t");
    add("covariance", "sigma");
    ParameterValue buffer;
    buffer.type = ParameterValue::Type::integer;
    buffer.integer = 65536;
    all.members.emplace_back("buffer", buffer);
    writer = std::make_unique<JsonWriter>(Binding({.name = "sky_out",
                                                   .parameters = Parameters(all),
                                                   .covariances = {channel.covariance},
                                                   .spec = &spec,
                                                   .inputs_bound = {true},
                                                   .channels = {&channel}}));
    writer->open();
  }
  void add(Time t, std::vector<double> fields, const std::vector<double>& rows, const std::vector<double>& P) {
    SampleView sample;
    sample.t = t;
    sample.fields = fields.data();
    sample.row_fields = rows.data();
    sample.rows = static_cast<int>(rows.size() / 2);
    sample.covariance = P.empty() ? nullptr : P.data();
    writer->on(Input(0, true), sample);
  }
  std::string text() {
    writer->close();
    std::ifstream file(folder / "out.jsonl");
    return {std::istreambuf_iterator<char>(file), {}};
  }
};

std::string refusal(const Texts& parameters) {
  try {
    const Written written(parameters);
  } catch (const ComponentError& error) {
    return error.pointer() + ": " + error.what();
  }
  return "";
}

constexpr double no_number = std::numeric_limits<double>::quiet_NaN();

}  // namespace

TEST_CASE("json_writer: fields by their names, rows as lists, sigmas by component") {
  Written written;
  written.add(12'500'000'000, {0.5, no_number}, {1, 40, 2, 41.5}, {4, 1, 1, 9});
  written.add(-10'000'000, {-0.0, 1e300}, {}, {});
  CHECK(
      written.text() ==
      R"({"channel":"sky_out","t":12.5,"lat":0.5,"odd":null,"pseudo\"range":[1,2],"cn0":[40,41.5],"sigma":{"north":2,"east":3}})"
      "\n"
      R"({"channel":"sky_out","t":-0.01,"lat":-0,"odd":1e+300,"pseudo\"range":[],"cn0":[]})"
      "\n");
}

TEST_CASE("json_writer: names of channel and time, the whole covariance, none at all") {
  Written full(Texts{{"channel", "sky.obs"}, {"time", "timestamp"}, {"covariance", "full"}});
  full.add(1'700'000'000'123'456'789, {1, 2}, {}, {4, 1, 1, std::numeric_limits<double>::infinity()});
  CHECK(full.text() ==
        R"({"channel":"sky.obs","timestamp":1700000000.123456789,"lat":1,"odd":2,"pseudo\"range":[],"cn0":[],)"
        R"("sigma":{"north":2,"east":null},"covariance":[[4,1],[1,null]]})"
        "\n");
  Written none(Texts{{"covariance", "none"}});
  none.add(0, {1, 2}, {}, {4, 1, 1, 9});
  CHECK(none.text() == "{\"channel\":\"sky_out\",\"t\":0.0,\"lat\":1,\"odd\":2,\"pseudo\\\"range\":[],\"cn0\":[]}\n");
}

TEST_CASE("json_writer: numbers are read again as the same") {
  Written written;
  std::vector<double> numbers;
  for (int i = 0; i < 2000; ++i) numbers.push_back(std::sin(i * 1.7) * std::pow(10, i % 300 - 150));
  for (const double number : numbers) written.add(0, {number, -number}, {}, {});
  const auto lines = lines_of(written.text());
  REQUIRE(lines.size() == numbers.size());
  for (std::size_t i = 0; i < lines.size(); ++i) {
    const json object = json::parse(lines[i]);
    REQUIRE(object.at("lat").get<double>() == numbers[i]);
    REQUIRE(object.at("odd").get<double>() == -numbers[i]);
  }
}

TEST_CASE("json_writer: a key that would be there twice is refused") {
  CHECK(refusal({{"time", "lat"}}) == "/time: a line would have two values 'lat'; give the time another name");
  CHECK(refusal({{"time", "channel"}}).rfind("/time: ", 0) == 0);
  CHECK(refusal({{"time", "sigma"}}).rfind("/covariance: ", 0) == 0);
  CHECK(refusal({{"time", "stamp"}}).empty());
}

TEST_CASE("json_writer does not allocate after the first sample") {
  if (!conform::allocations_are_counted()) return;
  Written written(Texts{{"covariance", "full"}});
  const std::vector<double> rows{-1.2345678901234567e-300, 40, 2, 41.5, 3, 42}, P{4, 1, 1, 9};
  std::vector<double> fields{-1.2345678901234567e-300, no_number};
  SampleView sample;
  sample.fields = fields.data();
  sample.row_fields = rows.data();
  sample.rows = 3;
  sample.covariance = P.data();
  const auto before = conform::allocations();
  for (int i = 0; i < 100; ++i) {
    sample.t = i;
    written.writer->on(Input(0, true), sample);
  }
  CHECK(conform::allocations() == before);
}

namespace {

/// The quickstart, with its truth (100 Hz) sent as JSON.
void write_config(const test::Workbench& bench, const std::string& sinks) {
  bench.write("live.json",
              "{\"extends\": \"" BINNACLE_TEST_PROJECT "/configs/quickstart.json\", \"sinks\": {" + sinks + "}}");
}

std::string truth_to(const std::string& address) {
  return "\"truth\": {\"type\": \"stream/json_writer\", \"input\": \"drive.truth\", \"to\": \"" + address +
         "\", \"buffer\": 65536}";
}

double wall_seconds(const std::function<void()>& work) {
  const auto begin = std::chrono::steady_clock::now();
  work();
  return std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
}

/// The summary without what the machine's clock says.
json results_of(const std::string& summary) {
  json filters = json::parse(summary).at("filters");
  for (auto& filter : filters) filter.erase("filter_s");
  return filters;
}

}  // namespace

TEST_CASE("a run beside a client that never reads takes no longer, and its results are the same") {
  const test::Workbench bench;
  write_config(bench, "");
  test::Outcome alone, served;
  test::binnacle(bench, {"run", "live.json", "--json"});  // what is read from disk once
  const double alone_s = wall_seconds([&] { alone = test::binnacle(bench, {"run", "live.json", "--json"}); });
  REQUIRE(alone.status == 0);

  const int port = free_port();
  write_config(bench, truth_to("tcp://:" + std::to_string(port)));
  const double served_s = wall_seconds([&] {
    test::Command command(bench, {"run", "live.json", "--json"});
    const Reading idle = connected(port, 4096);
    served = command.wait();
  });
  INFO(alone_s << " s alone, " << served_s << " s with a client\n" << served.err);
  REQUIRE(served.status == 0);
  CHECK(results_of(served.out) == results_of(alone.out));
  CHECK(served_s < alone_s + 3);  // what still waits has a second
  CHECK(served.err.find("B145") != std::string::npos);
  CHECK(served.err.find("read too slowly") != std::string::npos);
}

TEST_CASE("a quiet run says that its output was lost, unless the receiver left") {
  const test::Workbench bench;
  const auto quiet_run = [&](const auto& visit) {
    const int port = free_port();
    write_config(bench, truth_to("tcp://:" + std::to_string(port)));
    test::Command command(bench, {"run", "live.json", "--quiet"});
    return visit(command, connected(port, 4096));
  };
  const auto slow = quiet_run([](auto& command, Reading idle) {
    const auto run = command.wait();
    idle.close();
    return run;
  });
  const auto gone = quiet_run([](auto& command, Reading client) {
    client.close();
    return command.wait();
  });
  INFO(slow.err << gone.err);
  CHECK(slow.status == 0);
  CHECK(slow.err.find("warning[B145]") != std::string::npos);
  CHECK(slow.err.ends_with("\n1 warning\n"));
  CHECK(lines_of(slow.err).size() == 2);
  CHECK(gone.err.empty());
}

TEST_CASE("a port in use ends the run before it begins, with the place in the config") {
  const test::Workbench bench;
  const Reading taken(bound(SOCK_STREAM));
  ::listen(taken.fd(), 1);
  write_config(bench, truth_to("tcp://:" + std::to_string(port_of(taken.fd()))));
  const auto outcome = test::binnacle(bench, {"run", "live.json"});
  CHECK(outcome.status == 5);
  INFO(outcome.err);
  CHECK(outcome.err.rfind("live.json:1:", 0) == 0);
  CHECK(outcome.err.find("/sinks/truth") != std::string::npos);
  CHECK(outcome.err.find("Address already in use") != std::string::npos);
}

TEST_CASE("standard output: lines of JSON and nothing else, as many as there are samples") {
  const test::Workbench bench;
  write_config(bench, truth_to("stdout:"));
  const auto outcome = test::binnacle(bench, {"run", "live.json", "--quiet"});
  CHECK(outcome.status == 0);
  const auto lines = lines_of(outcome.out);
  CHECK(lines.size() > 1000);
  double before = -1;
  for (const auto& line : lines) {
    const json object = json::parse(line);
    REQUIRE(object.at("channel") == "truth");
    REQUIRE(object.at("t").get<double>() > before);
    before = object.at("t").get<double>();
  }
}

}  // namespace json_writer_test
