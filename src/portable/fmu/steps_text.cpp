#include "portable/fmu/texts.h"

/// An instance for co-simulation, by hand in C99, for both versions of the standard. Constants come before
/// it:
/// @_FMU_STEP, and what a step of the model returns.
namespace mimbre::portable {

const char* const fmu_steps_head_text = R"c(
/* The state of the calls, as FMI names it. */
enum {
  @_FMU_MADE = 1,
  @_FMU_STARTS = 2,     /* initialization mode */
  @_FMU_RUNS = 4,       /* step mode */
  @_FMU_STOPPED = 8,    /* a step could not be made */
  @_FMU_TERMINATED = 16,
  @_FMU_EVENTS = 32 /* event mode */
};

#define @_FMU_SETTABLE (@_FMU_MADE | @_FMU_STARTS | @_FMU_RUNS | @_FMU_EVENTS)
#define @_FMU_FIXED 0 /* where parameters cannot be set */
#define @_FMU_ENDS (@_FMU_RUNS | @_FMU_STOPPED | @_FMU_EVENTS)
#define @_FMU_STOPS 1 /* a stop time is kept: no step ends behind it */
#if @_FMU_VARIES
#define @_FMU_NO_ADJOINTS "the FMU has no adjoint derivatives; it has directional ones: fmi3GetDirectionalDerivative"
#else
#define @_FMU_NO_ADJOINTS "the FMU has neither adjoint nor directional derivatives"
#endif

/* References: the time; inputs and tunable parameters; outputs; fixed parameters; counts; fixed parameters that are
 * whole numbers. */
#define @_FMU_FIRST_OUTPUT (1u + @_FMU_INPUTS)
#define @_FMU_FIRST_PARAMETER (@_FMU_FIRST_OUTPUT + @_FMU_OUTPUTS)
#define @_FMU_FIRST_COUNT (@_FMU_FIRST_PARAMETER + @_FMU_PARAMETERS)
#define @_FMU_FIRST_WHOLE (@_FMU_FIRST_COUNT + @_FMU_COUNTS)
#define @_FMU_REALS @_FMU_FIRST_COUNT
enum { @_FMU_COUNT_STEPS, @_FMU_COUNT_ITERATIONS, @_FMU_COUNT_UNCONVERGED, @_FMU_COUNTS };

/* Together with the state of the model, everything that later calls depend on. */
typedef struct {
  double begin; /* the importer's time where the model starts */
  double first; /* the model's own time there */
  double now;   /* where the last step of the importer ended */
  double stop;
  double steps;  /* of the model, so far */
  double weight; /* between the last two of them, where now is between */
  double given[@_FMU_INPUTS + 1];
  double before[@_FMU_OUTPUTS + 1], after[@_FMU_OUTPUTS + 1]; /* outputs at the last two, where now is between */
  int mode, between, iterations, unconverged;
  int ended; /* an event of the model ended the run; 2: it will, at `ends` */
  int happened; /* an event at the end of the last step of the model, which the importer does not know of */
  double ends;
} @_fmu_progress;
)c";

const char* const fmu_steps_text = R"c(
static double @_fmu_output(@_fmu *f, int output) {
  const @_fmu_progress *const p = &f->progress;
  if (!p->between) return @_get_output(&f->model, output);
  if (@_fmu_jumps[output]) return p->before[output]; /* an event is not in between */
  return p->before[output] + p->weight*(p->after[output] - p->before[output]);
}

static int @_fmu_real(@_fmu *f, unsigned long reference, double *value) {
  if (reference == 0)
    *value = f->progress.now;
  else if (reference < @_FMU_FIRST_OUTPUT)
    *value = f->progress.given[reference - 1];
#if @_FMU_PARAMETERS > 0
  else if (reference >= @_FMU_FIRST_PARAMETER) {
    if (@_get_parameter(&f->model, (int)(reference - @_FMU_FIRST_PARAMETER), value) != @_MADE)
      return @_fmu_wrong(f, @_message(&f->model));
  }
#endif
  else {
#if @_FMU_LIBRARY
    if (!f->progress.between && @_find(&f->model) != @_MADE) return @_fmu_wrong(f, @_message(&f->model));
#endif
    *value = @_fmu_output(f, (int)(reference - @_FMU_FIRST_OUTPUT));
  }
  return @_FMU_OK;
}

