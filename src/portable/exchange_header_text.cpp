#include "portable/texts.h"

/// The functions of code for model exchange, as its header declares them. '@' stands for the model's name.
namespace mimbre::portable {

const char* const exchange_header_text = R"c(
/* Functions that return an int return OK or another of the numbers above. After a call that fails, the state is as
 * before the call. Lengths are in m, angles in rad, times in s, masses in kg; arrays have the sizes above. */

/* The model where it starts: closed loops, the start values of inputs and parameters, the model's own start time. */
void @_init(@ *s);

/* Sets an input or a parameter, by its number above, from now on; a value outside its range is set to the range's end.
 * NO_SUCH: there is no such input, or the value is not finite. The first call of a function below starts the
 * controllers with the inputs of that instant; s->state.begun = 0 makes the next call start them again. */
int @_set_input(@ *s, int input, double value);

/* Sets the time, s. NO_SUCH: it is not finite. Functions of time stay before the next event until @_update is called. */
int @_set_time(@ *s, double time);

/* Set and get the continuous states, in the order above. NO_SUCH: one is not finite. The functions below report
 * whether the loops close at these states. */
int @_set_states(@ *s, const double *states);
int @_get_states(@ *s, double *states);

/* Nominal sizes of the states, in their units, for absolute tolerances. They change where @_update reports other states. */
int @_get_nominals(const @ *s, double *nominals);

/* The derivatives of the states by time, per s. NOT_CONVERGED, DRIFTED: the loops do not close at these states.
 * SINGULAR: the mechanism is singular there. NOT_FINITE: a force or a derivative is not finite. A solver may then try
 * a shorter step. */
int @_get_derivatives(@ *s, double *derivatives);

/* Computes the outputs into s->output, in the order and the units above. Returns as @_get_derivatives does. */
int @_get_outputs(@ *s);

/* Event indicators, without unit. They are positive; call @_update when one becomes negative. Returns likewise. */
int @_get_indicators(@ *s, double *indicators);

/* The instant of the next event in time, s: a jump or a kink of a function of time. HUGE_VAL: there is none. */
double @_get_next_event(const @ *s);

/* Passes the event at the time of now: functions of time go on behind it, and other coordinates are chosen where an
 * indicator is small. `changed`: 1 where the states and nominals are others now, and have to be read anew; else 0.
 * Returns likewise. */
int @_update(@ *s, int *changed);

double @_time(const @ *s); /* s */

/* Copy all that later calls depend on, also to another instance; these then have the same bits. */
void @_save(const @ *s, @_state *state);
void @_restore(@ *s, const @_state *state);
)c";

const char* const variations_header_text = R"c(
/* Directional derivatives: by how much derivatives, outputs and event indicators change, to first order, where states
 * and inputs change by the given amounts and the time does not. `indicators` may be NULL. Indicators are found by
 * differences, the others are exact. Returns as @_get_derivatives does. */
int @_vary(@ *s, const double *states, const double *inputs, double *derivatives, double *outputs,
           double *indicators);

/* Partial derivatives by time, per s, with states and inputs held, by differences. */
int @_vary_time(@ *s, double *derivatives, double *outputs, double *indicators);
)c";

}  // namespace mimbre::portable
