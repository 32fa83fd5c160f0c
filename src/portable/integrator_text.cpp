#include "portable/texts.h"

/// What IndexThree (src/integrate/index3.cpp) does with a fixed cost, by hand in C99. '@' stands for the
/// model's name; constants and tables come before it, and the phases of the recorded model.
namespace mimbre::portable {

const char* const linear_text = R"c(
/* The entries of the Jacobian come row by row. */
static void @_times_jacobian(const @ *s, const double *x, double *out) {
  int i, k;
  for (k = 0; k < @_M; ++k) out[k] = 0.0;
  for (i = 0; i < @_ROWS; ++i) {
    const int last = @_j_first[i + 1];
    double sum = 0.0, other = 0.0;
    for (k = @_j_first[i]; k + 1 < last; k += 2) {
      sum += s->jacobian[k]*x[@_j_column[k]];
      other += s->jacobian[k + 1]*x[@_j_column[k + 1]];
    }
    if (k < last) sum += s->jacobian[k]*x[@_j_column[k]];
    out[@_j_row[i]] = sum + other;
  }
}

static void @_add_jacobian_transposed(const @ *s, const double *y, double weight, double *out) {
  int i, k;
  for (i = 0; i < @_ROWS; ++i) {
    const int last = @_j_first[i + 1];
    const double factor = weight*y[@_j_row[i]];
    for (k = @_j_first[i]; k < last; ++k) out[@_j_column[k]] += factor*s->jacobian[k];
  }
}

/* column[r] -= sum of left[r]*right over so many columns of a panel, four rows from r on. */
static void @_subtract(double *column, const double *left, const double *right, int columns, int stride, int rows) {
  double x0 = 0.0, x1 = 0.0, x2 = 0.0, x3 = 0.0;
  int k;
  for (k = 0; k < columns; ++k, left += stride, right += stride) {
    const double factor = *right;
    x0 += left[0]*factor;
    x1 += left[1]*factor;
    x2 += left[2]*factor;
    x3 += left[3]*factor;
  }
  column[0] -= x0;
  if (rows > 1) column[1] -= x1;
  if (rows > 2) column[2] -= x2;
  if (rows > 3) column[3] -= x3;
}

/* The same for two columns beside each other. */
static void @_subtract_two(double *column, int next, const double *left, const double *right, int columns, int stride,
                           int rows) {
  double x0 = 0.0, x1 = 0.0, x2 = 0.0, x3 = 0.0, y0 = 0.0, y1 = 0.0, y2 = 0.0, y3 = 0.0;
  double *const other = column + next;
  int k;
  for (k = 0; k < columns; ++k, left += stride, right += stride) {
    const double factor = right[0], second = right[1];
    x0 += left[0]*factor;
    x1 += left[1]*factor;
    x2 += left[2]*factor;
    x3 += left[3]*factor;
    y0 += left[0]*second;
    y1 += left[1]*second;
    y2 += left[2]*second;
    y3 += left[3]*second;
  }
  column[0] -= x0;
  other[0] -= y0;
  if (rows > 1) {
    column[1] -= x1;
    other[1] -= y1;
  }
  if (rows > 2) {
    column[2] -= x2;
    other[2] -= y2;
  }
  if (rows > 3) {
    column[3] -= x3;
    other[3] -= y3;
  }
}

/* Divides a column from its diagonal on; 0: it cannot be divided by that. */
static int @_divide(double *column, double *l, double *inverse, int j, int stride) {
  int r;
  *inverse = 1.0/column[j];
  if (!(fabs(*inverse) > 0.0 && *inverse - *inverse == 0.0)) return 0;
  for (r = j/4*4; r < stride; r += 4) {
    l[r] = column[r];
    l[r + 1] = column[r + 1];
    l[r + 2] = column[r + 2];
    l[r + 3] = column[r + 3];
    column[r] *= *inverse;
    column[r + 1] *= *inverse;
    column[r + 2] *= *inverse;
    column[r + 3] *= *inverse;
  }
  return 1;
}

/* L D L^T over dense panels, two columns at a time; the unknown whose pivot cannot be divided by, -1: none. */
static int @_factor(@ *s) {
  int i, j, r, u;
  double *const scaled = s->scaled;
  for (i = 0; i < @_PANELS; ++i) {
    const @_panel *const p = @_panels + i;
    double *const a = s->matrix + p->offset, *const inverse = s->inverse + p->first;
    const int stride = p->stride;
    for (j = 0; j < p->columns; j += 2) {
      double *const column = a + j*stride, *const l = scaled + j*stride;
      const int two = j + 1 < p->columns;
      for (r = j/4*4; r < stride && j > 0; r += 4)
        if (two)
          @_subtract_two(column + r, stride, a + r, scaled + j, j, stride, 4);
        else
          @_subtract(column + r, a + r, scaled + j, j, stride, 4);
      if (!@_divide(column, l, inverse + j, j, stride)) return @_unknown[p->first + j];
      if (!two) break;
      for (r = j/4*4; r < stride; r += 4) @_subtract(column + stride + r, column + r, l + j + 1, 1, stride, 4);
      if (!@_divide(column + stride, l + stride, inverse + j + 1, j + 1, stride)) return @_unknown[p->first + j + 1];
    }
    for (u = p->first_update; u < p->last_update; ++u) {
      const @_update *const t = @_updates + u;
      const double *const left = a + t->row, *const right = scaled + t->column;
      for (j = 0; j < t->columns; j += 2) {
        double *const column = s->matrix + t->target + j*t->target_stride;
        const int first = t->row == t->column ? j/4*4 : 0;
        if (j + 1 < t->columns)
          for (r = first; r < t->rows; r += 4)
            @_subtract_two(column + r, t->target_stride, left + r, right + j, p->columns, stride, t->rows - r);
        else
          for (r = first; r < t->rows; r += 4)
            @_subtract(column + r, left + r, right + j, p->columns, stride, t->rows - r);
      }
    }
  }
  return -1;
}

/* Rows between a panel's columns and those below are 0. */
static void @_solve(@ *s, double *x) {
  int i, j, r;
  double *const z = s->column;
  for (i = 0; i < @_PANELS; ++i) {
    const @_panel *const p = @_panels + i;
    const int *const own = @_unknown + p->first, *const rows = @_row + p->first_row;
    const int stride = p->stride;
    const double *l = s->matrix + p->offset;
    for (j = 0; j < p->columns; ++j) z[j] = x[own[j]];
    for (r = p->columns; r < stride; ++r) z[r] = 0.0;
    for (j = 0; j + 1 < p->columns; j += 2, l += 2*stride) {
      const double *const next = l + stride;
      const double first = z[j], second = z[j + 1] - l[j + 1]*first;
      z[j + 1] = second;
      for (r = j + 2; r < stride; r += 2) {
        z[r] -= l[r]*first + next[r]*second;
        z[r + 1] -= l[r + 1]*first + next[r + 1]*second;
      }
    }
    if (j < p->columns)
      for (r = j + 1; r < stride; ++r) z[r] -= l[r]*z[j];
    for (j = 0; j < p->columns; ++j) x[own[j]] = z[j];
    for (r = p->below; r < stride; ++r) x[rows[r - p->below]] += z[r];
  }
  for (i = @_PANELS; i-- > 0;) {
    const @_panel *const p = @_panels + i;
    const int *const own = @_unknown + p->first, *const rows = @_row + p->first_row;
    const int stride = p->stride;
    const double *const a = s->matrix + p->offset, *const inverse = s->inverse + p->first;
    for (r = p->columns; r < p->below; ++r) z[r] = 0.0;
    for (r = p->below; r < stride; ++r) z[r] = x[rows[r - p->below]];
    j = p->columns;
    if (j%2 == 1) {
      const double *const l = a + --j*stride;
      double sum = 0.0;
      for (r = j + 1; r < stride; ++r) sum += l[r]*z[r];
      z[j] = x[own[j]]*inverse[j] - sum;
    }
    while (j > 0) {
      const double *const next = a + (j - 1)*stride, *const l = next - stride;
      double sum0 = 0.0, sum1 = 0.0, next0 = 0.0, next1 = 0.0;
      for (r = j; r < stride; r += 2) {
        sum0 += l[r]*z[r];
        next0 += next[r]*z[r];
        sum1 += l[r + 1]*z[r + 1];
        next1 += next[r + 1]*z[r + 1];
      }
      z[j - 1] = x[own[j - 1]]*inverse[j - 1] - (next0 + next1);
      z[j - 2] = x[own[j - 2]]*inverse[j - 2] - (sum0 + sum1 + l[j - 1]*z[j - 1]);
      j -= 2;
    }
    for (j = 0; j < p->columns; ++j) x[own[j]] = z[j];
  }
}

static int @_factor_all(@ *s) {
  memset(s->matrix, 0, sizeof s->matrix);
  @_assemble(s);
#if @_MARKED > 0
  @_tangents(s);
  memcpy(s->assembled, s->matrix, sizeof s->assembled);
  memcpy(s->tangent_kept, s->tangent, sizeof s->tangent_kept);
  memcpy(s->state.mark_kept, s->mark, sizeof s->state.mark_kept);
#endif
  return @_factor(s);
}

static int @_tangent_changed(const @ *s) {
#if @_MARKED > 0
  int k;
  for (k = 0; k < @_MARKED; ++k)
    if (fabs(s->mark[k] - s->state.mark_kept[k]) > @_mark_small[k]) return 1;
#else
  (void)s;
#endif
  return 0;
}

/* The matrix with the tangents of now in place of those that it was assembled with. */
static int @_factor_tangents(@ *s) {
#if @_MARKED > 0
  int e, i;
  @_tangents(s);
  for (e = 0; e < @_MARKED; ++e) {
    const @_marked *const m = @_marked_elements + e;
    const int n = m->size*m->size;
    double *const old = s->tangent_kept + m->tangent;
    const double *const now = s->tangent + m->tangent;
    int changed = 0, touched = 0;
    for (i = 0; i < n; ++i) {
      changed = changed || old[i] != now[i];
      touched = touched || old[i] != 0.0;
    }
    if (!changed) continue;
    s->state.mark_kept[e] = s->mark[e];
    for (i = 0; i < n; ++i) {
      s->difference[i] = now[i] - old[i];
      old[i] = now[i];
    }
    @_exchange(s, e, m->contact && !touched);
  }
  memcpy(s->matrix, s->assembled, sizeof s->assembled);
  return @_factor(s);
#else
  return @_factor_all(s);
#endif
}
)c";

