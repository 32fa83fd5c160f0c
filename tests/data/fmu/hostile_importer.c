/* Calls the functions of an FMU for co-simulation at random, with wrong arguments as often as right ones, and wants a status
 * of the standard each time. Compiled under the sanitizers; INSTANCE_STEP: the model's own, s. */
#include "hostile.h"

/* One of so many instances wants events. */
#ifndef INSTANCE_EVENTS
#define INSTANCE_EVENTS 9
#endif

static void *make(void) {
#if FMI == 2
  return fmi2Instantiate(one_of(9) ? "one" : NULL, one_of(9) ? fmi2CoSimulation : fmi2ModelExchange,
                         one_of(9) ? TOKEN : "other", NULL, callbacks(), 0, one_of(2));
#else
  return fmi3InstantiateCoSimulation(one_of(9) ? "one" : NULL, one_of(9) ? TOKEN : NULL, NULL, false, one_of(2) != 0,
                                     one_of(INSTANCE_EVENTS) == 0, one_of(2) != 0, NULL, one_of(9) == 0 ? 3 : 0, NULL,
                                     one_of(5) ? told : NULL, NULL);
#endif
}

enum { most = 6, handles = 4 };

static int call(int function, void *c, void **state, byte **bytes, size_t *size, double *now) {
  unsigned refs[most];
  double values[most];
  int wholes[most], k;
  const size_t count = (size_t)one_of(most + 1);
  void **const handle = state + one_of(handles);
  for (k = 0; k < most; ++k) {
    refs[k] = reference(16);
    values[k] = number(INSTANCE_STEP);
    wholes[k] = one_of(5);
  }
  switch (function) {
    case 0:
#if FMI == 2
      return fmi2SetupExperiment(c, one_of(2), number(INSTANCE_STEP), one_of(3) ? 0.0 : number(INSTANCE_STEP), one_of(4) == 0, number(INSTANCE_STEP));
    case 1:
      return fmi2EnterInitializationMode(c);
#else
    case 1:
      return fmi3EnterInitializationMode(c, one_of(5) == 0, number(INSTANCE_STEP), one_of(3) ? 0.0 : number(INSTANCE_STEP), one_of(4) == 0,
                                         number(INSTANCE_STEP));
#endif
    case 2:
      return F(ExitInitializationMode)(c);
    case 3:
      return one_of(10) ? no_call : F(Terminate)(c);
    case 4:
      return one_of(10) ? no_call : F(Reset)(c);
#if FMI == 2
    case 5:
      return fmi2GetReal(c, maybe(refs), count, (double *)maybe(values));
    case 6:
    case 7:
      return fmi2SetReal(c, maybe(refs), count, maybe(values));
    case 8:
      return fmi2GetInteger(c, maybe(refs), count, (int *)maybe(wholes));
    case 9:
      return fmi2SetInteger(c, maybe(refs), count, maybe(wholes));
    case 10:
      return fmi2GetString(c, refs, count, NULL);
    case 11:
      return fmi2GetFMUstate(c, one_of(9) ? handle : NULL);
    case 12:
      return fmi2SetFMUstate(c, one_of(9) ? *handle : (void *)refs);
    case 13:
      return fmi2FreeFMUstate(c, one_of(9) ? handle : NULL);
    case 14:
      return fmi2SetRealInputDerivatives(c, refs, count, wholes, values);
    case 15:
      return fmi2GetStatus(c, fmi2DoStepStatus, NULL);
#else
    case 5:
      return fmi3GetFloat64(c, maybe(refs), count, (double *)maybe(values), one_of(5) ? count : 3);
    case 6:
    case 7:
      return fmi3SetFloat64(c, maybe(refs), count, maybe(values), one_of(5) ? count : 7);
    case 8:
      return fmi3GetInt32(c, maybe(refs), count, (int *)maybe(wholes), one_of(5) ? count : 0);
    case 9:
      return fmi3SetInt32(c, maybe(refs), count, maybe(wholes), count);
    case 10:
      return fmi3GetString(c, refs, count, NULL, count);
    case 11:
      return fmi3GetFMUState(c, one_of(9) ? handle : NULL);
    case 12:
      return fmi3SetFMUState(c, one_of(9) ? *handle : (void *)refs);
    case 13:
      return fmi3FreeFMUState(c, one_of(9) ? handle : NULL);
    case 14:
      return one_of(2) ? fmi3EnterEventMode(c) : fmi3EnterStepMode(c);
    case 15: {
      fmi3Boolean a, b, d, e, g;
      double next;
      return fmi3UpdateDiscreteStates(c, one_of(9) ? &a : NULL, &b, &d, &e, one_of(9) ? &g : NULL, &next);
    }
#endif
    case 16: {
      const char *names[2] = {one_of(2) ? "logStatusWarning" : "nothing", one_of(9) ? "logAll" : NULL};
      return F(SetDebugLogging)(c, one_of(2), count % 3, one_of(9) ? names : NULL);
    }
    case 17: {
      size_t wanted = 0;
      int status;
#if FMI == 2
      status = fmi2SerializedFMUstateSize(c, *handle, &wanted);
#else
      status = fmi3SerializedFMUStateSize(c, *handle, &wanted);
#endif
      if (status != 0) return status;
      free(*bytes);
      *size = one_of(4) ? wanted : wanted/2;
      *bytes = (byte *)calloc(1, *size);
#if FMI == 2
      return fmi2SerializeFMUstate(c, *handle, *bytes, *size);
#else
      return fmi3SerializeFMUState(c, *handle, *bytes, *size);
#endif
    }
    case 18:
      if (*size > 0 && one_of(2)) (*bytes)[draw() % *size] ^= (byte)(1 << one_of(7));
#if FMI == 2
      return fmi2DeSerializeFMUstate(c, *bytes, *size - (size_t)(*size > 0 && one_of(9) == 0), handle);
#else
      return fmi3DeserializeFMUState(c, *bytes, *size - (size_t)(*size > 0 && one_of(9) == 0), handle);
#endif
    case 19: {
      unsigned knowns[2];
      double results[most];
      knowns[0] = reference(5);
      knowns[1] = reference(5);
#if FMI == 2
      return fmi2GetDirectionalDerivative(c, maybe(refs), count, maybe(knowns), 2, maybe(values), (double *)maybe(results));
#else
      return fmi3GetDirectionalDerivative(c, maybe(refs), count, maybe(knowns), 2, maybe(values), one_of(5) ? 2 : 3, (double *)maybe(results), one_of(5) ? count : 4);
#endif
    }
    default: {
      const double from = one_of(9) ? *now : number(INSTANCE_STEP);
      const double length = one_of(4) ? INSTANCE_STEP*(double)one_of(400)/100.0 : number(INSTANCE_STEP);
      int status;
#if FMI == 2
      status = fmi2DoStep(c, from, length, one_of(2));
      fmi2GetRealStatus(c, fmi2LastSuccessfulTime, now);
#else
      fmi3Boolean a, b, d;
      double last = *now;
      status = fmi3DoStep(c, from, length, false, one_of(9) ? &a : NULL, &b, &d, &last);
      *now = last;
#endif
      return status;
    }
  }
}

int main(int count, char **words) {
  const long rounds = count > 1 ? atol(words[1]) : 1000;
  long round;
  for (round = 0; round < rounds/200; ++round) {
    void *const c = make();
    void *state[handles] = {NULL, NULL, NULL, NULL};
    byte *bytes = NULL;
    size_t size = 0;
    double now = 0.0;
    int k;
    if (c && one_of(3)) initialize(c);
    for (k = 0; k < 200; ++k) {
      const int function = one_of(23);
      if (!counted(function, call(function, one_of(50) ? c : NULL, state, &bytes, &size, &now))) return 1;
    }
    free(bytes);
    F(FreeInstance)(c);
  }
  print_counts();
  return 0;
}
