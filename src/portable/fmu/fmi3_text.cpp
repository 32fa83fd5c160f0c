#include "portable/fmu/texts.h"

/// FMI 3.0, written from the public standard (fmi-standard.org, version 3.0.2).
namespace mimbre::portable {

const char* const fmi3_types_text = R"c(
typedef void *fmi3Instance;
typedef void *fmi3InstanceEnvironment;
typedef void *fmi3FMUState;
typedef uint32_t fmi3ValueReference;
typedef float fmi3Float32;
typedef double fmi3Float64;
typedef int8_t fmi3Int8;
typedef uint8_t fmi3UInt8;
typedef int16_t fmi3Int16;
typedef uint16_t fmi3UInt16;
typedef int32_t fmi3Int32;
typedef uint32_t fmi3UInt32;
typedef int64_t fmi3Int64;
typedef uint64_t fmi3UInt64;
typedef bool fmi3Boolean;
typedef char fmi3Char;
typedef const fmi3Char *fmi3String;
typedef uint8_t fmi3Byte;
typedef const fmi3Byte *fmi3Binary;
typedef bool fmi3Clock;
typedef enum { fmi3OK, fmi3Warning, fmi3Discard, fmi3Error, fmi3Fatal } fmi3Status;
typedef enum { fmi3Independent, fmi3Constant, fmi3Fixed, fmi3Tunable, fmi3Discrete, fmi3Dependent } fmi3DependencyKind;
typedef enum { fmi3IntervalNotYetKnown, fmi3IntervalUnchanged, fmi3IntervalChanged } fmi3IntervalQualifier;
typedef void (*fmi3LogMessageCallback)(fmi3InstanceEnvironment, fmi3Status, fmi3String, fmi3String);
typedef void (*fmi3ClockUpdateCallback)(fmi3InstanceEnvironment);
typedef void (*fmi3IntermediateUpdateCallback)(fmi3InstanceEnvironment, fmi3Float64, fmi3Boolean, fmi3Boolean,
                                               fmi3Boolean, fmi3Boolean, fmi3Boolean *, fmi3Float64 *);
typedef void (*fmi3LockPreemptionCallback)(void);
typedef void (*fmi3UnlockPreemptionCallback)(void);

typedef fmi3ValueReference @_fmu_reference;
typedef fmi3Int32 @_fmu_integer;

/* The importer's callbacks. */
typedef struct {
  fmi3LogMessageCallback log;
  fmi3InstanceEnvironment environment;
} @_fmu_host;

static void @_fmu_log(const @_fmu_host *host, int status, const char *category, const char *message) {
  if (host->log) host->log(host->environment, (fmi3Status)status, category, message);
}
static void *@_fmu_allocate(const @_fmu_host *host, size_t size) {
  (void)host;
  return calloc(1, size);
}
static void @_fmu_release(const @_fmu_host *host, void *memory) {
  (void)host;
  free(memory);
}
static void @_fmu_forget(@_fmu_host *host) { (void)host; }
)c";

const char* const fmi3_text = R"c(
#define @_FMU_OF(instance, call) ((instance) ? (fmi3Status)(call) : fmi3Error)

@_FMU_EXPORT fmi3String @_FMU_NAME(fmi3GetVersion)(void) { return "3.0"; }

/* An instance, or none where there is a refusal. */
static @_fmu *@_fmu_make(fmi3String instance_name, fmi3String token, fmi3Boolean logs, fmi3InstanceEnvironment environment,
                         fmi3LogMessageCallback log, const char *refusal) {
  @_fmu *f;
  @_fmu_host host;
  const char *const first = @_fmu_refusal(instance_name, token);
  host.log = log;
  host.environment = environment;
  if (first) refusal = first;
  f = refusal ? NULL : (@_fmu *)@_fmu_allocate(&host, sizeof *f);
  if (!refusal && !f) refusal = "there is no memory for an instance";
  if (refusal) {
    @_fmu_log(&host, @_FMU_ERROR, "logStatusError", refusal);
    return NULL;
  }
  return @_fmu_set_up(f, &host, logs);
}

@_FMU_EXPORT fmi3Status @_FMU_NAME(fmi3SetDebugLogging)(fmi3Instance instance, fmi3Boolean on, size_t count,
                                            const fmi3String categories[]) {
  return @_FMU_OF(instance, @_fmu_set_logging((@_fmu *)instance, on, count, categories));
}