const char* const integrator_text = R"c(
static double @_larger(double a, double b) { return a < b ? b : a; }
static double @_smaller(double a, double b) { return b < a ? b : a; }

static double @_largest(const double *x, const double *scale, int n) {
  double most = 0.0;
  int k;
  for (k = 0; k < n; ++k)
    if (fabs(x[k]) > most*scale[k]) most = fabs(x[k])/scale[k];
  return most;
}
static double @_of_coordinates(const double *x) { return @_largest(x, @_coordinate_scale, @_N); }
static double @_of_equations(const double *x) { return @_largest(x, @_equation_scale, @_M); }

#if @_CIRCLE > 0
/* Loops of signals go around until nothing changes any more; of one that is too fast what it makes is not a number. */
static void @_settle(@ *s, void (*go_round)(@ *)) {
  int k, round, settled = 0;
  for (round = 0; round < @_SIGNAL_ROUNDS && !(settled && round > 1); ++round) {
    go_round(s);
    settled = 1;
    for (k = 0; k < @_CIRCLE; ++k) {
      if (s->unsettled[k] != 0.0) settled = 0;
      if (round + 1 == @_SIGNAL_ROUNDS && s->lost[k] != 0.0) s->made[k] = s->slot[@_circle_slot[k]] = NAN;
      s->ahead[k] = s->made[k];
    }
  }
}
#endif

/* What signals see of the motion, at an instant: 0 before the first step, 1 at rest, 2 in a step. */
static void @_sense(@ *s, int instant) {
#if @_SENSES
#if @_BLOCKS
  if (instant == 0) {
    @_sense_fresh(s);
#if @_CIRCLE > 0
    @_settle(s, @_sense_round_fresh);
    @_see_fresh(s);
#endif
  }
  if (instant == 1) {
    @_sense_rest(s);
#if @_CIRCLE > 0
    @_settle(s, @_sense_round_rest);
    @_see_rest(s);
#endif
  }
  if (instant == 2)
#endif
  {
    @_sense_step(s);
#if @_CIRCLE > 0
    @_settle(s, @_sense_round_step);
    @_see_step(s);
#endif
  }
#endif
  (void)s;
  (void)instant;
}
#if @_DELAYS > 0
/* The inputs of delays at a moment, from lists of how many points there are, which is the newest, and of their times and
   values. */
