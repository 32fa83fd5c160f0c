/* Calls the functions of an FMU for model exchange at random, with wrong arguments as often as right ones, and wants a
 * status of the standard each time. Compiled under the sanitizers; STATES: how many there are. */
#include "hostile.h"

static void *make(void) {
#if FMI == 2
  return fmi2Instantiate(one_of(9) ? "one" : NULL, one_of(9) ? fmi2ModelExchange : fmi2CoSimulation,
                         one_of(9) ? TOKEN : "other", NULL, callbacks(), 0, one_of(2));
#else
  return fmi3InstantiateModelExchange(one_of(9) ? "one" : NULL, one_of(9) ? TOKEN : NULL, NULL, false, one_of(2) != 0,
                                      NULL, one_of(5) ? told : NULL);
#endif
}

enum { most = 80 };

static int call(int function, void *c, double *states, size_t wanted) {
  unsigned refs[most];
  double values[most];
  size_t count = (size_t)one_of(7), all = one_of(5) ? wanted : (size_t)one_of(most);
  int k;
  for (k = 0; k < most; ++k) {
    refs[k] = reference(60);
    values[k] = number(0.01);
  }
  switch (function) {
    case 0:
      return F(ExitInitializationMode)(c);
    case 1:
      return one_of(10) ? no_call : F(Terminate)(c);
    case 2:
      return one_of(10) ? no_call : F(Reset)(c);
    case 3:
      return F(EnterEventMode)(c);
    case 4:
      return F(EnterContinuousTimeMode)(c);
    case 5:
      return F(SetTime)(c, number(0.01));
    case 6:
      return F(SetContinuousStates)(c, maybe(values), all);
    case 7: /* near the last ones */
      if (F(GetContinuousStates)(c, states, wanted) != 0) return 3;
      for (k = 0; k < (int)wanted; ++k) states[k] += 0.01*((double)one_of(200)/100.0 - 1.0);
      return F(SetContinuousStates)(c, states, wanted);
    case 8:
      return F(GetContinuousStates)(c, (double *)maybe(values), all);
    case 9:
      return F(GetNominalsOfContinuousStates)(c, (double *)maybe(values), all);
    case 10:
      return F(GetEventIndicators)(c, (double *)maybe(values), (size_t)one_of(4));
#if FMI == 2
    case 11:
      return fmi2GetDerivatives(c, (double *)maybe(values), all);
    case 12: {
      fmi2EventInfo info;
      return fmi2NewDiscreteStates(c, one_of(9) ? &info : NULL);
    }
    case 13: {
      fmi2Boolean a, b;
      return fmi2CompletedIntegratorStep(c, 1, one_of(9) ? &a : NULL, &b);
    }
    case 14:
      return fmi2SetReal(c, maybe(refs), count, maybe(values));
    case 15:
      return fmi2GetDirectionalDerivative(c, maybe(refs), count, maybe(refs + 10), 2, maybe(values), (double *)maybe(values + 20));
    case 16:
      return fmi2EnterInitializationMode(c);
    default:
      return fmi2GetReal(c, maybe(refs), count, (double *)maybe(values));
#else
    case 11:
      return fmi3GetContinuousStateDerivatives(c, (double *)maybe(values), all);
    case 12: {
      fmi3Boolean a, b, d, e, f;
      double next;
      return fmi3UpdateDiscreteStates(c, one_of(9) ? &a : NULL, &b, &d, &e, &f, &next);
    }
    case 13: {
      fmi3Boolean a, b;
      return fmi3CompletedIntegratorStep(c, true, one_of(9) ? &a : NULL, &b);
    }
    case 14:
      return fmi3SetFloat64(c, maybe(refs), count, maybe(values), one_of(5) ? count : 7);
    case 15:
      return fmi3GetDirectionalDerivative(c, maybe(refs), count, maybe(refs + 10), 2, maybe(values), one_of(5) ? 2 : 3,
                                          (double *)maybe(values + 20), count);
    case 16:
      return fmi3EnterInitializationMode(c, false, 0.0, 0.0, false, 0.0);
    default:
      return fmi3GetFloat64(c, maybe(refs), count, (double *)maybe(values), one_of(5) ? count : 3);
#endif
  }
}

int main(int count, char **words) {
  const long rounds = count > 1 ? atol(words[1]) : 1000;
  long round;
  double states[most];
  for (round = 0; round < rounds/200; ++round) {
    void *const c = make();
    int k;
    if (c && one_of(4)) {
      initialize(c);
      if (one_of(3)) F(EnterContinuousTimeMode)(c);
    }
    for (k = 0; k < 200; ++k) {
      const int function = one_of(18);
      if (!counted(function, call(function, one_of(50) ? c : NULL, states, STATES))) return 1;
    }
    F(FreeInstance)(c);
  }
  print_counts();
  return 0;
}