@_FMU_EXPORT fmi3Instance @_FMU_NAME(fmi3InstantiateScheduledExecution)(
    fmi3String instance_name, fmi3String token, fmi3String resources, fmi3Boolean visible, fmi3Boolean logs,
    fmi3InstanceEnvironment environment, fmi3LogMessageCallback log, fmi3ClockUpdateCallback update,
    fmi3LockPreemptionCallback lock, fmi3UnlockPreemptionCallback unlock) {
  (void)instance_name;
  (void)token;
  (void)resources;
  (void)visible;
  (void)logs;
  (void)update;
  (void)lock;
  (void)unlock;
  if (log) log(environment, fmi3Error, "logStatusError", "the FMU is not for scheduled execution");
  return NULL;
}
@_FMU_EXPORT void @_FMU_NAME(fmi3FreeInstance)(fmi3Instance instance) {
  if (instance) @_fmu_end((@_fmu *)instance);
}

@_FMU_EXPORT fmi3Status @_FMU_NAME(fmi3EnterInitializationMode)(fmi3Instance instance, fmi3Boolean has_tolerance,
                                                    fmi3Float64 tolerance, fmi3Float64 start, fmi3Boolean has_stop,
                                                    fmi3Float64 stop) {
  @_fmu *const f = (@_fmu *)instance;
  int status;
  if (!f || !@_fmu_turn(f, @_FMU_MADE)) return fmi3Error;
  status = @_fmu_experiment(f, has_tolerance, tolerance, start, has_stop, stop);
  if (status == @_FMU_OK) f->progress.mode = @_FMU_STARTS;
  return (fmi3Status)status;
}
@_FMU_EXPORT fmi3Status @_FMU_NAME(fmi3ExitInitializationMode)(fmi3Instance instance) {
  return @_FMU_OF(instance, @_fmu_run((@_fmu *)instance));
}
@_FMU_EXPORT fmi3Status @_FMU_NAME(fmi3Terminate)(fmi3Instance instance) {
  return @_FMU_OF(instance, @_fmu_go((@_fmu *)instance, @_FMU_ENDS, @_FMU_TERMINATED));
}
@_FMU_EXPORT fmi3Status @_FMU_NAME(fmi3Reset)(fmi3Instance instance) {
  if (!instance) return fmi3Error;
  @_fmu_begin((@_fmu *)instance);
  return fmi3OK;
}

/* Whether there are as many values as the variables have elements. */
static int @_fmu_fits(const @_fmu_reference *references, size_t count, size_t value_count) {
  size_t k, wanted = 0;
  if (count > value_count || (count > 0 && !references)) return 0; /* each variable has one at least */
  for (k = 0; k < count; ++k) wanted += @_fmu_size(references[k]);
  return wanted == value_count;
}
static int @_fmu_list_reals(const @_fmu *f, const @_fmu_reference *references, size_t count, const double *values,
                            size_t value_count) {
  if (!@_fmu_fits(references, count, value_count)) {
    @_fmu_wrong(f, "references are missing, or the number of values is not that of the variables' elements");
    return 0;
  }
  if (count > 0 && !values) {
    @_fmu_wrong(f, "values are missing");
    return 0;
  }
  return 1;
}