static void @_look_back(@ *s, double time) {
  int i;
  for (i = 0; i < @_DELAYS; ++i) {
    const @_delay *const d = @_all_delays + i;
    const double *const list = s->state.u + d->held + 1 + d->inputs;
    const double moment = time - d->time;
    const int points = (int)list[0], oldest = (int)list[1] - (points - 1) + d->room;
    int low = 0, high = points;
    const double *a, *b;
    s->delayed[i] = s->delay_rate[i] = 0.0;
    if (points == 0) continue;
    while (low < high) {
      const int middle = (low + high)/2;
      if (list[2 + 2*((oldest + middle)%d->room)] <= moment)
        low = middle + 1;
      else
        high = middle;
    }
    a = list + 2 + 2*((oldest + (low > 0 ? low - 1 : 0))%d->room);
    b = list + 2 + 2*((oldest + (low < points ? low : points - 1))%d->room);
    s->delayed[i] = a[1];
    if (a == b) continue;
    s->delayed[i] = a[1] + (moment - a[0])/(b[0] - a[0])*(b[1] - a[1]);
    s->delay_rate[i] = (b[1] - a[1])/(b[0] - a[0]);
  }
}

/* A point of now into the list of what a block remembers. */
static void @_keep_delay(const @_delay *d, double *u, int begun, double time) {
  double *const list = u + d->held + 1 + d->inputs, *at;
  const double value = u[d->held + 1];
  int points = begun ? (int)list[0] : 0, last = points > 0 ? (int)list[1] : 0, jumps;
  at = list + 2 + 2*last;
  if (points > 0 && at[0] == time && at[1] == value) return;
  jumps = points > 0 && at[0] == time;
  if (!(points > 1 && !jumps && time - list[2 + 2*((last - 1 + d->room)%d->room)] < 3.0*d->time/d->room)) {
    last = points > 0 ? (last + 1)%d->room : 0;
    points = points < d->room ? points + 1 : d->room;
  }
  at = list + 2 + 2*last;
  at[0] = time;
  at[1] = value;
  list[0] = points;
  list[1] = last;
}
static void @_keep_delays(@ *s, int begun) {
  int i;
  for (i = 0; i < @_DELAYS; ++i) {
    const @_delay *const d = @_all_delays + i;
    const int list = d->held + 1 + d->inputs;
    memcpy(s->next_u + list, s->state.u + list, (size_t)(2 + 2*d->room)*sizeof(double));
    if (!d->sampled) @_keep_delay(d, s->next_u, begun, s->now[0]);
  }
}
#endif

static void @_signals(@ *s, int instant, double time) {
  s->now[0] = time;
#if @_DELAYS > 0
  @_look_back(s, time);
#endif
#if @_BLOCKS
  if (instant == 0) @_signals_fresh(s);
  if (instant == 1) @_signals_rest(s);
  if (instant == 2)
#endif
    @_signals_step(s);
  (void)instant;
}
static int @_rest_instant(const @ *s) { return s->state.begun ? 1 : 0; }
static void @_residual_rest(@ *s) {
#if @_RESTS
  @_forces_rest(s);
#else
  @_forces_step(s);
#endif
}

/* Anderson acceleration: corrections of a few iterates x, here s->r, mixed so that they cancel as far as possible; y goes
   along. */
static void @_mix(@ *s, double *x, double *y, int along) {
  const int columns = s->mixed < @_DEPTH ? s->mixed : @_DEPTH;
  int i, j, k, slot;
  memcpy(s->new_x, x, sizeof s->new_x);
  for (k = 0; k < along; ++k) s->new_y[k] = y[k];
  for (k = 0; k < @_N; ++k) s->new_d[k] = s->r[k]/@_coordinate_scale[k];
  if (columns > 0) {
    double gram[@_DEPTH][@_DEPTH], right[@_DEPTH], scale[@_DEPTH], theta[@_DEPTH], most = 0.0;
    for (i = 0; i < @_DEPTH; ++i) {
      for (j = 0; j < @_DEPTH; ++j) gram[i][j] = i == j ? 1.0 : 0.0;
      right[i] = 0.0;
    }
    for (j = 0; j < columns; ++j) {
      for (k = 0; k < @_N; ++k) right[j] += (s->new_d[k] - s->mix_d[j][k])*s->new_d[k];
      for (i = 0; i <= j; ++i) {
        double sum = 0.0;
        for (k = 0; k < @_N; ++k) sum += (s->new_d[k] - s->mix_d[i][k])*(s->new_d[k] - s->mix_d[j][k]);
        gram[i][j] = gram[j][i] = sum;
      }
    }
    for (j = 0; j < @_DEPTH; ++j) scale[j] = 1.0/sqrt(@_larger(gram[j][j], 1e-300));
    for (i = 0; i < @_DEPTH; ++i)
      for (j = 0; j < @_DEPTH; ++j) gram[i][j] *= scale[i]*scale[j];
    for (j = 0; j < @_DEPTH; ++j) {
      gram[j][j] += 1e-10;
      theta[j] = scale[j]*right[j];
    }
    for (j = 0; j < @_DEPTH; ++j)
      for (i = j + 1; i < @_DEPTH; ++i) {
        const double factor = gram[i][j]/gram[j][j];
        for (k = j; k < @_DEPTH; ++k) gram[i][k] -= factor*gram[j][k];
        theta[i] -= factor*theta[j];
      }
    for (j = @_DEPTH; j-- > 0;) {
      for (i = j + 1; i < @_DEPTH; ++i) theta[j] -= gram[j][i]*theta[i];
      theta[j] /= gram[j][j];
    }
    for (j = 0; j < @_DEPTH; ++j) {
      theta[j] *= scale[j];
      most = @_larger(most, fabs(theta[j]));
    }
    if (@_all_finite(theta, @_DEPTH) && most < 1e4)
      for (j = 0; j < columns; ++j) {
        for (k = 0; k < @_N; ++k) x[k] -= theta[j]*(s->new_x[k] - s->mix_x[j][k]);
        for (k = 0; k < along; ++k) y[k] -= theta[j]*(s->new_y[k] - s->mix_y[j][k]);
      }
  }
  slot = s->mixed%@_DEPTH;
  memcpy(s->mix_x[slot], s->new_x, sizeof s->new_x);
  memcpy(s->mix_y[slot], s->new_y, sizeof s->new_y);
  memcpy(s->mix_d[slot], s->new_d, sizeof s->new_d);
  ++s->mixed;
}

