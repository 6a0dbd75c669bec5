// SPDX-License-Identifier: Apache-2.0
// The constellation_simulator transform: from where a vehicle is to what its receiver measures.
#include "constellation_simulator.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <iterator>
#include <string>

#include "constellation.hpp"
#include "gnss/channels.hpp"
#include "gnss/observation_rows.hpp"
#include "gnss/signal_path.hpp"
#include "random/normal.hpp"
#include "strapdown/earth.hpp"
#include "strapdown/rotation.hpp"

namespace binnacle::constellation_simulator {

namespace {

using Eigen::Vector3d;

constexpr int most_satellites = 32, most_systems = 8;

FieldSpec level(const char* name, const char* unit, const char* text, bool optional = false) {
  return {name, unit, FieldKind::level, optional, false, text};
}

/// All but the constellation's.
std::vector<ParameterSpec> receiver_parameters() {
  using namespace parameter;
  return {time("every").above(0).defaults("\"1 s\"").about(
              "time between epochs; the first is the first sample of the input"),
          number("elevation_mask", "rad")
              .at_least(-1.5)
              .at_most(1.5)
              .defaults("\"10 deg\"")
              .about("elevation below which satellites are not visible"),
          number("antenna_mask", "rad")
              .at_least(-1.5)
              .at_most(1.5)
              .about("angle above the body's x-y plane below which satellites are not visible, as in a banked turn; "
                     "requires roll, pitch, yaw"),
          boolean("earth_rotation").defaults("true").about("whether the earth rotates during the signal's travel"),
          object("pseudorange",
                 {number("bias", "m")
                      .at_least(0)
                      .defaults("6")
                      .about("1-sigma of the time-correlated error of each satellite, a Gauss-Markov process"),
                  number("tau", "s").above(0).defaults("1800").about("correlation time of this error"),
                  number("noise", "m").at_least(0).defaults("2").about("1-sigma of the white noise")})
              .defaults("{}")
              .about("errors of pseudoranges"),
          object("range_rate",
                 {number("noise", "m/s").at_least(0).defaults("0.05").about("1-sigma of the white noise")})
              .defaults("{}")
              .about("errors of range rates"),
          object("clock", {number("S_f", "m^2/s")
                               .at_least(0)
                               .defaults("0.009")
                               .about("power spectral density of the white frequency noise, times c^2"),
                           number("S_g", "m^2/s^3")
                               .at_least(0)
                               .defaults("0.0355")
                               .about("power spectral density of the random walk of the frequency, times c^2"),
                           number("bias", "m").at_least(0).defaults("100").about("1-sigma of the initial bias"),
                           number("drift", "m/s").at_least(0).defaults("1").about("1-sigma of the initial drift")})
              .defaults("{}")
              .about("the receiver's clock")};
}

/// What happens to it, and what else it emits.
std::vector<ParameterSpec> event_parameters() {
  using namespace parameter;
  return {list("cuts", object("cut", {time("from").required().about("start of the interval"),
                                      time("to").required().about("end of the interval"),
                                      integer("satellites")
                                          .at_least(0)
                                          .at_most(most_satellites)
                                          .required()
                                          .about("number of visible satellites that remain; 0: an outage"),
                                      choice("keep", {"highest", "lowest"})
                                          .defaults("\"highest\"")
                                          .about("selection of the remaining satellites")}))
              .about("intervals in which fewer satellites are visible"),
          list("faults",
               object("fault", {text("satellite").required().about("satellite, for example \"G05\""),
                                time("from").required().about("start of the interval"),
                                time("to").required().about("end of the interval"),
                                number("pseudorange", "m").defaults("0").about("error added to the pseudorange"),
                                number("range_rate", "m/s").defaults("0").about("error added to the range rate")}))
              .about("faulty measurements of satellites"),
          object("given",
                 {integer("systems")
                      .at_least(1)
                      .at_most(most_systems)
                      .defaults("1")
                      .about("satellite systems: satellite i is of system 1 + (i - 1) mod systems"),
                  number("offset", "m")
                      .at_least(0)
                      .defaults("100")
                      .about("1-sigma of the constant offset of the pseudoranges of each system after the first")})
              .about("additional channel NAME.given, with the same measurements and the satellites' ECEF positions"),
          list("clock_jumps",
               object("jump", {time("at").required().about("time of the reset"),
                               number("jump", "s").required().about("offset added to the receiver's clock")}))
              .about("resets of the receiver's clock")};
}

}  // namespace

/// Plain memory in the arena. Every satellite's deviates are drawn at every epoch, seen or not, so masks and cuts change no
/// other figure.
struct ConstellationSimulator::Memory {
  Time last;                                       // epoch; no_time: none yet
  double clock_bias, clock_drift;                  // m, m/s
  std::array<double, most_satellites> range_bias;  // m
  std::array<double, most_systems> offset;         // m, of the channel `given`
  random::Philox clock_stream, bias_stream, noise_stream, rate_stream;
};

struct ConstellationSimulator::Antenna {
  Vector3d r_e, v_e;
  Eigen::Matrix3d C_en;
  std::optional<Vector3d> up_e;  // of the body, where its attitude is known
};

/// What the receiver measures of one satellite.
struct ConstellationSimulator::Row {
  gnss::SatelliteKey satellite;
  double pseudorange, rate, sine;  // of its elevation
  gnss::SatelliteState state;      // when it sent
};

/// The rows of an epoch, at first none.
struct ConstellationSimulator::Rows {
  std::array<Row, most_satellites> all;
  int count = 0;
};

ComponentSpec ConstellationSimulator::spec() {
  ComponentSpec spec;
  spec.type = "constellation_simulator";
  spec.summary = "Pseudoranges and range rates of a receiver on a simulated vehicle, with the satellites' ephemerides.";
  spec.source =
      "paper 003, section 5.1, equations (5) and (7); IS-GPS-200 20.3.3.4.3; Brown and Hwang, 3rd ed., section 11.2";
  spec.parameters = constellation_parameters();
  const std::vector<ParameterSpec> own = receiver_parameters();
  spec.parameters.insert(spec.parameters.end(), own.begin(), own.end());
  const std::vector<ParameterSpec> events = event_parameters();
  spec.parameters.insert(spec.parameters.end(), events.begin(), events.end());
  spec.inputs = {{"truth",
                  {level("lat", "rad", "latitude of the antenna"), level("lon", "rad", "longitude of the antenna"),
                   level("height", "m", "height of the antenna"), level("vn", "m/s", "velocity of the antenna, north"),
                   level("ve", "m/s", "velocity of the antenna, east"),
                   level("vd", "m/s", "velocity of the antenna, down"), level("roll", "rad", "of the body", true),
                   level("pitch", "rad", "of the body", true), level("yaw", "rad", "of the body", true)},
                  false,
                  "true motion of the antenna; epochs are at times of its samples"}};
  spec.example = R"json({"input": "drive.truth", "elevation_mask": "10 deg",
    "cuts": [{"from": "200 s", "to": "400 s", "satellites": 3}]})json";
  return spec;
}

