// SPDX-License-Identifier: Apache-2.0
// allan: the noise of a channel by its Allan deviation.
#include <memory>
#include <string>

#include "allan_channel.hpp"
#include "atomic_file.hpp"
#include "interrupt.hpp"
#include "output.hpp"
#include "sentinel.hpp"
#include "verbs.hpp"

namespace binnacle::command {

namespace {

struct AllanVerbOptions {
  std::string config_path;
  ConfigOptions config;
  std::string channel, picture;
  double full = 1;
  std::uint64_t seed = 1;
  bool json = false;
};

int allan_of(const AllanVerbOptions& options) {
  watch_signals("nothing was written");
  std::unique_ptr<AtomicFile> picture;
  if (!options.picture.empty()) picture = std::make_unique<AtomicFile>(options.picture);
  const AllanChannel channel =
      allan_channel(options.config_path, options.config.load_options(options.config_path), options.channel,
                    options.full, options.seed, [] { return interrupted_by() == 0; });
  print_abridged(channel.warnings, "binnacle run has all");
  stand_down();
  if (interrupted_by() != 0) {
    picture.reset();
    print_error("interrupted; nothing was written");
    die_of_signal();
  }
  if (picture) {
    picture->write(allan_svg(channel));
    picture->commit();
  }
  if (options.json)
    print_json(allan_json(channel));
  else
    print(allan_text(channel));
  if (channel.samples > 0) return ok;
  print_error("no sample came on '" + options.channel + "'");
  return data;
}

}  // namespace

Verb allan_verb(CLI::App& command) {
  const auto options = std::make_shared<AllanVerbOptions>();
  CLI::App* app = add_verb(command, "allan");
  app->add_option("CONFIG", options->config_path, "The config")->required();
  options->config.add_to(*app);
  options->config.add_variant_to(*app);
  app->add_option("--channel", options->channel, "Channel, such as imu")->type_name("NAME")->required();
  app->add_option(
         "--overlap", options->full,
         "Largest averaging time in seconds with fully overlapping averages; longer averages overlap by at least 15/16")
      ->type_name("S")
      ->check(CLI::PositiveNumber)
      ->capture_default_str();
  app->add_option("--seed", options->seed, "Seed of all random numbers")->type_name("N")->capture_default_str();
  app->add_option("--picture", options->picture, "Write a plot of the deviations")->type_name("FILE.svg");
  app->add_flag("--json", options->json, "Print the figures as JSON on stdout");
  return {app, [options] { return allan_of(*options); }};
}

}  // namespace binnacle::command
