#include "portable/fmu/texts.h"

/// Functions of both versions of the standard for model exchange, written from FMI 2.0.4 and 3.0.2.
namespace mimbre::portable {

const char* const fmi2_exchange_text = R"c(
typedef struct {
  fmi2Boolean newDiscreteStatesNeeded, terminateSimulation, nominalsOfContinuousStatesChanged;
  fmi2Boolean valuesOfContinuousStatesChanged, nextEventTimeDefined;
  fmi2Real nextEventTime;
} fmi2EventInfo;

/* Allowed in event mode as well, unlike in FMI 3. */
@_FMU_EXPORT fmi2Status @_FMU_NAME(fmi2EnterEventMode)(fmi2Component c) {
  return @_FMU_OF(c, @_fmu_go((@_fmu *)c, @_FMU_RUNS | @_FMU_EVENTS, @_FMU_EVENTS));
}
@_FMU_EXPORT fmi2Status @_FMU_NAME(fmi2EnterContinuousTimeMode)(fmi2Component c) {
  return @_FMU_OF(c, @_fmu_go((@_fmu *)c, @_FMU_EVENTS, @_FMU_RUNS));
}
@_FMU_EXPORT fmi2Status @_FMU_NAME(fmi2NewDiscreteStates)(fmi2Component c, fmi2EventInfo *info) {
  @_fmu *const f = (@_fmu *)c;
  int changed = 0, more = 0, status;
  double next = 0.0;
  if (!f) return fmi2Error;
  if (!info) return (fmi2Status)@_fmu_wrong(f, "a pointer for the results of the update is missing");
  status = @_fmu_update(f, &changed, &more, &next);
  info->newDiscreteStatesNeeded = info->terminateSimulation = 0;
  info->nominalsOfContinuousStatesChanged = info->valuesOfContinuousStatesChanged = changed;
  info->nextEventTimeDefined = more;
  info->nextEventTime = next;
  return (fmi2Status)status;
}
@_FMU_EXPORT fmi2Status @_FMU_NAME(fmi2CompletedIntegratorStep)(fmi2Component c, fmi2Boolean no_return, fmi2Boolean *event,
                                                    fmi2Boolean *terminate) {
  @_fmu *const f = (@_fmu *)c;
  (void)no_return;
  if (!f || !@_fmu_turn(f, @_FMU_RUNS)) return fmi2Error;
  if (!event || !terminate) return (fmi2Status)@_fmu_wrong(f, "a pointer for the results of the step is missing");
  *event = *terminate = 0;
  return fmi2OK;
}
@_FMU_EXPORT fmi2Status @_FMU_NAME(fmi2SetTime)(fmi2Component c, fmi2Real time) {
  return @_FMU_OF(c, @_fmu_set_time((@_fmu *)c, time));
}
@_FMU_EXPORT fmi2Status @_FMU_NAME(fmi2SetContinuousStates)(fmi2Component c, const fmi2Real states[], size_t count) {
  return @_FMU_OF(c, @_fmu_set_states((@_fmu *)c, states, count));
}
@_FMU_EXPORT fmi2Status @_FMU_NAME(fmi2GetContinuousStates)(fmi2Component c, fmi2Real states[], size_t count) {
  return @_FMU_OF(c, @_fmu_get_states((@_fmu *)c, states, count));
}
@_FMU_EXPORT fmi2Status @_FMU_NAME(fmi2GetDerivatives)(fmi2Component c, fmi2Real derivatives[], size_t count) {
  return @_FMU_OF(c, @_fmu_get_derivatives((@_fmu *)c, derivatives, count));
}
@_FMU_EXPORT fmi2Status @_FMU_NAME(fmi2GetEventIndicators)(fmi2Component c, fmi2Real indicators[], size_t count) {
  return @_FMU_OF(c, @_fmu_get_indicators((@_fmu *)c, indicators, count));
}
@_FMU_EXPORT fmi2Status @_FMU_NAME(fmi2GetNominalsOfContinuousStates)(fmi2Component c, fmi2Real nominals[], size_t count) {
  return @_FMU_OF(c, @_fmu_get_nominals((@_fmu *)c, nominals, count));
}
)c";

const char* const fmi3_exchange_text = R"c(
@_FMU_EXPORT fmi3Instance @_FMU_NAME(fmi3InstantiateModelExchange)(fmi3String instance_name, fmi3String token,
                                                       fmi3String resources, fmi3Boolean visible, fmi3Boolean logs,
                                                       fmi3InstanceEnvironment environment,
                                                       fmi3LogMessageCallback log) {
  (void)resources;
  (void)visible;
  return @_fmu_make(instance_name, token, logs, environment, log, NULL);
}
@_FMU_EXPORT fmi3Instance @_FMU_NAME(fmi3InstantiateCoSimulation)(
    fmi3String instance_name, fmi3String token, fmi3String resources, fmi3Boolean visible, fmi3Boolean logs,
    fmi3Boolean event_mode, fmi3Boolean early_return, const fmi3ValueReference intermediate[],
    size_t intermediate_count, fmi3InstanceEnvironment environment, fmi3LogMessageCallback log,
    fmi3IntermediateUpdateCallback update) {
  (void)instance_name;
  (void)token;
  (void)resources;
  (void)visible;
  (void)logs;
  (void)event_mode;
  (void)early_return;
  (void)intermediate;
  (void)intermediate_count;
  (void)update;
  if (log) log(environment, fmi3Error, "logStatusError", "the FMU is for model exchange only");
  return NULL;
}

