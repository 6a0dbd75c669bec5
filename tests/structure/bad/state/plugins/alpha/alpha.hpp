// SPDX-License-Identifier: Apache-2.0
// A model that keeps state in every place there is, among much that only looks like it.
#pragma once

#include <string>

namespace alpha {

inline constexpr double gravity = 9.8;
const int table[] = {1, 2, 3};
extern const char text[];
using Size = int;
struct Forward;
enum class Kind { one, two };

inline int calls = 0;       // bad
int counts[3] = {0, 0, 0};  // bad
std::string name{"alpha"};  // bad
thread_local int depth;     // bad

template <class T>
T twice(T x) {
  static_assert(sizeof(T) > 1);
  return static_cast<T>(2 * x);
}

/* mutable in a comment; */
class Model {
 public:
  static Model spec();
  static constexpr int rows = 3;
  static const char* title(int row = 0) { return row ? "static mutable" : "x"; }
  int evaluate(double x) const {
    static const double half = 0.5;
    static int n = 0;                             // bad
    const_cast<Model*>(this)->value_ = x * half;  // bad
    return ++n;
  }
  Model& operator=(const Model&) = default;

 private:
  static int instances_;     // bad
  mutable double value_{1};  // bad
  double gain_ = 1'000;
};

}  // namespace alpha
