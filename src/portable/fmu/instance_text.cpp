#include "portable/fmu/texts.h"

/// One instance of an FMU, by hand in C99, for both versions of the standard and both kinds of FMUs. Before
/// it come constants (@_FMU_TOKEN, the number of inputs and outputs), the tables of the inputs, and for its
/// kind the struct @_fmu_progress, the modes and the masks @_FMU_SETTABLE and @_FMU_FIXED.
namespace mimbre::portable {

const char* const fmu_instance_text = R"c(
/* Results of calls; the same numbers in all versions of FMI. */
enum { @_FMU_OK = 0, @_FMU_WARNING = 1, @_FMU_DISCARD = 2, @_FMU_ERROR = 3, @_FMU_FATAL = 4 };

/* A state that was saved; that of the model lies behind it. */
typedef struct @_fmu_saved {
  struct @_fmu_saved *next;
  size_t size; /* of that */
  @_fmu_progress progress;
} @_fmu_saved;

typedef struct {
  @_fmu_host host;
  int logs; /* whether warnings are wanted */
  /* In co-simulation: what the importer wants to know of events, and of the last step whether one happened at its end, and
   * whether it ended early for that. */
  int uses_events, returns_early, event, early;
  @_fmu_saved *saved;
  @_fmu_progress progress;
  @ model;
} @_fmu;

/* A serialized state: the token, a checksum of all that follows, the size of the model's state, the progress, that
 * state. */
#define @_FMU_HEAD 64 /* bytes of the token */
#define @_FMU_BEFORE_STATE (@_FMU_HEAD + 16 + sizeof(@_fmu_progress))

static int @_fmu_tell(const @_fmu *f, int status, const char *message) {
  if (status != @_FMU_WARNING || f->logs)
    @_fmu_log(&f->host, status,
              status == @_FMU_WARNING   ? "logStatusWarning"
              : status == @_FMU_DISCARD ? "logStatusDiscard"
                                        : "logStatusError",
              message);
  return status;
}
static int @_fmu_wrong(const @_fmu *f, const char *message) { return @_fmu_tell(f, @_FMU_ERROR, message); }

static int @_fmu_finite(double x) { return x - x == 0.0; }

/* Whether a function may be called in the mode of now. */
static int @_fmu_turn(const @_fmu *f, int modes) {
  if (f->progress.mode & modes) return 1;
  @_fmu_wrong(f, "the function cannot be called in this mode; nothing was done");
  return 0;
}

static int @_fmu_go(@_fmu *f, int from, int to) {
  if (!@_fmu_turn(f, from)) return @_FMU_ERROR;
  f->progress.mode = to;
  return @_FMU_OK;
}

/* Where initialization has not begun. */
static void @_fmu_begin(@_fmu *f) {
  int k;
  @_init(&f->model);
  memset(&f->progress, 0, sizeof f->progress);
  f->progress.mode = @_FMU_MADE;
  f->progress.first = f->progress.begin = f->progress.now = @_time(&f->model);
#if @_FMU_STOPS
  f->progress.stop = HUGE_VAL;
#endif
  for (k = 0; k < @_FMU_INPUTS; ++k) f->progress.given[k] = @_fmu_start[k];
}

/* A new instance, of memory that is not set. NULL: it cannot be made, and is gone. */
static @_fmu *@_fmu_set_up(@_fmu *f, const @_fmu_host *host, int logs) {
  f->host = *host;
  f->logs = logs;
  f->saved = NULL;
  f->uses_events = f->returns_early = f->event = f->early = 0;
#if @_FMU_LIBRARY
  {
    char message[4000];
    if (!@_open(&f->model, message, sizeof message)) {
      @_fmu_host last = f->host;
      @_fmu_wrong(f, message);
      @_fmu_forget(&last);
      @_fmu_release(&last, f);
      return NULL;
    }
  }
#endif
  @_fmu_begin(f);
  return f;
}

/* Why an instance cannot be made; NULL: it can. */
static const char *@_fmu_refusal(const char *instance_name, const char *token) {
  const char *c = instance_name;
  while (c && *c == ' ') ++c;
  if (!c || !*c) return "the instance has no name";
  if (!token || strcmp(token, @_FMU_TOKEN) != 0)
    return "the token is not that of this FMU: the model description and the binary do not belong together";
  return NULL;
}

/* The model starts at the importer's time `start`. */
static int @_fmu_experiment(@_fmu *f, int has_tolerance, double tolerance, double start, int has_stop, double stop) {
  if (has_tolerance && !(@_fmu_finite(tolerance) && tolerance > 0.0))
    return @_fmu_wrong(f, "the tolerance is not a positive number");
  if (!@_fmu_finite(start)) return @_fmu_wrong(f, "the start time is not finite");
  if (has_stop && !(@_fmu_finite(stop) && stop >= start))
    return @_fmu_wrong(f, "the stop time is not finite, or before the start time");
  f->progress.begin = f->progress.now = start;
#if @_FMU_STOPS
  f->progress.stop = has_stop ? stop : HUGE_VAL;
#endif
  if (start != f->progress.first)
    @_fmu_tell(f, @_FMU_WARNING, "functions of time in the model count from its own start, not from the start time");
  return @_FMU_OK;
}

static int @_fmu_known(unsigned long reference, unsigned long first, unsigned long count) {
  return reference >= first && reference - first < count;
}

/* Whether a list of references is one of variables of a kind; `values` as many values as references. */
static int @_fmu_list(const @_fmu *f, const void *references, size_t count, const void *values, size_t value_count) {
  if (count != value_count) {
    @_fmu_wrong(f, "the numbers of values and references differ, but all variables are scalars");
    return 0;
  }
  if (count > 0 && (!references || !values)) {
    @_fmu_wrong(f, "references or values are missing");
    return 0;
  }
  return 1;
}

/* None of the FMU's variables is of the type. */
static int @_fmu_none(const @_fmu *f, size_t count) {
  return count > 0 ? @_fmu_wrong(f, "the FMU has no variables of this type") : @_FMU_OK;
}

#if !@_FMU_VARIES
/* Directional derivatives: there are none. */
static int @_fmu_vary(@_fmu *f, const @_fmu_reference *unknowns, size_t unknown_count, const @_fmu_reference *knowns,
                      size_t known_count, const double *seed, double *result) {
  (void)unknowns;
  (void)unknown_count;
  (void)knowns;
  (void)known_count;
  (void)seed;
  (void)result;
  return @_fmu_wrong(f, "the FMU has no directional derivatives");
}
#endif

#if @_FMU_ARRAYS
/* How many values a variable has; 0: it is an element of another one. */
static size_t @_fmu_size(unsigned long reference) {
  const unsigned long output = reference - @_FMU_FIRST_OUTPUT;
  return @_fmu_known(reference, @_FMU_FIRST_OUTPUT, @_FMU_OUTPUTS) ? (size_t)@_fmu_sizes[output] : 1;
}
/* An element, by the reference that it has as a scalar. */
static unsigned long @_fmu_element(unsigned long reference, size_t k) {
  const unsigned long output = reference - @_FMU_FIRST_OUTPUT;
  if (!@_fmu_known(reference, @_FMU_FIRST_OUTPUT, @_FMU_OUTPUTS)) return reference;
  return @_FMU_FIRST_OUTPUT + (unsigned long)@_fmu_elements[output*@_FMU_LONGEST + k];
}
#else
static size_t @_fmu_size(unsigned long reference) {
  (void)reference;
  return 1;
}
static unsigned long @_fmu_element(unsigned long reference, size_t k) {
  (void)k;
  return reference;
}
#endif

/* The value of a variable of real numbers. */
static int @_fmu_real(@_fmu *f, unsigned long reference, double *value);

static int @_fmu_get_reals(@_fmu *f, const @_fmu_reference *references, size_t count, double *values) {
  size_t k, e;
  int status = @_FMU_OK;
  for (k = 0; k < count; ++k)
    if (!@_fmu_known(references[k], 0, @_FMU_REALS) || @_fmu_size(references[k]) == 0)
      return @_fmu_wrong(f, "a reference belongs to no variable of this type; nothing was read");
  for (k = 0; k < count; ++k)
    for (e = 0; e < @_fmu_size(references[k]) && status == @_FMU_OK; ++e)
      status = @_fmu_real(f, @_fmu_element(references[k], e), values++);
  return status;
}

#if @_FMU_PARAMETERS + @_FMU_WHOLE_PARAMETERS > 0
static int @_fmu_check_parameter(@_fmu *f, int parameter, double value) {
  if (@_check_parameter(&f->model, parameter, value) != @_MADE) return @_fmu_wrong(f, @_message(&f->model));
  return @_FMU_OK;
}
#endif

static int @_fmu_set_counts(@_fmu *f, const @_fmu_reference *references, size_t count, const @_fmu_integer *values) {
#if @_FMU_WHOLE_PARAMETERS > 0
  size_t k;
  if (!@_fmu_turn(f, @_FMU_SETTABLE)) return @_FMU_ERROR;
  for (k = 0; k < count; ++k) {
    if (!@_fmu_known(references[k], @_FMU_FIRST_WHOLE, @_FMU_WHOLE_PARAMETERS))
      return @_fmu_wrong(f, "a reference belongs to no parameter of this type; nothing was set");
    if (@_fmu_check_parameter(f, @_FMU_PARAMETERS + (int)(references[k] - @_FMU_FIRST_WHOLE), values[k]) != @_FMU_OK)
      return @_FMU_ERROR;
  }
  for (k = 0; k < count; ++k)
    @_set_parameter(&f->model, @_FMU_PARAMETERS + (int)(references[k] - @_FMU_FIRST_WHOLE), values[k]);
  return @_FMU_OK;
#else
  (void)references;
  (void)values;
  return count > 0 ? @_fmu_wrong(f, "no variable of this type can be set") : @_FMU_OK;
#endif
}

static int @_fmu_set_reals(@_fmu *f, const @_fmu_reference *references, size_t count, const double *values) {
  size_t k;
  int limited = 0;
  if (!@_fmu_turn(f, @_FMU_SETTABLE)) return @_FMU_ERROR;
  for (k = 0; k < count; ++k) {
#if @_FMU_PARAMETERS > 0
    if (@_fmu_known(references[k], @_FMU_FIRST_PARAMETER, @_FMU_PARAMETERS)) {
      if (@_fmu_check_parameter(f, (int)(references[k] - @_FMU_FIRST_PARAMETER), values[k]) != @_FMU_OK)
        return @_FMU_ERROR;
      continue;
    }
#endif
    if (!@_fmu_known(references[k], 1, @_FMU_INPUTS))
      return @_fmu_wrong(f, "a reference belongs to neither an input nor a parameter; nothing was set");
    if ((f->progress.mode & @_FMU_FIXED) && @_fmu_tunable[references[k] - 1])
      return @_fmu_wrong(f, "parameters can be set only before the start and at events; nothing was set");
    if (!@_fmu_finite(values[k])) return @_fmu_wrong(f, "a value is not finite; nothing was set");
  }
  for (k = 0; k < count; ++k) {
    const int input = (int)references[k] - 1;
    double value = values[k];
#if @_FMU_PARAMETERS > 0
    if (references[k] >= @_FMU_FIRST_PARAMETER) {
      @_set_parameter(&f->model, (int)(references[k] - @_FMU_FIRST_PARAMETER), value);
      continue;
    }
#endif
    if (value < @_fmu_least[input]) value = @_fmu_least[input];
    if (value > @_fmu_most[input]) value = @_fmu_most[input];
    limited = limited || value != values[k];
    f->progress.given[input] = value;
    @_set_input(&f->model, input, value);
  }
  if (limited) return @_fmu_tell(f, @_FMU_WARNING, "a value is outside the range of its variable and was set to the end of the range");
  return @_FMU_OK;
}

static @_fmu_saved *@_fmu_find(const @_fmu *f, const void *state) {
  @_fmu_saved *one = f->saved;
  while (one && one != state) one = one->next;
  return one;
}

static unsigned char *@_fmu_bytes(@_fmu_saved *state) { return (unsigned char *)(state + 1); }

/* How large the model's state is; 0, with a message: there is none. */
static size_t @_fmu_size_of_state(@_fmu *f) {
#if @_FMU_LIBRARY
  const size_t size = @_state_size(&f->model);
  if (size == 0) @_fmu_wrong(f, @_message(&f->model));
  return size;
#else
  (void)f;
  return sizeof(@_state);
#endif
}

static @_fmu_saved *@_fmu_new_state(@_fmu *f, size_t size) {
  @_fmu_saved *const one = (@_fmu_saved *)@_fmu_allocate(&f->host, sizeof *one + size);
  if (!one) {
    @_fmu_wrong(f, "out of memory for a state");
    return NULL;
  }
  one->size = size;
  one->next = f->saved;
  f->saved = one;
  return one;
}

static void @_fmu_take_out(@_fmu *f, @_fmu_saved *state) {
  @_fmu_saved **link = &f->saved;
  while (*link != state) link = &(*link)->next;
  *link = state->next;
  @_fmu_release(&f->host, state);
}

/* A place for a state of that size: `before`, where it is one; else a new one in place of it. */
static @_fmu_saved *@_fmu_place(@_fmu *f, @_fmu_saved *before, size_t size) {
  @_fmu_saved *one = before;
  if (before && before->size == size) return before;
  one = @_fmu_new_state(f, size);
  if (one && before) @_fmu_take_out(f, before);
  return one;
}

static int @_fmu_get_state(@_fmu *f, void **state) {
  @_fmu_saved *one;
  size_t size;
  if (!state) return @_fmu_wrong(f, "the pointer for the state is missing");
  if (*state && !@_fmu_find(f, *state)) return @_fmu_wrong(f, "the state does not belong to this instance");
  size = @_fmu_size_of_state(f);
  one = size > 0 ? @_fmu_place(f, *state ? @_fmu_find(f, *state) : NULL, size) : NULL;
  if (!one) return @_FMU_ERROR;
  *state = one;
  memcpy(&one->progress, &f->progress, sizeof f->progress);
#if @_FMU_LIBRARY
  if (@_save(&f->model, @_fmu_bytes(one), size) != @_MADE) {
    @_fmu_take_out(f, one);
    *state = NULL;
    return @_fmu_wrong(f, @_message(&f->model));
  }
#else
  @_save(&f->model, (@_state *)(void *)@_fmu_bytes(one));
#endif
  return @_FMU_OK;
}

static int @_fmu_set_state(@_fmu *f, const void *state) {
  @_fmu_saved *const one = @_fmu_find(f, state);
  if (!one) return @_fmu_wrong(f, "the state does not belong to this instance");
#if @_FMU_LIBRARY
  if (@_restore(&f->model, @_fmu_bytes(one), one->size) != @_MADE) return @_fmu_wrong(f, @_message(&f->model));
#else
  @_restore(&f->model, (const @_state *)(void *)@_fmu_bytes(one));
#endif
  memcpy(&f->progress, &one->progress, sizeof f->progress);
  return @_FMU_OK;
}

static int @_fmu_free_state(@_fmu *f, void **state) {
  @_fmu_saved *one;
  if (!state || !*state) return @_FMU_OK;
  one = @_fmu_find(f, *state);
  if (!one) return @_fmu_wrong(f, "the state does not belong to this instance");
  @_fmu_take_out(f, one);
  *state = NULL;
  return @_FMU_OK;
}

/* FNV-1a */
static uint64_t @_fmu_checksum(const unsigned char *bytes, size_t count) {
  uint64_t sum = 14695981039346656037u;
  size_t k;
  for (k = 0; k < count; ++k) sum = (sum ^ bytes[k])*1099511628211u;
  return sum;
}

static int @_fmu_state_size(@_fmu *f, const void *state, size_t *size) {
  const @_fmu_saved *const one = @_fmu_find(f, state);
  if (!size || !one) return @_fmu_wrong(f, "the state does not belong to this instance, or the pointer for its size is missing");
  *size = @_FMU_BEFORE_STATE + one->size;
  return @_FMU_OK;
}

static int @_fmu_write_state(@_fmu *f, const void *state, unsigned char *bytes, size_t size) {
  @_fmu_saved *const one = @_fmu_find(f, state);
  unsigned char *const data = bytes ? bytes + @_FMU_HEAD + 8 : NULL;
  uint64_t sum, length;
  if (!one || !bytes) return @_fmu_wrong(f, "the state does not belong to this instance, or the array for its bytes is missing");
  if (size < @_FMU_BEFORE_STATE + one->size) return @_fmu_wrong(f, "the array is too small for the state");
  memset(bytes, 0, size);
  memcpy(bytes, @_FMU_TOKEN, sizeof @_FMU_TOKEN);
  length = one->size;
  memcpy(data, &length, sizeof length);
  memcpy(data + 8, &one->progress, sizeof one->progress);
  memcpy(bytes + @_FMU_BEFORE_STATE, @_fmu_bytes(one), one->size);
  sum = @_fmu_checksum(data, 8 + sizeof one->progress + one->size);
  memcpy(bytes + @_FMU_HEAD, &sum, sizeof sum);
  return @_FMU_OK;
}

static int @_fmu_read_state(@_fmu *f, const unsigned char *bytes, size_t size, void **state) {
  const unsigned char *const data = bytes ? bytes + @_FMU_HEAD + 8 : NULL;
  @_fmu_saved *one;
  uint64_t sum, length;
  if (!bytes || !state) return @_fmu_wrong(f, "the bytes of a state, or the pointer for it, are missing");
  if (size < @_FMU_BEFORE_STATE || memcmp(bytes, @_FMU_TOKEN, sizeof @_FMU_TOKEN) != 0)
    return @_fmu_wrong(f, "the bytes are not those of a state of this FMU");
  memcpy(&sum, bytes + @_FMU_HEAD, sizeof sum);
  memcpy(&length, data, sizeof length);
  if (length > size - @_FMU_BEFORE_STATE || sum != @_fmu_checksum(data, 8 + sizeof one->progress + (size_t)length))
    return @_fmu_wrong(f, "the bytes of the state are damaged");
  if (*state && !@_fmu_find(f, *state)) return @_fmu_wrong(f, "the state does not belong to this instance");
  one = @_fmu_place(f, *state ? @_fmu_find(f, *state) : NULL, (size_t)length);
  if (!one) return @_FMU_ERROR;
  memcpy(&one->progress, data + 8, sizeof one->progress);
  memcpy(@_fmu_bytes(one), bytes + @_FMU_BEFORE_STATE, one->size);
  *state = one;
  return @_FMU_OK;
}

/* Warnings are logged, or not; of what the model description calls categories. */
static int @_fmu_set_logging(@_fmu *f, int on, size_t count, const char *const *categories) {
  size_t k;
  int warnings = count == 0;
  if (count > 0 && !categories) return @_fmu_wrong(f, "the categories are missing");
  for (k = 0; k < count; ++k) {
    const char *const name = categories[k];
    if (!name) return @_fmu_wrong(f, "a category is missing");
    if (strcmp(name, "logStatusWarning") == 0 || strcmp(name, "logAll") == 0)
      warnings = 1;
    else if (strcmp(name, "logStatusDiscard") != 0 && strcmp(name, "logStatusError") != 0)
      return @_fmu_wrong(f, "there is no such category of messages");
  }
  if (warnings) f->logs = on;
  return @_FMU_OK;
}

static void @_fmu_end(@_fmu *f) {
  @_fmu_host host;
  while (f->saved) @_fmu_take_out(f, f->saved);
#if @_FMU_LIBRARY
  @_close(&f->model);
#endif
  host = f->host;
  @_fmu_forget(&host);
  @_fmu_release(&host, f);
}
)c";

}  // namespace mimbre::portable
