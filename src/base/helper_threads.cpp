#include "base/helper_threads.h"

#include <dlfcn.h>

#include <mutex>

namespace mimbre {
namespace {

std::mutex mutex;
int users = 0;

/// Found at run time: which BLAS and which OpenMP are there is the system's choice.
void end_threads() {
  using EndBlas = int (*)();
  static const auto end_blas = reinterpret_cast<EndBlas>(dlsym(RTLD_DEFAULT, "blas_thread_shutdown_"));
  if (end_blas) end_blas();
  using EndOpenMp = int (*)(int);
  constexpr int soft = 1;  // omp_pause_soft: OpenMP 5.0, 3.2.44
  static const auto end_openmp = reinterpret_cast<EndOpenMp>(dlsym(RTLD_DEFAULT, "omp_pause_resource_all"));
  if (end_openmp) end_openmp(soft);
}

}  // namespace

HelperThreads::HelperThreads() {
  const std::lock_guard lock(mutex);
  ++users;
}

HelperThreads::~HelperThreads() {
  const std::lock_guard lock(mutex);
  if (--users == 0) end_threads();
}

void end_helper_threads() {
  const std::lock_guard lock(mutex);
  if (users == 0) end_threads();
}

}  // namespace mimbre
