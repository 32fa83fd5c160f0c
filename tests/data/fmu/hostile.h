/* Shared by the programs that call the functions of an FMU at random: draws, wrong arguments, and how many
 * calls succeed. Compiled with FMI (2 or 3), WRAPPER (the file of the functions) and TOKEN. */
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

/* Half of them odd; `own`: one more of these. */
static double number(double own) {
  const double odd[] = {0.0,   -0.0,   1.0,    -1.0,    NAN,  HUGE_VAL, -HUGE_VAL,
                        1e300, -1e300, 1e-300, DBL_MIN, 1e16, 0.1,      own};
  const int k = one_of(28);
  return k < 14 ? odd[k] : (double)one_of(2000) / 1000.0 - 1.0;
}

static unsigned reference(int most) { return one_of(8) ? (unsigned)one_of(most) : (unsigned)draw(); }

static const void* maybe(const void* p) { return one_of(20) ? p : NULL; }

/* Messages have a category and a status that is not OK. */
#if FMI == 2
#define F(name) fmi2##name
typedef fmi2Byte byte;
static void told(void* e, const char* name, fmi2Status s, const char* category, const char* message, ...) {
#else
#define F(name) fmi3##name
typedef fmi3Byte byte;
static void told(void* e, fmi3Status s, const char* category, const char* message) {
  const char* name = "";
#endif
  (void)e;
  if (!name || !category || !message || (int)s < 1 || (int)s > 3) abort();
}

#if FMI == 2
/* With the allocators of the importer, or none; NULL: no callbacks at all. */
static const fmi2CallbackFunctions* callbacks(void) {
  static fmi2CallbackFunctions calls;
  calls.logger = one_of(5) ? told : NULL;
  calls.allocateMemory = one_of(5) ? calloc : NULL;
  calls.freeMemory = calls.allocateMemory ? free : NULL;
  return one_of(20) ? &calls : NULL;
}
#endif

static void initialize(void* c) {
#if FMI == 2
  fmi2EnterInitializationMode(c);
#else
  fmi3EnterInitializationMode(c, false, 0.0, 0.0, false, 0.0);
#endif
  F(ExitInitializationMode)(c);
}

/* What a draw returns that makes no call. */
enum { no_call = -1, functions = 32 };
static long calls_of[functions], good_of[functions];

/* Whether the status is one of the standard. */
static int counted(int function, int status) {
  if (status == no_call) return 1;
  ++calls_of[function];
  if (status == 0) ++good_of[function];
  return status >= 0 && status <= 3;
}

/* Which functions have never succeeded, and the share of calls that did. */
static void print_counts(void) {
  long all = 0, good = 0;
  int k;
  for (k = 0; k < functions; ++k) {
    all += calls_of[k];
    good += good_of[k];
    if (calls_of[k] > 0 && good_of[k] == 0) printf("function %d never succeeded\n", k);
  }
  printf("%ld calls, %ld %% of them good\n", all, all > 0 ? 100 * good / all : 0);
}
