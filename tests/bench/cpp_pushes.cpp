// SPDX-License-Identifier: Apache-2.0
// The pushes of python_session_bench.py in C++, in the same process and on the same numbers.
#include <time.h>

#include <cstddef>
#include <cstdint>
#include <exception>
#include <iostream>
#include <memory>

#include "binnacle/composition.hpp"
#include "binnacle/session.hpp"

using namespace binnacle;

namespace {

double thread_seconds() {
  timespec now{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &now);
  return static_cast<double>(now.tv_sec) + 1e-9 * static_cast<double>(now.tv_nsec);
}

}  // namespace

extern "C" __attribute__((visibility("default"))) double cpp_pushes(const char* config, const char* plugins,
                                                                    const char* first_channel, const double* first,
                                                                    const double* first_covariance, const char* channel,
                                                                    std::size_t count, std::size_t width,
                                                                    const Time* t0s, const Time* ts,
                                                                    const double* fields, double* state) {
  try {
    LoadOptions options;
    options.plugin_folders.emplace_back(plugins);
    static const auto composition = Composition::load(config, options);
    Session session(composition);
    SampleView start{.t = t0s[0], .fields = first, .covariance = first_covariance, .available = true};
    session.push(session.channel(first_channel), start);
    const ChannelId imu = session.channel(channel);
    const double begin = thread_seconds();
    for (std::size_t i = 0; i < count; ++i) session.push(imu, t0s[i], ts[i], {fields + i * width, width});
    const double end = thread_seconds();
    for (const double x : session.state({0})) *state++ = x;
    return end - begin;
  } catch (const std::exception& error) {
    std::cerr << error.what() << '\n';
    return -1;
  }
}
