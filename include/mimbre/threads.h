#pragma once

namespace mimbre {

/// From now on linear algebra of the whole process (OpenBLAS, MKL, OpenMP) works in the thread that calls it,
/// and the helper threads that OpenBLAS has are ended: finite-element reductions then have the same bits
/// whatever the number of processors, and nothing waits, by spinning, beside steps in real time. OpenBLAS
/// also computes by its kernels for AVX2 where the processor has it, whatever else it has, for the same bits
/// on every such machine; OPENBLAS_CORETYPE in the environment chooses others. For a process that is the
/// caller's own, once, before other threads use such libraries or the environment; the program `mimbre`
/// begins with it. mimbre itself changes no thread pool: while it factorises, it asks for its own thread
/// alone where a library has such a setting for one thread (OpenMP, MKL; not OpenBLAS with threads of its
/// own, whose number decides the last bits then).
void use_one_blas_thread();

}  // namespace mimbre
