#include "portable/fmu/texts.h"

/// An instance for model exchange, by hand in C99, for both versions of the standard. Constants come before
/// it: the numbers of states and indicators, and the results of the model's functions.
namespace mimbre::portable {

const char* const fmu_exchange_head_text = R"c(
/* The state of the calls, as FMI names it. */
enum {
  @_FMU_MADE = 1,
  @_FMU_STARTS = 2, /* initialization mode */
  @_FMU_EVENTS = 4, /* event mode */
  @_FMU_RUNS = 8,   /* continuous-time mode */
  @_FMU_TERMINATED = 16
};
#define @_FMU_SETTABLE (@_FMU_MADE | @_FMU_STARTS | @_FMU_EVENTS | @_FMU_RUNS)
#define @_FMU_FIXED @_FMU_RUNS /* where parameters are fixed */
#define @_FMU_ENDS (@_FMU_EVENTS | @_FMU_RUNS)
#define @_FMU_STOPS 0 /* solvers evaluate beyond a stop time, and interpolate back to it */
#if @_FMU_VARIES
#define @_FMU_NO_ADJOINTS "the FMU has no adjoint derivatives; it has directional ones: fmi3GetDirectionalDerivative"
#else
#define @_FMU_NO_ADJOINTS "the FMU has neither adjoint nor directional derivatives"
#endif

/* References: the time; inputs and parameters; outputs; continuous states; their derivatives; in FMI 3 event indicators. */
#define @_FMU_FIRST_OUTPUT (1u + @_FMU_INPUTS)
#define @_FMU_FIRST_STATE (@_FMU_FIRST_OUTPUT + @_FMU_OUTPUTS)
#define @_FMU_FIRST_DERIVATIVE (@_FMU_FIRST_STATE + @_FMU_STATES)
#define @_FMU_FIRST_INDICATOR (@_FMU_FIRST_DERIVATIVE + @_FMU_STATES)
#define @_FMU_REALS (@_FMU_FIRST_INDICATOR + @_FMU_INDICATOR_VARIABLES)

/* Together with the state of the model, everything that later calls depend on. */
typedef struct {
  double begin; /* the importer's time where the model starts */
  double first; /* the model's own time there */
  double now;
  double given[@_FMU_INPUTS + 1];
  int mode, spare;
} @_fmu_progress;
)c";

const char* const fmu_exchange_text = R"c(
static int @_fmu_failed(@_fmu *f, int status) {
  switch (status) {
    case @_FMU_NOT_FINITE:
      return @_fmu_tell(f, @_FMU_DISCARD, "the derivatives at these states are not finite");
    case @_FMU_SINGULAR:
      return @_fmu_tell(f, @_FMU_DISCARD, "the mechanism is singular at these states");
    case @_FMU_DRIFTED:
      return @_fmu_tell(f, @_FMU_DISCARD, "the loops of the model do not close at these states");
    default:
      return @_fmu_tell(f, @_FMU_DISCARD, "no positions of the dependent coordinates are found at these states");
  }
}

/* Until initialization is over, controllers start anew with the values that are set. */
static @ *@_fmu_model(@_fmu *f) {
  if (f->progress.mode & (@_FMU_MADE | @_FMU_STARTS)) f->model.state.begun = 0;
  return &f->model;
}

static int @_fmu_real(@_fmu *f, unsigned long reference, double *value) {
  double values[@_FMU_STATES + @_FMU_INDICATORS + 1];
  int status = @_FMU_MODEL_OK;
  if (reference == 0) {
    *value = f->progress.now;
  } else if (reference < @_FMU_FIRST_OUTPUT) {
    *value = f->progress.given[reference - 1];
  } else if (reference < @_FMU_FIRST_STATE) {
    status = @_get_outputs(@_fmu_model(f));
    if (status == @_FMU_MODEL_OK) *value = f->model.output[reference - @_FMU_FIRST_OUTPUT];
  } else if (reference < @_FMU_FIRST_DERIVATIVE) {
    status = @_get_states(@_fmu_model(f), values);
    if (status == @_FMU_MODEL_OK) *value = values[reference - @_FMU_FIRST_STATE];
  } else if (reference < @_FMU_FIRST_INDICATOR) {
    status = @_get_derivatives(@_fmu_model(f), values);
    if (status == @_FMU_MODEL_OK) *value = values[reference - @_FMU_FIRST_DERIVATIVE];
  } else {
    status = @_get_indicators(@_fmu_model(f), values);
    if (status == @_FMU_MODEL_OK) *value = values[reference - @_FMU_FIRST_INDICATOR];
  }
  return status == @_FMU_MODEL_OK ? @_FMU_OK : @_fmu_failed(f, status);
}