/* Positions, velocities and accelerations at the end of the step from the increment of the positions. */
static void @_from_increment(@ *s) {
  const double i = 1.0/(@_BETA*@_H*@_H), c = (0.5 - @_BETA)/@_BETA;
  int k;
  @_retract(s);
  memcpy(s->q, s->moved, sizeof s->q);
  for (k = 0; k < @_N; ++k) {
    s->algorithmic[k] = i*(s->x[k] - @_H*s->state.v[k]) - c*s->start_algorithmic[k];
    s->v[k] = s->state.v[k] + @_H*((1.0 - @_GAMMA)*s->start_algorithmic[k] + @_GAMMA*s->algorithmic[k]);
    s->a[k] = ((1.0 - @_ALPHA_M)*s->algorithmic[k] + @_ALPHA_M*s->start_algorithmic[k] -
               @_ALPHA_F*s->start_a[k])/(1.0 - @_ALPHA_F);
  }
}

#if @_MARKED > 0
/* The forces where accelerations at the start lead. */
static void @_move_start(@ *s, double along) {
  int k;
  for (k = 0; k < @_N; ++k) {
    s->x[k] = @_SCALE*s->a[k];
    s->v[k] = s->state.v[k] + @_RATE*s->x[k];
    s->x[k] += along*s->state.v[k];
  }
  @_retract(s);
  memcpy(s->q, s->moved, sizeof s->q);
  memcpy(s->multipliers, s->start_multipliers, sizeof s->start_multipliers);
  @_signals(s, 2, s->state.time);
  @_motion(s);
  @_sense(s, 2);
  @_forces_step(s);
}

/* Where what sticks at the start breaks away within the step, accelerations at which forces balance there, by Newton;
   else, or where it does not settle, those that are known stay. */
static int @_break_away(@ *s) {
  int k, round, fell = 0;
  @_move_start(s, 0.0);
  for (k = 0; k < @_MARKED; ++k)
    fell = fell || (s->state.mark_kept[k] - s->mark[k] > @_mark_small[k] && s->mark[k] < 0.9*s->state.mark_kept[k]);
  if (!fell) return @_OK;
  memcpy(s->algorithmic, s->a, sizeof s->a);
  memcpy(s->stuck_multipliers, s->start_multipliers, sizeof s->start_multipliers);
  for (round = 0; round < @_BROKEN_ROUNDS; ++round) {
    @_move_start(s, @_H);
    if (@_tangent_changed(s)) {
      int bad;
      memcpy(s->rest_r, s->r, sizeof s->r);
      bad = @_factor_all(s);
      memcpy(s->r, s->rest_r, sizeof s->r);
      if (bad >= 0) break;
    }
    memcpy(s->q, s->state.q, sizeof s->q);
    memcpy(s->v, s->state.v, sizeof s->v);
    @_motion(s);
    for (k = 0; k < @_M; ++k) s->g[k] = @_PENALTY*@_penalty[k]*s->phi_ddot[k];
    @_add_jacobian_transposed(s, s->g, 1.0, s->r);
    for (k = 0; k < @_N; ++k) s->r[k] = -s->r[k];
    @_solve(s, s->r);
    if (!@_all_finite(s->r, @_N)) break;
    for (k = 0; k < @_N; ++k) s->a[k] += s->r[k];
    @_times_jacobian(s, s->r, s->impulse);
    for (k = 0; k < @_M; ++k) s->start_multipliers[k] += s->g[k] + @_PENALTY*@_penalty[k]*s->impulse[k];
    if (@_of_coordinates(s->r) <= 1e-5*@_larger(@_ACCELERATION, @_of_coordinates(s->a))) return @_OK;
  }
  memcpy(s->a, s->algorithmic, sizeof s->a);
  memcpy(s->start_multipliers, s->stuck_multipliers, sizeof s->start_multipliers);
  memcpy(s->q, s->state.q, sizeof s->q);
  memcpy(s->v, s->state.v, sizeof s->v);
  memcpy(s->multipliers, s->start_multipliers, sizeof s->start_multipliers);
  @_signals(s, 2, s->state.time);
  @_motion(s);
  @_sense(s, 2);
  @_forces_step(s);
  return @_factor_all(s) < 0 ? @_OK : @_SINGULAR;
}
#endif

/* Accelerations at the start of the first step, as a step of its length sees them. */
static int @_start(@ *s) {
  const int instant = @_rest_instant(s);
  int k, round;
#if @_LOADS
  double before = 0.0;
  int slow = 0;
  s->mixed = 0;
#endif
  memcpy(s->q, s->state.q, sizeof s->q);
  memcpy(s->v, s->state.v, sizeof s->v);
  for (k = 0; k < @_N; ++k) s->a[k] = 0.0;
  for (k = 0; k < @_M; ++k) s->multipliers[k] = s->start_multipliers[k] = 0.0;
  for (round = 0; round < @_START_ROUNDS; ++round) {
    if (round == 0) {
      double correct = 0.0;
      int bad;
      @_signals(s, instant, s->state.time);
      @_motion(s);
      @_sense(s, instant);
      @_residual_rest(s);
      memcpy(s->rest_r, s->r, sizeof s->rest_r);
#if @_RESTS
      @_forces_step(s);
#endif
      bad = @_factor_all(s);
      memcpy(s->r, s->rest_r, sizeof s->r);
      for (k = 0; k < @_N; ++k) correct += s->r[k] - s->r[k];
      if (!(correct == 0.0)) return @_NOT_FINITE;
      if (bad >= 0) return @_SINGULAR;
#if @_LOADS
      @_loads(s);
#endif
    } else {
      @_motion(s);
      for (k = 0; k < @_N; ++k) s->r[k] = 0.0;
#if @_LOADS
      @_loads(s); /* what has changed of them */
      for (k = 0; k < @_N; ++k) s->r[k] = s->loads[k] - s->along[@_M + k];
#endif
    }
#if @_LOADS
    for (k = 0; k < @_N; ++k) s->along[@_M + k] = s->loads[k];
#endif
    for (k = 0; k < @_M; ++k) s->g[k] = @_PENALTY*@_penalty[k]*s->phi_ddot[k];
    @_add_jacobian_transposed(s, s->g, 1.0, s->r);
    for (k = 0; k < @_N; ++k) s->r[k] = -s->r[k];
    @_solve(s, s->r);
    if (!@_all_finite(s->r, @_N)) return @_NOT_FINITE;
    for (k = 0; k < @_N; ++k) s->a[k] += s->r[k];
    @_times_jacobian(s, s->r, s->impulse);
    for (k = 0; k < @_M; ++k) s->start_multipliers[k] += s->g[k] + @_PENALTY*@_penalty[k]*s->impulse[k];
    if ((@_M == 0 && !@_LOADS) || @_of_coordinates(s->r) <= 1e-8*@_larger(@_ACCELERATION, @_of_coordinates(s->a))) break;
#if @_LOADS
    slow = slow || (round > 0 && @_of_coordinates(s->r) > 0.2*before);
    before = @_of_coordinates(s->r);
    if (!slow) continue;
    for (k = 0; k < @_M; ++k) s->along[k] = s->start_multipliers[k];
    @_mix(s, s->a, s->along, @_M + @_N);
    for (k = 0; k < @_M; ++k) s->start_multipliers[k] = s->along[k];
#endif
  }
#if @_MARKED > 0
  if (@_break_away(s) != @_OK) return @_SINGULAR;
#endif
  memcpy(s->start_a, s->a, sizeof s->a);
  memcpy(s->start_algorithmic, s->a, sizeof s->a);
  return @_OK;
}