ConstellationSimulator::ConstellationSimulator(const Binding& binding) : constellation_(read_constellation(binding)) {
  const Parameters& parameters = binding.parameters();
  every_ = parameters.time("every");
  min_sin_elevation_ = std::sin(parameters.number("elevation_mask"));
  has_antenna_mask_ = parameters.has("antenna_mask");
  min_sin_antenna_ = has_antenna_mask_ ? std::sin(parameters.number("antenna_mask")) : -1.0;
  const Input input = binding.input("truth");
  position_ = binding.fields(input, "lat", "lon", "height");
  velocity_ = binding.fields(input, "vn", "ve", "vd");
  attitude_ = binding.fields(input, "roll", "pitch", "yaw");
  if (has_antenna_mask_ && !attitude_.is_bound())
    throw ComponentError("an antenna mask needs roll, pitch and yaw, which the channel does not carry",
                         "/antenna_mask");
  has_rotation_ = parameters.boolean("earth_rotation");
  bias_ = parameters.object("pseudorange").number("bias");
  tau_ = parameters.object("pseudorange").number("tau");
  noise_ = parameters.object("pseudorange").number("noise");
  rate_noise_ = parameters.object("range_rate").number("noise");
  if (parameters.has("given")) {
    systems_ = static_cast<int>(parameters.object("given").integer("systems"));
    offset_ = parameters.object("given").number("offset");
  }
  const Parameters clock = parameters.object("clock");
  S_f_ = clock.number("S_f"), S_g_ = clock.number("S_g");
  clock_bias_ = clock.number("bias"), clock_drift_ = clock.number("drift");
  read_events(parameters);

  declare_channels();
  memory_ = declaration_.keeps<Memory>();
}