@_FMU_EXPORT fmi3Status @_FMU_NAME(fmi3GetFloat64)(fmi3Instance instance, const fmi3ValueReference vr[], size_t count,
                                       fmi3Float64 values[], size_t value_count) {
  @_fmu *const f = (@_fmu *)instance;
  if (!f || !@_fmu_list_reals(f, vr, count, values, value_count)) return fmi3Error;
  return (fmi3Status)@_fmu_get_reals(f, vr, count, values);
}
@_FMU_EXPORT fmi3Status @_FMU_NAME(fmi3SetFloat64)(fmi3Instance instance, const fmi3ValueReference vr[], size_t count,
                                       const fmi3Float64 values[], size_t value_count) {
  @_fmu *const f = (@_fmu *)instance;
  if (!f || !@_fmu_list_reals(f, vr, count, values, value_count)) return fmi3Error;
  return (fmi3Status)@_fmu_set_reals(f, vr, count, values);
}
@_FMU_EXPORT fmi3Status @_FMU_NAME(fmi3GetInt32)(fmi3Instance instance, const fmi3ValueReference vr[], size_t count,
                                     fmi3Int32 values[], size_t value_count) {
  @_fmu *const f = (@_fmu *)instance;
  if (!f || !@_fmu_list(f, vr, count, values, value_count)) return fmi3Error;
  return (fmi3Status)@_fmu_get_counts(f, vr, count, values);
}
@_FMU_EXPORT fmi3Status @_FMU_NAME(fmi3SetInt32)(fmi3Instance instance, const fmi3ValueReference vr[], size_t count,
                                     const fmi3Int32 values[], size_t value_count) {
  @_fmu *const f = (@_fmu *)instance;
  if (!f || !@_fmu_list(f, vr, count, values, value_count)) return fmi3Error;
  return (fmi3Status)@_fmu_set_counts(f, vr, count, values);
}
@_FMU_EXPORT fmi3Status @_FMU_NAME(fmi3GetFloat32)(fmi3Instance instance, const fmi3ValueReference vr[], size_t count, fmi3Float32 values[], size_t value_count) {
  (void)vr;
  (void)values;
  (void)value_count;
  return @_FMU_OF(instance, @_fmu_none((@_fmu *)instance, count));
}
@_FMU_EXPORT fmi3Status @_FMU_NAME(fmi3SetFloat32)(fmi3Instance instance, const fmi3ValueReference vr[], size_t count, const fmi3Float32 values[], size_t value_count) {
  (void)vr;
  (void)values;
  (void)value_count;
  return @_FMU_OF(instance, @_fmu_none((@_fmu *)instance, count));
}
@_FMU_EXPORT fmi3Status @_FMU_NAME(fmi3GetInt8)(fmi3Instance instance, const fmi3ValueReference vr[], size_t count, fmi3Int8 values[], size_t value_count) {
  (void)vr;
  (void)values;
  (void)value_count;
  return @_FMU_OF(instance, @_fmu_none((@_fmu *)instance, count));
}
@_FMU_EXPORT fmi3Status @_FMU_NAME(fmi3SetInt8)(fmi3Instance instance, const fmi3ValueReference vr[], size_t count, const fmi3Int8 values[], size_t value_count) {
  (void)vr;
  (void)values;
  (void)value_count;
  return @_FMU_OF(instance, @_fmu_none((@_fmu *)instance, count));
}
@_FMU_EXPORT fmi3Status @_FMU_NAME(fmi3GetUInt8)(fmi3Instance instance, const fmi3ValueReference vr[], size_t count, fmi3UInt8 values[], size_t value_count) {
  (void)vr;
  (void)values;
  (void)value_count;
  return @_FMU_OF(instance, @_fmu_none((@_fmu *)instance, count));
}
@_FMU_EXPORT fmi3Status @_FMU_NAME(fmi3SetUInt8)(fmi3Instance instance, const fmi3ValueReference vr[], size_t count, const fmi3UInt8 values[], size_t value_count) {
  (void)vr;
  (void)values;
  (void)value_count;
  return @_FMU_OF(instance, @_fmu_none((@_fmu *)instance, count));
}
@_FMU_EXPORT fmi3Status @_FMU_NAME(fmi3GetInt16)(fmi3Instance instance, const fmi3ValueReference vr[], size_t count, fmi3Int16 values[], size_t value_count) {
  (void)vr;
  (void)values;
  (void)value_count;
  return @_FMU_OF(instance, @_fmu_none((@_fmu *)instance, count));
}
@_FMU_EXPORT fmi3Status @_FMU_NAME(fmi3SetInt16)(fmi3Instance instance, const fmi3ValueReference vr[], size_t count, const fmi3Int16 values[], size_t value_count) {
  (void)vr;
  (void)values;
  (void)value_count;
  return @_FMU_OF(instance, @_fmu_none((@_fmu *)instance, count));
}
@_FMU_EXPORT fmi3Status @_FMU_NAME(fmi3GetUInt16)(fmi3Instance instance, const fmi3ValueReference vr[], size_t count, fmi3UInt16 values[], size_t value_count) {
  (void)vr;
  (void)values;
  (void)value_count;
  return @_FMU_OF(instance, @_fmu_none((@_fmu *)instance, count));
}
@_FMU_EXPORT fmi3Status @_FMU_NAME(fmi3SetUInt16)(fmi3Instance instance, const fmi3ValueReference vr[], size_t count, const fmi3UInt16 values[], size_t value_count) {
  (void)vr;
  (void)values;
  (void)value_count;
  return @_FMU_OF(instance, @_fmu_none((@_fmu *)instance, count));
}
@_FMU_EXPORT fmi3Status @_FMU_NAME(fmi3GetUInt32)(fmi3Instance instance, const fmi3ValueReference vr[], size_t count, fmi3UInt32 values[], size_t value_count) {
  (void)vr;
  (void)values;
  (void)value_count;
  return @_FMU_OF(instance, @_fmu_none((@_fmu *)instance, count));
}
@_FMU_EXPORT fmi3Status @_FMU_NAME(fmi3SetUInt32)(fmi3Instance instance, const fmi3ValueReference vr[], size_t count, const fmi3UInt32 values[], size_t value_count) {
  (void)vr;
  (void)values;
  (void)value_count;
  return @_FMU_OF(instance, @_fmu_none((@_fmu *)instance, count));
}
@_FMU_EXPORT fmi3Status @_FMU_NAME(fmi3GetInt64)(fmi3Instance instance, const fmi3ValueReference vr[], size_t count, fmi3Int64 values[], size_t value_count) {
  (void)vr;
  (void)values;
  (void)value_count;
  return @_FMU_OF(instance, @_fmu_none((@_fmu *)instance, count));
}
@_FMU_EXPORT fmi3Status @_FMU_NAME(fmi3SetInt64)(fmi3Instance instance, const fmi3ValueReference vr[], size_t count, const fmi3Int64 values[], size_t value_count) {
  (void)vr;
  (void)values;
  (void)value_count;
  return @_FMU_OF(instance, @_fmu_none((@_fmu *)instance, count));
}
@_FMU_EXPORT fmi3Status @_FMU_NAME(fmi3GetUInt64)(fmi3Instance instance, const fmi3ValueReference vr[], size_t count, fmi3UInt64 values[], size_t value_count) {
  (void)vr;
  (void)values;
  (void)value_count;
  return @_FMU_OF(instance, @_fmu_none((@_fmu *)instance, count));
}
@_FMU_EXPORT fmi3Status @_FMU_NAME(fmi3SetUInt64)(fmi3Instance instance, const fmi3ValueReference vr[], size_t count, const fmi3UInt64 values[], size_t value_count) {
  (void)vr;
  (void)values;
  (void)value_count;
  return @_FMU_OF(instance, @_fmu_none((@_fmu *)instance, count));
}
@_FMU_EXPORT fmi3Status @_FMU_NAME(fmi3GetBoolean)(fmi3Instance instance, const fmi3ValueReference vr[], size_t count, fmi3Boolean values[], size_t value_count) {
  (void)vr;
  (void)values;
  (void)value_count;
  return @_FMU_OF(instance, @_fmu_none((@_fmu *)instance, count));
}
@_FMU_EXPORT fmi3Status @_FMU_NAME(fmi3SetBoolean)(fmi3Instance instance, const fmi3ValueReference vr[], size_t count, const fmi3Boolean values[], size_t value_count) {
  (void)vr;
  (void)values;
  (void)value_count;
  return @_FMU_OF(instance, @_fmu_none((@_fmu *)instance, count));
}
@_FMU_EXPORT fmi3Status @_FMU_NAME(fmi3GetString)(fmi3Instance instance, const fmi3ValueReference vr[], size_t count, fmi3String values[], size_t value_count) {
  (void)vr;
  (void)values;
  (void)value_count;
  return @_FMU_OF(instance, @_fmu_none((@_fmu *)instance, count));
}
@_FMU_EXPORT fmi3Status @_FMU_NAME(fmi3SetString)(fmi3Instance instance, const fmi3ValueReference vr[], size_t count, const fmi3String values[], size_t value_count) {
  (void)vr;
  (void)values;
  (void)value_count;
  return @_FMU_OF(instance, @_fmu_none((@_fmu *)instance, count));
}
@_FMU_EXPORT fmi3Status @_FMU_NAME(fmi3GetBinary)(fmi3Instance instance, const fmi3ValueReference vr[], size_t count, size_t sizes[], fmi3Binary values[], size_t value_count) {
  (void)vr;
  (void)sizes;
  (void)values;
  (void)value_count;
  return @_FMU_OF(instance, @_fmu_none((@_fmu *)instance, count));
}
@_FMU_EXPORT fmi3Status @_FMU_NAME(fmi3SetBinary)(fmi3Instance instance, const fmi3ValueReference vr[], size_t count, const size_t sizes[], const fmi3Binary values[], size_t value_count) {
  (void)vr;
  (void)sizes;
  (void)values;
  (void)value_count;
  return @_FMU_OF(instance, @_fmu_none((@_fmu *)instance, count));
}
@_FMU_EXPORT fmi3Status @_FMU_NAME(fmi3GetClock)(fmi3Instance instance, const fmi3ValueReference vr[], size_t count, fmi3Clock values[]) {
  (void)vr;
  (void)values;
  return @_FMU_OF(instance, @_fmu_none((@_fmu *)instance, count));
}
@_FMU_EXPORT fmi3Status @_FMU_NAME(fmi3SetClock)(fmi3Instance instance, const fmi3ValueReference vr[], size_t count, const fmi3Clock values[]) {
  (void)vr;
  (void)values;
  return @_FMU_OF(instance, @_fmu_none((@_fmu *)instance, count));
}

