#include "base/one_thread.h"

#include <dlfcn.h>

#include <cstdlib>

#include "mimbre/threads.h"

namespace mimbre {
namespace {

/// Found at run time: which BLAS and which OpenMP are there is the system's choice.
template <class Function>
Function* found(const char* name) {
  return reinterpret_cast<Function*>(dlsym(RTLD_DEFAULT, name));
}

/// Without active levels OpenMP's parallel regions are their first thread's, also those that ask for a number
/// of threads, as CHOLMOD's do; the setting is the calling thread's (max-active-levels-var, OpenMP 5.0,
/// 2.5.1, GCC from 11). MKL_Set_Num_Threads_Local gives back what it replaces, 0 where that was none.
struct Settings {
  int (*openmp_levels)() = found<int()>("omp_get_max_active_levels");
  void (*set_openmp_levels)(int) = found<void(int)>("omp_set_max_active_levels");
  int (*set_mkl)(int) = found<int(int)>("MKL_Set_Num_Threads_Local");
};
const Settings& settings() {
  static const Settings all;
  return all;
}

/// OpenBLAS picks its kernels by the processor when it is loaded, and their sums differ in the last bits. It
/// reads the name of a processor from the environment, but then alone: so it starts again.
void use_the_kernels_of_the_baseline() {
  static constexpr const char* variable = "OPENBLAS_CORETYPE";
  auto* const end = found<void()>("gotoblas_dynamic_quit");
  auto* const start = found<void()>("gotoblas_dynamic_init");
  if (!end || !start || std::getenv(variable)) return;
#ifdef __x86_64__
  if (!__builtin_cpu_supports("avx2") || !__builtin_cpu_supports("fma")) return;
  ::setenv(variable, "Haswell", 1);
  end();
  start();
  ::unsetenv(variable);
#endif
}

}  // namespace

OneThread::OneThread() {
  const Settings& s = settings();
  if (s.openmp_levels && s.set_openmp_levels) {
    openmp_ = s.openmp_levels();
    s.set_openmp_levels(0);
  }
  if (s.set_mkl) mkl_ = s.set_mkl(1);
}

OneThread::~OneThread() {
  const Settings& s = settings();
  if (openmp_ >= 0) s.set_openmp_levels(openmp_);
  if (s.set_mkl) s.set_mkl(mkl_);
}

void use_one_blas_thread() {
  if (auto* const set = found<void(int)>("openblas_set_num_threads")) set(1);
  // They come back where somebody asks for more.
  if (auto* const end = found<int()>("blas_thread_shutdown_")) end();
  use_the_kernels_of_the_baseline();
  if (auto* const set = found<void(int)>("MKL_Set_Num_Threads")) set(1);
  if (auto* const set = found<void(int)>("omp_set_max_active_levels")) set(0);
}

}  // namespace mimbre
