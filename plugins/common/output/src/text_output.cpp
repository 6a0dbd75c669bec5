// SPDX-License-Identifier: Apache-2.0
#include "output/text_output.hpp"

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <stdexcept>
#include <string>
#include <utility>

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include "worker.hpp"

namespace binnacle::text_output {

namespace {

using address::Descriptor;
using address::Kind;

/// A serial line is at most a second behind.
std::size_t buffer_of(const address::Address& address, std::size_t wanted) {
  if (address.kind != Kind::serial) return wanted;
  return std::min(wanted, std::max<std::size_t>(1024, static_cast<std::size_t>(address.baud) / 10));
}

bool is_regular(int descriptor) {
  struct stat status {};
  return ::fstat(descriptor, &status) == 0 && S_ISREG(status.st_mode);
}

}  // namespace

std::vector<ParameterSpec> TextOutput::parameters() {
  std::vector<ParameterSpec> specs;
  specs.push_back(
      parameter::path("to").required().about("stdout:, file:PATH, tcp://HOST:PORT (connects), tcp://:PORT (a server on "
                                             "loopback), tcp://HOST:PORT?server (a server "
                                             "there), udp://HOST:PORT, serial:///dev/NAME?baud=115200"));
  specs.push_back(parameter::integer("buffer").at_least(1024).at_most(1 << 30).defaults("1048576").about(
      "buffer in bytes for a slow receiver; beyond it the oldest lines are lost and counted; for a serial line, at "
      "most the bytes of one second"));
  return specs;
}

TextOutput::TextOutput(const Parameters& parameters)
    : address_(address::parse(parameters.text("to"), address::Direction::output, "/to")),
      buffer_(buffer_of(address_, static_cast<std::size_t>(parameters.integer("buffer")))) {}

TextOutput::~TextOutput() = default;

void TextOutput::open() {
  worker_.reset();
  lines_ = lost_ = 0;
  is_cut_ = false;
  if (open_file()) return;
  try {
    worker_ = std::make_unique<Worker>(address_, buffer_);
  } catch (const std::runtime_error& fault) {
    throw ComponentError("'" + address_.text + "': " + fault.what(), "/to");
  }
}

/// False: it is no regular file.
bool TextOutput::open_file() {
  if (address_.kind == Kind::standard_output) {
    file_ = Descriptor(is_regular(STDOUT_FILENO) ? ::fcntl(STDOUT_FILENO, F_DUPFD_CLOEXEC, 0) : -1);
    return static_cast<bool>(file_);
  }
  if (address_.kind != Kind::file) return false;
  file_ = Descriptor(::open(address_.path.c_str(), O_WRONLY | O_CREAT | O_NONBLOCK | O_CLOEXEC | O_NOCTTY, 0666));
  if (!file_)
    throw ComponentError("'" + address_.path + "' cannot be opened: " + std::strerror(errno) +
                             (errno == ENXIO ? "; this pipe has no reader" : ""),
                         "/to");
  is_old_ = is_regular(file_.get());
  if (is_old_) return true;
  file_.reset();
  return false;
}

/// At the first line, or the end: a run that is resumed goes on in it.
void TextOutput::empty_file() {
  if (std::exchange(is_old_, false) && ::ftruncate(file_.get(), 0) != 0)
    throw ComponentError("'" + address_.path + "' cannot be emptied: " + std::strerror(errno), "/to");
}

void TextOutput::exchange(StateBytes& bytes) {
  if (!file_ || address_.kind != Kind::file) return;
  if (!bytes.is_reading()) empty_file();
  std::int64_t position = ::lseek(file_.get(), 0, SEEK_CUR);
  bytes.value(position);
  bytes.value(lines_);
  bytes.value(lost_);
  bytes.value(is_cut_);
  if (!bytes.is_reading() || !bytes.holds()) return;
  is_old_ = false;
  const auto refuse = [&](const std::string& why) { throw ComponentError::in_data(why, address_.path, 0, "B084"); };
  struct stat status {};
  if (::fstat(file_.get(), &status) != 0 || status.st_size < position)
    refuse("is shorter than at the checkpoint, so the run cannot continue in it");
  if (::ftruncate(file_.get(), position) != 0 || ::lseek(file_.get(), position, SEEK_SET) != position)
    refuse(std::string("cannot be cut back to the checkpoint: ") + std::strerror(errno));
}

void TextOutput::write(std::string_view line) {
  if (file_) return write_file(line);
  if (!worker_) return;
  worker_->add(line);
  if (worker_->has_warnings()) pass_warnings();
}

void TextOutput::write_file(std::string_view line) {
  empty_file();
  ++lines_;
  const ssize_t count = is_cut_ ? ::write(file_.get(), "\n", 1) : 1;
  if (count == 1) is_cut_ = false;
  std::string_view rest = line;
  while (!is_cut_ && !rest.empty()) {
    const ssize_t written = ::write(file_.get(), rest.data(), rest.size());
    if (written < 0 && errno == EINTR) continue;
    if (written < 0) break;
    rest.remove_prefix(static_cast<std::size_t>(written));
  }
  if (rest.empty()) return;
  is_cut_ = is_cut_ || rest.size() < line.size();
  if (lost_++ == 0) warn("B146", std::string(std::strerror(errno)) + "; lines are lost until there is room again");
}

void TextOutput::close() {
  if (file_) {
    empty_file();
    if (lost_ > 0) warn("B145", loss_text(lost_, lines_) + ": they could not be written to the file");
    file_.reset();
  }
  if (!worker_) return;
  worker_->finish();
  pass_warnings();
  worker_.reset();
}

void TextOutput::pass_warnings() {
  for (const auto& [code, message] : worker_->take_warnings()) warn(code, message);
}

void TextOutput::warn(const char* code, const std::string& message) {
  if (reporter_) reporter_->warn(code, address_.text, 0, message);
}

}  // namespace binnacle::text_output