@_FMU_EXPORT fmi3Status @_FMU_NAME(fmi3GetFMUState)(fmi3Instance instance, fmi3FMUState *state) {
  return @_FMU_OF(instance, @_fmu_get_state((@_fmu *)instance, state));
}
@_FMU_EXPORT fmi3Status @_FMU_NAME(fmi3SetFMUState)(fmi3Instance instance, fmi3FMUState state) {
  return @_FMU_OF(instance, @_fmu_set_state((@_fmu *)instance, state));
}
@_FMU_EXPORT fmi3Status @_FMU_NAME(fmi3FreeFMUState)(fmi3Instance instance, fmi3FMUState *state) {
  return @_FMU_OF(instance, @_fmu_free_state((@_fmu *)instance, state));
}
@_FMU_EXPORT fmi3Status @_FMU_NAME(fmi3SerializedFMUStateSize)(fmi3Instance instance, fmi3FMUState state, size_t *size) {
  return @_FMU_OF(instance, @_fmu_state_size((@_fmu *)instance, state, size));
}
@_FMU_EXPORT fmi3Status @_FMU_NAME(fmi3SerializeFMUState)(fmi3Instance instance, fmi3FMUState state, fmi3Byte bytes[],
                                              size_t size) {
  return @_FMU_OF(instance, @_fmu_write_state((@_fmu *)instance, state, bytes, size));
}
@_FMU_EXPORT fmi3Status @_FMU_NAME(fmi3DeserializeFMUState)(fmi3Instance instance, const fmi3Byte bytes[], size_t size,
                                                fmi3FMUState *state) {
  return @_FMU_OF(instance, @_fmu_read_state((@_fmu *)instance, bytes, size, state));
}

