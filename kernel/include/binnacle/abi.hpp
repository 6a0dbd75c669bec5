// SPDX-License-Identifier: Apache-2.0
// The ABI guard: what a plugin was compiled with, as plain data that can be read before its code is trusted.
#pragma once

#include <Eigen/Core>

#include <cstddef>
#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "binnacle/eigen.hpp"
#include "binnacle/registry.hpp"

// SHA-256 over these headers, its first 16 hex digits, as `#define BINNACLE_HEADER_HASH 0x…ull`; made by the build.
#if __has_include("binnacle/header_hash.hpp")
#include "binnacle/header_hash.hpp"
#endif
#ifndef BINNACLE_HEADER_HASH
#define BINNACLE_HEADER_HASH 0
#endif

namespace binnacle::abi {

inline constexpr std::uint64_t magic = 0x454c'4341'4e4e'4942;  // "BINNACLE", little-endian
inline constexpr std::uint32_t api_major = 1;                  // changes with any interface; refused
inline constexpr std::uint32_t api_minor = 0;                  // additions; a newer one than the host's is refused

/// Size and alignment of a type, in bytes.
struct TypeLayout {
  std::uint32_t size;
  std::uint32_t align;
};

/// The types that cross, in the order of TypeLayouts. Names for messages; the guard carries the numbers only.
// clang-format off
#define BINNACLE_ABI_TYPES(X)                                                                                         \
  X(std::string) X(std::vector<double>) X(std::unique_ptr<Source>) X(ParameterSpec) X(PortSpec) X(FieldSpec)          \
  X(ChannelPort) X(ComponentSpec) X(ParameterValue) X(Parameters) X(ComponentError) X(NamedUnit) X(PortBinding)       \
  X(Binding) X(NoiseBinding) X(Port) X(Field) X(RowField) X(DrivingRate) X(Input) X(MatrixView) X(ConstMatrixView)    \
  X(VectorView) X(ConstVectorView) X(Result) X(Driving) X(Output) X(Norm) X(StateBlockDeclaration) X(Coupling)        \
  X(ProcessDeclaration) X(InputSample) X(Step) X(ProcessOutput) X(ContinuousOutput) X(ProcessInput)                   \
  X(ContinuousInput) X(PhiBlock) X(QBlock) X(ResidualGroup) X(MeasurementDeclaration) X(MeasurementInput)             \
  X(MeasurementOutput) X(DerivedDeclaration) X(DerivedInput) X(DerivedOutput) X(Innovation) X(ChannelDeclaration)     \
  X(SampleView) X(SampleWriter) X(StateBlock) X(ProcessModel) X(MeasurementModel) X(DerivedBlock) X(NoiseEstimator)     \
  X(Source) X(Transform) X(Sink) X(Registry) X(Reporter) X(Emitter)
// clang-format on

#define BINNACLE_ABI_COUNT(...) +1
inline constexpr std::uint32_t type_count = 0 BINNACLE_ABI_TYPES(BINNACLE_ABI_COUNT);
#undef BINNACLE_ABI_COUNT
inline constexpr std::uint32_t max_types = 96;
static_assert(type_count <= max_types);

/// Widths are fixed and there is no padding, so it reads the same whatever compiled it.
struct Guard {
  std::uint64_t magic;
  std::uint32_t size;  // of this struct
  std::uint32_t api_major;
  std::uint32_t api_minor;
  std::uint32_t types_used;
  TypeLayout types[max_types];         // the first types_used of them
  std::uint32_t standard_library;      // 1 libstdc++, 2 libc++, 0 another
  std::uint32_t standard_library_abi;  // libstdc++: _GLIBCXX_USE_CXX11_ABI + 2 · inline namespace. libc++: its version
  std::uint32_t debug_containers;      // 1 _GLIBCXX_DEBUG, 2 libc++'s debug mode
  std::uint32_t container_assertions;  // _GLIBCXX_ASSERTIONS: does not change layouts
  std::uint32_t sanitizers;            // Sanitizer bits
  std::uint32_t eigen_version;         // world · 10000 + major · 100 + minor
  std::uint32_t eigen_max_align;       // EIGEN_MAX_ALIGN_BYTES
  std::uint32_t reserved;
  std::uint64_t instruction_sets;  // bits of BINNACLE_ABI_INSTRUCTION_SETS; x86 only
  std::uint64_t header_hash;
  char compiler[64];
  char name[64];
  char version[32];
};

/// Bits of Guard::sanitizers.
enum Sanitizer : std::uint32_t { address_sanitizer = 1, thread_sanitizer = 2, memory_sanitizer = 4 };

namespace detail {

/// Its start, if it is longer; the rest of `to` is zero.
template <std::size_t N>
consteval void copy_start(char (&to)[N], const char* from) {
  for (std::size_t i = 0; i + 1 < N && from[i] != '\0'; ++i) to[i] = from[i];
}

template <std::size_t N>
consteval void copy_text(char (&to)[N], const char* from) {
  if (std::char_traits<char>::length(from) >= N) throw "this text is too long for the guard";
  copy_start(to, from);
}

consteval std::uint32_t sanitizer_bits() {
  std::uint32_t bits = 0;
#if defined(__SANITIZE_ADDRESS__)
  bits |= address_sanitizer;
#endif
#if defined(__SANITIZE_THREAD__)
  bits |= thread_sanitizer;
#endif
#if defined(__has_feature)
#if __has_feature(address_sanitizer)
  bits |= address_sanitizer;
#endif
#if __has_feature(thread_sanitizer)
  bits |= thread_sanitizer;
#endif
#if __has_feature(memory_sanitizer)
  bits |= memory_sanitizer;
#endif
#endif
  return bits;
}

// The compiler's macro for each instruction set, and the name that -m and __builtin_cpu_supports take. Each has the bit of
// its place; append only.
// clang-format off
#define BINNACLE_ABI_INSTRUCTION_SETS(X)                                                                              \
  X(__SSE3__, "sse3") X(__SSSE3__, "ssse3") X(__SSE4_1__, "sse4.1") X(__SSE4_2__, "sse4.2") X(__POPCNT__, "popcnt")   \
  X(__AVX__, "avx") X(__AVX2__, "avx2") X(__FMA__, "fma") X(__BMI__, "bmi") X(__BMI2__, "bmi2")                       \
  X(__AVX512F__, "avx512f") X(__AVX512CD__, "avx512cd") X(__AVX512DQ__, "avx512dq") X(__AVX512BW__, "avx512bw")       \
  X(__AVX512VL__, "avx512vl") X(__AVX512IFMA__, "avx512ifma") X(__AVX512VBMI__, "avx512vbmi")                         \
  X(__AVX512VNNI__, "avx512vnni") X(__AVX512VBMI2__, "avx512vbmi2") X(__AVX512BITALG__, "avx512bitalg")               \
  X(__AVX512VPOPCNTDQ__, "avx512vpopcntdq") X(__FMA4__, "fma4") X(__XOP__, "xop") X(__SSE4A__, "sse4a")
// clang-format on

consteval std::uint64_t instruction_set_bits() {
  std::uint64_t bits = 0;
  int i = 0;
  // A macro that is defined is 1 by then, any other is still its own name.
#define BINNACLE_ABI_TEXT(macro) #macro
#define BINNACLE_ABI_BIT(macro, name) bits |= std::uint64_t{BINNACLE_ABI_TEXT(macro)[0] == '1'} << i++;
  BINNACLE_ABI_INSTRUCTION_SETS(BINNACLE_ABI_BIT)
#undef BINNACLE_ABI_BIT
#undef BINNACLE_ABI_TEXT
  return bits;
}

}  // namespace detail

/// Evaluated where it is written, with that file's compiler settings, and at compile time: nothing of the plugin runs.
/// A name or version that is too long does not compile.
consteval Guard make_guard(const char* name, const char* version) {
  Guard guard{};
  guard.magic = magic;
  guard.size = sizeof(Guard);
  guard.api_major = api_major;
  guard.api_minor = api_minor;
  guard.types_used = type_count;
  std::size_t i = 0;
#define BINNACLE_ABI_LAYOUT(...)                                       \
  guard.types[i++] = {static_cast<std::uint32_t>(sizeof(__VA_ARGS__)), \
                      static_cast<std::uint32_t>(alignof(__VA_ARGS__))};
  BINNACLE_ABI_TYPES(BINNACLE_ABI_LAYOUT)
#undef BINNACLE_ABI_LAYOUT
#if defined(__GLIBCXX__)
  guard.standard_library = 1;
  guard.standard_library_abi = _GLIBCXX_USE_CXX11_ABI + 2 * _GLIBCXX_INLINE_VERSION;
#elif defined(_LIBCPP_VERSION)
  guard.standard_library = 2;
  guard.standard_library_abi = _LIBCPP_ABI_VERSION;
#endif
#ifdef _GLIBCXX_DEBUG
  guard.debug_containers |= 1;
#endif
#ifdef _LIBCPP_ENABLE_DEBUG_MODE
  guard.debug_containers |= 2;
#endif
#ifdef _GLIBCXX_ASSERTIONS
  guard.container_assertions = 1;
#endif
  guard.sanitizers = detail::sanitizer_bits();
  guard.eigen_version = EIGEN_WORLD_VERSION * 10000 + EIGEN_MAJOR_VERSION * 100 + EIGEN_MINOR_VERSION;
  guard.eigen_max_align = EIGEN_MAX_ALIGN_BYTES;
  guard.instruction_sets = detail::instruction_set_bits();
  guard.header_hash = BINNACLE_HEADER_HASH;
#if defined(__clang__)
  detail::copy_start(guard.compiler, "Clang " __VERSION__);
#elif defined(__GNUC__)
  detail::copy_start(guard.compiler, "GCC " __VERSION__);
#else
  detail::copy_start(guard.compiler, "another compiler");
#endif
  detail::copy_text(guard.name, name);
  detail::copy_text(guard.version, version);
  return guard;
}

}  // namespace binnacle::abi
