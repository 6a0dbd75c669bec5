// SPDX-License-Identifier: Apache-2.0
// The faults transform: each kind does to a channel what its name says, when and to what it names, and nothing else.
#include "faults/faults.hpp"

#include <cmath>
#include <limits>
#include <string>
#include <vector>

#include <nlohmann/json.hpp>

#include "binnacle/bind.hpp"
#include "binnacle/geodesy.hpp"
#include "catch.hpp"

namespace faults_test {

namespace {

using namespace binnacle;
using Json = nlohmann::json;

constexpr Time second = 1'000'000'000;
constexpr double lat = 0.85, lon = 0.15, height = 120;

struct Row {
  double satellite, range;
};
struct Sample {
  Time t = 0, t0 = no_time;
  std::vector<double> fields;
  std::vector<Row> rows;
  std::vector<double> covariance;
};

/// lat, lon, height and v of an instant; two satellites' ranges; a covariance of one component.
ChannelDeclaration channel() {
  ChannelDeclaration channel("gnss", {field::level("lat", "rad"), field::level("sat", "1").per_row(),
                                      field::level("lon", "rad"), field::level("range", "m").per_row(),
                                      field::level("height", "m"), field::level("v", "m/s")});
  channel.max_rows = 2;
  channel.covariance = {{"north", "m"}};
  return channel;
}
enum { at_lat, at_lon, at_height, at_v };

class Bench final : public Emitter {
 public:
  explicit Bench(const Json& faults, ChannelDeclaration its_channel = channel(), std::uint64_t seed = 7)
      : channel_(std::move(its_channel)),
        transform_(testing::bind<faults::Faults>(
            {.parameters = Json{{"faults", faults}}, .channels = {{"samples", &channel_}}, .name = "bad"})) {
    memory_.resize(transform_->declaration().memory_bytes + 1);
    transform_->start(seed, memory_.data());
  }
  const ChannelDeclaration& emits() const { return transform_->declaration().channels.at(0); }

  /// One a second from 1 s on, of constant values.
  std::vector<Sample> run(int count, double v_slope = 0) {
    said.clear();
    for (int k = 1; k <= count; ++k) {
      const double fields[] = {lat, lon, height, 3 + v_slope * k}, rows[] = {5, 2e7, 9, 3e7}, covariance[] = {4};
      SampleView view;
      view.t = k * second;
      view.t0 = (k - 1) * second;
      view.rows = 2;
      view.fields = fields;
      view.row_fields = rows;
      view.covariance = covariance;
      transform_->on({Input(0, true), view, memory_.data()}, *this);
    }
    return said;
  }

  SampleWriter& on(OutputChannel) override {
    writer_ = {.fields = fields_, .row_fields = rows_, .covariance = covariance_};
    writer_.field_count = 4, writer_.row_width = 2, writer_.max_rows = 2, writer_.covariance_dof = 1;
    writer_.clear();
    return writer_;
  }
  void emit(OutputChannel) override {
    Sample sample{writer_.t, writer_.t0, {fields_, fields_ + 4}, {}, {}};
    for (int i = 0; i < writer_.rows; ++i) sample.rows.push_back({rows_[2 * i], rows_[2 * i + 1]});
    if (writer_.has_covariance) sample.covariance.assign(covariance_, covariance_ + 1);
    said.push_back(sample);
  }
  void emit_again(OutputChannel channel) override { emit(channel); }

  std::vector<Sample> said;