static int @_fmu_count(const @_fmu *f, unsigned long reference) {
  const @_fmu_progress *const p = &f->progress;
  switch (reference - @_FMU_FIRST_COUNT) {
    case @_FMU_COUNT_STEPS:
      return p->steps < 2147483647.0 ? (int)p->steps : 2147483647;
    case @_FMU_COUNT_ITERATIONS:
      return p->iterations;
    default:
      return p->unconverged;
  }
}

static int @_fmu_get_counts(@_fmu *f, const @_fmu_reference *references, size_t count, @_fmu_integer *values) {
  size_t k;
  for (k = 0; k < count; ++k)
    if (!@_fmu_known(references[k], @_FMU_FIRST_COUNT, @_FMU_COUNTS + @_FMU_WHOLE_PARAMETERS))
      return @_fmu_wrong(f, "a reference belongs to no variable of this type; nothing was read");
  for (k = 0; k < count; ++k) {
#if @_FMU_WHOLE_PARAMETERS > 0
    if (references[k] >= @_FMU_FIRST_WHOLE) {
      double value;
      if (@_get_parameter(&f->model, @_FMU_PARAMETERS + (int)(references[k] - @_FMU_FIRST_WHOLE), &value) != @_MADE)
        return @_fmu_wrong(f, @_message(&f->model));
      values[k] = (@_fmu_integer)value;
      continue;
    }
#endif
    values[k] = @_fmu_count(f, references[k]);
  }
  return @_FMU_OK;
}

#if @_FMU_VARIES
/* How outputs that are asked for vary at an instant of the model, at their places among all. */
static int @_fmu_vary_at_rest(@_fmu *f, const int *asked, const double *inputs, double time, double *outputs) {
#if @_FMU_LIBRARY
  int list[@_FMU_OUTPUTS + 1], count = 0, k;
  double found[@_FMU_OUTPUTS + 1];
  for (k = 0; k < @_FMU_OUTPUTS; ++k)
    if (asked[k]) list[count++] = k;
  if (@_vary(&f->model, inputs, time, list, count, found) != @_MADE) return @_fmu_wrong(f, @_message(&f->model));
  for (k = 0; k < count; ++k) outputs[list[k]] = found[k];
#else
  (void)asked;
  @_vary(&f->model, inputs, time, outputs);
#endif
  return @_FMU_OK;
}

/* The directional derivatives of outputs along the seed of inputs, parameters and the time, the motion being that of now.
 * Between two steps outputs are on a line, and inputs count from its end on. */
