// SPDX-License-Identifier: Apache-2.0
// faulty_check SUITE LIBRARY CHECK [STATUS[/STATUS]]: the suite finds CHECK to be fail (or STATUS), and nothing else that is
// bad. CHECK "nothing": it finds nothing at all. CHECK "verdict": nothing is bad, and yet it does not conform, for none of
// the checks of numbers could be tried.
#include <cstdio>
#include <cstdlib>
#include <string>

#include <nlohmann/json.hpp>

namespace {

std::string output_of(const std::string& command, int& status) {
  std::string text;
  FILE* pipe = ::popen(command.c_str(), "r");
  if (!pipe) return text;
  char buffer[4096];
  for (std::size_t count; (count = std::fread(buffer, 1, sizeof buffer, pipe)) > 0;) text.append(buffer, count);
  status = ::pclose(pipe);
  return text;
}

}  // namespace

int main(int argc, char** argv) {
  if (argc < 4) return 2;
  const std::string wanted = argv[3], wanted_status = argc > 4 ? argv[4] : "fail";
  int status = 0;
  const std::string text =
      output_of("'" + std::string(argv[1]) + "' '" + argv[2] + "' --json - --jobs 1 --time-limit 10 --level 5", status);
  const auto results = nlohmann::json::parse(text, nullptr, false);
  if (!results.is_object()) return std::fprintf(stderr, "no JSON but: %s\n", text.c_str()), 1;

  const bool is_verdict = wanted == "verdict";
  bool is_found = wanted == "nothing" || (is_verdict && !results.at("untried").empty()), is_good = true, is_bad = false;
  for (const auto& check : results.at("checks")) {
    const std::string id = check.at("check"), found = check.at("status"), message = check.at("message");
    is_bad |= found == "fail" || found == "crash" || found == "timeout";
    if (id == wanted && ("/" + wanted_status + "/").find("/" + found + "/") != std::string::npos) {
      is_found = true;
      std::printf("%s is %s: %s\n", id.c_str(), found.c_str(), message.c_str());
    } else if (found != "pass" && found != "skip" && !(is_verdict && found == "warn")) {
      is_good = false;
      std::printf("besides, %s is %s: %s\n", id.c_str(), found.c_str(), message.c_str());
    }
  }
  if (!is_found) std::printf("%s is not %s\n", wanted.c_str(), wanted_status.c_str());
  if (results.at("conforms") == (is_bad || is_verdict)) return std::printf("and the verdict is wrong\n"), 1;
  return is_found && is_good ? 0 : 1;
}