 private:
  ChannelDeclaration channel_;
  std::unique_ptr<faults::Faults> transform_;
  std::vector<std::byte> memory_;
  double fields_[4], rows_[4], covariance_[1];
  SampleWriter writer_;
};

std::vector<Sample> spoilt(const Json& fault, int count = 4, double v_slope = 0) {
  return Bench(Json::array({fault})).run(count, v_slope);
}
std::vector<double> column(const std::vector<Sample>& samples, std::size_t field) {
  std::vector<double> values;
  for (const auto& sample : samples) values.push_back(sample.fields[field]);
  return values;
}
using Values = std::vector<double>;

std::string refusal(const Json& fault) {
  try {
    spoilt(fault);
  } catch (const ComponentError& error) {
    return error.pointer() + ": " + error.what();
  }
  return "taken";
}

double mean(const std::vector<double>& values) {
  double sum = 0;
  for (const double v : values) sum += v;
  return sum / static_cast<double>(values.size());
}
double deviation(const std::vector<double>& values) {
  double sum = 0;
  for (const double v : values) sum += (v - mean(values)) * (v - mean(values));
  return std::sqrt(sum / static_cast<double>(values.size()));
}

}  // namespace

TEST_CASE("faults: without a fault the channel comes through to the bit, rows and covariance too") {
  Bench bench(Json::array());
  CHECK(bench.emits().name.empty());
  CHECK(bench.emits().fields.size() == 6);
  CHECK(bench.emits().max_rows == 2);
  const auto samples = bench.run(3, 0.5);
  REQUIRE(samples.size() == 3);
  CHECK(samples[1].t == 2 * second);
  CHECK(samples[1].t0 == 1 * second);
  CHECK(samples[1].fields == Values{lat, lon, height, 4});
  REQUIRE(samples[1].rows.size() == 2);
  CHECK(samples[1].rows[1].satellite == 9);
  CHECK(samples[1].rows[1].range == 3e7);
  CHECK(samples[1].covariance == Values{4});
}

TEST_CASE("faults: a step is there within its window, of which the end is not part") {
  const Json step = {{"kind", "step"}, {"fields", {"v"}}, {"by", 2}, {"from", 2}, {"until", 4}};
  CHECK(column(spoilt(step), at_v) == Values{3, 5, 5, 3});
  Json late = step;
  late["since"] = "start";  // the first sample is at 1 s
  CHECK(column(spoilt(late, 5), at_v) == Values{3, 3, 5, 5, 3});
  CHECK(column(spoilt(step), at_height) == Values{height, height, height, height});
}

TEST_CASE("faults: metres on latitude and longitude are metres on the ground") {
  const auto north = spoilt({{"kind", "step"}, {"fields", {"lat"}}, {"by", "m"}}).front();
  const auto east = spoilt({{"kind", "step"}, {"fields", {"lon"}}, {"by", "m"}}).front();
  const auto a = geodesy::radii(lat);
  CHECK((north.fields[at_lat] - lat) * (a.meridian + height) == Approx(1).epsilon(1e-6));
  CHECK((east.fields[at_lon] - lon) * (a.transverse + height) * std::cos(lat) == Approx(1).epsilon(1e-6));
}

TEST_CASE("faults: a ramp grows from nothing to its size") {
  const Json ramp = {{"kind", "ramp"}, {"fields", {"v"}}, {"by", 4}, {"from", 1}, {"until", 5}};
  CHECK(column(spoilt(ramp, 5), at_v) == Values{3, 4, 5, 6, 3});
}

TEST_CASE("faults: what is frozen stays as it was last") {
  const Json frozen = {{"kind", "freeze"}, {"fields", {"v", "range"}}, {"from", 3}, {"until", 5}};
  CHECK(column(spoilt(frozen, 5, 1), at_v) == Values{4, 5, 5, 5, 8});
}

TEST_CASE("faults: values are scaled, swapped, negated, coarse or none") {
  CHECK(spoilt({{"kind", "scale"}, {"fields", {"v"}}, {"factor", 0.5}})[0].fields[at_v] == 1.5);
  CHECK(spoilt({{"kind", "scale"}, {"fields", {"covariance"}}, {"factor", 0.25}})[0].covariance == Values{1});
  const auto swapped = spoilt({{"kind", "swap"}, {"fields", {"lat", "lon"}}})[0];
  CHECK(swapped.fields[at_lat] == lon);
  CHECK(swapped.fields[at_lon] == lat);
  CHECK(spoilt({{"kind", "negate"}, {"fields", {"height"}}})[0].fields[at_height] == -height);
  CHECK(spoilt({{"kind", "quantize"}, {"fields", {"height"}}, {"by", 50}})[0].fields[at_height] == 100);
  const auto none = spoilt({{"kind", "nan"}})[0];
  for (const double value : none.fields) CHECK(std::isnan(value));
  CHECK(std::isnan(none.rows[1].range));
}

TEST_CASE("faults: rows of one key alone") {
  const Json step = {{"kind", "step"}, {"fields", {"range"}}, {"by", 10}, {"row_field", "sat"}, {"row_value", 9}};
  const auto rows = spoilt(step)[0].rows;
  CHECK(rows[0].range == 2e7);
  CHECK(rows[1].range == 3e7 + 10);
}

TEST_CASE("faults: samples are dropped, doubled, labelled late, or jitter") {
  const auto window = [](const char* kind) { return Json{{"kind", kind}, {"from", 2}, {"until", 3}}; };
  CHECK(spoilt(window("drop")).size() == 3);
  const auto doubled = spoilt(window("duplicate"));
  REQUIRE(doubled.size() == 5);
  CHECK(doubled[1].t == doubled[2].t);
  const auto late = spoilt({{"kind", "delay"}, {"time", 0.25}});
  CHECK(late[0].t == second + second / 4);
  CHECK(late[0].t0 == second / 4);
  std::vector<double> labels;
  for (const auto& sample : spoilt({{"kind", "jitter"}, {"time", 0.1}}, 4000)) {
    const double t = seconds(sample.t);
    labels.push_back(t - static_cast<double>(labels.size() + 1));
  }
  CHECK(mean(labels) == Approx(0).margin(4 * 0.1 / std::sqrt(4000)));
  CHECK(deviation(labels) == Approx(0.1).epsilon(0.05));
}

TEST_CASE("faults: noise and outliers have the deviation and the share that they are given") {
  const auto noise = column(spoilt({{"kind", "noise"}, {"fields", {"v"}}, {"sigma", 2}}, 4000), at_v);
  CHECK(mean(noise) == Approx(3).margin(4 * 2 / std::sqrt(4000)));
  CHECK(deviation(noise) == Approx(2).epsilon(0.05));
  const auto relative = column(spoilt({{"kind", "noise"}, {"fields", {"v"}}, {"factor", 0.1}}, 4000), at_v);
  CHECK(deviation(relative) == Approx(0.3).epsilon(0.05));
  const Json outliers = {{"kind", "outliers"}, {"fields", {"v"}}, {"size", 50}, {"tail", "fixed"}, {"share", 0.1}};
  int high = 0, low = 0;
  for (const double v : column(spoilt(outliers, 4000), at_v)) high += v == 53, low += v == -47;
  CHECK(high == Approx(200).margin(4 * std::sqrt(190)));
  CHECK(low == Approx(200).margin(4 * std::sqrt(190)));
  // Student's t of 3 has the deviation √3 and 1 in 33 beyond 3.18.
  int beyond = 0;
  for (const double v : column(spoilt({{"kind", "outliers"}, {"fields", {"v"}}, {"size", 1}}, 10000), at_v))
    beyond += std::abs(v - 3) > 3.182;
  CHECK(beyond == Approx(500).margin(4 * std::sqrt(475)));
}

TEST_CASE("faults: the same seed gives the same, another another, and faults do not share a stream") {
  const Json noise = {{"kind", "noise"}, {"fields", {"v"}}, {"sigma", 1}};
  const auto values = [&](const Json& all, std::uint64_t seed) {
    return column(Bench(all, channel(), seed).run(5), at_v);
  };
  const Json one = Json::array({noise});
  CHECK(values(one, 1) == values(one, 1));
  CHECK(values(one, 1) != values(one, 2));
  const Json with_other = Json::array({noise, {{"kind", "drop"}, {"share", 0}}});
  CHECK(values(one, 1) == values(with_other, 1));
}

TEST_CASE("faults: what cannot be is refused at its place") {
  const auto step = [](const Json& more) {
    Json fault = {{"kind", "step"}, {"fields", {"v"}}, {"by", 1}};
    fault.update(more);
    return refusal(fault);
  };
  CHECK(step(Json::object()) == "taken");
  CHECK(step({{"fields", {"u"}}}) ==
        "/faults/0/fields/0: the channel has no field 'u' (it has lat, sat, lon, range, height, v)");
  CHECK(step({{"by", "m"}}) == "/faults/0/by: field 'v' is in m/s, not in m");
  CHECK(step({{"sigma", 1}}) == "/faults/0/sigma: 'step' has no 'sigma'");
  CHECK(step({{"from", 3}, {"until", 3}}) == "/faults/0/until: it ends before it begins");
  CHECK(step({{"row_field", "sat"}}).starts_with("/faults/0: 'row_field' and"));
  CHECK(step({{"row_field", "v"}, {"row_value", 1}}).starts_with("/faults/0/row_field: "));
  CHECK(refusal({{"kind", "step"}, {"fields", {"v"}}}) == "/faults/0: 'step' needs 'by'");
  CHECK(refusal({{"kind", "noise"}, {"sigma", 1}, {"factor", 1}}) ==
        "/faults/0: 'noise' needs either 'sigma' or 'factor'");
  CHECK(refusal({{"kind", "drop"}, {"fields", {"v"}}}).starts_with("/faults/0/fields: 'drop' is of whole samples"));
  CHECK(refusal({{"kind", "swap"}, {"fields", {"v"}}}).starts_with("/faults/0/fields: 'swap' needs two"));
  CHECK(refusal({{"kind", "swap"}, {"fields", {"v", "range"}}}).starts_with("/faults/0/fields: 'swap' needs two"));
  CHECK(refusal({{"kind", "negate"}, {"fields", {"covariance"}}}).starts_with("/faults/0/fields/0: 'covariance' can"));
  CHECK(refusal({{"kind", "ramp"}, {"fields", {"v"}}, {"by", 1}}) == "/faults/0: a ramp needs 'from' and 'until'");
}

}  // namespace faults_test
