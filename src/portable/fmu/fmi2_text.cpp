#include "portable/fmu/texts.h"

/// FMI 2.0, written from the public standard (fmi-standard.org, version 2.0.4).
namespace mimbre::portable {

const char* const fmi2_types_text = R"c(
typedef void *fmi2Component;
typedef void *fmi2ComponentEnvironment;
typedef void *fmi2FMUstate;
typedef unsigned int fmi2ValueReference;
typedef double fmi2Real;
typedef int fmi2Integer;
typedef int fmi2Boolean;
typedef char fmi2Char;
typedef const fmi2Char *fmi2String;
typedef char fmi2Byte;
typedef enum { fmi2OK, fmi2Warning, fmi2Discard, fmi2Error, fmi2Fatal, fmi2Pending } fmi2Status;
typedef enum { fmi2ModelExchange, fmi2CoSimulation } fmi2Type;
typedef enum { fmi2DoStepStatus, fmi2PendingStatus, fmi2LastSuccessfulTime, fmi2Terminated } fmi2StatusKind;
typedef void (*fmi2CallbackLogger)(fmi2ComponentEnvironment, fmi2String, fmi2Status, fmi2String, fmi2String, ...);
typedef void *(*fmi2CallbackAllocateMemory)(size_t, size_t);
typedef void (*fmi2CallbackFreeMemory)(void *);
typedef void (*fmi2StepFinished)(fmi2ComponentEnvironment, fmi2Status);
typedef struct {
  fmi2CallbackLogger logger;
  fmi2CallbackAllocateMemory allocateMemory;
  fmi2CallbackFreeMemory freeMemory;
  fmi2StepFinished stepFinished;
  fmi2ComponentEnvironment componentEnvironment;
} fmi2CallbackFunctions;

typedef fmi2ValueReference @_fmu_reference;
typedef fmi2Integer @_fmu_integer;

/* The importer's callbacks. */
typedef struct {
  fmi2CallbackFunctions calls;
  char *name;
} @_fmu_host;

/* The message is a format: a path in it may have '%'. */
static void @_fmu_log(const @_fmu_host *host, int status, const char *category, const char *message) {
  char text[4096];
  size_t k = 0;
  for (; *message && k + 2 < sizeof text; ++message) {
    if (*message == '%') text[k++] = '%';
    text[k++] = *message;
  }
  text[k] = 0;
  if (host->calls.logger)
    host->calls.logger(host->calls.componentEnvironment, host->name, (fmi2Status)status, category, text);
}
static void *@_fmu_allocate(const @_fmu_host *host, size_t size) { return host->calls.allocateMemory(1, size); }
static void @_fmu_release(const @_fmu_host *host, void *memory) { host->calls.freeMemory(memory); }
static void @_fmu_forget(@_fmu_host *host) {
  @_fmu_release(host, host->name);
  host->name = NULL;
}
)c";

const char* const fmi2_text = R"c(
#define @_FMU_OF(c, call) ((c) ? (fmi2Status)(call) : fmi2Error)

@_FMU_EXPORT fmi2String @_FMU_NAME(fmi2GetTypesPlatform)(void) { return "default"; }
@_FMU_EXPORT fmi2String @_FMU_NAME(fmi2GetVersion)(void) { return "2.0"; }

@_FMU_EXPORT fmi2Component @_FMU_NAME(fmi2Instantiate)(fmi2String instance_name, fmi2Type type, fmi2String token,
                                           fmi2String resources, const fmi2CallbackFunctions *functions,
                                           fmi2Boolean visible, fmi2Boolean logs) {
  @_fmu *f;
  @_fmu_host host;
  const char *refusal = @_fmu_refusal(instance_name, token);
  (void)resources;
  (void)visible;
  if (!functions) return NULL;
  host.calls = *functions;
  host.name = NULL;
  if (!host.calls.allocateMemory || !host.calls.freeMemory) {
    host.calls.allocateMemory = calloc;
    host.calls.freeMemory = free;
  }
  if (!refusal && type != @_FMU_KIND) refusal = "the FMU is of the other kind";
  f = refusal ? NULL : (@_fmu *)@_fmu_allocate(&host, sizeof *f);
  if (f) host.name = (char *)@_fmu_allocate(&host, strlen(instance_name) + 1);
  if (!refusal && !(f && host.name)) refusal = "there is no memory for an instance";
  if (refusal) {
    if (f) @_fmu_release(&host, f);
    if (host.calls.logger)
      host.calls.logger(host.calls.componentEnvironment, instance_name ? instance_name : "@", fmi2Error,
                        "logStatusError", refusal);
    return NULL;
  }
  memcpy(host.name, instance_name, strlen(instance_name) + 1);
  return @_fmu_set_up(f, &host, logs != 0);
}

@_FMU_EXPORT void @_FMU_NAME(fmi2FreeInstance)(fmi2Component c) {
  if (c) @_fmu_end((@_fmu *)c);
}

