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

/// A model, of bytes that mimbre::model_bytes() wrote, and its source, of portable::source_bytes(); without
/// bytes it has no parameters. Both stay where they are while it is open. NULL: the reason is in `message`,
/// which has `room` bytes.
mimbre_model* mimbre_model_open(const unsigned char* bytes, size_t size, const unsigned char* source,
                                size_t source_size, char* message, size_t room);
void mimbre_model_close(mimbre_model* model);
/// Back to the start, with the inputs and parameters of the model.
int mimbre_model_begin(mimbre_model* model);
/// Whether a fixed parameter (portable::fixed_parameters()) may have a value now; else mimbre_model_message()
/// says why not.
int mimbre_model_check_parameter(mimbre_model* model, int parameter, double value);
/// From now on the model is the one with this value. It is read again when something of it is next asked for.
int mimbre_model_set_parameter(mimbre_model* model, int parameter, double value);
/// Its value, also of one that follows from others.
int mimbre_model_parameter(mimbre_model* model, int parameter, double* value);
/// Finds the start with the inputs and parameters that were set.
int mimbre_model_find(mimbre_model* model);
/// The same, once and for all: inputs that are set from now on act in the next step.
int mimbre_model_start(mimbre_model* model);
double mimbre_model_time(const mimbre_model* model);
/// How many events of the model have happened.
double mimbre_model_event_count(const mimbre_model* model);
/// An input or a parameter, within its range. Before mimbre_model_start() and the first step the start is
/// that of a model with this value, equilibrium included.
int mimbre_model_set_input(mimbre_model* model, int input, double value);
/// Not a number where the start cannot be found with the inputs that were set.
double mimbre_model_output(mimbre_model* model, int output);
/// Derivatives of outputs where inputs and the time change by the given amounts and the motion and all states
/// are held: `inputs` has a number for each input and parameter; writes one for each of the `count` outputs.
int mimbre_model_vary(mimbre_model* model, const double* inputs, double time, const int* outputs, int count,
                      double* derivatives);
/// One step, with the number of its iterations.
int mimbre_model_step(mimbre_model* model, int* iterations);
/// Why the last call that failed did so.
const char* mimbre_model_message(const mimbre_model* model);
/// All that the next step depends on, as bytes: so many now. 0: there is none.
size_t mimbre_model_state_size(mimbre_model* model);
int mimbre_model_save(mimbre_model* model, unsigned char* bytes, size_t size);
int mimbre_model_restore(mimbre_model* model, const unsigned char* bytes, size_t size);
}
#pragma GCC visibility pop