@_FMU_EXPORT fmi3Status @_FMU_NAME(fmi3GetDirectionalDerivative)(fmi3Instance instance, const fmi3ValueReference unknowns[], size_t unknown_count, const fmi3ValueReference knowns[], size_t known_count, const fmi3Float64 seed[], size_t seed_count, fmi3Float64 result[], size_t result_count) {
  @_fmu *const f = (@_fmu *)instance;
  if (!f) return fmi3Error;
  if (!@_fmu_fits(knowns, known_count, seed_count) || !@_fmu_fits(unknowns, unknown_count, result_count))
    return (fmi3Status)@_fmu_wrong(f, "references are missing, or the seed or the results have not as many values as the variables have elements");
  return (fmi3Status)@_fmu_vary(f, unknowns, unknown_count, knowns, known_count, seed, result);
}
)c"
                              R"c(
/* Functions that the model description excludes. */
@_FMU_EXPORT fmi3Status @_FMU_NAME(fmi3EvaluateDiscreteStates)(fmi3Instance instance) {
  return @_FMU_OF(instance, @_fmu_wrong((@_fmu *)instance, "the FMU has no discrete states"));
}
@_FMU_EXPORT fmi3Status @_FMU_NAME(fmi3EnterConfigurationMode)(fmi3Instance instance) {
  return @_FMU_OF(instance, @_fmu_wrong((@_fmu *)instance, "the FMU has no structural parameters"));
}
@_FMU_EXPORT fmi3Status @_FMU_NAME(fmi3ExitConfigurationMode)(fmi3Instance instance) {
  return @_FMU_OF(instance, @_fmu_wrong((@_fmu *)instance, "the FMU has no structural parameters"));
}
@_FMU_EXPORT fmi3Status @_FMU_NAME(fmi3GetNumberOfVariableDependencies)(fmi3Instance instance, fmi3ValueReference variable, size_t *count_of) {
  (void)variable;
  (void)count_of;
  return @_FMU_OF(instance, @_fmu_wrong((@_fmu *)instance, "dependencies are in the model description alone"));
}
@_FMU_EXPORT fmi3Status @_FMU_NAME(fmi3GetVariableDependencies)(fmi3Instance instance, fmi3ValueReference dependent, size_t elements[], fmi3ValueReference independents[], size_t independent_elements[], fmi3DependencyKind kinds[], size_t number) {
  (void)dependent;
  (void)elements;
  (void)independents;
  (void)independent_elements;
  (void)kinds;
  (void)number;
  return @_FMU_OF(instance, @_fmu_wrong((@_fmu *)instance, "dependencies are in the model description alone"));
}
@_FMU_EXPORT fmi3Status @_FMU_NAME(fmi3GetAdjointDerivative)(fmi3Instance instance, const fmi3ValueReference unknowns[], size_t unknown_count, const fmi3ValueReference knowns[], size_t known_count, const fmi3Float64 seed[], size_t seed_count, fmi3Float64 result[], size_t result_count) {
  (void)unknowns;
  (void)unknown_count;
  (void)knowns;
  (void)known_count;
  (void)seed;
  (void)seed_count;
  (void)result;
  (void)result_count;
  return @_FMU_OF(instance, @_fmu_wrong((@_fmu *)instance, @_FMU_NO_ADJOINTS));
}
@_FMU_EXPORT fmi3Status @_FMU_NAME(fmi3GetIntervalDecimal)(fmi3Instance instance, const fmi3ValueReference vr[], size_t number, fmi3Float64 intervals[], fmi3IntervalQualifier qualifiers[]) {
  (void)vr;
  (void)number;
  (void)intervals;
  (void)qualifiers;
  return @_FMU_OF(instance, @_fmu_wrong((@_fmu *)instance, "the FMU has no clocks"));
}
@_FMU_EXPORT fmi3Status @_FMU_NAME(fmi3GetIntervalFraction)(fmi3Instance instance, const fmi3ValueReference vr[], size_t number, fmi3UInt64 counters[], fmi3UInt64 resolutions[], fmi3IntervalQualifier qualifiers[]) {
  (void)vr;
  (void)number;
  (void)counters;
  (void)resolutions;
  (void)qualifiers;
  return @_FMU_OF(instance, @_fmu_wrong((@_fmu *)instance, "the FMU has no clocks"));
}
@_FMU_EXPORT fmi3Status @_FMU_NAME(fmi3GetShiftDecimal)(fmi3Instance instance, const fmi3ValueReference vr[], size_t number, fmi3Float64 shifts[]) {
  (void)vr;
  (void)number;
  (void)shifts;
  return @_FMU_OF(instance, @_fmu_wrong((@_fmu *)instance, "the FMU has no clocks"));
}
@_FMU_EXPORT fmi3Status @_FMU_NAME(fmi3GetShiftFraction)(fmi3Instance instance, const fmi3ValueReference vr[], size_t number, fmi3UInt64 counters[], fmi3UInt64 resolutions[]) {
  (void)vr;
  (void)number;
  (void)counters;
  (void)resolutions;
  return @_FMU_OF(instance, @_fmu_wrong((@_fmu *)instance, "the FMU has no clocks"));
}
@_FMU_EXPORT fmi3Status @_FMU_NAME(fmi3SetIntervalDecimal)(fmi3Instance instance, const fmi3ValueReference vr[], size_t number, const fmi3Float64 intervals[]) {
  (void)vr;
  (void)number;
  (void)intervals;
  return @_FMU_OF(instance, @_fmu_wrong((@_fmu *)instance, "the FMU has no clocks"));
}
@_FMU_EXPORT fmi3Status @_FMU_NAME(fmi3SetIntervalFraction)(fmi3Instance instance, const fmi3ValueReference vr[], size_t number, const fmi3UInt64 counters[], const fmi3UInt64 resolutions[]) {
  (void)vr;
  (void)number;
  (void)counters;
  (void)resolutions;
  return @_FMU_OF(instance, @_fmu_wrong((@_fmu *)instance, "the FMU has no clocks"));
}
@_FMU_EXPORT fmi3Status @_FMU_NAME(fmi3SetShiftDecimal)(fmi3Instance instance, const fmi3ValueReference vr[], size_t number, const fmi3Float64 shifts[]) {
  (void)vr;
  (void)number;
  (void)shifts;
  return @_FMU_OF(instance, @_fmu_wrong((@_fmu *)instance, "the FMU has no clocks"));
}
@_FMU_EXPORT fmi3Status @_FMU_NAME(fmi3SetShiftFraction)(fmi3Instance instance, const fmi3ValueReference vr[], size_t number, const fmi3UInt64 counters[], const fmi3UInt64 resolutions[]) {
  (void)vr;
  (void)number;
  (void)counters;
  (void)resolutions;
  return @_FMU_OF(instance, @_fmu_wrong((@_fmu *)instance, "the FMU has no clocks"));
}
@_FMU_EXPORT fmi3Status @_FMU_NAME(fmi3ActivateModelPartition)(fmi3Instance instance, fmi3ValueReference clock, fmi3Float64 time) {
  (void)clock;
  (void)time;
  return @_FMU_OF(instance, @_fmu_wrong((@_fmu *)instance, "the FMU has no clocks"));
}
)c";

