#include "portable/library/library_text.h"

/// The interface of generated code by the library's runtime, whose functions runtime.h describes.
namespace mimbre::portable {

const char* const library_header_text = R"c(
#include <stddef.h>

typedef struct mimbre_model mimbre_model;

enum { @_MADE = 0, @_UNCONVERGED = 1 /* of a step; more: it was not made */, @_ENDED = 3 /* an event ended the run */ };

typedef struct {
  mimbre_model *motion;
  int iterations; /* of the last step */
} @;

/* Of an instance that is closed; 0: it cannot be opened, and the message says why. */
int @_open(@ *s, char *message, size_t room);
void @_close(@ *s);
void @_init(@ *s);
/* Fixed parameters, by number. Whether one may have a value now; not 0: the message says why not. */
int @_check_parameter(@ *s, int parameter, double value);
int @_set_parameter(@ *s, int parameter, double value);
int @_get_parameter(@ *s, int parameter, double *value);
/* The start with the inputs and parameters that were set; not 0: there is none. */
int @_find(@ *s);
/* The same, once and for all: inputs that are set from now on act in the next step. */
int @_start(@ *s);
void @_set_input(@ *s, int input, double value);
double @_get_output(@ *s, int output);
/* Directional derivatives of `count` outputs: by how much they change, to first order, where inputs and the time change
 * by the given amounts and the motion and all states are held. Not 0: they are not known. */
int @_vary(@ *s, const double *inputs, double time, const int *outputs, int count, double *derivatives);
int @_step(@ *s);
double @_time(const @ *s);
double @_event_count(const @ *s); /* how many events of the model have happened */
size_t @_state_size(@ *s); /* bytes now; 0: there is no state */
int @_save(@ *s, unsigned char *state, size_t size);
int @_restore(@ *s, const unsigned char *state, size_t size);
/* Why the last call that failed did so. */
const char *@_message(const @ *s);
)c";

const char* const library_source_text = R"c(
mimbre_model *mimbre_model_open(const unsigned char *bytes, size_t size, const unsigned char *source,
                                size_t source_size, char *message, size_t room);
void mimbre_model_close(mimbre_model *model);
int mimbre_model_begin(mimbre_model *model);
int mimbre_model_check_parameter(mimbre_model *model, int parameter, double value);
int mimbre_model_set_parameter(mimbre_model *model, int parameter, double value);
int mimbre_model_parameter(mimbre_model *model, int parameter, double *value);
int mimbre_model_find(mimbre_model *model);
int mimbre_model_start(mimbre_model *model);
double mimbre_model_time(const mimbre_model *model);
double mimbre_model_event_count(const mimbre_model *model);
int mimbre_model_set_input(mimbre_model *model, int input, double value);
double mimbre_model_output(mimbre_model *model, int output);
int mimbre_model_vary(mimbre_model *model, const double *inputs, double time, const int *outputs, int count,
                      double *derivatives);
int mimbre_model_step(mimbre_model *model, int *iterations);
const char *mimbre_model_message(const mimbre_model *model);
size_t mimbre_model_state_size(mimbre_model *model);
int mimbre_model_save(mimbre_model *model, unsigned char *bytes, size_t size);
int mimbre_model_restore(mimbre_model *model, const unsigned char *bytes, size_t size);

int @_open(@ *s, char *message, size_t room) {
  s->iterations = 0;
  s->motion = mimbre_model_open((const unsigned char *)@_bytes, @_SIZE, (const unsigned char *)@_source, @_SOURCE,
                                message, room);
  return s->motion != NULL;
}
void @_close(@ *s) { mimbre_model_close(s->motion); }
void @_init(@ *s) { mimbre_model_begin(s->motion); }
int @_check_parameter(@ *s, int parameter, double value) {
  return mimbre_model_check_parameter(s->motion, parameter, value);
}
int @_set_parameter(@ *s, int parameter, double value) {
  return mimbre_model_set_parameter(s->motion, parameter, value);
}
int @_get_parameter(@ *s, int parameter, double *value) {
  return mimbre_model_parameter(s->motion, parameter, value);
}
int @_find(@ *s) { return mimbre_model_find(s->motion); }
int @_start(@ *s) { return mimbre_model_start(s->motion); }
void @_set_input(@ *s, int input, double value) { mimbre_model_set_input(s->motion, input, value); }
double @_get_output(@ *s, int output) { return mimbre_model_output(s->motion, @_channels[output]); }
int @_vary(@ *s, const double *inputs, double time, const int *outputs, int count, double *derivatives) {
  int channels[sizeof @_channels/sizeof @_channels[0]];
  int k;
  for (k = 0; k < count; ++k) channels[k] = @_channels[outputs[k]];
  return mimbre_model_vary(s->motion, inputs, time, channels, count, derivatives);
}
int @_step(@ *s) { return mimbre_model_step(s->motion, &s->iterations); }
double @_time(const @ *s) { return mimbre_model_time(s->motion); }
double @_event_count(const @ *s) { return mimbre_model_event_count(s->motion); }
size_t @_state_size(@ *s) { return mimbre_model_state_size(s->motion); }
int @_save(@ *s, unsigned char *state, size_t size) { return mimbre_model_save(s->motion, state, size); }
int @_restore(@ *s, const unsigned char *state, size_t size) { return mimbre_model_restore(s->motion, state, size); }
const char *@_message(const @ *s) { return mimbre_model_message(s->motion); }
)c";

}  // namespace mimbre::portable
