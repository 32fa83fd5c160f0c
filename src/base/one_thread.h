#pragma once

namespace mimbre {

/// While it lives, linear algebra called by this thread works in this thread alone, as far as the library
/// that was found has such a setting for one thread; other threads do not notice. See mimbre/threads.h.
class OneThread {
 public:
  OneThread();
  ~OneThread();
  OneThread(const OneThread&) = delete;
  OneThread& operator=(const OneThread&) = delete;

 private:
  int openmp_ = -1, mkl_ = 0;  ///< as they were
};

}  // namespace mimbre