/* Adds to a vector the smallest change that takes a violation back. */
static void @_project(@ *s, double *target, const double *violation, double tolerance) {
  int k, round;
  memcpy(s->g, violation, sizeof s->g);
  for (round = 0; round < 6 && @_of_equations(s->g) > tolerance; ++round) {
    for (k = 0; k < @_M; ++k) s->impulse[k] = @_penalty[k]*s->g[k];
    for (k = 0; k < @_N; ++k) s->r[k] = 0.0;
    @_add_jacobian_transposed(s, s->impulse, -@_PENALTY, s->r);
    @_solve(s, s->r);
    for (k = 0; k < @_N; ++k) target[k] += s->r[k];
    @_times_jacobian(s, s->r, s->impulse);
    for (k = 0; k < @_M; ++k) {
      s->g[k] += s->impulse[k];
      s->force[k] += @_PENALTY*@_penalty[k]*s->g[k];
    }
  }
}

static void @_extrapolate(@ *s) {
  int k;
  memcpy(s->own, s->x, sizeof s->own);
  s->replaced = 0;
  if (s->state.known == 0) return;
  if (s->state.order == 1)
    for (k = 0; k < @_N; ++k) s->x[k] += s->state.last[k];
  if (s->state.order == 2)
    for (k = 0; k < @_N; ++k) s->x[k] += 2.0*s->state.last[k] - s->state.before[k];
}

static void @_learn(@ *s) {
  double least, left;
  int k;
  if (s->replaced) {
    s->state.known = s->state.order = 0;
    return;
  }
  for (k = 0; k < @_N; ++k) s->error[k] = s->x[k] - s->own[k];
  least = @_of_coordinates(s->error);
  s->state.order = 0;
  if (s->state.known > 0) {
    for (k = 0; k < @_N; ++k) s->rest[k] = s->error[k] - s->state.last[k];
    left = @_of_coordinates(s->rest);
    if (left < least) {
      least = left;
      s->state.order = 1;
    }
  }
  if (s->state.known > 1) {
    for (k = 0; k < @_N; ++k) s->rest[k] = s->error[k] - 2.0*s->state.last[k] + s->state.before[k];
    left = @_of_coordinates(s->rest);
    if (left < least) s->state.order = 2;
  }
  memcpy(s->state.before, s->state.last, sizeof s->error);
  memcpy(s->state.last, s->error, sizeof s->error);
  s->state.known = s->state.known < 2 ? s->state.known + 1 : 2;
}

static double @_rate_of(const double *v) { return @_ACCELERATION > 0.0 ? sqrt(@_ACCELERATION) : @_of_coordinates(v); }

#if @_FLIGHTS > 0
/* What flies freely keeps its momentum, and of what is rigid the energy of rotation. */
static void @_start_flight(@ *s) {
  memcpy(s->q, s->state.q, sizeof s->q);
  memcpy(s->v, s->state.v, sizeof s->v);
  memcpy(s->a, s->state.a, sizeof s->a);
  @_origin(s);
  @_signals(s, @_rest_instant(s), s->state.time);
  @_motion(s);
  @_flight_begin(s);
}
static void @_end_flight(@ *s) {
  int i, k;
#if @_FLIGHT_TURNS
  /* The energy that the change of shape adds to the rotation: the mean of its power at both ends. */
  @_flight_rates(s);
  memcpy(s->unprojected, s->v, sizeof s->v);
  memcpy(s->moved, s->q, sizeof s->q);
  memcpy(s->v, s->flight_rate, sizeof s->v);
  memcpy(s->q, s->state.q, sizeof s->q);
  @_motion(s);
  @_flight_gain(s);
  for (i = 0; i < @_FLIGHTS; ++i) s->flight_sum[i] = s->flight_gain[i];
  memcpy(s->q, s->moved, sizeof s->q);
  @_motion(s);
  @_flight_gain(s);
  for (i = 0; i < @_FLIGHTS; ++i) s->flight_sum[i] += s->flight_gain[i];
  memcpy(s->v, s->unprojected, sizeof s->v);
  @_motion(s);
#endif
  @_flight_end(s);
  for (i = 0; i < @_FLIGHTS; ++i) {
    const double *const to = s->flown + @_FLIGHT_NUMBERS*i; /* 7 positions, 6 velocities, 6 accelerations, 6 algorithmic ones */
    double *const v = s->v + @_flight_v[i], *const a = s->a + @_flight_v[i];
    double *const algorithmic = s->algorithmic + @_flight_v[i];
    for (k = 0; k < 7; ++k) s->q[@_flight_q[i] + k] = to[k];
    for (k = 0; k < 6; ++k) {
      v[k] = to[7 + k];
      a[k] = to[13 + k];
      algorithmic[k] = to[19 + k];
    }
  }
  @_motion(s);
}
#endif

