// SPDX-License-Identifier: Apache-2.0
// life: made and unmade, alone and beside another, from one thread and from two, it is a function of what it is handed.
#include <algorithm>
#include <atomic>
#include <cmath>
#include <thread>

#include "allocations.hpp"
#include "fixture.hpp"
#include "miniature.hpp"
#include "tried_roles.hpp"

namespace binnacle::conform {

namespace {

void create(Trial& trial) {
  for (int i = 0; i < 3; ++i) {
    trial.stage("constructor");
    auto composition = compose_example(trial);
    trial.stage("destructor");
    composition.reset();
  }
  trial.stage("");
}

void calls(Trial& trial) {
  const auto subject = fixture_of_example(trial);
  auto memory = subject->fresh_memory();
  for (std::uint64_t k = 0; k < 5; ++k) {
    const Answer answer = subject->turn(k, memory.data(), unwritten());
    if (!answer.result) trial.warn("call ", k, " with ordinary input is refused: ", answer.result.reason);
    if (!trial.expect(answer.damage.empty(), answer.damage)) return;
    // A source or transform may leave a field untold; its check of numbers looks at that.
    if (trial.role != Role::source && trial.role != Role::transform)
      trial.expect(answer.is_finite(), "call ", k, " with ordinary input gives a number that is not finite");
  }
}

void repeatable(Trial& trial) {
  const auto subject = fixture_of_example(trial);
  if (subject->is_live()) Trial::not_applicable("its input cannot be read again");
  const auto another = fixture_of_example(trial);
  auto first = subject->fresh_memory(), again = subject->fresh_memory(), other = another->fresh_memory();
  const auto turns = static_cast<std::uint64_t>(trial.repeats(20));
  for (std::uint64_t k = 0; k < turns; ++k) {
    const Answer a = subject->turn(k, first.data(), unwritten());
    const Answer b = subject->turn(k, again.data(), unwritten());
    const Answer c = another->turn(k, other.data(), unwritten());
    if (!trial.expect(a == b, "call ", k,
                      " made twice from the same start gives two answers: a state of its own, or start() that differs"))
      return;
    if (!trial.expect(a == c, "call ", k, " on a second object with the same settings gives another answer")) return;
  }
}

/// The example with the first number that may be another one changed, so that the two instances differ.
Json other_settings(const ComponentSpec& spec, Json settings) {
  for (const auto& parameter : spec.parameters) {
    if (parameter.type != ParameterType::number || !std::isfinite(parameter.minimum) ||
        std::isfinite(parameter.maximum))
      continue;
    settings[parameter.name] = std::max(parameter.minimum, 0.0) + 0.37;
    return settings;
  }
  return settings;
}

void interleaved(Trial& trial) {
  const Catalog catalog = load_catalog(trial);
  const ComponentType& type = component(trial, catalog);
  const Json example = example_of(type.spec);
  const auto subject = fixture(trial, compose(trial, miniature(trial, type, catalog, example)));
  if (subject->is_live()) Trial::not_applicable("its input cannot be read again");
  auto alone = subject->fresh_memory();
  std::vector<Answer> expected;
  const auto turns = static_cast<std::uint64_t>(trial.repeats(20));
  for (std::uint64_t k = 0; k < turns; ++k) expected.push_back(subject->turn(k, alone.data(), unwritten()));

  std::unique_ptr<Fixture> other;
  try {
    other = fixture(trial, compose(trial, miniature(trial, type, catalog, other_settings(type.spec, example))));
  } catch (const Error&) {
    other = fixture_of_example(trial);
  }
  auto memory = subject->fresh_memory(), foreign = other->fresh_memory();
  for (std::uint64_t k = 0; k < turns; ++k) {
    other->turn(k + 1000, foreign.data(), unwritten());
    const Answer answer = subject->turn(k, memory.data(), unwritten());
    if (!trial.expect(answer == expected[k], "call ", k,
                      " gives another answer when a second instance is called in between: they share a state"))
      return;
  }
}

void defaults(Trial& trial) {
  const Catalog catalog = load_catalog(trial);
  const ComponentType& type = component(trial, catalog);
  const Json example = example_of(type.spec);
  Json spelled = example;
  for (const auto& parameter : type.spec.parameters)
    if (!parameter.default_json.empty() && parameter.default_json[0] != '/' && !spelled.contains(parameter.name))
      spelled[parameter.name] = Json::parse(parameter.default_json, nullptr, true, true);
  if (spelled == example) Trial::not_applicable("no parameter with a default is left to the default in the example");
  const auto implied = fixture(trial, compose(trial, miniature(trial, type, catalog, example)));
  const auto given = fixture(trial, compose(trial, miniature(trial, type, catalog, spelled)));
  auto a = implied->fresh_memory(), b = given->fresh_memory();
  const auto turns = static_cast<std::uint64_t>(trial.repeats(20));
  for (std::uint64_t k = 0; k < turns; ++k)
    if (!trial.expect(implied->turn(k, a.data(), unwritten()) == given->turn(k, b.data(), unwritten()),
                      "with its defaults spelled out, it gives another answer"))
      return;
}

void snapshot(Trial& trial) {
  const auto subject = fixture_of_example(trial);
  if (subject->memory_bytes() == 0) Trial::not_applicable("it has no memory");
  auto memory = subject->fresh_memory();
  const auto turns = static_cast<std::uint64_t>(trial.repeats(20));
  for (std::uint64_t k = 0; k < turns; ++k) subject->turn(k, memory.data(), unwritten());
  auto restored = memory;  // elsewhere: an address kept inside would show
  std::vector<Answer> expected;
  for (std::uint64_t k = turns; k < 2 * turns; ++k) expected.push_back(subject->turn(k, memory.data(), unwritten()));
  const auto another = fixture_of_example(trial);
  for (std::uint64_t k = turns; k < 2 * turns; ++k)
    if (!trial.expect(another->turn(k, restored.data(), unwritten()) == expected[k - turns],
                      "restored from a copy of its memory it continues differently: part of its state is elsewhere"))
      return;
}

void threads(Trial& trial) {
  const auto subject = fixture_of_example(trial);
  if (subject->is_live()) Trial::not_applicable("its input cannot be read again");
  const auto turns = static_cast<std::uint64_t>(trial.repeats(400));
  auto memory = subject->fresh_memory();
  std::vector<Answer> expected;
  for (std::uint64_t k = 0; k < turns; ++k) expected.push_back(subject->turn(k, memory.data(), unwritten()));
  std::atomic<bool> differs = false;
  std::atomic<int> ready = 0;
  const auto work = [&] {
    ++ready;
    while (ready < 2) std::this_thread::yield();
    for (int round = 0; round < 3; ++round) {
      auto own = subject->fresh_memory();
      for (std::uint64_t k = 0; k < turns && !differs; ++k)
        if (!(subject->turn(k, own.data(), unwritten()) == expected[k])) differs = true;
    }
  };
  std::thread second(work);
  work();
  second.join();
  trial.expect(!differs, "called from two threads at once it gives another answer: its const calls share something");
}

void leaks(Trial& trial) {
  if (!held_bytes_are_counted())
    Trial::not_applicable("bytes are not counted under a sanitizer, nor with a C library other than glibc");
  const auto life = [&] {
    auto subject = fixture_of_example(trial);
    auto memory = subject->fresh_memory();
    for (std::uint64_t k = 0; k < 20; ++k) subject->turn(k, memory.data(), unwritten());
  };
  for (int i = 0; i < 3; ++i) life();
  const auto before = held_bytes();
  constexpr int lives = 10;
  for (int i = 0; i < lives; ++i) life();
  const auto grown = held_bytes() - before;
  trial.expect(grown < 8 * lives, "leaks ", grown / lives, " bytes a life (made, called 20 times, unmade)");
}

}  // namespace

std::vector<Check> life_checks() {
  return {
      check("life.create", 1, every_role, {"metadata.example", "metadata.declared"},
            "it can be made and unmade without being used", create),
      check("life.calls", 2, called_roles, {"life.create"},
            "ordinary calls return, throw nothing and write exactly what was declared", calls),
      check("life.repeatable", 2, called_roles, {"life.calls"}, "same input, same memory: same output, bit for bit",
            repeatable),
      check("life.interleaved", 3, called_roles, {"life.repeatable"}, "two instances do not affect each other",
            interleaved),
      check("life.defaults", 3, called_roles, {"life.repeatable"}, "defaults given are defaults implied", defaults),
      check("life.snapshot", 3, called_roles, {"life.repeatable"},
            "restored from a copy of its memory it continues as if uninterrupted", snapshot),
      check("life.threads", 4, called_roles, {"life.repeatable", "life.interleaved"},
            "its const calls may run in two threads at once", threads),
      check("life.leaks", 4, called_roles, {"life.repeatable"}, "it frees all memory that it allocated", leaks),
  };
}

}  // namespace binnacle::conform