const char* const fmi3_steps_text = R"c(
@_FMU_EXPORT fmi3Instance @_FMU_NAME(fmi3InstantiateCoSimulation)(
    fmi3String instance_name, fmi3String token, fmi3String resources, fmi3Boolean visible, fmi3Boolean logs,
    fmi3Boolean event_mode, fmi3Boolean early_return, const fmi3ValueReference intermediate[],
    size_t intermediate_count, fmi3InstanceEnvironment environment, fmi3LogMessageCallback log,
    fmi3IntermediateUpdateCallback update) {
  @_fmu *f;
  (void)resources;
  (void)visible;
  (void)intermediate;
  (void)update;
  f = @_fmu_make(instance_name, token, logs, environment, log,
                 event_mode && !@_FMU_EVENT_MODE ? "the FMU has no event mode"
                 : intermediate_count > 0        ? "the FMU has no intermediate variables"
                                                 : NULL);
  if (!f) return NULL;
  f->uses_events = event_mode;
  f->returns_early = early_return;
  return f;
}
@_FMU_EXPORT fmi3Instance @_FMU_NAME(fmi3InstantiateModelExchange)(fmi3String instance_name, fmi3String token,
                                                       fmi3String resources, fmi3Boolean visible, fmi3Boolean logs,
                                                       fmi3InstanceEnvironment environment,
                                                       fmi3LogMessageCallback log) {
  (void)instance_name;
  (void)token;
  (void)resources;
  (void)visible;
  (void)logs;
  if (log) log(environment, fmi3Error, "logStatusError", "the FMU is for co-simulation only");
  return NULL;
}

