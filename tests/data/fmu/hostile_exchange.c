/* Calls the functions of an FMU for model exchange at random, with wrong arguments as often as right ones, and wants a
 * status of the standard each time. Compiled under the sanitizers with FMI (2 or 3), WRAPPER (its file), TOKEN and STATES. */
#include WRAPPER

#include <stdio.h>

static uint64_t seed = 88172645463325252u;
static uint64_t draw(void) {
  seed ^= seed << 13;
  seed ^= seed >> 7;
  seed ^= seed << 17;
  return seed;
}
static int one_of(int count) { return (int)(draw() % (uint64_t)count); }

static double number(void) {
  static const double odd[] = {0.0, -0.0, 1.0, -1.0, NAN, HUGE_VAL, -HUGE_VAL, 1e300, -1e300, 1e-300, DBL_MIN, 1e16, 0.1};
  const int k = one_of(26);
  return k < 13 ? odd[k] : (double)one_of(2000)/1000.0 - 1.0;
}

static unsigned reference(void) { return one_of(8) ? (unsigned)one_of(60) : (unsigned)draw(); }

static const void *maybe(const void *p) { return one_of(20) ? p : NULL; }

#if FMI == 2
#define F(name) fmi2##name
typedef fmi2Status status_of;
static void *make(void) {
  static fmi2CallbackFunctions calls;
  calls.logger = NULL;
  calls.allocateMemory = one_of(5) ? calloc : NULL;
  calls.freeMemory = calls.allocateMemory ? free : NULL;
  return fmi2Instantiate(one_of(9) ? "one" : NULL, one_of(9) ? fmi2ModelExchange : fmi2CoSimulation,
                         one_of(9) ? TOKEN : "other", NULL, one_of(20) ? &calls : NULL, 0, one_of(2));
}
#else
#define F(name) fmi3##name
typedef fmi3Status status_of;
static void *make(void) {
  return fmi3InstantiateModelExchange(one_of(9) ? "one" : NULL, one_of(9) ? TOKEN : NULL, NULL, false, one_of(2) != 0,
                                      NULL, NULL);
}
#endif

enum { most = 80 };

static int call(void *c, double *states, size_t wanted) {
  unsigned refs[most];
  double values[most];
  size_t count = (size_t)one_of(7), all = one_of(5) ? wanted : (size_t)one_of(most);
  int k;
  for (k = 0; k < most; ++k) {
    refs[k] = reference();
    values[k] = number();
  }
  switch (one_of(18)) {
    case 0:
      return F(ExitInitializationMode)(c);
    case 1:
      return one_of(10) ? 0 : F(Terminate)(c);
    case 2:
      return one_of(10) ? 0 : F(Reset)(c);
    case 3:
      return F(EnterEventMode)(c);
    case 4:
      return F(EnterContinuousTimeMode)(c);
    case 5:
      return F(SetTime)(c, number());
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
  long done = 0, round, good = 0;
  double states[most];
  for (round = 0; round < rounds/200; ++round) {
    void *const c = make();
    const size_t wanted = STATES;
    int k;
    if (c && one_of(4)) {
#if FMI == 2
      fmi2EnterInitializationMode(c);
#else
      fmi3EnterInitializationMode(c, false, 0.0, 0.0, false, 0.0);
#endif
      F(ExitInitializationMode)(c);
      if (one_of(3)) F(EnterContinuousTimeMode)(c);
    }
    for (k = 0; k < 200; ++k) {
      const int status = call(one_of(50) ? c : NULL, states, wanted);
      if (status < 0 || status > 3) return 1;
      if (status == 0) ++good;
      ++done;
    }
    F(FreeInstance)(c);
  }
  printf("%ld calls, %ld of them good\n", done, good);
  return 0;
}