static int @_fmu_vary(@_fmu *f, const @_fmu_reference *unknowns, size_t unknown_count, const @_fmu_reference *knowns,
                      size_t known_count, const double *seed, double *result) {
  const @_fmu_progress *const p = &f->progress;
  double inputs[@_FMU_INPUTS + 1], outputs[@_FMU_OUTPUTS + 1], time = 0.0;
  size_t k, e;
  int output, asked[@_FMU_OUTPUTS + 1] = {0};
  if (!@_fmu_turn(f, @_FMU_STARTS | @_FMU_RUNS | @_FMU_STOPPED | @_FMU_TERMINATED | @_FMU_EVENTS))
    return @_FMU_ERROR;
  if ((unknown_count > 0 && (!unknowns || !result)) || (known_count > 0 && (!knowns || !seed)))
    return @_fmu_wrong(f, "the references, the seed or the array of results is missing");
  memset(inputs, 0, sizeof inputs);
  for (k = 0; k < unknown_count; ++k)
    if (!@_fmu_known(unknowns[k], @_FMU_FIRST_OUTPUT, @_FMU_OUTPUTS) || @_fmu_size(unknowns[k]) == 0)
      return @_fmu_wrong(f, "an unknown is no output of real numbers; nothing was read");
  for (k = 0; k < unknown_count; ++k)
    for (e = 0; e < @_fmu_size(unknowns[k]); ++e) asked[@_fmu_element(unknowns[k], e) - @_FMU_FIRST_OUTPUT] = 1;
  for (k = 0; k < known_count; ++k) {
    if (!@_fmu_known(knowns[k], 0, 1u + @_FMU_INPUTS))
      return @_fmu_wrong(f, "a known is neither input nor tunable parameter nor the time; nothing was read");
    if (!@_fmu_finite(seed[k])) return @_fmu_wrong(f, "a seed is not finite; nothing was read");
    if (knowns[k] == 0)
      time += seed[k];
    else
      inputs[knowns[k] - 1] += seed[k];
  }
  if (p->between)
    for (output = 0; output < @_FMU_OUTPUTS; ++output)
      outputs[output] = @_fmu_jumps[output] ? 0.0 : time*(p->after[output] - p->before[output])/@_FMU_STEP;
  else if (@_fmu_vary_at_rest(f, asked, inputs, time, outputs) != @_FMU_OK)
    return @_FMU_ERROR;
  for (k = 0; k < unknown_count; ++k)
    for (e = 0; e < @_fmu_size(unknowns[k]); ++e)
      *result++ = outputs[@_fmu_element(unknowns[k], e) - @_FMU_FIRST_OUTPUT];
  return @_FMU_OK;
}
#endif

/* Leaves initialization mode. */
static int @_fmu_run(@_fmu *f) {
  if (!@_fmu_turn(f, @_FMU_STARTS)) return @_FMU_ERROR;
#if @_FMU_LIBRARY
  if (@_start(&f->model) != @_MADE) return @_fmu_wrong(f, @_message(&f->model));
#else
  @_start_events(&f->model);
#endif
  return @_fmu_go(f, @_FMU_STARTS, f->uses_events ? @_FMU_EVENTS : @_FMU_RUNS);
}

static void @_fmu_outputs(@_fmu *f, double *values) {
  int k;
  for (k = 0; k < @_FMU_OUTPUTS; ++k) values[k] = @_get_output(&f->model, k);
}

static int @_fmu_step_failed(@_fmu *f, int status) {
  @_fmu_progress *const p = &f->progress;
  p->mode = @_FMU_STOPPED;
  p->between = 0;
  p->now = p->begin + p->steps*@_FMU_STEP;
  p->ended = status == @_FMU_ENDED;
  if (p->ended) {
    const double whole = p->now + (1.0 - 1e-6)*@_FMU_STEP;
    p->now = p->begin + (@_time(&f->model) - p->first);
    if (p->now > whole) p->steps += 1.0; /* the step was made to its end */
  }
#if @_FMU_LIBRARY
  return @_fmu_tell(f, @_FMU_DISCARD, @_message(&f->model));
#else
  switch (status) {
    case @_FMU_ENDED:
      return @_fmu_tell(f, @_FMU_DISCARD, "an event of the model ends the run");
    case @_FMU_NOT_FINITE:
      return @_fmu_tell(f, @_FMU_DISCARD, "a step of the model is not finite");
    case @_FMU_SINGULAR:
      return @_fmu_tell(f, @_FMU_DISCARD, "the matrix of a step of the model is singular");
    case @_FMU_DRIFTED:
      return @_fmu_tell(f, @_FMU_DISCARD, "the loops of the model have come apart in a step");
    default:
      return @_fmu_tell(f, @_FMU_DISCARD, "the iterations of a step of the model did not converge");
  }
#endif
}

/* In the step that an event ends: on the straight line to it, or to the end of the run. */
static int @_fmu_go_to_end(@_fmu *f, double end) {
  @_fmu_progress *const p = &f->progress;
  const double from = p->begin + p->steps*@_FMU_STEP;
  if (!(end < p->ends)) return @_fmu_step_failed(f, @_FMU_ENDED);
  p->between = 1;
  p->weight = (end - from)/(p->ends - from);
  p->now = end;
  return @_FMU_OK;
}

