#include "portable/texts.h"

/// The equations of motion as ordinary differential equations, written by hand in C99. '@' stands for the
/// model's name; constants, tables and the phases of a recorded instant come before it.
///
/// Of the N coordinates z, R depend on the other F = N − R by chosen equations Φ = 0 (coordinate
/// partitioning: Wehage, Haug 1982; second velocity transformation: Serna, Avilés, García de Jalón 1982):
///
///     Φ(z) = 0 by Newton's method,   ż = N żi + c with Φz N = 0,   z̈ = N z̈i + d with Φz d = −γ,
///     Nᵀ M N z̈i = −Nᵀ (M d − Q)
///
/// Positions are increments x from a reference (retract); rotations are rotation vectors, ẋ = dexp⁻¹(x) ω.
/// The Jacobian by x is Φz dexp(x).
namespace mimbre::portable {

const char* const exchange_text = R"c(
/* Largest change, in units of the scales, of independent coordinates in one part, and of a correction by Newton's method. */
#define @_FURTHEST 0.3
/* Other coordinates are chosen once the quality has fallen to this share of that at the last choice. */
#define @_WORSE 0.3
/* rad^2: an independent rotation vector whose square is larger gets a new reference. */
#define @_TURNED 4.0

/* Signals of time and inputs, and signals of the motion; blocks show their start values until they have begun. */
static void @_signals(@ *s, double time) {
  s->now[0] = time;
#if @_BLOCKS
  if (!s->state.begun)
    @_signals_fresh(s);
  else
    @_signals_rest(s);
#else
  @_signals_step(s);
#endif
}
static void @_see(@ *s) {
#if @_SENSES && @_BLOCKS
  if (!s->state.begun)
    @_sense_fresh(s);
  else
    @_sense_rest(s);
#elif @_SENSES
  @_sense_step(s);
#else
  (void)s;
#endif
}

/* Bound of the round-off of an event's instant and of its place in a period. */
static double @_about(double event) { return event - event == 0.0 ? 1e-14*(1.0 + fabs(event)) : 0.0; }

/* The time for functions of time: kept between the last event and the next one, which has not been passed yet. */
static double @_side(const @_state *state, double time) {
  const double after = state->last_event + @_about(state->last_event);
  const double before = state->next_event - @_about(state->next_event);
  return time < after ? after : time < before ? time : before;
}

/* Events up to this instant count as one with an event at the time. */
static double @_until(double time) { return time + 1e-9*(1.0 + fabs(time)); }

/* The last instant up to `until` at which a function of time jumps or has a kink, and the first one later. */
static double @_last_event(double until) {
  double last = -HUGE_VAL;
  int k;
  for (k = 0; k < @_EVENTS; ++k) {
    const @_event *const e = @_events + k;
    double at = e->time;
    if (e->period > 0.0) at += floor((until - e->time)/e->period)*e->period;
    if (at > until) at -= e->period;
    if (at <= until && at > last) last = at;
  }
  return last;
}
static double @_next_event(double until) {
  double next = HUGE_VAL;
  int k;
  for (k = 0; k < @_EVENTS; ++k) {
    const @_event *const e = @_events + k;
    double at = e->time;
    if (e->period > 0.0) at += (floor((until - e->time)/e->period) + 1.0)*e->period;
    if (!(at > until)) at += e->period;
    if (at > until && at < next) next = at;
  }
  return next;
}

/* Enters the continuous states at a share of the way from those of the last solution to those that are set. */
static void @_place(@ *s, double share) {
  const double whole = share < 1.0 ? share : 1.0;
  int k;
  double time = s->state.time;
  if (whole < 1.0) time = s->state.at_time + whole*(time - s->state.at_time);
  time = @_side(&s->state, time);
  for (k = 0; k < @_F; ++k) {
    const int j = s->state.independent[k], p = @_position_of[j];
    double y = s->state.c[k];
    if (whole < 1.0) y = s->state.at[k] + whole*(y - s->state.at[k]);
    s->x[j] = p < 0 ? y : y - s->state.q[p];
  }
  for (k = 0; k < @_W; ++k) {
    double w = s->state.c[2*@_F + k];
    if (whole < 1.0) w = s->state.at[2*@_F + k] + whole*(w - s->state.at[2*@_F + k]);
    if (@_remembered[k].held)
      s->state.u[@_remembered[k].at] = w;
    else
      s->state.z[@_remembered[k].at] = w;
    if (@_remembered[k].integral) s->state.u[@_remembered[k].at + 1] = time;
  }
  @_signals(s, time);
}

static void @_geometry(@ *s) {
  int k;
  @_retract(s);
  memcpy(s->q, s->moved, sizeof s->q);
  @_motion(s);
  @_jacobian(s);
  memset(s->dense, 0, sizeof s->dense);
  for (k = 0; k < @_J; ++k) s->dense[@_j_row[k]*@_N + @_j_column[k]] += s->jacobian[k];
}

#if @_R > 0 || @_VARIES
/* Of dexp(x) v = v - a x cross v + b x cross (x cross v). */
static void @_turn_series(const double *x, double *a, double *b) {
  const double y = x[0]*x[0] + x[1]*x[1] + x[2]*x[2], r = sqrt(y);
  *a = y < 1e-4 ? 0.5 - y*(1.0/24.0 - y/720.0) : (1.0 - cos(r))/y;
  *b = y < 1e-4 ? 1.0/6.0 - y*(1.0/120.0 - y/5040.0) : (r - sin(r))/(y*r);
}
#endif

#if @_R > 0
/* A row of the Jacobian by x: g dexp(x) = g − A g × x + B (g × x) × x of rotations. */
static void @_turn_row(const @ *s, double *row) {
  int k;
  for (k = 0; k < @_ROTATIONS; ++k) {
    const double *const x = s->x + @_rotation[k];
    double *const g = row + @_rotation[k];
    double a, b;
    const double h0 = g[1]*x[2] - g[2]*x[1], h1 = g[2]*x[0] - g[0]*x[2], h2 = g[0]*x[1] - g[1]*x[0];
    @_turn_series(x, &a, &b);
    g[0] += b*(h1*x[2] - h2*x[1]) - a*h0;
    g[1] += b*(h2*x[0] - h0*x[2]) - a*h1;
    g[2] += b*(h0*x[1] - h1*x[0]) - a*h2;
  }
}

/* L U factors of the chosen rows and the dependent columns, scaled; of the Jacobian by x if `turned`. Returns whether
 * the matrix is regular. */
static int @_factor(@ *s, int turned) {
  int i, j, k, p;
  for (p = 0; p < @_R; ++p) {
    double *const row = s->rows_of + p*@_N;
    memcpy(row, s->dense + s->state.row[p]*@_N, @_N*sizeof *row);
    if (turned) @_turn_row(s, row);
    for (j = 0; j < @_R; ++j) {
      const int c = s->state.dependent[j];
      s->lu[p*@_R + j] = row[c]*@_coordinate_scale[c]/@_equation_scale[s->state.row[p]];
    }
  }
  for (k = 0; k < @_R; ++k) {
    double most = 0.0;
    p = k;
    for (i = k; i < @_R; ++i)
      if (fabs(s->lu[i*@_R + k]) > most) {
        most = fabs(s->lu[i*@_R + k]);
        p = i;
      }
    if (!(most > 1e-14)) return 0;
    s->pivot[k] = p;
    if (p != k)
      for (j = 0; j < @_R; ++j) {
        const double kept = s->lu[k*@_R + j];
        s->lu[k*@_R + j] = s->lu[p*@_R + j];
        s->lu[p*@_R + j] = kept;
      }
    for (i = k + 1; i < @_R; ++i) {
      const double factor = s->lu[i*@_R + k]/s->lu[k*@_R + k];
      s->lu[i*@_R + k] = factor;
      if (factor != 0.0)
        for (j = k + 1; j < @_R; ++j) s->lu[i*@_R + j] -= factor*s->lu[k*@_R + j];
    }
  }
  return 1;
}

/* Solves for the dependent coordinates; b has the right side by chosen rows, then the solution. */
static void @_solve(const @ *s, double *b) {
  int i, k;
  for (k = 0; k < @_R; ++k) b[k] /= @_equation_scale[s->state.row[k]];
  for (k = 0; k < @_R; ++k) {
    const double kept = b[s->pivot[k]];
    b[s->pivot[k]] = b[k];
    b[k] = kept;
  }
  for (k = 0; k < @_R; ++k)
    for (i = 0; i < k; ++i) b[k] -= s->lu[k*@_R + i]*b[i];
  for (k = @_R; k-- > 0;) {
    for (i = k + 1; i < @_R; ++i) b[k] -= s->lu[k*@_R + i]*b[i];
    b[k] /= s->lu[k*@_R + k];
  }
  for (k = 0; k < @_R; ++k) b[k] *= @_coordinate_scale[s->state.dependent[k]];
}

/* The same with the transposed matrix: g by dependent coordinates, then by chosen rows. */
static void @_solve_transposed(const @ *s, double *g) {
  int i, k;
  for (k = 0; k < @_R; ++k) g[k] *= @_coordinate_scale[s->state.dependent[k]];
  for (k = 0; k < @_R; ++k) {
    for (i = 0; i < k; ++i) g[k] -= s->lu[i*@_R + k]*g[i];
    g[k] /= s->lu[k*@_R + k];
  }
  for (k = @_R; k-- > 0;)
    for (i = k + 1; i < @_R; ++i) g[k] -= s->lu[i*@_R + k]*g[i];
  for (k = @_R; k-- > 0;) {
    const double kept = g[k];
    g[k] = g[s->pivot[k]];
    g[s->pivot[k]] = kept;
  }
  for (k = 0; k < @_R; ++k) g[k] /= @_equation_scale[s->state.row[k]];
}

/* Newton's method for the dependent coordinates, from their present values. */
static int @_close(@ *s) {
  double before = HUGE_VAL;
  int k, round;
  for (round = 0; round < 12; ++round) {
    double size = 0.0;
    @_geometry(s);
    if (!@_all_finite(s->phi, @_M)) return @_NOT_FINITE;
    if (!@_factor(s, @_ROTATIONS > 0)) return @_SINGULAR;
    for (k = 0; k < @_R; ++k) s->b[k] = -s->phi[s->state.row[k]];
    @_solve(s, s->b);
    for (k = 0; k < @_R; ++k) {
      const double x = fabs(s->b[k])/@_coordinate_scale[s->state.dependent[k]];
      if (!(x <= @_FURTHEST)) return @_NOT_CONVERGED;
      if (x > size) size = x;
    }
    if (size <= 1e-14 || (size <= 1e-10 && size > 0.25*before)) {
      for (k = 0; k < @_M; ++k)
        if (!(fabs(s->phi[k]) <= 1e-6*@_equation_scale[k])) return @_DRIFTED;
      return @_OK;
    }
    before = size;
    for (k = 0; k < @_R; ++k) s->x[s->state.dependent[k]] += s->b[k];
  }
  return @_NOT_CONVERGED;
}

/* The positions at the continuous states, in parts if these are far from those of the last solution. */
static int @_find_positions(@ *s) {
  double done = 0.0, part, most, way = 0.0;
  int k, tries;
  memcpy(s->x, s->state.x, sizeof s->x);
  memcpy(s->good_x, s->state.x, sizeof s->good_x);
  if (s->state.closed && s->state.time == s->state.at_time && memcmp(s->state.c, s->state.at, sizeof s->state.c) == 0) {
    @_place(s, 1.0);
    @_geometry(s);
    return @_factor(s, 0) ? @_OK : @_SINGULAR;
  }
  for (k = 0; k < @_F; ++k) {
    const double by = fabs(s->state.c[k] - s->state.at[k])/@_coordinate_scale[s->state.independent[k]];
    if (!(by - by == 0.0)) return @_NOT_FINITE;
    if (by > way) way = by;
  }
  most = way > @_FURTHEST ? @_FURTHEST/way : 1.0;
  if (most < 1e-4) return @_NOT_CONVERGED; /* thousands of turns away */
  part = most;
  for (tries = 0; tries < 20000; ++tries) {
    const double share = done + part < 1.0 ? done + part : 1.0;
    int status;
    memcpy(s->x, s->good_x, sizeof s->x);
    @_place(s, share);
    status = @_close(s);
    if (status == @_OK) {
      if (share >= 1.0) return @_OK;
      memcpy(s->good_x, s->x, sizeof s->good_x);
      done = share;
      part = 2.0*part < most ? 2.0*part : most;
    } else {
      part *= 0.5;
      if (part < most/1024.0) return status;
    }
  }
  return @_NOT_CONVERGED;
}
#else
static int @_find_positions(@ *s) {
  memcpy(s->x, s->state.x, sizeof s->x);
  @_place(s, 1.0);
  @_geometry(s);
  return @_all_finite(s->q, @_Q) ? @_OK : @_NOT_FINITE;
}
#endif

/* The motions N that the equations leave free, and the quality of the independent coordinates: near 0 where dependent
 * coordinates move much faster than these. */
static void @_find_motions(@ *s) {
  double sum = 0.0;
  int c;
#if @_R > 0
  int k, p;
#endif
  memset(s->motions, 0, sizeof s->motions);
  for (c = 0; c < @_F; ++c) {
    const int j = s->state.independent[c];
    s->motions[j*@_F + c] = 1.0;
#if @_R > 0
    for (p = 0; p < @_R; ++p) s->b[p] = -s->rows_of[p*@_N + j];
    @_solve(s, s->b);
    for (k = 0; k < @_R; ++k) {
      const int i = s->state.dependent[k];
      const double scaled = s->b[k]*@_weight[j]/@_weight[i];
      s->motions[i*@_F + c] = s->b[k];
      sum += scaled*scaled;
    }
#endif
  }
  s->quality = 1.0/sqrt(1.0 + sum/(@_F > 0 ? @_F : 1));
}

/* Divides by the projected mass, whose factors are L D L^T. */
static void @_divide(const @ *s, double *x) {
  int c, j;
  for (c = 0; c < @_F; ++c)
    for (j = 0; j < c; ++j) x[c] -= s->projected[c*@_F + j]*x[j];
  for (c = 0; c < @_F; ++c) x[c] /= s->projected[c*@_F + c];
  for (c = @_F; c-- > 0;)
    for (j = c + 1; j < @_F; ++j) x[c] -= s->projected[j*@_F + c]*x[j];
}

/* The factors of the projected mass, and the accelerations of the independent coordinates. */
static int @_accelerate(@ *s) {
  int c, i, j, k;
  memset(s->momentum, 0, sizeof s->momentum);
  for (k = 0; k < @_MASS; ++k) {
    const int row = @_mass_row[k], column = @_mass_column[k];
    const double m = s->mass[k];
    for (c = 0; c < @_F; ++c) s->momentum[row*@_F + c] += m*s->motions[column*@_F + c];
    if (row != column)
      for (c = 0; c < @_F; ++c) s->momentum[column*@_F + c] += m*s->motions[row*@_F + c];
  }
  memset(s->projected, 0, sizeof s->projected);
  for (c = 0; c < @_F; ++c) s->acceleration[c] = 0.0;
  for (i = 0; i < @_N; ++i)
    for (c = 0; c < @_F; ++c) {
      const double n = s->motions[i*@_F + c];
      if (n == 0.0) continue;
      s->acceleration[c] -= n*s->r[i];
      for (j = 0; j <= c; ++j) s->projected[c*@_F + j] += n*s->momentum[i*@_F + j];
    }
  for (c = 0; c < @_F; ++c) {
    const double least = 1e-14*s->projected[c*@_F + c];
    double d = s->projected[c*@_F + c];
    for (j = 0; j < c; ++j) {
      double l = s->projected[c*@_F + j];
      for (k = 0; k < j; ++k) l -= s->projected[c*@_F + k]*s->projected[j*@_F + k]*s->projected[k*@_F + k];
      l /= s->projected[j*@_F + j];
      s->projected[c*@_F + j] = l;
      d -= l*l*s->projected[j*@_F + j];
    }
    if (!(d > least)) return @_SINGULAR;
    s->projected[c*@_F + c] = d;
  }
  @_divide(s, s->acceleration);
  return @_OK;
}

/* Gives dependent rotations of more than 1 rad a new reference. */
static void @_renew_references(@ *s) {
  int k, c;
  for (k = 0; k < @_ROTATIONS; ++k) {
    double *const x = s->x + @_rotation[k];
    int chosen = 0;
    for (c = 0; c < @_F; ++c)
      chosen = chosen || (s->state.independent[c] >= @_rotation[k] && s->state.independent[c] < @_rotation[k] + 3);
    if (chosen || !(x[0]*x[0] + x[1]*x[1] + x[2]*x[2] > 1.0)) continue;
    memcpy(s->state.q + @_quaternion[k], s->q + @_quaternion[k], 4*sizeof *s->q);
    x[0] = x[1] = x[2] = 0.0;
  }
}

/* Finds the motion and the derivatives of the continuous states, unless they are known already. */
static int @_find_motion(@ *s) {
  int c, i, k, status;
  if (s->ready) return s->status;
  s->ready = 1;
  s->shown = 0;
  for (k = 0; k < @_N; ++k) s->v[k] = s->a[k] = 0.0;
  for (k = 0; k < @_M; ++k) s->multipliers[k] = 0.0;
  @_origin(s);
  s->status = @_find_positions(s);
  if (s->status != @_OK) return s->status;
  for (k = 0; k < @_F; ++k) s->v[s->state.independent[k]] = s->state.c[@_F + k];
#if @_R > 0
  @_motion(s);
  if (@_ROTATIONS > 0 && !@_factor(s, 0)) return s->status = @_SINGULAR;
  for (k = 0; k < @_R; ++k) s->b[k] = -s->phi_dot[s->state.row[k]];
  @_solve(s, s->b);
  for (k = 0; k < @_R; ++k) s->v[s->state.dependent[k]] = s->b[k];
#endif
  @_find_motions(s);
#if @_R > 0
  @_motion(s);
  for (k = 0; k < @_R; ++k) s->b[k] = -s->phi_ddot[s->state.row[k]];
  @_solve(s, s->b);
  for (k = 0; k < @_R; ++k) s->a[s->state.dependent[k]] = s->b[k];
#endif
  @_motion(s);
  @_see(s);
  @_forces(s);
  @_inertia(s);
  status = @_accelerate(s);
  if (status != @_OK) return s->status = status;
  for (i = 0; i < @_N; ++i)
    for (c = 0; c < @_F; ++c) {
      s->a[i] += s->motions[i*@_F + c]*s->acceleration[c];
      s->r[i] += s->momentum[i*@_F + c]*s->acceleration[c];
    }
#if @_R > 0
  for (k = 0; k < @_R; ++k) s->b[k] = -s->r[s->state.dependent[k]];
  @_solve_transposed(s, s->b);
  for (k = 0; k < @_R; ++k) s->multipliers[s->state.row[k]] = s->b[k];
#endif
  @_increment_rate(s);
  @_rates(s);
  for (k = 0; k < @_F; ++k) {
    s->derivative[k] = s->x_rate[s->state.independent[k]];
    s->derivative[@_F + k] = s->acceleration[k];
  }
  for (k = 0; k < @_W; ++k) s->derivative[2*@_F + k] = s->w_rate[k];
  if (!@_all_finite(s->derivative, @_C)) return s->status = @_NOT_FINITE;
  @_keep_turns(s);
  for (k = 0; k < @_TURNS; ++k) s->state.z[@_turn[k]] = s->next_z[@_turn[k]];
  @_renew_references(s);
  memcpy(s->state.x, s->x, sizeof s->x);
  memcpy(s->state.at, s->state.c, sizeof s->state.c);
  s->state.at_time = s->state.time;
  s->state.closed = 1;
  return @_OK;
}

/* Sets the continuous states from the positions q and velocities v, which become the reference. */
static void @_take(@ *s) {
  int k;
  memcpy(s->state.q, s->q, sizeof s->q);
  for (k = 0; k < @_N; ++k) s->x[k] = s->state.x[k] = 0.0;
  for (k = 0; k < @_F; ++k) {
    const int j = s->state.independent[k], p = @_position_of[j];
    s->state.c[k] = p < 0 ? 0.0 : s->q[p];
    s->state.c[@_F + k] = s->v[j];
  }
  for (k = 0; k < @_W; ++k)
    s->state.c[2*@_F + k] = @_remembered[k].held ? s->state.u[@_remembered[k].at] : s->state.z[@_remembered[k].at];
  memcpy(s->state.at, s->state.c, sizeof s->state.c);
  s->state.at_time = s->state.time;
  s->state.closed = 0;
  s->ready = 0;
}

/* Chooses the dependent coordinates, and the equations for them, by complete pivoting at the last positions. Returns
 * whether the rank is that of the start. */
static int @_choose(@ *s) {
  double first = 0.0;
  int c, i, j, p, count = 0;
  for (i = 0; i < @_M; ++i)
    for (j = 0; j < @_N; ++j) s->dense[i*@_N + j] *= @_weight[j]/@_equation_scale[i];
  for (i = 0; i < @_M; ++i) s->used_row[i] = 0;
  for (j = 0; j < @_N; ++j) s->used_column[j] = 0;
  for (p = 0; p < @_R; ++p) {
    double most = 0.0;
    int row = -1, column = -1;
    for (i = 0; i < @_M; ++i)
      for (j = 0; j < @_N && !s->used_row[i]; ++j)
        if (!s->used_column[j] && fabs(s->dense[i*@_N + j]) > most) {
          most = fabs(s->dense[i*@_N + j]);
          row = i;
          column = j;
        }
    if (p == 0) first = most;
    if (!(most > 1e-9*first)) return 0;
    s->used_row[row] = s->used_column[column] = 1;
    s->state.row[p] = row;
    s->state.dependent[p] = column;
    for (i = 0; i < @_M; ++i) {
      const double factor = s->dense[i*@_N + column]/s->dense[row*@_N + column];
      if (s->used_row[i] || factor == 0.0) continue;
      for (j = 0; j < @_N; ++j)
        if (!s->used_column[j]) s->dense[i*@_N + j] -= factor*s->dense[row*@_N + j];
    }
  }
  for (c = 0; c < @_N; ++c)
    if (!s->used_column[c] && count < @_F) s->state.independent[count++] = c;
  return 1;
}

/* The quality just after a choice, with which later ones are compared. */
static int @_settle(@ *s) {
  const int status = @_find_motion(s);
  if (status == @_OK) s->state.quality = s->quality;
  return status;
}

/* Starts the blocks with the present inputs. */
static int @_begin(@ *s) {
  int k, status = @_OK;
  if (s->state.begun) return @_OK;
  s->state.last_event = -HUGE_VAL;
  s->state.next_event = @_next_event(@_until(s->state.time));
  s->ready = 0;
#if @_BLOCKS
  status = @_settle(s);
  if (status != @_OK) return status;
  @_motion(s);
  @_see(s);
  @_keep_blocks_fresh(s);
  memcpy(s->state.u, s->next_u, sizeof s->next_u);
  for (k = 0; k < @_W; ++k)
    if (@_remembered[k].held) s->state.c[2*@_F + k] = s->state.u[@_remembered[k].at];
  s->ready = 0;
#else
  (void)k;
#endif
  s->state.begun = 1;
  status = @_settle(s);
  if (status != @_OK) s->state.begun = 0;
  return status;
}

void @_init(@ *s) {
  memset(s, 0, sizeof *s);
  s->state.time = @_START_TIME;
  s->state.last_event = -HUGE_VAL;
  s->state.next_event = HUGE_VAL;
  memcpy(s->state.q, @_start_q, sizeof @_start_q);
  memcpy(s->state.z, @_start_z, sizeof @_start_z);
  memcpy(s->state.u, @_start_u, sizeof @_start_u);
  memcpy(s->v, @_start_v, sizeof @_start_v);
  @_origin(s);
  @_signals(s, s->state.time);
  @_geometry(s);
  s->state.lost = !@_choose(s);
  @_take(s);
}

int @_set_input(@ *s, int input, double value) {
#if @_INPUTS > 0
  const @_held_input *h;
  double *u;
  if (input < 0 || input >= @_INPUTS || !(value - value == 0.0)) return @_NO_SUCH;
  h = @_held_inputs + input;
  value = value < h->least ? h->least : value > h->most ? h->most : value;
  u = s->state.u + h->held;
  u[0] = value;
  if (h->linear) u[2] = value;
  s->ready = 0;
  return @_OK;
#else
  (void)s;
  (void)input;
  (void)value;
  return @_NO_SUCH;
#endif
}

int @_set_time(@ *s, double time) {
  if (!(time - time == 0.0)) return @_NO_SUCH;
  if (time != s->state.time) s->ready = 0;
  s->state.time = time;
  return @_OK;
}

int @_set_states(@ *s, const double *states) {
  if (!@_all_finite(states, @_C)) return @_NO_SUCH;
  if (memcmp(states, s->state.c, @_C*sizeof *states) != 0) s->ready = 0;
  memcpy(s->state.c, states, @_C*sizeof *states);
  return @_OK;
}

static int @_now(@ *s) {
  const int status = s->state.lost ? @_SINGULAR : @_begin(s);
  return status == @_OK ? @_find_motion(s) : status;
}

int @_get_states(@ *s, double *states) {
  const int status = s->state.lost ? @_SINGULAR : @_begin(s);
  if (status != @_OK) return status;
  memcpy(states, s->state.c, @_C*sizeof *states);
  return @_OK;
}

int @_get_nominals(const @ *s, double *nominals) {
  int k;
  for (k = 0; k < @_F; ++k) {
    nominals[k] = @_coordinate_scale[s->state.independent[k]];
    nominals[@_F + k] = @_PACE*nominals[k];
  }
  for (k = 2*@_F; k < @_C; ++k) nominals[k] = 1.0;
  return @_OK;
}

int @_get_derivatives(@ *s, double *derivatives) {
  const int status = @_now(s);
  if (status != @_OK) return status;
  memcpy(derivatives, s->derivative, @_C*sizeof *derivatives);
  return @_OK;
}

int @_get_indicators(@ *s, double *indicators) {
  const int status = @_now(s);
  int k, c, count = 0;
  if (status != @_OK) return status;
  if (@_R > 0 && @_F > 0) indicators[count++] = s->quality/s->state.quality - @_WORSE;
  for (k = 0; k < @_ROTATIONS; ++k) {
    const double *const x = s->state.x + @_rotation[k];
    double left = 1.0;
    for (c = 0; c < @_F; ++c)
      if (s->state.independent[c] >= @_rotation[k] && s->state.independent[c] < @_rotation[k] + 3)
        left = 1.0 - (x[0]*x[0] + x[1]*x[1] + x[2]*x[2])/@_TURNED;
    indicators[count++] = left;
  }
  return @_OK;
}

int @_get_outputs(@ *s) {
  const int status = @_now(s);
  if (status != @_OK || s->shown) return status;
  memcpy(s->x, s->state.x, sizeof s->x);
  @_motion(s);
  @_see(s);
  @_forces(s);
  @_outputs(s);
  s->shown = 1;
  return @_OK;
}

static int @_pass_event(@ *s, int *changed) {
  const double until = @_until(s->state.time);
  double indicators[@_INDICATORS + 1];
  int k, renew = 0, status = @_now(s);
  if (status != @_OK) return status;
  if (s->state.next_event <= until) {
    const double last = @_last_event(until);
    s->state.last_event = last > s->state.next_event ? last : s->state.next_event;
    s->state.next_event = @_next_event(until);
    s->ready = 0;
    status = @_now(s);
    if (status != @_OK) return status;
  }
  status = @_get_indicators(s, indicators);
  if (status != @_OK) return status;
  for (k = 0; k < @_INDICATORS; ++k) renew = renew || indicators[k] <= 0.05;
  if (!renew) return @_OK;
  if (!@_choose(s)) return @_SINGULAR;
  @_take(s);
  *changed = 1;
  return @_settle(s);
}

int @_update(@ *s, int *changed) {
  const @_state kept = s->state;
  int status;
  *changed = 0;
  status = @_pass_event(s, changed);
  if (status == @_OK) return status;
  @_restore(s, &kept);
  *changed = 0;
  return status;
}

#if @_VARIES
static void @_vary_seen(@ *s) {
#if @_SENSES && @_BLOCKS
  @_d_sense_rest(s);
#elif @_SENSES
  @_d_sense_step(s);
#endif
  @_d_forces(s);
}

/* From d_x, of the increments from the reference, to d_q. */
static void @_vary_positions(@ *s) {
  int k;
  for (k = 0; k < @_N; ++k)
    if (@_position_of[k] >= 0) s->d_q[@_position_of[k]] = s->d_x[k];
  for (k = 0; k < @_ROTATIONS; ++k) {
    const double *const x = s->x + @_rotation[k], *const q = s->q + @_quaternion[k], *const d = s->d_x + @_rotation[k];
    double *const out = s->d_q + @_quaternion[k];
    double t[3], a, b;
    const double c0 = x[1]*d[2] - x[2]*d[1], c1 = x[2]*d[0] - x[0]*d[2], c2 = x[0]*d[1] - x[1]*d[0];
    @_turn_series(x, &a, &b);
    t[0] = d[0] - a*c0 + b*(x[1]*c2 - x[2]*c1);
    t[1] = d[1] - a*c1 + b*(x[2]*c0 - x[0]*c2);
    t[2] = d[2] - a*c2 + b*(x[0]*c1 - x[1]*c0);
    out[0] = -0.5*(q[1]*t[0] + q[2]*t[1] + q[3]*t[2]);
    out[1] = 0.5*(q[0]*t[0] + q[2]*t[2] - q[3]*t[1]);
    out[2] = 0.5*(q[0]*t[1] + q[3]*t[0] - q[1]*t[2]);
    out[3] = 0.5*(q[0]*t[2] + q[1]*t[1] - q[2]*t[0]);
  }
}

/* Event indicators by differences, since they are not recorded. */
static int @_vary_indicators(@ *s, const double *states, double *indicators) {
  const @_state kept = s->state;
  double size = 0.0, other[@_INDICATORS + 1];
  int k, status;
  memset(other, 0, sizeof other);
  memcpy(indicators, other, @_INDICATORS*sizeof *indicators);
  for (k = 0; k < @_F; ++k) {
    const double by = fabs(states[k])/@_coordinate_scale[s->state.independent[k]];
    if (by > size) size = by;
  }
  if (@_INDICATORS == 0 || !(size > 0.0)) return @_OK;
  size = 1e-5/size;
  for (k = 0; k < @_F; ++k) s->state.c[k] = kept.c[k] + size*states[k];
  s->ready = 0;
  status = @_get_indicators(s, indicators);
  if (status == @_OK) {
    for (k = 0; k < @_F; ++k) s->state.c[k] = kept.c[k] - size*states[k];
    s->ready = 0;
    status = @_get_indicators(s, other);
    for (k = 0; k < @_INDICATORS; ++k) indicators[k] = (indicators[k] - other[k])/(2.0*size);
  }
  s->state = kept;
  s->ready = 0;
  return status;
}

/* The linearised equations of motion, from the exact derivatives of the recorded operations. */
int @_vary(@ *s, const double *states, const double *inputs, double *derivatives, double *outputs, double *indicators) {
  int c, i, k, status = @_now(s);
  if (status == @_OK && indicators) status = @_vary_indicators(s, states, indicators);
  if (status == @_OK) status = @_now(s);
  if (status != @_OK) return status;
  memcpy(s->x, s->state.x, sizeof s->x);
  memset(s->d_u, 0, sizeof s->d_u);
  memset(s->d_z, 0, sizeof s->d_z);
  memset(s->d_q, 0, sizeof s->d_q);
  memset(s->d_v, 0, sizeof s->d_v);
  memset(s->d_a, 0, sizeof s->d_a);
  memset(s->d_x, 0, sizeof s->d_x);
  memset(s->d_multipliers, 0, sizeof s->d_multipliers);
#if @_INPUTS > 0
  for (k = 0; k < @_INPUTS; ++k) {
    s->d_u[@_held_inputs[k].held] = inputs[k];
    if (@_held_inputs[k].linear) s->d_u[@_held_inputs[k].held + 2] = inputs[k];
  }
#else
  (void)inputs;
#endif
  for (k = 0; k < @_W; ++k)
    if (@_remembered[k].held)
      s->d_u[@_remembered[k].at] = states[2*@_F + k];
    else
      s->d_z[@_remembered[k].at] = states[2*@_F + k];
#if @_BLOCKS
  @_d_signals_rest(s);
#else
  @_d_signals_step(s);
#endif
  for (k = 0; k < @_F; ++k) s->d_x[s->state.independent[k]] = states[k];
#if @_R > 0
  @_d_motion(s);
  if (@_ROTATIONS > 0 && !@_factor(s, 1)) return @_SINGULAR;
  for (k = 0; k < @_R; ++k) {
    s->b[k] = -s->d_phi[s->state.row[k]];
    for (i = 0; i < @_N; ++i) s->b[k] -= s->rows_of[k*@_N + i]*s->d_x[i];
  }
  @_solve(s, s->b);
  for (k = 0; k < @_R; ++k) s->d_x[s->state.dependent[k]] = s->b[k];
  if (@_ROTATIONS > 0 && !@_factor(s, 0)) return @_SINGULAR;
#endif
  @_vary_positions(s);
  for (k = 0; k < @_F; ++k) s->d_v[s->state.independent[k]] = states[@_F + k];
#if @_R > 0
  @_d_motion(s);
  for (k = 0; k < @_R; ++k) s->b[k] = -s->d_phi_dot[s->state.row[k]];
  @_solve(s, s->b);
  for (k = 0; k < @_R; ++k) s->d_v[s->state.dependent[k]] = s->b[k];
#endif
  @_d_motion(s);
  @_vary_seen(s);
  @_d_increment_rate(s);
  @_d_rates(s);
#if @_R > 0
  for (k = 0; k < @_R; ++k) s->b[k] = -s->d_phi_ddot[s->state.row[k]];
  @_solve(s, s->b);
  for (k = 0; k < @_R; ++k) s->d_a[s->state.dependent[k]] = s->b[k];
  for (k = 0; k < @_MASS; ++k) {
    const int row = @_mass_row[k], column = @_mass_column[k];
    s->d_r[row] += s->mass[k]*s->d_a[column];
    if (row != column) s->d_r[column] += s->mass[k]*s->d_a[row];
  }
#endif
  for (c = 0; c < @_F; ++c) s->acceleration[c] = 0.0;
  for (i = 0; i < @_N; ++i)
    for (c = 0; c < @_F; ++c) s->acceleration[c] -= s->motions[i*@_F + c]*s->d_r[i];
  @_divide(s, s->acceleration);
  for (k = 0; k < @_F; ++k) {
    derivatives[k] = s->d_x_rate[s->state.independent[k]];
    derivatives[@_F + k] = s->acceleration[k];
  }
  for (k = 0; k < @_W; ++k) derivatives[2*@_F + k] = s->d_w_rate[k];
  for (i = 0; i < @_N; ++i)
    for (c = 0; c < @_F; ++c) s->d_a[i] += s->motions[i*@_F + c]*s->acceleration[c];
  @_d_motion(s);
  @_vary_seen(s);
  @_d_outputs(s);
  for (k = 0; k < @_OUTPUTS; ++k) outputs[k] = s->d_output[k];
  return @_all_finite(derivatives, @_C) ? @_OK : @_NOT_FINITE;
}

static int @_look(@ *s, double time, double *derivatives, double *outputs, double *indicators) {
  int status;
  @_set_time(s, time);
  status = @_get_derivatives(s, derivatives);
  if (status == @_OK) status = @_get_outputs(s);
  if (status == @_OK && indicators) status = @_get_indicators(s, indicators);
  if (status == @_OK) memcpy(outputs, s->output, @_OUTPUTS*sizeof *outputs);
  return status;
}
static void @_difference(double *a, const double *b, int n, double span) {
  int k;
  for (k = 0; k < n; ++k) a[k] = (a[k] - b[k])/span;
}

/* Central differences, since functions of time are not differentiated; one-sided beside events in time. */
int @_vary_time(@ *s, double *derivatives, double *outputs, double *indicators) {
  double other_derivatives[@_C + 1], other_outputs[@_OUTPUTS + 1], other_indicators[@_INDICATORS + 1];
  const double way = 1e-6*(1.0 + fabs(s->state.time));
  double before = s->state.time - way, after = s->state.time + way;
  int status = @_now(s);
  const @_state kept = s->state;
  if (status != @_OK) return status;
  if (before < s->state.last_event) before = s->state.last_event;
  if (after > s->state.next_event) after = s->state.next_event;
  if (!(after > before)) {
    before = s->state.time - way;
    after = s->state.time + way;
  }
  status = @_look(s, before, other_derivatives, other_outputs, indicators ? other_indicators : NULL);
  if (status == @_OK) status = @_look(s, after, derivatives, outputs, indicators);
  s->state = kept;
  s->ready = 0;
  if (status != @_OK) return status;
  @_difference(derivatives, other_derivatives, @_C, after - before);
  @_difference(outputs, other_outputs, @_OUTPUTS, after - before);
  if (indicators) @_difference(indicators, other_indicators, @_INDICATORS, after - before);
  return @_OK;
}
#endif

double @_get_next_event(const @ *s) { return s->state.next_event; }
double @_time(const @ *s) { return s->state.time; }

void @_save(const @ *s, @_state *state) { *state = s->state; }
void @_restore(@ *s, const @_state *state) {
  s->state = *state;
  s->ready = 0;
}
)c";

}  // namespace mimbre::portable
