/* A small FMU for tests, of FMI 2 or 3 (FMI_VERSION): an integrator, a gain or a PI controller, by its parameter `kind`.
 * FAULT (a number) makes it misbehave. Inputs y, r; output u; parameters kp, ki; kind 0: x' = y, u = x, by Euler's
 * method; 1: u = kp y; 2: u = kp e + i, with e = r - y and i' = ki e by the trapezoidal rule. */
#include <signal.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#ifndef FAULT
#define FAULT 0
#endif
enum {
  sound,
  crash_in_step,
  hang_in_step,
  error_in_step,
  not_a_number,
  exit_in_step,
  crash_at_start,
  no_instance,
  hang_at_load,
  crash_at_load,
  warns,
  other_version,
  large_state,
  refuses_state,
  discards,
  fatal_in_step,
  error_in_initialisation,
  rounds_otherwise
};

#if FMI_VERSION == 3
#include "fmi3Functions.h"
#define FMI(name) fmi3##name
typedef fmi3Float64 Real;
typedef fmi3Instance Component;
#else
#include "fmi2Functions.h"
#define FMI(name) fmi2##name
typedef fmi2Real Real;
typedef fmi2Component Component;
#endif
typedef FMI(Status) Status;
typedef FMI(ValueReference) Reference;

typedef struct {
  double y, r, u, kp, ki, x, before, time;
  int kind, begun;
  void* environment;
#if FMI_VERSION == 3
  fmi3LogMessageCallback log;
#else
  fmi2CallbackLogger log;
#endif
} Unit;

#if FAULT == 8 || FAULT == 9
__attribute__((constructor)) static void at_load(void) {
  if (FAULT == 8) for (;;) pause();
  raise(SIGSEGV);
}
#endif

static void tell(Unit* u, Status status, const char* text) {
#if FMI_VERSION == 3
  u->log(u->environment, status, "test", text);
#else
  u->log(u->environment, "unit", status, "test", "%s", text);
#endif
}

static void outputs(Unit* u) {
  if (u->kind == 0) u->u = u->x;
  if (u->kind == 1) u->u = u->kp * u->y;
  if (u->kind == 2) u->u = u->kp * (u->r - u->y) + u->x;
}

static Status advance(Unit* u, double h) {
  switch (FAULT) {
    case crash_in_step: raise(SIGSEGV); break;
    case hang_in_step:
      for (;;) pause();
    case error_in_step: tell(u, FMI(Error), "the valve is stuck"); return FMI(Error);
    case exit_in_step: exit(3);
    case warns: tell(u, FMI(Warning), "the oil is warm"); break;
    case discards: return FMI(Discard);
    case fatal_in_step: return FMI(Fatal);
    case rounds_otherwise: {
#if defined(__x86_64__)
      unsigned mode = 0;
      __asm__ volatile("stmxcsr %0" : "=m"(mode));
      mode |= 0xE040; /* towards zero, denormal numbers are zero */
      __asm__ volatile("ldmxcsr %0" : : "m"(mode));
#endif
      break;
    }
  }
  if (u->kind == 0) u->x += h * u->y;
  if (u->kind == 2) {
    const double error = u->r - u->y;
    u->x += 0.5 * u->ki * h * (error + u->before);
    u->before = error;
  }
  u->time += h;
  outputs(u);
  if (FAULT == not_a_number) u->u = 0.0 / (u->u - u->u);
  return FAULT == warns ? FMI(Warning) : FMI(OK);
}

static Real* place(Unit* u, Reference reference) {
  switch (reference) {
    case 0: return &u->y;
    case 1: return &u->r;
    case 2: return &u->u;
    case 3: return &u->kp;
    case 4: return &u->ki;
  }
  return 0;
}

static Unit* made(void* environment) {
  if (FAULT == crash_at_start) raise(SIGSEGV);
  if (FAULT == no_instance) return 0;
  Unit* u = (Unit*)calloc(1, sizeof(Unit));
  u->kp = 1;
  u->environment = environment;
  return u;
}