static int @_fmu_get_counts(const @_fmu *f, const @_fmu_reference *references, size_t count, @_fmu_integer *values) {
  (void)references;
  (void)values;
  return @_fmu_none(f, count);
}

/* Leaves initialization mode. */
static int @_fmu_run(@_fmu *f) {
  double derivatives[@_FMU_STATES + 1];
  int status;
  if (!@_fmu_turn(f, @_FMU_STARTS)) return @_FMU_ERROR;
  status = @_get_derivatives(@_fmu_model(f), derivatives);
  if (status != @_FMU_MODEL_OK) return @_fmu_failed(f, status);
  f->progress.mode = @_FMU_EVENTS;
  return @_FMU_OK;
}

/* Whether the importer's array has the wanted size. */
static int @_fmu_places(const @_fmu *f, const void *values, size_t count, size_t wanted) {
  if (count == wanted && (values || count == 0)) return 1;
  @_fmu_wrong(f, "the array has the wrong size, or is missing; nothing was done");
  return 0;
}

static int @_fmu_update(@_fmu *f, int *changed, int *has_next, double *next) {
  int status;
  double event;
  if (!@_fmu_turn(f, @_FMU_EVENTS)) return @_FMU_ERROR;
  status = @_update(&f->model, changed);
  if (status != @_FMU_MODEL_OK) return @_fmu_failed(f, status);
  event = @_get_next_event(&f->model);
  *has_next = event < HUGE_VAL;
  *next = *has_next ? event - f->progress.first + f->progress.begin : 0.0;
  return @_FMU_OK;
}

/* FMI 2.0.4 names event mode only for FMUs without continuous time, FMI 3.0.2 continuous-time mode alone. Importers set
 * the time at events, too, and that changes nothing else. */
static int @_fmu_set_time(@_fmu *f, double time) {
  if (!@_fmu_turn(f, @_FMU_EVENTS | @_FMU_RUNS)) return @_FMU_ERROR;
  if (!@_fmu_finite(time) || !@_fmu_finite(time - f->progress.begin)) return @_fmu_wrong(f, "the time is not finite");
  f->progress.now = time;
  @_set_time(&f->model, f->progress.first + (time - f->progress.begin));
  return @_FMU_OK;
}

static int @_fmu_set_states(@_fmu *f, const double *states, size_t count) {
  size_t k;
  if (!@_fmu_turn(f, @_FMU_RUNS) || !@_fmu_places(f, states, count, @_FMU_STATES)) return @_FMU_ERROR;
  for (k = 0; k < count; ++k)
    if (!@_fmu_finite(states[k])) return @_fmu_wrong(f, "a state is not finite; nothing was set");
  if (count > 0) @_set_states(&f->model, states);
  return @_FMU_OK;
}

static int @_fmu_get_states(@_fmu *f, double *states, size_t count) {
  int status;
  if (!@_fmu_places(f, states, count, @_FMU_STATES)) return @_FMU_ERROR;
  if (count == 0) return @_FMU_OK;
  status = @_get_states(@_fmu_model(f), states);
  return status == @_FMU_MODEL_OK ? @_FMU_OK : @_fmu_failed(f, status);
}

static int @_fmu_get_nominals(@_fmu *f, double *nominals, size_t count) {
  if (!@_fmu_places(f, nominals, count, @_FMU_STATES)) return @_FMU_ERROR;
  if (count > 0) @_get_nominals(&f->model, nominals);
  return @_FMU_OK;
}

static int @_fmu_get_derivatives(@_fmu *f, double *derivatives, size_t count) {
  int status;
  if (!@_fmu_places(f, derivatives, count, @_FMU_STATES)) return @_FMU_ERROR;
  if (count == 0) return @_FMU_OK;
  status = @_get_derivatives(@_fmu_model(f), derivatives);
  return status == @_FMU_MODEL_OK ? @_FMU_OK : @_fmu_failed(f, status);
}

static int @_fmu_get_indicators(@_fmu *f, double *indicators, size_t count) {
  int status;
  if (!@_fmu_places(f, indicators, count, @_FMU_INDICATORS)) return @_FMU_ERROR;
  if (count == 0) return @_FMU_OK;
  status = @_get_indicators(@_fmu_model(f), indicators);
  return status == @_FMU_MODEL_OK ? @_FMU_OK : @_fmu_failed(f, status);
}

