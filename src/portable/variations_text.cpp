#include "portable/texts.h"

/// How outputs of a step's code vary with inputs and the time, by hand in C99.
namespace mimbre::portable {

const char* const variations_at_rest_header_text =
    R"c(/* Directional derivatives: by how much outputs change, to first order, where inputs and the time change by the given
 * amounts and the motion does not. Inputs that are reached in a straight line do not act at once. */
void @_vary(@ *s, const double *inputs, double time, double *outputs);

)c";

const char* const variations_text = R"c(
void @_vary(@ *s, const double *inputs, double time, double *outputs) {
  int k;
  @_get_output(s, 0); /* evaluates the state of now */
  memset(s->d_u, 0, sizeof s->d_u);
#if @_INPUTS > 0
  for (k = 0; k < @_INPUTS; ++k)
    if (!@_held_inputs[k].linear) s->d_u[@_held_inputs[k].held] = inputs[k];
#else
  (void)inputs;
#endif
  s->d_now[0] = time;
#if @_BLOCKS
  if (@_rest_instant(s) == 0)
    @_d_signals_fresh(s);
  else
    @_d_signals_rest(s);
#else
  @_d_signals_step(s);
#endif
#if @_SENSES && @_BLOCKS
  if (@_rest_instant(s) == 0)
    @_d_sense_fresh(s);
  else
    @_d_sense_rest(s);
#elif @_SENSES
  @_d_sense_step(s);
#endif
  @_d_outputs(s);
  for (k = 0; k < @_OUTPUTS; ++k) outputs[k] = s->d_output[k];
}
)c";

}  // namespace mimbre::portable