/* Whether an event has happened by `end`. Where the importer allows it the step then ends there. */
static int @_fmu_meets_event(@_fmu *f, double end) {
#if @_FMU_EVENT_MODE
  @_fmu_progress *const p = &f->progress;
  const double at = p->begin + p->steps*@_FMU_STEP, about = 1e-6*@_FMU_STEP + 1e-12*fabs(end);
  if (!p->happened || at > end + about) return 0;
  p->happened = 0;
  f->event = 1;
  f->early = f->returns_early && at < end - about;
  if (!f->early) return 0;
  p->between = 0;
  p->now = at;
  return 1;
#else
  (void)f;
  (void)end;
  return 0;
#endif
}

/* To from + length: steps of the model until it is there or behind, then between the last two. */
static int @_fmu_do_step(@_fmu *f, double from, double length) {
  @_fmu_progress *const p = &f->progress;
  const double end = from + length;
  double counted, nearest, target;
  int whole; /* a whole number of the model's steps */
  if (!@_fmu_turn(f, @_FMU_RUNS)) return @_FMU_ERROR;
  if (!@_fmu_finite(from) || !@_fmu_finite(length) || !@_fmu_finite(end))
    return @_fmu_wrong(f, "the communication point or the step is not finite");
  if (!(length > 0.0)) return @_fmu_wrong(f, "the communication step is not positive");
  if (!(fabs(from - p->now) <= 1e-6*@_FMU_STEP + 1e-12*fabs(p->now)))
    return @_fmu_wrong(f, "the step does not begin where the last one ended");
  if (!(end > p->now)) return @_fmu_wrong(f, "the communication step is too short for the time to change");
  if (end > p->stop + 1e-6*@_FMU_STEP + 1e-12*fabs(p->stop)) return @_fmu_wrong(f, "the step ends behind the stop time");
  counted = (end - p->begin)/@_FMU_STEP;
  nearest = floor(counted + 0.5);
  whole = fabs(counted - nearest) <= 1e-6 + 4.0*DBL_EPSILON*(fabs(p->begin) + fabs(end))/@_FMU_STEP;
  target = whole ? nearest : ceil(counted);
  if (!(target - p->steps <= 1e9)) return @_fmu_wrong(f, "the communication step has more than 1e9 steps of the model");
  f->event = f->early = 0;
  if (p->ended == 2) return @_fmu_go_to_end(f, end);
  if (@_fmu_meets_event(f, end)) return @_FMU_OK;
  if (p->steps < target) p->iterations = 0;
  while (p->steps < target) {
    int status;
#if @_FMU_EVENT_MODE
    const double events = @_event_count(&f->model);
#endif
    if (!whole && p->steps + 1.0 >= target) @_fmu_outputs(f, p->before);
    status = @_step(&f->model);
    if (status == @_FMU_ENDED && !whole && p->steps + 1.0 >= target) {
      p->ended = 2;
      p->ends = p->begin + (@_time(&f->model) - p->first);
      @_fmu_outputs(f, p->after);
      return @_fmu_go_to_end(f, end);
    }
    if (status > @_FMU_UNCONVERGED) return @_fmu_step_failed(f, status);
    p->steps += 1.0;
    p->iterations += f->model.iterations;
    if (status == @_FMU_UNCONVERGED && p->unconverged < 2147483647) ++p->unconverged;
    if (!whole && p->steps >= target) @_fmu_outputs(f, p->after);
#if @_FMU_EVENT_MODE
    if (@_event_count(&f->model) != events) p->happened = 1;
    if (@_fmu_meets_event(f, end)) return @_FMU_OK;
#endif
  }
  p->between = !whole;
  p->weight = counted - (p->steps - 1.0);
  p->now = end;
  return @_FMU_OK;
}
)c";

}  // namespace mimbre::portable