/* One step of the index-3 augmented Lagrangian with a fixed number of iterations. */
static int @_integrate(@ *s) {
  const double end = s->state.time + @_H, penalty = @_PENALTY/@_SCALE;
  double nearest = HUGE_VAL, previous = 0.0, rate = 1.0, least = 0.0, first_correction = 0.0;
  double violation = 0.0, accelerations = 0.0, correction = 0.0, rate_violation = 0.0, velocity_tolerance = 0.0;
  double enough, accepted, change;
  int refactor = 1, slow = 0, corrections = 0, idle = 0, settled = 0, converged = 0, predicted = 1, projected = 0;
  int iteration, k, round, status = @_OK, near_singular = 0, satisfied;

  memcpy(s->start_a, s->state.a, sizeof s->start_a);
  memcpy(s->start_algorithmic, s->state.algorithmic, sizeof s->start_algorithmic);
#if @_FLIGHTS > 0
  @_start_flight(s);
#endif
  @_origin(s);
  if (!s->state.started) {
    s->state.known = s->state.order = 0;
    status = @_start(s);
    if (status != @_OK) return status;
  }
  @_signals(s, 2, end);
  memcpy(s->multipliers, s->state.multipliers, sizeof s->multipliers);
  s->mixed = 0;
  for (k = 0; k < @_N; ++k) {
    const double next = (s->start_a[k] - @_ALPHA_M*s->start_algorithmic[k])/(1.0 - @_ALPHA_M);
    s->x[k] = @_H*s->state.v[k] + @_H*@_H*((0.5 - @_BETA)*s->start_algorithmic[k] + @_BETA*next);
    s->x[k] /= @_temper[k];
  }
  @_extrapolate(s);

  for (iteration = 0; iteration < @_ITERATIONS; ++iteration) {
    const int last = iteration + 1 == @_ITERATIONS;
    double error, asked, share, off;
    int stagnant, refactored, held = 0;
    @_from_increment(s);
    @_motion(s);
    @_sense(s, 2);
#if @_STICKS
    held = predicted;
    s->holds[0] = held;
#endif
    @_forces_step(s);
#if @_STICKS
    s->holds[0] = 0.0;
#endif
    ++s->iterations;
    violation = @_of_equations(s->phi);
    accelerations = @_larger(@_ACCELERATION, @_of_coordinates(s->a));
    if (predicted) {
      predicted = 0;
      if (violation > 0.05*@_of_coordinates(s->x)) {
        for (k = 0; k < @_N; ++k) s->x[k] = s->own[k] = 0.0;
        s->replaced = 1;
        continue;
      }
      if (@_NEWMARK && @_tangent_changed(s)) {
        for (k = 0; k < @_N; ++k) s->x[k] = s->own[k] = @_H*s->state.v[k];
        s->replaced = 1;
        continue;
      }
    }

    /* The correction. */
    refactored = refactor;
    if (refactored || @_tangent_changed(s)) {
      int bad;
      s->mixed = 0;
      memcpy(s->rest_r, s->r, sizeof s->r);
      bad = refactored ? @_factor_all(s) : @_factor_tangents(s);
      memcpy(s->r, s->rest_r, sizeof s->r);
      ++s->factorisations;
      if (bad >= 0) {
        if (corrections > 0 && previous > 1.0) return @_NOT_CONVERGED;
        return @_all_finite(s->r, @_N) ? @_SINGULAR : @_NOT_FINITE;
      }
    }
    for (k = 0; k < @_M; ++k) s->impulse[k] = penalty*@_penalty[k]*s->phi[k];
    @_add_jacobian_transposed(s, s->impulse, 1.0, s->r);
    for (k = 0; k < @_N; ++k) s->r[k] *= -@_SCALE;
    @_solve(s, s->r);
    @_times_jacobian(s, s->r, s->impulse);
    correction = @_of_coordinates(s->r);

    /* Multipliers that balance it. */
    settled = iteration >= 3 && violation <= @_POSITION_TOLERANCE;
    memcpy(s->multipliers_before, s->multipliers, sizeof s->multipliers);
    for (k = 0; k < @_M; ++k) {
      s->force[k] = penalty*@_penalty[k]*(s->phi[k] + s->impulse[k]);
      if (!settled) s->multipliers[k] += s->force[k];
    }
    if (corrections == 0 || correction < @_smaller(nearest, 0.1)) {
      nearest = correction;
      memcpy(s->nearest_x, s->x, sizeof s->x);
      memcpy(s->nearest_multipliers, s->multipliers_before, sizeof s->multipliers);
    }
    if (!@_all_finite(s->r, @_N))
      return corrections > 0 && previous > 1.0 ? @_NOT_CONVERGED : @_NOT_FINITE;
    @_compose(s);
    memcpy(s->x, s->composed, sizeof s->x);
    if (slow) @_mix(s, s->x, s->multipliers, @_M);

    /* Whether it was the last. */
    rate = corrections == 0 ? 1.0 : correction/@_larger(previous, 1e-300);
    previous = correction;
    slow = slow || (corrections > 1 && refactored && rate > 0.2);
    refactor = !slow && corrections > 0 && rate > 0.1;
    if (corrections == 0 || correction < 0.5*least) {
      least = correction;
      idle = 0;
    } else {
      ++idle;
    }
    ++corrections;
    error = correction*(rate < 0.5 ? rate/(1.0 - rate) : 1.0);
    if (corrections == 1) first_correction = correction;
    stagnant = idle >= 4 && violation <= @_ROUND_OFF;
    asked = @_TOLERANCE*@_SCALE*accelerations;
    share = @_larger(3e-5, 3.0*@_TOLERANCE);
    for (k = 0; k < @_N; ++k) s->rest[k] = s->x[k] - s->own[k];
    off = @_larger(@_of_coordinates(s->rest), first_correction);
    enough = stagnant ? @_larger(@_larger(asked, 1e-11), 1e4*@_ROUND_OFF) : @_smaller(asked, share*off);
    accepted = @_larger(enough, DBL_EPSILON);
    converged = !held && error <= accepted && violation*@_smaller(1.0, rate) <= @_POSITION_TOLERANCE;
    if (!converged && !last) continue;

    /* The end of the iterations. */
    {
      const int diverged = !converged && correction > @_smaller(nearest, 0.1);
      if (diverged) {
        memcpy(s->x, s->nearest_x, sizeof s->x);
        memcpy(s->multipliers, s->nearest_multipliers, sizeof s->multipliers);
        settled = 0;
      }
      @_from_increment(s);
      if (settled)
        for (k = 0; k < @_M; ++k) s->multipliers[k] += s->force[k];
      velocity_tolerance = @_VELOCITY_TOLERANCE*@_rate_of(s->v);
      if (!(@_ACCELERATION > 0.0)) velocity_tolerance = @_larger(velocity_tolerance, @_ROUND_OFF/@_H);
      memcpy(s->unprojected, s->v, sizeof s->v);
      projected = 0;
      if (!slow && !diverged && @_M > 0) {
        for (k = 0; k < @_M; ++k) s->rates[k] = s->phi_dot[k] + @_RATE*s->impulse[k];
        rate_violation = @_of_equations(s->rates);
        projected = rate_violation > velocity_tolerance;
        if (projected) @_project(s, s->v, s->rates, velocity_tolerance);
      }
      @_motion(s);
      if (!(@_of_equations(s->phi) <= 10.0*@_POSITION_TOLERANCE)) converged = 0;
    }
    if (last || converged) break;
    refactor = !slow;
  }

  if (!converged) {
    s->unconverged = 1;
    if (!@_all_finite(s->x, @_N) || !@_all_finite(s->v, @_N) || !@_all_finite(s->a, @_N)) return @_NOT_FINITE;
    for (k = 0; k < @_M; ++k)
      if (!(fabs(s->phi[k]) <= @_DRIFT_LIMIT*@_equation_scale[k])) return @_DRIFTED;
  }
  if (@_M > 0) {
    const double wanted = velocity_tolerance;
    accepted = 100.0*wanted;
    if (!projected) rate_violation = @_of_equations(s->phi_dot);
    for (round = 0; round < 5; ++round) {
      const int first = round == 0 && !projected;
      if (@_of_equations(s->phi_dot) <= (first ? wanted : accepted)) break;
      memcpy(s->violation, s->phi_dot, sizeof s->violation);
      @_project(s, s->v, s->violation, wanted);
      @_motion(s);
    }
    for (k = 0; k < @_N; ++k) s->unprojected[k] -= s->v[k];
    change = @_of_coordinates(s->unprojected);
    satisfied = @_of_equations(s->phi_dot) <= accepted;
    near_singular = !satisfied || (change > 100.0*rate_violation && change > 1e-5*@_of_coordinates(s->v));
    if (near_singular) {
      s->unconverged = 1;
      for (k = 0; k < @_N; ++k) s->v[k] += s->unprojected[k];
      @_motion(s);
    }
    for (k = 0; k < @_N; ++k)
      s->algorithmic[k] -= s->a[k]*((1.0 - @_ALPHA_F)/(1.0 - @_ALPHA_M));
    if (!near_singular) {
      for (k = 0; k < @_M; ++k) s->force[k] = 0.0;
      memcpy(s->violation, s->phi_ddot, sizeof s->violation);
      @_project(s, s->a, s->violation, @_ACCELERATION_TOLERANCE*accelerations);
      for (k = 0; k < @_M; ++k) s->multipliers[k] += s->force[k];
    }
    for (k = 0; k < @_N; ++k)
      s->algorithmic[k] += s->a[k]*((1.0 - @_ALPHA_F)/(1.0 - @_ALPHA_M));
  }
  if (!@_all_finite(s->v, @_N)) return @_NOT_FINITE;
#if @_FLIGHTS > 0
  @_end_flight(s);
  if (!@_all_finite(s->q, @_Q) || !@_all_finite(s->v, @_N)) return @_NOT_FINITE;
#endif

  s->state.time += @_H;
  memcpy(s->state.q, s->q, sizeof s->q);
  memcpy(s->state.v, s->v, sizeof s->v);
  memcpy(s->state.a, s->a, sizeof s->a);
  memcpy(s->state.algorithmic, s->algorithmic, sizeof s->algorithmic);
  memcpy(s->state.multipliers, s->multipliers, sizeof s->multipliers);
  s->state.started = 1;
  @_learn(s);
  return @_OK;
}
)c";

