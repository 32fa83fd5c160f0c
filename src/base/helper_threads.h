#pragma once

namespace mimbre {

/// While one lives, the linear algebra below may keep helper threads. When the last one goes they end.
class HelperThreads {
 public:
  HelperThreads();
  ~HelperThreads();
  HelperThreads(const HelperThreads&) = delete;
  HelperThreads& operator=(const HelperThreads&) = delete;
};

/// Ends the helper threads of OpenBLAS and of OpenMP (CHOLMOD's), which may wait for work by spinning and
/// would take cores from what runs in time, unless a HelperThreads lives; they come back with the next work.
/// Does nothing where these libraries are others. A program that calls OpenBLAS itself from another thread at
/// that moment must hold a HelperThreads.
void end_helper_threads();

}  // namespace mimbre