@_FMU_EXPORT fmi3Status @_FMU_NAME(fmi3DoStep)(fmi3Instance instance, fmi3Float64 from, fmi3Float64 length, fmi3Boolean no_return,
                                   fmi3Boolean *event, fmi3Boolean *terminate, fmi3Boolean *early_return,
                                   fmi3Float64 *last) {
  @_fmu *const f = (@_fmu *)instance;
  int status;
  (void)no_return;
  if (!f) return fmi3Error;
  if (!event || !terminate || !early_return || !last)
    return (fmi3Status)@_fmu_wrong(f, "a pointer for the results of the step is missing");
  *event = *terminate = *early_return = false;
  status = @_fmu_do_step(f, from, length);
  *event = f->uses_events && f->event;
  *early_return = f->early;
  *terminate = f->progress.ended == 1;
  *last = f->progress.now;
  return (fmi3Status)status;
}

/* Events of the model have happened where a step ends: in event mode the importer sees what they have set. */
@_FMU_EXPORT fmi3Status @_FMU_NAME(fmi3EnterEventMode)(fmi3Instance instance) {
  @_fmu *const f = (@_fmu *)instance;
  if (!f) return fmi3Error;
  if (!f->uses_events) return (fmi3Status)@_fmu_wrong(f, "the FMU was made without event mode, or has none");
  return (fmi3Status)@_fmu_go(f, @_FMU_RUNS, @_FMU_EVENTS);
}
@_FMU_EXPORT fmi3Status @_FMU_NAME(fmi3EnterStepMode)(fmi3Instance instance) {
  return @_FMU_OF(instance, @_fmu_go((@_fmu *)instance, @_FMU_EVENTS, @_FMU_RUNS));
}
@_FMU_EXPORT fmi3Status @_FMU_NAME(fmi3UpdateDiscreteStates)(fmi3Instance instance, fmi3Boolean *need_update, fmi3Boolean *terminate, fmi3Boolean *nominals_changed, fmi3Boolean *values_changed, fmi3Boolean *has_next, fmi3Float64 *next) {
  @_fmu *const f = (@_fmu *)instance;
  if (!f || !@_fmu_turn(f, @_FMU_EVENTS)) return fmi3Error;
  if (!need_update || !terminate || !nominals_changed || !values_changed || !has_next || !next)
    return (fmi3Status)@_fmu_wrong(f, "a pointer for the results of the update is missing");
  *need_update = *terminate = *nominals_changed = *values_changed = *has_next = false;
  *next = 0.0;
  return fmi3OK;
}