const char* const finite_text = R"c(
static int @_all_finite(const double *x, int n) {
  int k;
  for (k = 0; k < n; ++k)
    if (!(x[k] - x[k] == 0.0)) return 0;
  return 1;
}
)c";

const char* const interface_text = R"c(
/* Evaluates the state at rest, for who looks at it. */
static void @_look(@ *s) {
  const int instant = @_rest_instant(s);
  memcpy(s->q, s->state.q, sizeof s->q);
  memcpy(s->v, s->state.v, sizeof s->v);
  memcpy(s->a, s->state.a, sizeof s->a);
  memcpy(s->multipliers, s->state.multipliers, sizeof s->multipliers);
  @_origin(s);
  @_signals(s, instant, s->state.time);
  @_motion(s);
  @_sense(s, instant);
}

#if @_SAMPLED > 0
/* What is evaluated at instants and due now: what takes another of them takes its new value. */
static void @_sample(@ *s) {
  const int instant = @_rest_instant(s);
  int k, i, looked = 0, stale = 0;
  for (k = 0; k < @_SAMPLED; ++k) {
    const @_sampled *const t = @_all_sampled + k;
    double *const at = s->state.u + t->held, *const due = at + t->values, *const made = due + 1;
    if (s->state.time < *due - 1e-6*t->every) continue;
    if (!looked) {
      @_look(s);
      @_residual_rest(s);
      looked = 1;
    }
    if (stale && t->chained) {
      @_signals(s, instant, s->state.time);
      @_sense(s, instant);
      stale = 0;
    }
    @_evaluate_sampled(s, k, t->block >= 0 && s->state.u[t->block] > 0.5);
    for (i = 0; i < t->values; ++i) {
      if (s->sampled[i] == at[i]) continue;
      at[i] = s->sampled[i];
      stale = 1;
#if @_BLOCKS
      s->state.u[@_CLOCK + 1] = 1.0;
#endif
    }
#if @_DELAYS > 0
    if (t->delay >= 0) {
      const int begun = s->state.u[t->block] > 0.5;
      for (i = 0; i < t->memory; ++i) s->state.u[t->block + i] = s->sampled[t->values + i];
      @_keep_delay(@_all_delays + t->delay, s->state.u, begun, s->state.time);
    } else
#endif
      for (i = 0; i < t->memory; ++i) s->state.u[t->block + i] = s->sampled[t->values + i];
#if @_EVENTS > 0
    s->state.settled[0] = 0.0;
#endif
    *made = s->state.time;
    *due = (floor(s->state.time/t->every + 1e-6) + 1.0)*t->every;
  }
}
#endif

/* What blocks start from where something has jumped; where a relay switches by that, its output has jumped, too. */
static void @_take_jumps(@ *s) {
#if @_BLOCKS
  int k;
  for (k = 0; k < @_EVENT_ROUNDS && s->state.u[@_CLOCK + 1] > 0.0; ++k) {
    @_look(s);
    if (s->state.begun)
      @_keep_blocks_rest(s);
    else
      @_keep_blocks_fresh(s);
#if @_DELAYS > 0
    @_keep_delays(s, s->state.begun);
#endif
    memcpy(s->state.u, s->next_u, sizeof s->next_u);
#if @_EVENTS > 0
    s->state.settled[0] = 0.0;
#endif
    s->shown = 0;
  }
#else
  (void)s;
#endif
}