#if @_FMU_VARIES
static void @_fmu_add(double *to, const double *by, int count, double factor) {
  int k;
  for (k = 0; k < count; ++k) to[k] += factor*by[k];
}
static int @_fmu_add_time(@_fmu *f, double seed, double *derivatives, double *outputs, double *indicators) {
  double by_derivatives[@_FMU_STATES + 1], by_outputs[@_FMU_OUTPUTS + 1], by_indicators[@_FMU_INDICATORS + 1];
  const int status = @_vary_time(@_fmu_model(f), by_derivatives, by_outputs, indicators ? by_indicators : NULL);
  if (status != @_FMU_MODEL_OK) return status;
  @_fmu_add(derivatives, by_derivatives, @_FMU_STATES, seed);
  @_fmu_add(outputs, by_outputs, @_FMU_OUTPUTS, seed);
  if (indicators) @_fmu_add(indicators, by_indicators, @_FMU_INDICATORS, seed);
  return status;
}
#endif

#if @_FMU_VARIES
/* The directional derivatives of unknowns (derivatives, outputs, event indicators) along the seed of knowns (states,
 * inputs, parameters, time). */
static int @_fmu_vary(@_fmu *f, const @_fmu_reference *unknowns, size_t unknown_count, const @_fmu_reference *knowns,
                      size_t known_count, const double *seed, double *result) {
  double states[@_FMU_STATES + 1], inputs[@_FMU_INPUTS + 1];
  double derivatives[@_FMU_STATES + 1], outputs[@_FMU_OUTPUTS + 1], indicators[@_FMU_INDICATORS + 1], time = 0.0;
  size_t k, e;
  int status, wanted = 0; /* indicators */
  if (!@_fmu_turn(f, @_FMU_STARTS | @_FMU_EVENTS | @_FMU_RUNS | @_FMU_TERMINATED)) return @_FMU_ERROR;
  if ((unknown_count > 0 && (!unknowns || !result)) || (known_count > 0 && (!knowns || !seed)))
    return @_fmu_wrong(f, "the references, the seed or the array of results is missing");
  memset(states, 0, sizeof states);
  memset(inputs, 0, sizeof inputs);
  memset(indicators, 0, sizeof indicators);
  for (k = 0; k < unknown_count; ++k) {
    const int indicator = @_fmu_known(unknowns[k], @_FMU_FIRST_INDICATOR, @_FMU_INDICATOR_VARIABLES);
    wanted = wanted || indicator;
    if ((!indicator && !@_fmu_known(unknowns[k], @_FMU_FIRST_OUTPUT, @_FMU_OUTPUTS) &&
         !@_fmu_known(unknowns[k], @_FMU_FIRST_DERIVATIVE, @_FMU_STATES)) ||
        @_fmu_size(unknowns[k]) == 0)
      return @_fmu_wrong(f, "an unknown is neither derivative nor output nor event indicator; nothing was read");
  }
  for (k = 0; k < known_count; ++k) {
    const int input = @_fmu_known(knowns[k], 1, @_FMU_INPUTS);
    if (!input && knowns[k] != 0 && !@_fmu_known(knowns[k], @_FMU_FIRST_STATE, @_FMU_STATES))
      return @_fmu_wrong(f, "a known is neither input nor parameter nor state nor the time; nothing was read");
    if (!@_fmu_finite(seed[k])) return @_fmu_wrong(f, "a seed is not finite; nothing was read");
    if (knowns[k] == 0)
      time += seed[k];
    else if (input)
      inputs[knowns[k] - 1] += seed[k];
    else
      states[knowns[k] - @_FMU_FIRST_STATE] += seed[k];
  }
  status = @_vary(@_fmu_model(f), states, inputs, derivatives, outputs, wanted ? indicators : NULL);
  if (status == @_FMU_MODEL_OK && time != 0.0)
    status = @_fmu_add_time(f, time, derivatives, outputs, wanted ? indicators : NULL);
  if (status != @_FMU_MODEL_OK) return @_fmu_failed(f, status);
  for (k = 0; k < unknown_count; ++k)
    for (e = 0; e < @_fmu_size(unknowns[k]); ++e) {
      const unsigned long unknown = @_fmu_element(unknowns[k], e);
      *result++ = unknown < @_FMU_FIRST_STATE       ? outputs[unknown - @_FMU_FIRST_OUTPUT]
                  : unknown < @_FMU_FIRST_INDICATOR ? derivatives[unknown - @_FMU_FIRST_DERIVATIVE]
                                                    : indicators[unknown - @_FMU_FIRST_INDICATOR];
    }
  return @_FMU_OK;
}
#endif
)c";

}  // namespace mimbre::portable