@_FMU_EXPORT fmi2Status @_FMU_NAME(fmi2SetDebugLogging)(fmi2Component c, fmi2Boolean on, size_t count, const fmi2String categories[]) {
  return @_FMU_OF(c, @_fmu_set_logging((@_fmu *)c, on != 0, count, categories));
}

@_FMU_EXPORT fmi2Status @_FMU_NAME(fmi2SetupExperiment)(fmi2Component c, fmi2Boolean has_tolerance, fmi2Real tolerance,
                                            fmi2Real start, fmi2Boolean has_stop, fmi2Real stop) {
  @_fmu *const f = (@_fmu *)c;
  if (!f || !@_fmu_turn(f, @_FMU_MADE)) return fmi2Error;
  return (fmi2Status)@_fmu_experiment(f, has_tolerance, tolerance, start, has_stop, stop);
}

@_FMU_EXPORT fmi2Status @_FMU_NAME(fmi2EnterInitializationMode)(fmi2Component c) {
  return @_FMU_OF(c, @_fmu_go((@_fmu *)c, @_FMU_MADE, @_FMU_STARTS));
}
@_FMU_EXPORT fmi2Status @_FMU_NAME(fmi2ExitInitializationMode)(fmi2Component c) {
  return @_FMU_OF(c, @_fmu_run((@_fmu *)c));
}
@_FMU_EXPORT fmi2Status @_FMU_NAME(fmi2Terminate)(fmi2Component c) {
  return @_FMU_OF(c, @_fmu_go((@_fmu *)c, @_FMU_ENDS, @_FMU_TERMINATED));
}
@_FMU_EXPORT fmi2Status @_FMU_NAME(fmi2Reset)(fmi2Component c) {
  if (!c) return fmi2Error;
  @_fmu_begin((@_fmu *)c);
  return fmi2OK;
}

@_FMU_EXPORT fmi2Status @_FMU_NAME(fmi2GetReal)(fmi2Component c, const fmi2ValueReference vr[], size_t count, fmi2Real value[]) {
  @_fmu *const f = (@_fmu *)c;
  if (!f || !@_fmu_list(f, vr, count, value, count)) return fmi2Error;
  return (fmi2Status)@_fmu_get_reals(f, vr, count, value);
}
@_FMU_EXPORT fmi2Status @_FMU_NAME(fmi2GetInteger)(fmi2Component c, const fmi2ValueReference vr[], size_t count,
                                       fmi2Integer value[]) {
  @_fmu *const f = (@_fmu *)c;
  if (!f || !@_fmu_list(f, vr, count, value, count)) return fmi2Error;
  return (fmi2Status)@_fmu_get_counts(f, vr, count, value);
}
@_FMU_EXPORT fmi2Status @_FMU_NAME(fmi2SetReal)(fmi2Component c, const fmi2ValueReference vr[], size_t count,
                                    const fmi2Real value[]) {
  @_fmu *const f = (@_fmu *)c;
  if (!f || !@_fmu_list(f, vr, count, value, count)) return fmi2Error;
  return (fmi2Status)@_fmu_set_reals(f, vr, count, value);
}
@_FMU_EXPORT fmi2Status @_FMU_NAME(fmi2SetInteger)(fmi2Component c, const fmi2ValueReference vr[], size_t count,
                                       const fmi2Integer value[]) {
  @_fmu *const f = (@_fmu *)c;
  if (!f || !@_fmu_list(f, vr, count, value, count)) return fmi2Error;
  return (fmi2Status)@_fmu_set_counts(f, vr, count, value);
}
@_FMU_EXPORT fmi2Status @_FMU_NAME(fmi2GetBoolean)(fmi2Component c, const fmi2ValueReference vr[], size_t count,
                                       fmi2Boolean value[]) {
  (void)vr;
  (void)value;
  return @_FMU_OF(c, @_fmu_none((@_fmu *)c, count));
}
@_FMU_EXPORT fmi2Status @_FMU_NAME(fmi2SetBoolean)(fmi2Component c, const fmi2ValueReference vr[], size_t count,
                                       const fmi2Boolean value[]) {
  (void)vr;
  (void)value;
  return @_FMU_OF(c, @_fmu_none((@_fmu *)c, count));
}
@_FMU_EXPORT fmi2Status @_FMU_NAME(fmi2GetString)(fmi2Component c, const fmi2ValueReference vr[], size_t count,
                                       fmi2String value[]) {
  (void)vr;
  (void)value;
  return @_FMU_OF(c, @_fmu_none((@_fmu *)c, count));
}
@_FMU_EXPORT fmi2Status @_FMU_NAME(fmi2SetString)(fmi2Component c, const fmi2ValueReference vr[], size_t count,
                                       const fmi2String value[]) {
  (void)vr;
  (void)value;
  return @_FMU_OF(c, @_fmu_none((@_fmu *)c, count));
}