const char* FMI(GetVersion)(void) { return FAULT == other_version ? "1.0" : FMI_VERSION == 3 ? "3.0" : "2.0"; }
void FMI(FreeInstance)(Component c) { free(c); }
Status FMI(Terminate)(Component c) { (void)c; return FMI(OK); }
Status FMI(ExitInitializationMode)(Component c) {
  Unit* u = (Unit*)c;
  u->before = u->r - u->y;
  u->begun = 1;
  outputs(u);
  if (FAULT == error_in_initialisation) {
    tell(u, FMI(Error), "no oil");
    return FMI(Error);
  }
  return FMI(OK);
}
#if FMI_VERSION == 3
#define COUNT , size_t values
#define UNUSED_COUNT (void)values
#define STATE(verb) fmi3##verb##FMUState
Component fmi3InstantiateCoSimulation(fmi3String name, fmi3String token, fmi3String resources, fmi3Boolean visible,
                                      fmi3Boolean logging, fmi3Boolean events, fmi3Boolean early,
                                      const fmi3ValueReference required[], size_t count,
                                      fmi3InstanceEnvironment environment, fmi3LogMessageCallback log,
                                      fmi3IntermediateUpdateCallback update) {
  (void)name, (void)resources, (void)visible, (void)logging, (void)events, (void)early, (void)required, (void)count, (void)update;
  if (strcmp(token, "{unit}") != 0) return 0;
  Unit* u = made(environment);
  if (u) u->log = log;
  return u;
}
Status fmi3EnterInitializationMode(Component c, fmi3Boolean a, double b, double start, fmi3Boolean d, double e) {
  (void)a, (void)b, (void)d, (void)e;
  ((Unit*)c)->time = start;
  return FMI(OK);
}
Status fmi3GetInt32(Component c, const Reference r[], size_t k, fmi3Int32 v[], size_t n) { (void)r, (void)k, (void)n; v[0] = ((Unit*)c)->kind; return FMI(OK); }
Status fmi3SetInt32(Component c, const Reference r[], size_t k, const fmi3Int32 v[], size_t n) { (void)r, (void)k, (void)n; ((Unit*)c)->kind = v[0]; return FMI(OK); }
#define GET fmi3GetFloat64
#define SET fmi3SetFloat64
#else
#define COUNT
#define UNUSED_COUNT (void)0
#define STATE(verb) fmi2##verb##FMUstate
const char* fmi2GetTypesPlatform(void) { return "default"; }
Component fmi2Instantiate(fmi2String name, fmi2Type type, fmi2String guid, fmi2String resources,
                          const fmi2CallbackFunctions* functions, fmi2Boolean visible, fmi2Boolean logging) {
  (void)name, (void)type, (void)resources, (void)visible, (void)logging;
  if (strcmp(guid, "{unit}") != 0) return 0;
  Unit* u = made(functions->componentEnvironment);
  if (u) u->log = functions->logger;
  return u;
}
Status fmi2SetupExperiment(Component c, fmi2Boolean a, double b, double start, fmi2Boolean d, double e) {
  (void)a, (void)b, (void)d, (void)e;
  ((Unit*)c)->time = start;
  return FMI(OK);
}
Status fmi2EnterInitializationMode(Component c) { (void)c; return FMI(OK); }
Status fmi2SetInteger(Component c, const Reference r[], size_t k, const fmi2Integer v[]) { (void)r, (void)k; ((Unit*)c)->kind = v[0]; return FMI(OK); }
#define GET fmi2GetReal
#define SET fmi2SetReal
#endif
#ifndef WITHOUT_GET
Status GET(Component c, const Reference r[], size_t count, Real v[] COUNT) {
  UNUSED_COUNT;
  for (size_t k = 0; k < count; ++k) {
    Real* at = place((Unit*)c, r[k]);
    if (!at) return FMI(Error);
    v[k] = *at;
  }
  return FMI(OK);
}
#endif
Status SET(Component c, const Reference r[], size_t count, const Real v[] COUNT) {
  UNUSED_COUNT;
  for (size_t k = 0; k < count; ++k) {
    Real* at = place((Unit*)c, r[k]);
    if (!at) return FMI(Error);
    *at = v[k];
  }
  return FMI(OK);
}
#if FMI_VERSION == 3
Status fmi3DoStep(Component c, double time, double h, fmi3Boolean prior, fmi3Boolean* event, fmi3Boolean* terminate,
                  fmi3Boolean* early, double* last) {
  Unit* u = (Unit*)c;
  (void)prior;
  *event = *terminate = *early = 0;
  *last = time + h;
#else
Status fmi2DoStep(Component c, double time, double h, fmi2Boolean prior) {
  Unit* u = (Unit*)c;
  (void)prior;
#endif
  if (time - u->time > 1e-9 || u->time - time > 1e-9) {
    tell(u, FMI(Error), "the step does not begin where the last one ended");
    return FMI(Error);
  }
  return advance(u, h);
}
#if FMI_VERSION == 3
#define SIZE fmi3SerializedFMUStateSize
#define SERIALIZE fmi3SerializeFMUState
#define DESERIALIZE fmi3DeserializeFMUState
typedef fmi3Byte Byte;
#else
#define SIZE fmi2SerializedFMUstateSize
#define SERIALIZE fmi2SerializeFMUstate
#define DESERIALIZE fmi2DeSerializeFMUstate
typedef fmi2Byte Byte;
#endif
Status STATE(Get)(Component c, void** state) {
  *state = malloc(sizeof(Unit));
  memcpy(*state, c, sizeof(Unit));
  return FMI(OK);
}
Status STATE(Set)(Component c, void* state) {
  Unit *u = (Unit*)c, own = *u;
  if (FAULT == refuses_state) return FMI(Error);
  memcpy(u, state, sizeof(Unit));
  u->environment = own.environment;
  u->log = own.log;
  return FMI(OK);
}
Status STATE(Free)(Component c, void** state) {
  (void)c;
  free(*state);
  *state = 0;
  return FMI(OK);
}
Status SIZE(Component c, void* state, size_t* size) {
  (void)c, (void)state;
  *size = FAULT == large_state ? (size_t)-1 / 2 : sizeof(Unit);
  return FMI(OK);
}
Status SERIALIZE(Component c, void* state, Byte bytes[], size_t size) {
  (void)c;
  memcpy(bytes, state, size);
  return FMI(OK);
}
Status DESERIALIZE(Component c, const Byte bytes[], size_t size, void** state) {
  (void)c;
  if (size != sizeof(Unit)) return FMI(Error);
  *state = malloc(size);
  memcpy(*state, bytes, size);
  return FMI(OK);
}