/* Functions that the model description excludes. */
@_FMU_EXPORT fmi3Status @_FMU_NAME(fmi3GetOutputDerivatives)(fmi3Instance instance, const fmi3ValueReference vr[], size_t number, const fmi3Int32 orders[], fmi3Float64 values[], size_t value_count) {
  (void)vr;
  (void)number;
  (void)orders;
  (void)values;
  (void)value_count;
  return @_FMU_OF(instance, @_fmu_wrong((@_fmu *)instance, "the FMU has no derivatives of outputs by time"));
}
@_FMU_EXPORT fmi3Status @_FMU_NAME(fmi3EnterContinuousTimeMode)(fmi3Instance instance) {
  return @_FMU_OF(instance, @_fmu_wrong((@_fmu *)instance, "the FMU is for co-simulation only"));
}
@_FMU_EXPORT fmi3Status @_FMU_NAME(fmi3CompletedIntegratorStep)(fmi3Instance instance, fmi3Boolean no_return, fmi3Boolean *event, fmi3Boolean *terminate) {
  (void)no_return;
  (void)event;
  (void)terminate;
  return @_FMU_OF(instance, @_fmu_wrong((@_fmu *)instance, "the FMU is for co-simulation only"));
}
@_FMU_EXPORT fmi3Status @_FMU_NAME(fmi3SetTime)(fmi3Instance instance, fmi3Float64 time) {
  (void)time;
  return @_FMU_OF(instance, @_fmu_wrong((@_fmu *)instance, "the FMU is for co-simulation only"));
}
@_FMU_EXPORT fmi3Status @_FMU_NAME(fmi3SetContinuousStates)(fmi3Instance instance, const fmi3Float64 states[], size_t number) {
  (void)states;
  (void)number;
  return @_FMU_OF(instance, @_fmu_wrong((@_fmu *)instance, "the FMU is for co-simulation only"));
}
@_FMU_EXPORT fmi3Status @_FMU_NAME(fmi3GetContinuousStateDerivatives)(fmi3Instance instance, fmi3Float64 derivatives[], size_t number) {
  (void)derivatives;
  (void)number;
  return @_FMU_OF(instance, @_fmu_wrong((@_fmu *)instance, "the FMU is for co-simulation only"));
}
@_FMU_EXPORT fmi3Status @_FMU_NAME(fmi3GetEventIndicators)(fmi3Instance instance, fmi3Float64 indicators[], size_t number) {
  (void)indicators;
  (void)number;
  return @_FMU_OF(instance, @_fmu_wrong((@_fmu *)instance, "the FMU is for co-simulation only"));
}
@_FMU_EXPORT fmi3Status @_FMU_NAME(fmi3GetContinuousStates)(fmi3Instance instance, fmi3Float64 states[], size_t number) {
  (void)states;
  (void)number;
  return @_FMU_OF(instance, @_fmu_wrong((@_fmu *)instance, "the FMU is for co-simulation only"));
}
@_FMU_EXPORT fmi3Status @_FMU_NAME(fmi3GetNominalsOfContinuousStates)(fmi3Instance instance, fmi3Float64 nominals[], size_t number) {
  (void)nominals;
  (void)number;
  return @_FMU_OF(instance, @_fmu_wrong((@_fmu *)instance, "the FMU is for co-simulation only"));
}
@_FMU_EXPORT fmi3Status @_FMU_NAME(fmi3GetNumberOfEventIndicators)(fmi3Instance instance, size_t *number) {
  (void)number;
  return @_FMU_OF(instance, @_fmu_wrong((@_fmu *)instance, "the FMU is for co-simulation only"));
}
@_FMU_EXPORT fmi3Status @_FMU_NAME(fmi3GetNumberOfContinuousStates)(fmi3Instance instance, size_t *number) {
  (void)number;
  return @_FMU_OF(instance, @_fmu_wrong((@_fmu *)instance, "the FMU is for co-simulation only"));
}
)c";

}  // namespace mimbre::portable