@_FMU_EXPORT fmi2Status @_FMU_NAME(fmi2GetFMUstate)(fmi2Component c, fmi2FMUstate *state) {
  return @_FMU_OF(c, @_fmu_get_state((@_fmu *)c, state));
}
@_FMU_EXPORT fmi2Status @_FMU_NAME(fmi2SetFMUstate)(fmi2Component c, fmi2FMUstate state) {
  return @_FMU_OF(c, @_fmu_set_state((@_fmu *)c, state));
}
@_FMU_EXPORT fmi2Status @_FMU_NAME(fmi2FreeFMUstate)(fmi2Component c, fmi2FMUstate *state) {
  return @_FMU_OF(c, @_fmu_free_state((@_fmu *)c, state));
}
@_FMU_EXPORT fmi2Status @_FMU_NAME(fmi2SerializedFMUstateSize)(fmi2Component c, fmi2FMUstate state, size_t *size) {
  return @_FMU_OF(c, @_fmu_state_size((@_fmu *)c, state, size));
}
@_FMU_EXPORT fmi2Status @_FMU_NAME(fmi2SerializeFMUstate)(fmi2Component c, fmi2FMUstate state, fmi2Byte bytes[], size_t size) {
  return @_FMU_OF(c, @_fmu_write_state((@_fmu *)c, state, (unsigned char *)bytes, size));
}
@_FMU_EXPORT fmi2Status @_FMU_NAME(fmi2DeSerializeFMUstate)(fmi2Component c, const fmi2Byte bytes[], size_t size,
                                                fmi2FMUstate *state) {
  return @_FMU_OF(c, @_fmu_read_state((@_fmu *)c, (const unsigned char *)bytes, size, state));
}

@_FMU_EXPORT fmi2Status @_FMU_NAME(fmi2GetDirectionalDerivative)(fmi2Component c, const fmi2ValueReference unknowns[],
                                                     size_t unknown_count, const fmi2ValueReference knowns[],
                                                     size_t known_count, const fmi2Real seed[], fmi2Real result[]) {
  return @_FMU_OF(c, @_fmu_vary((@_fmu *)c, unknowns, unknown_count, knowns, known_count, seed, result));
}
)c";

const char* const fmi2_steps_text = R"c(
/* Functions that the model description excludes. */
@_FMU_EXPORT fmi2Status @_FMU_NAME(fmi2SetRealInputDerivatives)(fmi2Component c, const fmi2ValueReference vr[], size_t count,
                                                    const fmi2Integer order[], const fmi2Real value[]) {
  (void)vr;
  (void)order;
  (void)value;
  return @_FMU_OF(c, count > 0 ? @_fmu_wrong((@_fmu *)c, "inputs have no derivatives") : @_FMU_OK);
}
@_FMU_EXPORT fmi2Status @_FMU_NAME(fmi2GetRealOutputDerivatives)(fmi2Component c, const fmi2ValueReference vr[], size_t count,
                                                     const fmi2Integer order[], fmi2Real value[]) {
  (void)vr;
  (void)order;
  (void)value;
  return @_FMU_OF(c, count > 0 ? @_fmu_wrong((@_fmu *)c, "outputs have no derivatives") : @_FMU_OK);
}

@_FMU_EXPORT fmi2Status @_FMU_NAME(fmi2DoStep)(fmi2Component c, fmi2Real from, fmi2Real length, fmi2Boolean no_return) {
  (void)no_return;
  return @_FMU_OF(c, @_fmu_do_step((@_fmu *)c, from, length));
}
@_FMU_EXPORT fmi2Status @_FMU_NAME(fmi2CancelStep)(fmi2Component c) {
  return @_FMU_OF(c, @_fmu_wrong((@_fmu *)c, "no step is waiting: each is made at once"));
}
@_FMU_EXPORT fmi2Status @_FMU_NAME(fmi2GetStatus)(fmi2Component c, const fmi2StatusKind kind, fmi2Status *value) {
  (void)kind;
  (void)value;
  return c ? fmi2Discard : fmi2Error;
}
@_FMU_EXPORT fmi2Status @_FMU_NAME(fmi2GetRealStatus)(fmi2Component c, const fmi2StatusKind kind, fmi2Real *value) {
  if (!c || !value) return fmi2Error;
  if (kind != fmi2LastSuccessfulTime) return fmi2Discard;
  *value = ((const @_fmu *)c)->progress.now;
  return fmi2OK;
}
@_FMU_EXPORT fmi2Status @_FMU_NAME(fmi2GetIntegerStatus)(fmi2Component c, const fmi2StatusKind kind, fmi2Integer *value) {
  (void)kind;
  (void)value;
  return c ? fmi2Discard : fmi2Error;
}
@_FMU_EXPORT fmi2Status @_FMU_NAME(fmi2GetBooleanStatus)(fmi2Component c, const fmi2StatusKind kind, fmi2Boolean *value) {
  if (!c || !value) return fmi2Error;
  if (kind != fmi2Terminated) return fmi2Discard;
  *value = ((@_fmu *)c)->progress.ended == 1;
  return fmi2OK;
}
@_FMU_EXPORT fmi2Status @_FMU_NAME(fmi2GetStringStatus)(fmi2Component c, const fmi2StatusKind kind, fmi2String *value) {
  (void)kind;
  (void)value;
  return c ? fmi2Discard : fmi2Error;
}
)c";

}  // namespace mimbre::portable
