// SPDX-License-Identifier: Apache-2.0
// Lines to files, sockets and pseudo-terminals; receivers that are slow, come, go, or are not there.
#include "output/text_output.hpp"

#include <algorithm>
#include <csignal>
#include <fstream>
#include <iterator>
#include <numeric>

#include <sys/stat.h>

#include "allocations.hpp"
#include "catch.hpp"
#include "output/line_queue.hpp"
#include "receivers.hpp"

namespace text_output_test {

using namespace binnacle;
using namespace binnacle::receivers;
using text_output::LineQueue;
using text_output::TextOutput;
using Clock = std::chrono::steady_clock;

namespace {

TextOutput output_to(const std::string& to, std::int64_t buffer = 1 << 20) {
  ParameterValue address, bytes, all;
  address.type = ParameterValue::Type::text;
  address.text = to;
  bytes.type = ParameterValue::Type::integer;
  bytes.integer = buffer;
  all.type = ParameterValue::Type::object;
  all.members = {{"to", address}, {"buffer", bytes}};
  return TextOutput(Parameters(all));
}

std::string line(int i) { return "line " + std::to_string(i) + "\n"; }

std::string lines(int from, int to) {
  std::string text;
  for (int i = from; i < to; ++i) text += line(i);
  return text;
}

std::string server(int port) { return "tcp://:" + std::to_string(port); }

std::string text_of(const std::string& path) {
  std::ifstream file(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(file), {}};
}

std::string refusal(const std::string& to) {
  try {
    output_to(to).open();
  } catch (const ComponentError& error) {
    return error.pointer() + ": " + error.what();
  }
  return "";
}

/// Writes until the condition holds, for three seconds at most; how many.
template <class Condition>
int write_until(TextOutput& output, Condition&& holds) {
  const auto begin = Clock::now();
  for (int i = 0;; ++i) {
    if (holds() || Clock::now() - begin > std::chrono::seconds(3)) return i;
    output.write(line(i));
    std::this_thread::sleep_for(std::chrono::milliseconds(5));
  }
}

/// Sum of "N of M lines were lost".
int lost_in(const std::vector<std::string>& messages) {
  int lost = 0;
  for (const auto& message : messages) {
    const auto at = message.find(" of ");
    const auto begin = message.rfind(' ', at - 1);
    lost += std::stoi(message.substr(begin == message.npos ? 0 : begin + 1));
  }
  return lost;
}

}  // namespace

TEST_CASE("a queue of lines: what does not fit pushes the oldest out, and a line that was begun stays whole") {
  LineQueue queue(20);
  for (int i = 0; i < 4; ++i) queue.push("abc" + std::to_string(i) + "\n");
  CHECK(queue.waiting() == "abc0\nabc1\nabc2\nabc3\n");
  queue.sent(2);  // "c0\n" is left of the first
  queue.push("xyz\n");
  CHECK(queue.waiting() == "c0\nabc2\nabc3\nxyz\n");
  CHECK(queue.lost() == 1);
  CHECK(queue.lines() == 4);
  queue.push("0123456789012345678901234567890\n");
  CHECK(queue.waiting() == "c0\n");  // everything that could go did, and still there is no room
  CHECK(queue.lost() == 5);
  queue.restart();
  CHECK(queue.empty());
  CHECK(queue.lost() == 6);
  CHECK(queue.lines() == 0);
}

TEST_CASE("a queue of lines neither loses nor cuts one while it is emptied in pieces") {
  LineQueue queue(1000);
  std::string sent, pushed;
  for (int i = 0; i < 2000; ++i) {
    const std::string text = line(i);
    pushed += text;
    queue.push(text);
    while (queue.waiting().size() > static_cast<std::size_t>(i % 97)) {
      const auto piece = queue.waiting().substr(0, static_cast<std::size_t>(1 + i % 5));
      sent += piece;
      queue.sent(piece.size());
    }
  }
  sent += queue.waiting();
  CHECK(sent == pushed);
  CHECK(queue.lost() == 0);
}

TEST_CASE("a file has every line, at once") {
  const Folder folder;
  auto output = output_to("file:" + (folder / "lines.txt"));
  Warnings warnings;
  output.report_to(warnings);
  output.open();
  for (int i = 0; i < 20000; ++i) output.write(line(i));
  CHECK(text_of(folder / "lines.txt") == lines(0, 20000));
  output.close();
  output.open();  // the next run
  output.write(line(7));
  output.close();
  CHECK(text_of(folder / "lines.txt") == line(7));
  CHECK(warnings.all.empty());
}

TEST_CASE("a full disk is reported once, and what is lost is counted") {
  auto output = output_to("file:/dev/full");
  Warnings warnings;
  output.report_to(warnings);
  output.open();
  for (int i = 0; i < 10; ++i) output.write(line(i));
  output.close();
  REQUIRE(warnings.of("B146").size() == 1);
  CHECK(warnings.of("B146").front().find("No space left") == 0);
  CHECK(lost_in(warnings.of("B145")) == 10);
}

TEST_CASE("UDP: a datagram for each line") {
  const Reading socket(bound(SOCK_DGRAM));
  auto output = output_to("udp://127.0.0.1:" + std::to_string(port_of(socket.fd())));
  Warnings warnings;
  output.report_to(warnings);
  output.open();
  for (int i = 0; i < 50; ++i) output.write(line(i));
  output.close();
  for (int i = 0; i < 50; ++i) {
    char bytes[100];
    const auto count = ::recv(socket.fd(), bytes, sizeof bytes, 0);
    REQUIRE(std::string(bytes, static_cast<std::size_t>(count)) == line(i));
  }
  CHECK(warnings.all.empty());
}

TEST_CASE("UDP to nobody is reported, and goes on once somebody is there") {
  const int port = port_of(Reading(bound(SOCK_DGRAM)).fd());
  auto output = output_to("udp://127.0.0.1:" + std::to_string(port));
  Warnings warnings;
  output.report_to(warnings);
  output.open();
  write_until(output, [&] { return !warnings.all.empty(); });
  REQUIRE(warnings.of("B146").size() == 1);
  CHECK(warnings.of("B146").front().find("Connection refused") == 0);
  const Reading socket(bound(SOCK_DGRAM, port));
  write_until(output, [&] {
    pollfd handle{socket.fd(), POLLIN, 0};
    return ::poll(&handle, 1, 0) == 1;
  });
  output.close();
  CHECK(lost_in(warnings.of("B145")) > 0);
}

TEST_CASE("a server gives each client the lines since it came, whole") {
  const int port = free_port();
  auto output = output_to(server(port));
  Warnings warnings;
  output.report_to(warnings);
  output.open();
  Reading first = connected(port);
  write_until(output, [&] {
    pollfd handle{first.fd(), POLLIN, 0};
    return ::poll(&handle, 1, 0) == 1;
  });
  Reading second = connected(port);
  write_until(output, [&] {
    pollfd handle{second.fd(), POLLIN, 0};
    return ::poll(&handle, 1, 0) == 1;
  });
  for (int i = 1000; i < 3000; ++i) output.write(line(i));
  output.close();
  for (const Reading* client : {&first, &second}) {
    const std::string text = client->all();
    CHECK(text.rfind("line ", 0) == 0);
    CHECK(text.ends_with(lines(1000, 3000)));
  }
  CHECK(warnings.all.empty());
}

TEST_CASE("a client that never reads holds nobody up, and what it loses is counted") {
  constexpr int count = 200'000;
  const int port = free_port();
  auto output = output_to(server(port), 1 << 16);
  Warnings warnings;
  output.report_to(warnings);
  output.open();
  const Reading idle = connected(port, 4096);
  Reading good = connected(port);
  write_until(output, [&] {
    pollfd handles[2] = {{good.fd(), POLLIN, 0}, {idle.fd(), POLLIN, 0}};
    return ::poll(handles, 2, 0) == 2;
  });
  std::string received;
  std::thread reader([&] { received = good.all(); });
  const auto begin = Clock::now();
  double slowest = 0;
  for (int i = 0; i < count; ++i) {
    const auto before = Clock::now();
    output.write(line(i));
    slowest = std::max(slowest, std::chrono::duration<double>(Clock::now() - before).count());
    if (i % 200 == 199)
      std::this_thread::sleep_for(std::chrono::milliseconds(1));  // a fast run, and one that can be read
  }
  const double written_s = std::chrono::duration<double>(Clock::now() - begin).count();
  output.close();
  const double closed_s = std::chrono::duration<double>(Clock::now() - begin).count() - written_s;
  reader.join();
  INFO(written_s << " s for all, " << slowest << " s for the slowest, " << closed_s << " s to close");
  CHECK(slowest < 0.5);  // nothing of a receiver is waited for; the machine may do other things
  CHECK(closed_s < 20);  // a receiver that never reads is not waited for
  CHECK(received.ends_with(lines(count - 100, count)));
  const auto lost = warnings.of("B145");
  REQUIRE(lost.size() == 1);
  CHECK(lost.front().find("read too slowly") != std::string::npos);
  const int in_kernel = static_cast<int>(idle.all(std::chrono::milliseconds(200)).size());
  CHECK(lost_in(lost) > count / 2);
  CHECK(lost_in(lost) < count + 1000);
  INFO(in_kernel << " bytes reached it");
  CHECK(in_kernel > 0);
}

TEST_CASE("a pipe's reader that begins late and reads in pieces gets all that the buffer holds") {
  const Folder folder;
  const std::string pipe = folder / "pipe";
  REQUIRE(::mkfifo(pipe.c_str(), 0600) == 0);
  const Reading reading(::open(pipe.c_str(), O_RDONLY | O_NONBLOCK));
  auto output = output_to("file:" + pipe, 8 << 20);
  Warnings warnings;
  output.report_to(warnings);
  output.open();
  std::string received;
  std::thread reader([&] {
    std::this_thread::sleep_for(std::chrono::milliseconds(1500));
    const std::size_t size = lines(0, 200'000).size();
    while (received.size() < size) {
      const auto piece = reading.bytes(std::min<std::size_t>(65536, size - received.size()));
      if (piece.empty()) break;
      received += piece;
      std::this_thread::sleep_for(std::chrono::milliseconds(20));
    }
  });
  for (int i = 0; i < 200'000; ++i) {
    output.write(line(i));
    if (i % 1000 == 0) std::this_thread::sleep_for(std::chrono::milliseconds(1));  // the worker empties its ring
  }
  output.close();
  reader.join();
  CHECK(received == lines(0, 200'000));
  CHECK(warnings.all.empty());
}

TEST_CASE("a client that goes in mid-run ends nothing, and another may come") {
  const int port = free_port();
  auto output = output_to(server(port));
  Warnings warnings;
  output.report_to(warnings);
  output.open();
  for (int visit = 0; visit < 3; ++visit) {
    Reading client = connected(port);
    write_until(output, [&] {
      pollfd handle{client.fd(), POLLIN, 0};
      return ::poll(&handle, 1, 0) == 1;
    });
    client.close();
    for (int i = 0; i < 100; ++i) output.write(line(i));
  }
  Reading last = connected(port);
  write_until(output, [&] {
    pollfd handle{last.fd(), POLLIN, 0};
    return ::poll(&handle, 1, 0) == 1;
  });
  output.close();
  CHECK_FALSE(last.all().empty());
  CHECK(warnings.of("B145").empty());
}

TEST_CASE("a server without any client says so at the end") {
  auto output = output_to(server(free_port()));
  Warnings warnings;
  output.report_to(warnings);
  output.open();
  for (int i = 0; i < 10; ++i) output.write(line(i));
  output.close();
  REQUIRE(warnings.all.size() == 1);
  CHECK(warnings.all.front().message == "no client came; 10 lines went to nobody");
}

TEST_CASE("a TCP client connects again when the other side comes back") {
  Reading entrance(bound(SOCK_STREAM));
  const int port = port_of(entrance.fd());
  ::listen(entrance.fd(), 4);
  auto output = output_to("tcp://127.0.0.1:" + std::to_string(port));
  Warnings warnings;
  output.report_to(warnings);
  output.open();
  {
    const Reading peer(::accept(entrance.fd(), nullptr, nullptr));
    output.write(line(1));
    CHECK(peer.bytes(line(1).size()) == line(1));
  }
  write_until(output, [&] { return !warnings.all.empty(); });
  REQUIRE(warnings.of("B146").size() == 1);
  CHECK(warnings.of("B146").front().find("the program tries again every second") != std::string::npos);
  const Reading again(::accept(entrance.fd(), nullptr, nullptr));
  output.write("after\n");
  output.close();
  const std::string text = again.all();
  CHECK(text.ends_with("after\n"));
  CHECK(text.rfind("line ", 0) == 0);  // no half line
}

TEST_CASE("a pseudo-terminal gets the lines as they are") {
  Terminal terminal;
  auto output = output_to("serial://" + terminal.device() + "?baud=115200");
  Warnings warnings;
  output.report_to(warnings);
  output.open();
  std::string text;
  std::thread reader([&] { text = terminal.master().bytes(2 * lines(0, 100).size()); });
  for (int i = 0; i < 100; ++i) output.write("line " + std::to_string(i) + "\r\n");
  output.close();
  reader.join();
  std::string expected;
  for (int i = 0; i < 100; ++i) expected += "line " + std::to_string(i) + "\r\n";
  CHECK(text == expected);
  CHECK(warnings.all.empty());
}

TEST_CASE("a device that vanishes is reported, and the run goes on") {
  auto terminal = std::make_unique<Terminal>();
  auto output = output_to("serial://" + terminal->device());
  Warnings warnings;
  output.report_to(warnings);
  output.open();
  output.write(line(0));
  CHECK(terminal->master().bytes(line(0).size()) == line(0));
  terminal.reset();
  write_until(output, [&] { return !warnings.all.empty(); });
  REQUIRE(warnings.of("B146").size() == 1);
  for (int i = 0; i < 1000; ++i) output.write(line(i));
  output.close();
  CHECK(lost_in(warnings.of("B145")) > 0);
}

TEST_CASE("a serial line that is not read is at most a second behind") {
  Terminal terminal;
  auto output = output_to("serial://" + terminal.device() + "?baud=19200");
  Warnings warnings;
  output.report_to(warnings);
  output.open();
  for (int i = 0; i < 20'000; ++i) {
    output.write(line(i));
    if (i % 500 == 0) std::this_thread::sleep_for(std::chrono::milliseconds(2));
  }
  std::this_thread::sleep_for(std::chrono::milliseconds(100));
  std::string text;
  std::thread reader([&] { text = terminal.master().all(std::chrono::milliseconds(500)); });
  output.close();
  reader.join();
  const auto received = lines_of(text);
  CHECK(received.back() == "line 19999");
  CHECK(received.front() == "line 0");
  // What the system holds, and what a second of the line carries.
  CHECK(text.size() < 65536 + 2000);
  CHECK(lost_in(warnings.of("B145")) == 20'000 - static_cast<int>(received.size()));
}

TEST_CASE("what cannot be opened is refused with the reason") {
  const Reading taken(bound(SOCK_STREAM));
  ::listen(taken.fd(), 1);
  const int port = port_of(taken.fd());
  CHECK(refusal(server(port)).find("Address already in use") != std::string::npos);
  CHECK(refusal(server(port)).rfind("/to: 'tcp://:" + std::to_string(port) + "'", 0) == 0);
  CHECK(refusal("tcp://127.0.0.1:" + std::to_string(free_port())).find("Connection refused") != std::string::npos);
  CHECK(refusal("serial:///dev/ttyNONE").find("No such file") != std::string::npos);
  CHECK(refusal("file:/nowhere/file.txt").find("No such file") != std::string::npos);
  CHECK(refusal("udp://no.such.host.invalid:5005").find("cannot be found") != std::string::npos);
  CHECK(refusal("stdin:").find("did you mean 'stdout:'?") != std::string::npos);
  CHECK(refusal("nonsense://x").rfind("/to: ", 0) == 0);
}

TEST_CASE("writing does not allocate once it is warm") {
  if (!conform::allocations_are_counted()) return;
  const Folder folder;
  const Reading datagrams(bound(SOCK_DGRAM));
  const int port = free_port();
  for (const std::string& to :
       {"file:" + (folder / "lines.txt"), server(port), "udp://127.0.0.1:" + std::to_string(port_of(datagrams.fd()))}) {
    auto output = output_to(to);
    output.open();
    const std::string text = line(1);
    output.write(text);
    const auto before = conform::allocations();
    for (int i = 0; i < 1000; ++i) output.write(text);
    CHECK(conform::allocations() == before);
    output.close();
  }
}

TEST_CASE("an output that is not closed leaves its thread and its port") {
  const int port = free_port();
  {
    auto output = output_to(server(port));
    output.open();
    output.write(line(0));
  }
  auto output = output_to(server(port));
  output.open();
  output.open();  // as a run that broke leaves it
  output.close();
}

}  // namespace text_output_test
