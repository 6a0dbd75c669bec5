// SPDX-License-Identifier: Apache-2.0
#include "error.hpp"

#include <exception>
#include <new>

#include "wording/diagnostics_json.hpp"

namespace binnacle::c {

namespace {

struct LastError {
  std::string text;
  std::string json = "[]";
  bool is_out_of_memory = false;
};
thread_local LastError last_error;

void keep(const Diagnostics& diagnostics) {
  std::string json = json_text(diagnostics);
  last_error.text = diagnostics.text();
  last_error.json = std::move(json);
  last_error.is_out_of_memory = false;
}

void keep(const std::string& message) {
  Diagnostics diagnostics;
  diagnostics.error("", {}, "", message);
  keep(diagnostics);
}

/// Rethrows what is being handled. It may throw where there is no memory for the message.
binnacle_status keep_what_is_handled(const std::string& function) {
  try {
    throw;
  } catch (const Error& error) {
    keep(error.diagnostics());
    return error.exit_status();
  } catch (const std::invalid_argument& error) {
    keep(function + ": " + error.what());
    return BINNACLE_USAGE;
  } catch (const std::out_of_range& error) {
    keep(function + ": " + error.what());
    return BINNACLE_USAGE;
  } catch (const std::exception& error) {
    keep(function + ": internal: " + error.what());
  } catch (...) {
    keep(function + ": internal: something was thrown that is not a std::exception");
  }
  return BINNACLE_INTERNAL;
}

}  // namespace

std::string json_text(const Diagnostics& diagnostics) {
  return wording::to_json(diagnostics).dump(-1, ' ', false, nlohmann::ordered_json::error_handler_t::replace);
}

binnacle_status keep_exception(const char* function) noexcept {
  try {
    return keep_what_is_handled(function);
  } catch (...) {
    last_error.is_out_of_memory = true;
    return BINNACLE_INTERNAL;
  }
}

}  // namespace binnacle::c

using binnacle::c::last_error;

const char* binnacle_last_error() {
  return last_error.is_out_of_memory ? "error: there is no memory left" : last_error.text.c_str();
}

const char* binnacle_last_error_json() {
  return last_error.is_out_of_memory
             ? R"([{"severity":"error","code":"","file":"","line":0,"column":0,"pointer":"",)"
               R"("message":"there is no memory left","text":"error: there is no memory left"}])"
             : last_error.json.c_str();
}
