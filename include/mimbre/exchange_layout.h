/* How a simulation that runs against the clock and another program hand each other numbers: by UDP packets or
 * in shared memory (docs/exchange.md). Plain C, of no other header of mimbre; little-endian machines. */
#ifndef MIMBRE_EXCHANGE_LAYOUT_H
#define MIMBRE_EXCHANGE_LAYOUT_H

#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

/** "MMX1" */
#define MIMBRE_EXCHANGE_MAGIC 0x31584d4du
/** Values of one side at most. */
#define MIMBRE_EXCHANGE_MOST 4096u

/** What a packet is. */
enum mimbre_exchange_kind {
  MIMBRE_EXCHANGE_HELLO = 1, /**< peer to simulation: send me the names, and outputs from now on; no values */
  MIMBRE_EXCHANGE_NAMES =
      2, /**< the answer: text behind the head, `count` bytes of it (see docs/exchange.md) */
  MIMBRE_EXCHANGE_OUTPUTS = 3, /**< simulation to peer, after each step */
  MIMBRE_EXCHANGE_INPUTS = 4,  /**< peer to simulation; what is no number stays as it is */
  MIMBRE_EXCHANGE_BYE = 5      /**< peer to simulation: no more outputs; no values */
};

/** Every packet begins with it; `count` doubles follow outputs and inputs. */
typedef struct mimbre_exchange_head {
  uint32_t magic;
  uint16_t kind;
  uint16_t count;
  uint64_t layout;   /**< of the names: outputs and inputs of another layout are not taken; 0 in a hello */
  uint64_t sequence; /**< outputs: steps made; inputs: that of the outputs that they answer, 0 for none */
  double time;       /**< s, of the simulation; inputs: not used */
} mimbre_exchange_head;

/** One side's values in shared memory. `version` is odd while they are written: who reads takes them as they
 * are when it is even, and the same before and after. Its values follow it. */
typedef struct mimbre_exchange_block {
  uint64_t version;
  uint64_t sequence; /**< as in a packet */
  double time;
} mimbre_exchange_block;

/** The beginning of the shared memory. Places are bytes from there. */
typedef struct mimbre_exchange_memory {
  uint32_t magic;
  uint32_t size; /**< bytes of it all */
  uint64_t layout;
  uint32_t outputs; /**< how many values the simulation writes */
  uint32_t inputs;  /**< how many the peer writes */
  uint32_t names;   /**< where the text with the names is */
  uint32_t names_size;
  uint32_t output_block; /**< where their mimbre_exchange_block is */
  uint32_t input_block;
  uint64_t alive; /**< 1 before the first step, and one more with each; 0: it has ended */
} mimbre_exchange_memory;

#ifdef __GNUC__
/** Copies a side's values out, at most `count` of them. Returns 1; 0 where they were being written all along.
 */
static inline int mimbre_exchange_read(const mimbre_exchange_block* block, uint64_t* sequence, double* time,
                                       double* values, uint32_t count) {
  const double* from = (const double*)(const void*)(block + 1);
  for (int attempt = 0; attempt < 16; ++attempt) {
    const uint64_t before = __atomic_load_n(&block->version, __ATOMIC_ACQUIRE);
    if (before & 1u) continue;
    const uint64_t number = __atomic_load_n(&block->sequence, __ATOMIC_RELAXED);
    double when;
    __atomic_load(&block->time, &when, __ATOMIC_RELAXED);
    for (uint32_t k = 0; k < count; ++k) __atomic_load(&from[k], &values[k], __ATOMIC_RELAXED);
    __atomic_thread_fence(__ATOMIC_ACQUIRE);
    if (__atomic_load_n(&block->version, __ATOMIC_RELAXED) != before) continue;
    *sequence = number;
    *time = when;
    return 1;
  }
  return 0;
}

/** Puts a side's values in. One program, one thread may. */
static inline void mimbre_exchange_write(mimbre_exchange_block* block, uint64_t sequence, double time,
                                         const double* values, uint32_t count) {
  double* to = (double*)(void*)(block + 1);
  const uint64_t version = __atomic_load_n(&block->version, __ATOMIC_RELAXED) | 1u;
  __atomic_store_n(&block->version, version, __ATOMIC_RELAXED);
  __atomic_thread_fence(__ATOMIC_RELEASE);
  __atomic_store_n(&block->sequence, sequence, __ATOMIC_RELAXED);
  __atomic_store(&block->time, &time, __ATOMIC_RELAXED);
  for (uint32_t k = 0; k < count; ++k) __atomic_store(&to[k], &values[k], __ATOMIC_RELAXED);
  __atomic_store_n(&block->version, version + 1u, __ATOMIC_RELEASE);
}
#endif

#ifdef __cplusplus
}
#endif

#endif
