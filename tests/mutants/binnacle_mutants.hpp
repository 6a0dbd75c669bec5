// SPDX-License-Identifier: Apache-2.0
// Switches of mutants: draw.py puts this header into the first line of each file that it rewrites.
//   BINNACLE_MUTANT=17,23   mutants 17 and 23 are on
//   BINNACLE_REACHED=FILE   each process appends the number of each mutant that it reaches, once
// It includes nothing, and each library has its own copy of the state.
#pragma once

namespace binnacle_mutants {
extern "C" {
char* getenv(const char*) noexcept;
int open(const char*, int, ...);
long write(int, const void*, unsigned long);
int close(int);
}
}  // namespace binnacle_mutants

#pragma GCC visibility push(hidden)
namespace binnacle_mutants {

constexpr int most = 4096;

struct State {
  State() {
    reached = getenv("BINNACLE_REACHED");
    int id = -1;
    for (const char* c = getenv("BINNACLE_MUTANT"); c; ++c) {
      if (*c >= '0' && *c <= '9') {
        id = (id < 0 ? 0 : 10 * id) + (*c - '0');
        continue;
      }
      if (id >= 0 && id < most) is_on[id] = true;
      id = -1;
      if (*c == '\0') break;
    }
  }

  const char* reached = nullptr;
  bool is_on[most] = {};
  bool is_noted[most] = {};
};

inline State state;

[[gnu::noinline, gnu::cold]] inline void note(int id) {
  if (__atomic_exchange_n(&state.is_noted[id], true, __ATOMIC_RELAXED)) return;
  char text[16];
  int at = sizeof text;
  text[--at] = '\n';
  for (int rest = id; rest > 0 || at == sizeof text - 1; rest /= 10) text[--at] = static_cast<char>('0' + rest % 10);
  const int file = open(state.reached, 02002101, 0666);  // O_WRONLY | O_CREAT | O_APPEND | O_CLOEXEC
  if (file < 0) return;
  if (write(file, text + at, sizeof text - static_cast<unsigned long>(at)) < 0) state.is_noted[id] = false;
  close(file);
}

inline bool on(int id) {
  if (state.reached) note(id);
  return state.is_on[id];
}

}  // namespace binnacle_mutants
#pragma GCC visibility pop
