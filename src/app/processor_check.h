#pragma once

/// Ends the program with a message, exit code 2, where the processor lacks instructions that it is compiled
/// for. It runs before any other code of the program: what initialises globals is compiled for that
/// processor, too. For main.cpp alone, which is compiled for any processor. MIMBRE_PROCESSOR_LEVEL is the
/// `-march` of all else.
#if defined(__x86_64__) && defined(MIMBRE_PROCESSOR_LEVEL)
#include <unistd.h>

namespace mimbre::app {

__attribute__((constructor(101))) inline void check_processor() {
  __builtin_cpu_init();
  if (__builtin_cpu_supports(MIMBRE_PROCESSOR_LEVEL)) return;
  static constexpr char message[] =
      "mimbre: this program is compiled for processors of the level " MIMBRE_PROCESSOR_LEVEL
      " (Intel and AMD since 2013 to 2015; for x86-64-v4 with AVX-512), and this processor lacks some of its "
      "instructions; "
      "build it here with: cmake --preset release -DMIMBRE_PROCESSOR=native\n";
  [[maybe_unused]] const auto written = write(STDERR_FILENO, message, sizeof message - 1);
  _exit(2);
}

}  // namespace mimbre::app
#endif