void ConstellationSimulator::declare_channels() {
  const auto rows = static_cast<int>(constellation_.size());
  ChannelDeclaration seen("obs"), sent("ephemeris", gnss::ephemeris_fields()), clocks("truth");
  const auto fields = gnss::observation_fields(false);
  satellite_ = seen.carries_per_row(fields[gnss::observation::satellite]);
  pseudorange_ = seen.carries_per_row(fields[gnss::observation::pseudorange]);
  range_rate_ = seen.carries_per_row(fields[gnss::observation::range_rate]);
  seen.max_rows = sent.max_rows = rows;
  clock_bias_field_ = clocks.carries(level("bias", "m", "of the receiver's clock, times c"));
  clock_drift_field_ = clocks.carries(level("drift", "m/s", "of the receiver's clock, times c"));
  seen_field_ = clocks.carries(level("satellites", "1", "in view"));
  for (int i = 1; i < systems_; ++i) {
    const std::string name = "offset" + std::to_string(i - 1);
    offset_fields_.push_back(clocks.carries(level(name.c_str(), "m", "of system 2 and on, over system 1")));
  }
  observations_ = declaration_.emits(std::move(seen));
  ephemerides_ = declaration_.emits(std::move(sent));
  truth_ = declaration_.emits(std::move(clocks));
  if (systems_ > 0) declare_given(rows);
}

void ConstellationSimulator::declare_given(int rows) {
  ChannelDeclaration given("given", gnss::observation_fields(false));
  for (FieldSpec& field : gnss::given_fields()) given.fields.push_back(std::move(field));
  std::erase_if(given.fields, [](const FieldSpec& field) {
    return field.name == "cn0" || field.name.ends_with("_sigma") || field.name.ends_with("_variance");
  });
  given.max_rows = rows;
  given_ = declaration_.emits(std::move(given));
}

void ConstellationSimulator::read_events(const Parameters& parameters) {
  const auto span = [](const Parameters& event, const std::string& pointer) {
    const Span read{event.time("from"), event.time("to")};
    if (read.from > read.to) throw ComponentError("it ends before it begins", pointer);
    return read;
  };
  if (parameters.has("cuts"))
    for (const auto& element : parameters.list("cuts")) {
      const Parameters cut(element);
      cuts_.push_back({span(cut, "/cuts/" + std::to_string(cuts_.size())), static_cast<int>(cut.integer("satellites")),
                       cut.text("keep") == "lowest"});
    }
  if (parameters.has("faults"))
    for (const auto& element : parameters.list("faults")) {
      const Parameters fault(element);
      const std::string pointer = "/faults/" + std::to_string(faults_.size());
      const auto satellite = gnss::parse_satellite(fault.text("satellite"));
      if (!satellite)
        throw ComponentError("'" + fault.text("satellite") + "' is not a satellite: \"G01\" … \"G32\"",
                             pointer + "/satellite");
      if (std::none_of(constellation_.begin(), constellation_.end(),
                       [&](const gnss::Ephemeris& one) { return one.satellite == *satellite; }))
        throw ComponentError("'" + fault.text("satellite") + "' is none of the " +
                                 std::to_string(constellation_.size()) + " satellites that are simulated",
                             pointer + "/satellite");
      faults_.push_back({span(fault, pointer), *satellite, fault.number("pseudorange"), fault.number("range_rate")});
    }
  if (parameters.has("clock_jumps"))
    for (const auto& element : parameters.list("clock_jumps")) {
      const Parameters jump(element);
      jumps_.push_back({jump.time("at"), gnss::speed_of_light * jump.number("jump")});
    }
}