@_FMU_EXPORT fmi3Status @_FMU_NAME(fmi3EnterEventMode)(fmi3Instance instance) {
  return @_FMU_OF(instance, @_fmu_go((@_fmu *)instance, @_FMU_RUNS, @_FMU_EVENTS));
}
@_FMU_EXPORT fmi3Status @_FMU_NAME(fmi3EnterContinuousTimeMode)(fmi3Instance instance) {
  return @_FMU_OF(instance, @_fmu_go((@_fmu *)instance, @_FMU_EVENTS, @_FMU_RUNS));
}
@_FMU_EXPORT fmi3Status @_FMU_NAME(fmi3UpdateDiscreteStates)(fmi3Instance instance, fmi3Boolean *need_update, fmi3Boolean *terminate, fmi3Boolean *nominals_changed, fmi3Boolean *values_changed, fmi3Boolean *has_next, fmi3Float64 *next) {
  @_fmu *const f = (@_fmu *)instance;
  int changed = 0, more = 0, status;
  if (!f) return fmi3Error;
  if (!need_update || !terminate || !nominals_changed || !values_changed || !has_next || !next)
    return (fmi3Status)@_fmu_wrong(f, "a pointer for the results of the update is missing");
  *need_update = *terminate = *nominals_changed = *values_changed = *has_next = false;
  status = @_fmu_update(f, &changed, &more, next);
  *nominals_changed = *values_changed = changed != 0;
  *has_next = more != 0;
  return (fmi3Status)status;
}
@_FMU_EXPORT fmi3Status @_FMU_NAME(fmi3CompletedIntegratorStep)(fmi3Instance instance, fmi3Boolean no_return, fmi3Boolean *event, fmi3Boolean *terminate) {
  @_fmu *const f = (@_fmu *)instance;
  (void)no_return;
  if (!f || !@_fmu_turn(f, @_FMU_RUNS)) return fmi3Error;
  if (!event || !terminate) return (fmi3Status)@_fmu_wrong(f, "a pointer for the results of the step is missing");
  *event = *terminate = false;
  return fmi3OK;
}
@_FMU_EXPORT fmi3Status @_FMU_NAME(fmi3SetTime)(fmi3Instance instance, fmi3Float64 time) {
  return @_FMU_OF(instance, @_fmu_set_time((@_fmu *)instance, time));
}
@_FMU_EXPORT fmi3Status @_FMU_NAME(fmi3SetContinuousStates)(fmi3Instance instance, const fmi3Float64 states[], size_t number) {
  return @_FMU_OF(instance, @_fmu_set_states((@_fmu *)instance, states, number));
}
@_FMU_EXPORT fmi3Status @_FMU_NAME(fmi3GetContinuousStates)(fmi3Instance instance, fmi3Float64 states[], size_t number) {
  return @_FMU_OF(instance, @_fmu_get_states((@_fmu *)instance, states, number));
}
@_FMU_EXPORT fmi3Status @_FMU_NAME(fmi3GetContinuousStateDerivatives)(fmi3Instance instance, fmi3Float64 derivatives[], size_t number) {
  return @_FMU_OF(instance, @_fmu_get_derivatives((@_fmu *)instance, derivatives, number));
}
@_FMU_EXPORT fmi3Status @_FMU_NAME(fmi3GetEventIndicators)(fmi3Instance instance, fmi3Float64 indicators[], size_t number) {
  return @_FMU_OF(instance, @_fmu_get_indicators((@_fmu *)instance, indicators, number));
}
@_FMU_EXPORT fmi3Status @_FMU_NAME(fmi3GetNominalsOfContinuousStates)(fmi3Instance instance, fmi3Float64 nominals[], size_t number) {
  return @_FMU_OF(instance, @_fmu_get_nominals((@_fmu *)instance, nominals, number));
}
@_FMU_EXPORT fmi3Status @_FMU_NAME(fmi3GetNumberOfContinuousStates)(fmi3Instance instance, size_t *number) {
  if (!instance) return fmi3Error;
  if (!number) return (fmi3Status)@_fmu_wrong((@_fmu *)instance, "the pointer for the number is missing");
  *number = @_FMU_STATES;
  return fmi3OK;
}
@_FMU_EXPORT fmi3Status @_FMU_NAME(fmi3GetNumberOfEventIndicators)(fmi3Instance instance, size_t *number) {
  if (!instance) return fmi3Error;
  if (!number) return (fmi3Status)@_fmu_wrong((@_fmu *)instance, "the pointer for the number is missing");
  *number = @_FMU_INDICATORS;
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
@_FMU_EXPORT fmi3Status @_FMU_NAME(fmi3EnterStepMode)(fmi3Instance instance) {
  return @_FMU_OF(instance, @_fmu_wrong((@_fmu *)instance, "the FMU is for model exchange only"));
}
@_FMU_EXPORT fmi3Status @_FMU_NAME(fmi3DoStep)(fmi3Instance instance, fmi3Float64 from, fmi3Float64 length, fmi3Boolean no_return,
                                   fmi3Boolean *event, fmi3Boolean *terminate, fmi3Boolean *early_return,
                                   fmi3Float64 *last) {
  (void)from;
  (void)length;
  (void)no_return;
  (void)event;
  (void)terminate;
  (void)early_return;
  (void)last;
  return @_FMU_OF(instance, @_fmu_wrong((@_fmu *)instance, "the FMU is for model exchange only"));
}
)c";

}  // namespace mimbre::portable