#if @_EVENTS > 0
static void @_look_at_events(@ *s) {
  @_look(s);
  @_residual_rest(s);
  @_events(s);
}
static double @_side(double value) { return (double)(value > 0.0) - (double)(value < 0.0); }
static int @_crossed(const @ *s, int event) {
  const double now = @_side(s->event_value[event]), side = s->state.event_side[event];
  const int direction = @_all_events[event].direction;
  return now != 0.0 && side != 0.0 && now != side && (direction == 0 || (double)direction == now);
}
/* What has crossed happens, and what that makes cross. 1: it ends the run. */
static int @_settle_events(@ *s) {
  int ends = 0, round, k, i;
  for (round = 0; round <= @_EVENT_ROUNDS; ++round) {
    int crossed[@_EVENTS], any = 0;
    @_take_jumps(s);
    @_look_at_events(s);
    for (k = 0; k < @_EVENTS; ++k) {
      crossed[k] = @_crossed(s, k);
      any = any || crossed[k];
    }
    for (k = 0; k < @_EVENTS; ++k)
      if (@_side(s->event_value[k]) != 0.0) s->state.event_side[k] = @_side(s->event_value[k]);
    if (!any || round == @_EVENT_ROUNDS) break;
    for (k = 0; k < @_EVENTS; ++k) {
      const @_event *const e = @_all_events + k;
      if (!crossed[k]) continue;
      s->state.happened[k] += 1.0;
      s->state.when[k] = s->state.time;
      ends = ends || e->stops;
      for (i = e->first_set; i < e->last_set; ++i) @_set_input(s, @_event_inputs[i], s->event_set[i]);
    }
  }
  s->state.settled[0] = 1.0;
  s->shown = 0;
  return ends;
}
#endif

void @_start_events(@ *s) {
#if @_EVENTS > 0
  int k;
  @_look_at_events(s);
  for (k = 0; k < @_EVENTS; ++k) s->state.event_side[k] = @_side(s->event_value[k]);
#else
  (void)s;
#endif
}

void @_init(@ *s) {
#if @_EVENTS > 0
  int k;
#endif
  memset(s, 0, sizeof *s);
  s->state.time = @_START_TIME;
  memcpy(s->state.q, @_start_q, sizeof @_start_q);
  memcpy(s->state.v, @_start_v, sizeof @_start_v);
  memcpy(s->state.a, @_start_a, sizeof @_start_a);
  memcpy(s->state.algorithmic, @_start_a, sizeof @_start_a);
  memcpy(s->state.multipliers, @_start_multipliers, sizeof @_start_multipliers);
  memcpy(s->state.z, @_start_z, sizeof @_start_z);
  memcpy(s->state.u, @_start_u, sizeof @_start_u);
#if @_EVENTS > 0
  for (k = 0; k < @_EVENTS; ++k) s->state.when[k] = -1.0;
#endif
  @_start_events(s);
}

int @_set_input(@ *s, int input, double value) {
#if @_INPUTS > 0
  const @_held_input *h;
  double *u;
  if (input < 0 || input >= @_INPUTS || !(value - value == 0.0)) return @_NO_SUCH;
  h = @_held_inputs + input;
  value = @_smaller(@_larger(value, h->least), h->most);
  u = s->state.u + h->held;
  if (!h->linear) {
    if (value != u[0]) {
      u[1] = s->state.time;
#if @_BLOCKS
      s->state.u[@_CLOCK + 1] = 1.0;
#endif
    }
    u[0] = value;
  } else {
    u[0] = @_get_input(s, input);
    u[1] = s->state.time;
    u[2] = value;
    u[3] = s->state.time + @_H;
  }
  s->shown = 0;
#if @_EVENTS > 0
  s->state.settled[0] = 0.0;
#endif
  return @_OK;
#else
  (void)s;
  (void)input;
  (void)value;
  return @_NO_SUCH;
#endif
}

double @_get_input(const @ *s, int input) {
#if @_INPUTS > 0
  const @_held_input *h;
  const double *u;
  const double now = s->state.time;
  if (input < 0 || input >= @_INPUTS) return NAN;
  h = @_held_inputs + input;
  u = s->state.u + h->held;
  if (!h->linear) return u[0];
  if (!(u[3] > u[1]) || now >= u[3]) return u[2];
  if (now <= u[1]) return u[0];
  return u[0] + (u[2] - u[0])/(u[3] - u[1])*(now - u[1]);
#else
  (void)s;
  (void)input;
  return NAN;
#endif
}

int @_step(@ *s) {
  int status;
  s->iterations = s->factorisations = s->unconverged = 0;
#if @_SAMPLED > 0
  @_sample(s);
#endif
  @_take_jumps(s);
#if @_EVENTS > 0
  if (s->state.settled[0] == 0.0 && @_settle_events(s)) return @_ENDED;
#endif
  if (s->state.begun) s->state.started = 1;
#if @_JUMPS
  if (!s->state.started) {
    @_look(s);
    @_keep_laws(s);
    memcpy(s->state.z, s->next_z, sizeof s->next_z);
  }
#endif
  s->shown = 0;
  status = @_integrate(s);
  if (status != @_OK) return status;
#if @_REMEMBERS
  @_sense(s, 2);
  @_commit(s);
#if @_STATES > 0
  memcpy(s->state.z, s->next_z, sizeof s->next_z);
#endif
#if @_HOLDS
#if @_DELAYS > 0
  @_keep_delays(s, 1);
#endif
  memcpy(s->state.u, s->next_u, sizeof s->next_u);
#endif
#endif
  s->state.begun = 1;
  {
    const double multiple = round(s->state.time/@_H)*@_H;
    if (fabs(s->state.time - multiple) < 1e-6*@_H) s->state.time = multiple;
  }
#if @_EVENTS > 0
  if (@_settle_events(s)) return @_ENDED;
#elif @_RELAYS > 0
  @_take_jumps(s);
#endif
  return s->unconverged ? @_UNCONVERGED : @_OK;
}

double @_get_output(@ *s, int output) {
  if (output < 0 || output >= @_OUTPUTS) return NAN;
  if (!s->shown) {
    @_look(s);
    @_residual_rest(s);
    @_outputs(s);
    s->shown = 1;
  }
  return s->output[output];
}

double @_time(const @ *s) { return s->state.time; }

double @_event_count(const @ *s) {
  double count = 0.0;
#if @_EVENTS > 0
  int k;
  for (k = 0; k < @_EVENTS; ++k) count += s->state.happened[k];
#else
  (void)s;
#endif
  return count;
}

void @_save(const @ *s, @_state *state) { *state = s->state; }
void @_restore(@ *s, const @_state *state) {
  s->state = *state;
  s->shown = 0;
}
)c";

}  // namespace mimbre::portable