void ConstellationSimulator::initialise(std::uint64_t seed, const MemoryView& bytes) const {
  Memory& memory = bytes[memory_];
  memory.last = no_time;
  memory.clock_stream = random::stream(seed, "clock");
  memory.bias_stream = random::stream(seed, "pseudorange.bias");
  memory.noise_stream = random::stream(seed, "pseudorange.noise");
  memory.rate_stream = random::stream(seed, "range_rate.noise");
  memory.clock_bias = clock_bias_ * random::normal(memory.clock_stream);
  memory.clock_drift = clock_drift_ * random::normal(memory.clock_stream);
  for (double& bias : memory.range_bias) bias = bias_ * random::normal(memory.bias_stream);
  auto offsets = random::stream(seed, "given.offset");
  for (double& offset : memory.offset) offset = offset_ * random::normal(offsets);
  memory.offset[0] = 0;
}

/// Clock and slow errors from the last epoch to t.
void ConstellationSimulator::advance(Memory& memory, Time t) const {
  const double dt = memory.last == no_time ? 0.0 : seconds(t - memory.last);
  if (dt > 0) {
    const double variance = S_f_ * dt + S_g_ * dt * dt * dt / 3, cross = S_g_ * dt * dt / 2, rate_variance = S_g_ * dt;
    const double l11 = std::sqrt(variance), l21 = l11 > 0 ? cross / l11 : 0.0;
    const double l22 = std::sqrt(std::max(0.0, rate_variance - l21 * l21));
    const double first = random::normal(memory.clock_stream), second = random::normal(memory.clock_stream);
    memory.clock_bias += memory.clock_drift * dt + l11 * first;
    memory.clock_drift += l21 * first + l22 * second;
    const double decay = std::exp(-dt / tau_), kick = bias_ * std::sqrt(-std::expm1(-2 * dt / tau_));
    for (double& bias : memory.range_bias) bias = decay * bias + kick * random::normal(memory.bias_stream);
  }
  for (const Jump& jump : jumps_)
    if (jump.at <= t && (memory.last == no_time || jump.at > memory.last)) memory.clock_bias += jump.bias;
  memory.last = t;
}

void ConstellationSimulator::emit_ephemerides(Time t, Emitter& emitter) const {
  SampleWriter& out = emitter.on(ephemerides_);
  out.t = t;
  for (const gnss::Ephemeris& satellite : constellation_)
    gnss::write_ephemeris(satellite, out.row_view(out.rows++).data());
  emitter.emit(ephemerides_);
}

/// The tightest of the cuts at t; null: none.
const ConstellationSimulator::Cut* ConstellationSimulator::cut_at(Time t) const {
  const Cut* tightest = nullptr;
  for (const Cut& cut : cuts_)
    if (cut.span.contains(t) && (!tightest || cut.satellites < tightest->satellites)) tightest = &cut;
  return tightest;
}

bool ConstellationSimulator::is_visible(const Antenna& antenna, const Vector3d& direction) const {
  if (-antenna.C_en.col(2).dot(direction) < min_sin_elevation_) return false;
  return !antenna.up_e || antenna.up_e->dot(direction) >= min_sin_antenna_;
}

void ConstellationSimulator::measure(const Antenna& antenna, Time t, Memory& memory, Rows& rows) const {
  for (std::size_t i = 0; i < constellation_.size(); ++i) {
    const gnss::Ephemeris& satellite = constellation_[i];
    const double noise = noise_ * random::normal(memory.noise_stream),
                 rate_noise = rate_noise_ * random::normal(memory.rate_stream);
    double range =
        0.08 * gnss::speed_of_light;  // label less this over c: when it was sent; converges by 1e-5 each time
    gnss::SatelliteState state;
    gnss::SignalPath path;
    for (int k = 0; k < 4; ++k) {
      double back = range / gnss::speed_of_light;
      back += gnss::satellite_clock(satellite, t, back);
      state = gnss::satellite_state(satellite, t, back);
      path = gnss::signal_path(state.position, antenna.r_e, has_rotation_);
      range = path.range + memory.clock_bias - gnss::speed_of_light * state.clock;
    }
    if (!is_visible(antenna, path.direction)) continue;
    const double rate = gnss::range_rate(path, state.velocity, antenna.v_e, has_rotation_).rate;
    Row& row = rows.all[static_cast<std::size_t>(rows.count++)];
    row = {satellite.satellite, range + memory.range_bias[i] + noise,
           rate + memory.clock_drift - gnss::speed_of_light * state.clock_drift + rate_noise,
           -antenna.C_en.col(2).dot(path.direction), state};
    for (const Fault& fault : faults_)
      if (fault.satellite == satellite.satellite && fault.span.contains(t)) {
        row.pseudorange += fault.range;
        row.rate += fault.rate;
      }
  }
}

