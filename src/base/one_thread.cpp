#include "base/one_thread.h"

#include <dlfcn.h>

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
  if (auto* const set = found<void(int)>("MKL_Set_Num_Threads")) set(1);
  if (auto* const set = found<void(int)>("omp_set_max_active_levels")) set(0);
}

}  // namespace mimbre
