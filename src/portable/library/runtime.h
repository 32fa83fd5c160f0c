#pragma once
#include <stddef.h>

/// What an FMU with the library inside calls (FmuOptions::with_library): one model in motion, by functions of
/// C. The same declarations are in the FMU's own source (library_text.cpp). Nothing is thrown. Any number of
/// models may be open; each is used by one thread at a time.
#pragma GCC visibility push(default)
extern "C" {

typedef struct mimbre_model mimbre_model;

/// How a step or another call ended; mimbre_model_message() says why it failed.
enum {
  mimbre_model_ok = 0,
  mimbre_model_unconverged = 1,  ///< made, before its iterations had converged
  mimbre_model_failed = 2,       ///< the state is as before
  mimbre_model_stopped = 3       ///< an event of the model ended the run within the step
};

/// A model, of bytes that mimbre::model_bytes() wrote. They stay where they are while it is open. NULL: the
/// reason is in `message`, which has `room` bytes.
mimbre_model* mimbre_model_open(const unsigned char* bytes, size_t size, char* message, size_t room);
void mimbre_model_close(mimbre_model* model);
/// Back to the start, with the inputs of the model.
int mimbre_model_begin(mimbre_model* model);
/// Finds the start with the inputs that were set.
int mimbre_model_find(mimbre_model* model);
/// The same, once and for all: inputs that are set from now on act in the next step.
int mimbre_model_start(mimbre_model* model);
double mimbre_model_time(const mimbre_model* model);
/// An input or a parameter, within its range. Before mimbre_model_start() and the first step the start is
/// that of a model with this value, equilibrium included.
int mimbre_model_set_input(mimbre_model* model, int input, double value);
/// Not a number where the start cannot be found with the inputs that were set.
double mimbre_model_output(mimbre_model* model, int output);
/// One step, with the number of its iterations.
int mimbre_model_step(mimbre_model* model, int* iterations);
/// Why the last call that failed did so.
const char* mimbre_model_message(const mimbre_model* model);
/// All that the next step depends on, as bytes: at most state_bytes() (library_code.h).
int mimbre_model_save(mimbre_model* model, unsigned char* bytes, size_t size);
int mimbre_model_restore(mimbre_model* model, const unsigned char* bytes, size_t size);
}
#pragma GCC visibility pop