void ConstellationSimulator::apply(const Cut& cut, Rows& rows) {
  for (; rows.count > cut.satellites; --rows.count) {
    const auto end = rows.all.begin() + rows.count;
    const auto by_height = [](const Row& a, const Row& b) { return a.sine < b.sine; };
    const auto lost = cut.keeps_lowest ? std::max_element(rows.all.begin(), end, by_height)
                                       : std::min_element(rows.all.begin(), end, by_height);
    std::move(lost + 1, end, lost);
  }
}

void ConstellationSimulator::on(const TransformInput& in, Emitter& emitter) const {
  Memory& memory = in.memory[memory_];
  const SampleView& sample = in.sample;
  const Vector3d lla = sample[position_], v_n = sample[velocity_], roll_pitch_yaw = sample[attitude_];
  if (!lla.allFinite() || !v_n.allFinite()) return;
  if (memory.last != no_time && sample.t - memory.last < every_) return;
  if (memory.last == no_time) emit_ephemerides(sample.t, emitter);
  advance(memory, sample.t);

  Antenna antenna;
  antenna.C_en = strapdown::C_en(lla[0], lla[1]);
  antenna.r_e = strapdown::ecef_from_lla(lla);
  antenna.v_e = antenna.C_en * v_n;
  if (has_antenna_mask_ && roll_pitch_yaw.allFinite())
    antenna.up_e =
        -(antenna.C_en * strapdown::dcm_from_quaternion(strapdown::quaternion_from_euler(roll_pitch_yaw)).col(2));

  Rows rows;
  measure(antenna, sample.t, memory, rows);
  if (const Cut* const cut = cut_at(sample.t)) apply(*cut, rows);

  SampleWriter& clock = emitter.on(truth_);
  clock.t = sample.t;
  clock[clock_bias_field_] = memory.clock_bias;
  clock[clock_drift_field_] = memory.clock_drift;
  clock[seen_field_] = rows.count;
  for (std::size_t i = 0; i < offset_fields_.size(); ++i) clock[offset_fields_[i]] = memory.offset[i + 1];
  emitter.emit(truth_);
  if (rows.count == 0) return;
  SampleWriter& out = emitter.on(observations_);
  out.t = sample.t;
  out.rows = rows.count;
  for (int i = 0; i < rows.count; ++i) {
    const Row& seen = rows.all[static_cast<std::size_t>(i)];
    out(i, satellite_) = static_cast<double>(seen.satellite);
    out(i, pseudorange_) = seen.pseudorange;
    out(i, range_rate_) = seen.rate;
  }
  emitter.emit(observations_);
  if (systems_ > 0) emit_given(sample.t, memory, rows, emitter);
}

/// The rows of obs, each with its satellite: in the order of declare_given().
void ConstellationSimulator::emit_given(Time t, const Memory& memory, const Rows& rows, Emitter& emitter) const {
  SampleWriter& out = emitter.on(given_);
  out.t = t;
  out.rows = rows.count;
  for (int i = 0; i < rows.count; ++i) {
    const Row& seen = rows.all[static_cast<std::size_t>(i)];
    const auto number = static_cast<int>(seen.satellite % 100);
    const int system = (number - 1) % systems_;
    const Vector3d &r = seen.state.position, &v = seen.state.velocity;
    const double row[] = {static_cast<double>(number),
                          seen.pseudorange + memory.offset[static_cast<std::size_t>(system)],
                          seen.rate,
                          1.0 + system,
                          r[0],
                          r[1],
                          r[2],
                          v[0],
                          v[1],
                          v[2],
                          seen.state.clock,
                          seen.state.clock_drift};
    std::copy(std::begin(row), std::end(row), out.row_view(i).data());
  }
  emitter.emit(given_);
}

}  // namespace binnacle::constellation_simulator
