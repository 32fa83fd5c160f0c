#include "mimbre/build.h"

namespace mimbre {
namespace {

std::string compiler() {
#if defined(__clang__)
  return "Clang " __clang_version__;
#elif defined(__GNUC__)
  return "GCC " __VERSION__;
#else
  return "unknown";
#endif
}

std::string instructions() {
  std::string all;
  const auto add = [&](const char* name) { all += (all.empty() ? "" : ", ") + std::string(name); };
#ifdef __AVX512F__
  add("avx512f");
#endif
#ifdef __AVX2__
  add("avx2");
#endif
#ifdef __FMA__
  add("fma");
#endif
#ifdef __SSE2__
  if (all.empty()) add("sse2");
#endif
#ifdef __ARM_NEON
  add("neon");
#endif
  return all.empty() ? "none" : all;
}

}  // namespace

const BuildInfo& build_info() {
  static const BuildInfo info{MIMBRE_VERSION, compiler(), instructions()};
  return info;
}

}  // namespace mimbre
