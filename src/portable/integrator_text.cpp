#include "portable/texts.h"

/// What IndexThree (src/integrate/index3.cpp) does with a fixed cost, by hand in C99. '@' stands for the
/// model's name; constants and tables come before it, and the phases of the recorded model.
namespace mimbre::portable {

const char* const linear_text = R"c(
static void @_times_jacobian(const @ *s, const double *x, double *out) {
  int k;
  for (k = 0; k < @_M; ++k) out[k] = 0.0;
  for (k = 0; k < @_J; ++k) out[@_j_row[k]] += s->jacobian[k]*x[@_j_column[k]];
}

static void @_add_jacobian_transposed(const @ *s, const double *y, double weight, double *out) {
  int k;
  for (k = 0; k < @_J; ++k) out[@_j_column[k]] += weight*y[@_j_row[k]]*s->jacobian[k];
}

/* L D L^T over dense panels; the unknown whose pivot cannot be divided by, -1: none. */
static int @_factor(@ *s) {
  int i, j, k, r, u;
  double *const scaled = s->scaled;
  for (i = 0; i < @_PANELS; ++i) {
    const @_panel *const p = @_panels + i;
    double *const a = s->matrix + p->offset;
    const int stride = p->stride;
    for (j = 0; j < p->columns; ++j) {
      double *const column = a + j*stride, *const l = scaled + j*stride;
      double inverse;
      for (k = 0; k < j; ++k) {
        const double factor = scaled[k*stride + j];
        const double *const left = a + k*stride;
        for (r = j/4*4; r < stride; r += 4) {
          column[r] -= left[r]*factor;
          column[r + 1] -= left[r + 1]*factor;
          column[r + 2] -= left[r + 2]*factor;
          column[r + 3] -= left[r + 3]*factor;
        }
      }
      inverse = 1.0/column[j];
      if (!(fabs(inverse) > 0.0 && inverse - inverse == 0.0)) return @_unknown[p->first + j];
      s->inverse[p->first + j] = inverse;
      for (r = j/4*4; r < stride; r += 4) {
        l[r] = column[r];
        l[r + 1] = column[r + 1];
        l[r + 2] = column[r + 2];
        l[r + 3] = column[r + 3];
        column[r] *= inverse;
        column[r + 1] *= inverse;
        column[r + 2] *= inverse;
        column[r + 3] *= inverse;
      }
    }
    for (u = p->first_update; u < p->last_update; ++u) {
      const @_update *const t = @_updates + u;
      for (j = 0; j < t->columns; ++j) {
        double *const column = s->matrix + t->target + j*t->target_stride;
        const int first = t->row == t->column ? j/4*4 : 0;
        for (r = first; r < t->rows; r += 4) {
          const double *left = a + t->row + r, *right = scaled + t->column + j;
          double x0 = 0.0, x1 = 0.0, x2 = 0.0, x3 = 0.0;
          for (k = 0; k < p->columns; ++k, left += stride, right += stride) {
            const double factor = *right;
            x0 += left[0]*factor;
            x1 += left[1]*factor;
            x2 += left[2]*factor;
            x3 += left[3]*factor;
          }
          column[r] -= x0;
          if (r + 1 < t->rows) column[r + 1] -= x1;
          if (r + 2 < t->rows) column[r + 2] -= x2;
          if (r + 3 < t->rows) column[r + 3] -= x3;
        }
      }
    }
  }
  return -1;
}

static void @_solve(@ *s, double *x) {
  int i, j, r;
  double *const z = s->column;
  for (i = 0; i < @_PANELS; ++i) {
    const @_panel *const p = @_panels + i;
    const double *const a = s->matrix + p->offset;
    const int *const own = @_unknown + p->first, *const rows = @_row + p->first_row;
    for (r = 0; r < p->stride; ++r) z[r] = 0.0;
    for (j = 0; j < p->columns; ++j) {
      const double *const l = a + j*p->stride;
      const double known = x[own[j]] - z[j];
      x[own[j]] = known;
      for (r = j + 1; r < p->columns; ++r) z[r] += l[r]*known;
      for (r = p->below; r < p->stride; ++r) z[r] += l[r]*known;
    }
    for (r = p->below; r < p->stride; ++r) x[rows[r - p->below]] -= z[r];
  }
  for (i = @_PANELS; i-- > 0;) {
    const @_panel *const p = @_panels + i;
    const double *const a = s->matrix + p->offset;
    const int *const own = @_unknown + p->first, *const rows = @_row + p->first_row;
    for (r = p->below; r < p->stride; ++r) z[r] = x[rows[r - p->below]];
    for (j = p->columns; j-- > 0;) {
      const double *const l = a + j*p->stride;
      double sum0 = 0.0, sum1 = 0.0;
      for (r = j + 1; r < p->columns; ++r) sum0 += l[r]*z[r];
      for (r = p->below; r + 1 < p->stride; r += 2) {
        sum0 += l[r]*z[r];
        sum1 += l[r + 1]*z[r + 1];
      }
      z[j] = x[own[j]]*s->inverse[p->first + j] - (sum0 + sum1);
      x[own[j]] = z[j];
    }
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

/* Forces at an instant: 0 before the first step, 1 at rest, 2 in a step. */
static void @_sense(@ *s, int instant) {
#if @_SENSES
#if @_BLOCKS
  if (instant == 0) @_sense_fresh(s);
  if (instant == 1) @_sense_rest(s);
  if (instant == 2)
#endif
    @_sense_step(s);
#endif
  (void)s;
  (void)instant;
}
static void @_signals(@ *s, int instant, double time) {
  s->now[0] = time;
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

/* Anderson acceleration: corrections of a few iterates, mixed so that they cancel as far as possible. */
static void @_mix(@ *s) {
  const int columns = s->mixed < @_DEPTH ? s->mixed : @_DEPTH;
  int i, j, k, slot;
  memcpy(s->new_x, s->x, sizeof s->new_x);
  memcpy(s->new_y, s->multipliers, sizeof s->new_y);
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
        for (k = 0; k < @_N; ++k) s->x[k] -= theta[j]*(s->new_x[k] - s->mix_x[j][k]);
        for (k = 0; k < @_M; ++k) s->multipliers[k] -= theta[j]*(s->new_y[k] - s->mix_y[j][k]);
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

/* Accelerations at the start of the first step, as a step of its length sees them. */
static int @_start(@ *s) {
  const int instant = @_rest_instant(s);
  int k, round;
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
    } else {
      @_motion(s);
      for (k = 0; k < @_N; ++k) s->r[k] = 0.0;
    }
    for (k = 0; k < @_M; ++k) s->g[k] = @_PENALTY*@_penalty[k]*s->phi_ddot[k];
    @_add_jacobian_transposed(s, s->g, 1.0, s->r);
    for (k = 0; k < @_N; ++k) s->r[k] = -s->r[k];
    @_solve(s, s->r);
    if (!@_all_finite(s->r, @_N)) return @_NOT_FINITE;
    for (k = 0; k < @_N; ++k) s->a[k] += s->r[k];
    @_times_jacobian(s, s->r, s->impulse);
    for (k = 0; k < @_M; ++k) s->start_multipliers[k] += s->g[k] + @_PENALTY*@_penalty[k]*s->impulse[k];
    if (@_M == 0 || @_of_coordinates(s->r) <= 1e-8*@_larger(@_ACCELERATION, @_of_coordinates(s->a))) break;
  }
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
    int stagnant, refactored;
    @_from_increment(s);
    @_motion(s);
    @_sense(s, 2);
    @_forces_step(s);
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
    if (slow) @_mix(s);

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
    converged = error <= accepted && violation*@_smaller(1.0, rate) <= @_POSITION_TOLERANCE;
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

void @_init(@ *s) {
  memset(s, 0, sizeof *s);
  s->state.time = @_START_TIME;
  memcpy(s->state.q, @_start_q, sizeof @_start_q);
  memcpy(s->state.v, @_start_v, sizeof @_start_v);
  memcpy(s->state.a, @_start_a, sizeof @_start_a);
  memcpy(s->state.algorithmic, @_start_a, sizeof @_start_a);
  memcpy(s->state.multipliers, @_start_multipliers, sizeof @_start_multipliers);
  memcpy(s->state.z, @_start_z, sizeof @_start_z);
  memcpy(s->state.u, @_start_u, sizeof @_start_u);
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
#if @_BLOCKS
  if (s->state.u[@_CLOCK + 1] > 0.0) {
    @_look(s);
    if (s->state.begun)
      @_keep_blocks_rest(s);
    else
      @_keep_blocks_fresh(s);
    memcpy(s->state.u, s->next_u, sizeof s->next_u);
  }
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
  memcpy(s->state.u, s->next_u, sizeof s->next_u);
#endif
#endif
  s->state.begun = 1;
  {
    const double multiple = round(s->state.time/@_H)*@_H;
    if (fabs(s->state.time - multiple) < 1e-6*@_H) s->state.time = multiple;
  }
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

void @_save(const @ *s, @_state *state) { *state = s->state; }
void @_restore(@ *s, const @_state *state) {
  s->state = *state;
  s->shown = 0;
}
)c";

const char* const functions_text = R"c(
/* Value and both derivatives of polynomial pieces: piece k holds up to breaks[k]. */
typedef struct {
  int count;
  const double *breaks, *origins, *coefficients, *integrals;
  const int *first;
  double start, period, integral, at_zero;
} @_pieces;

static int @_find_piece(const @_pieces *f, double *x, double *turns) {
  int low = 0, high = f->count;
  *turns = 0.0;
  if (f->period > 0.0) {
    const double whole = floor((*x - f->start)/f->period), within = *x - whole*f->period;
    *turns = whole;
    *x = within;
    if (within < f->start) *x = f->start;
    if (within >= f->start + f->period) {
      *x = f->start;
      *turns = whole + 1.0;
    }
  }
  while (low < high) {
    const int middle = (low + high)/2;
    if (*x >= f->breaks[middle])
      low = middle + 1;
    else
      high = middle;
  }
  return low;
}

#if @_FUNCTIONS
static void @_evaluate_pieces(const @_pieces *f, double x, double *out) {
  double turns, s, v = 0.0, d = 0.0, half = 0.0;
  const int k = @_find_piece(f, &x, &turns);
  int i;
  s = x - f->origins[k];
  for (i = f->first[k + 1]; i-- > f->first[k];) {
    half = half*s + d;
    d = d*s + v;
    v = v*s + f->coefficients[i];
  }
  out[0] = v;
  out[1] = d;
  out[2] = 2.0*half;
}
#endif

#if @_INTEGRALS
static double @_integral_of(const @_pieces *f, double x) {
  double turns, s, v = 0.0;
  const int k = @_find_piece(f, &x, &turns);
  int i;
  s = x - f->origins[k];
  for (i = f->first[k + 1]; i-- > f->first[k];)
    v = v*s + f->coefficients[i]/(i - f->first[k] + 1);
  return turns*f->integral + f->integrals[k] + v*s - f->at_zero;
}
#endif

#if @_PROFILES
/* Height and slopes of a profile, as a footprint of so many metres to both sides feels it. */
static void @_profile(const @_pieces *f, double footprint, double x, double *out) {
  double high[3], low[3];
  const double length = 2.0*footprint;
  @_evaluate_pieces(f, x + footprint, high);
  @_evaluate_pieces(f, x - footprint, low);
  out[0] = (@_integral_of(f, x + footprint) - @_integral_of(f, x - footprint))/length;
  out[1] = (high[0] - low[0])/length;
  out[2] = 0.0;
}
#endif
)c";

const char* const roads_text = R"c(
#if @_GRIDS
/* The biquadratic spline of the heights of a grid. */
typedef struct {
  double origin[2], spacing[2];
  int rows, columns;
  const double *heights;
} @_grid;

static void @_grid_height(const @_grid *g, double x, double y, double *out) {
  const double place[2] = {x, y};
  const int counts[2] = {g->columns, g->rows};
  double value[2][3], first[2][3];
  int near[2], i, j, k;
  for (k = 0; k < 2; ++k) {
    const double u = (place[k] - g->origin[k])/g->spacing[k] + 0.5;
    const double most = counts[k] + 1.0, kept = u > -1.0 ? (u < most ? u : most) : -1.0, below = floor(kept),
                 t = kept - below;
    near[k] = (int)below;
    value[k][0] = 0.5*(1.0 - t)*(1.0 - t);
    value[k][1] = 0.5 + t*(1.0 - t);
    value[k][2] = 0.5*t*t;
    first[k][0] = t - 1.0;
    first[k][1] = 1.0 - 2.0*t;
    first[k][2] = t;
  }
  out[0] = out[1] = out[2] = 0.0;
  for (j = 0; j < 3; ++j)
    for (i = 0; i < 3; ++i) {
      int column = near[0] + i - 1, row = near[1] + j - 1;
      double z;
      column = column < 0 ? 0 : column > g->columns - 1 ? g->columns - 1 : column;
      row = row < 0 ? 0 : row > g->rows - 1 ? g->rows - 1 : row;
      z = g->heights[row*g->columns + column];
      out[0] += value[0][i]*value[1][j]*z;
      out[1] += first[0][i]*value[1][j]*z;
      out[2] += value[0][i]*first[1][j]*z;
    }
  out[1] /= g->spacing[0];
  out[2] /= g->spacing[1];
}
#endif

#if @_ROADS
/* A grid along a line. */
typedef struct {
  int points, across, closed;
  const double *line, *circles, *v, *height, *along, *sideways; /* circles: x, y, radius, first, count */
} @_road;

static double @_segment_distance(const @_road *g, int i, double x, double y) {
  const double *const a = g->line + 4*i, *const b = a + 4;
  const double tx = b[0] - a[0], ty = b[1] - a[1], px = x - a[0], py = y - a[1];
  double f = (px*tx + py*ty)/(tx*tx + ty*ty);
  f = f < 0.0 ? 0.0 : f > 1.0 ? 1.0 : f;
  return (px - f*tx)*(px - f*tx) + (py - f*ty)*(py - f*ty);
}

static double @_circle_distance(const double *c, double x, double y) {
  const double dx = x - c[0], dy = y - c[1], d = sqrt(dx*dx + dy*dy) - c[2];
  return d > 0.0 ? d : 0.0;
}

static int @_nearest_segment(const @_road *g, double x, double y) {
  int waiting[64], count = 0, found = 0;
  double distance[64], nearest = HUGE_VAL;
  waiting[count] = 0;
  distance[count++] = 0.0;
  while (count > 0) {
    const int circle = waiting[--count];
    const double *const c = g->circles + 5*circle;
    const int first = (int)c[3], of = (int)c[4];
    int i, swaps;
    double d0, d1;
    if (!(distance[count]*distance[count] <= nearest)) continue;
    for (i = first; i < first + of; ++i) {
      const double d = @_segment_distance(g, i, x, y);
      if (d < nearest || (d == nearest && i < found)) {
        nearest = d;
        found = i;
      }
    }
    if (of > 0) continue;
    d0 = @_circle_distance(g->circles + 5*first, x, y);
    d1 = @_circle_distance(g->circles + 5*(first + 1), x, y);
    swaps = d1 < d0;
    waiting[count] = swaps ? first : first + 1;
    distance[count++] = swaps ? d0 : d1;
    waiting[count] = swaps ? first + 1 : first;
    distance[count++] = swaps ? d1 : d0;
  }
  return found;
}

/* segment: f along, v across, with derivatives by x and y */
static void @_on_segment(const @_road *g, int i, double x, double y, double *at) {
  const double *const a = g->line + 4*i, *const b = a + 4;
  const double dx = b[0] - a[0], dy = b[1] - a[1], length = sqrt(dx*dx + dy*dy), tx = dx/length, ty = dy/length;
  const double turn0 = a[2]*tx + a[3]*ty, turn = b[2]*tx + b[3]*ty - turn0;
  const double px = x - a[0], py = y - a[1], along = px*tx + py*ty, v = py*tx - px*ty;
  const double width = length + v*turn, least = 1e-3*length;
  const int crossed = !(width > least);
  const double w = crossed ? least : width, f = (along - v*turn0)/w;
  const double by_s = 1.0/w, by_v = -(turn0 + (crossed ? 0.0 : f*turn))/w;
  at[0] = f;
  at[1] = v;
  at[2] = by_s*tx - by_v*ty;
  at[3] = by_s*ty + by_v*tx;
  at[4] = -ty;
  at[5] = tx;
}

static double @_ramp(double t, double width, double *first) {
  const double over = t + 0.5*width;
  *first = 0.0;
  if (!(over > 0.0)) return 0.0;
  if (over >= width) {
    *first = 1.0;
    return t;
  }
  *first = over/width;
  return over*over/(2.0*width);
}

static void @_weights(double t, double width, double before, double behind, double *value, double *first) {
  double back1, forth1;
  const double back = @_ramp(-t, width, &back1), forth = @_ramp(t, width, &forth1);
  value[0] = back/before;
  value[2] = forth/behind;
  value[1] = 1.0 - value[0] - value[2];
  first[0] = -back1/before;
  first[2] = forth1/behind;
  first[1] = -first[0] - first[2];
}

static void @_road_height(const @_road *g, double x, double y, double *out) {
  const int segments = g->points - 1;
  double at[6], other[6], u[3], u1[3], v[3], v1[3], f, z = 0.0, zu = 0.0, zv = 0.0;
  int segment = @_nearest_segment(g, x, y), row, rows[3], section, sections[3], low, high, i, j;
  @_on_segment(g, segment, x, y, at);
  if (at[0] < 0.0 || at[0] > 1.0) {
    const int before = at[0] < 0.0;
    int next = segment + (before ? -1 : 1);
    if (g->closed) next = (next + segments)%segments;
    if (next >= 0 && next < segments) {
      @_on_segment(g, next, x, y, other);
      if (before ? other[0] < 1.0 : other[0] > 0.0) {
        memcpy(at, other, sizeof at);
        segment = next;
      }
    }
  }
  f = at[0] < -1.0 ? -1.0 : at[0] > 2.0 ? 2.0 : at[0];
  row = segment + (f > 0.5 ? 1 : 0);
  rows[0] = row > 0 ? row - 1 : g->closed ? g->points - 2 : 0;
  rows[1] = row;
  rows[2] = row + 1 < g->points ? row + 1 : g->closed ? 1 : g->points - 1;
  @_weights(f - (row - segment), g->along[row], 1.0, 1.0, u, u1);
  low = 0;
  high = g->across;
  while (low < high) {
    const int middle = (low + high)/2;
    if (g->v[middle] > at[1])
      high = middle;
    else
      low = middle + 1;
  }
  section = low - 1 < 0 ? 0 : low - 1 > g->across - 1 ? g->across - 1 : low - 1;
  if (section + 1 < g->across && at[1] - g->v[section] > g->v[section + 1] - at[1]) ++section;
  sections[0] = section > 0 ? section - 1 : 0;
  sections[1] = section;
  sections[2] = section + 1 < g->across ? section + 1 : g->across - 1;
  @_weights(at[1] - g->v[section], g->sideways[section],
            section > 0 ? g->v[section] - g->v[section - 1] : HUGE_VAL,
            section + 1 < g->across ? g->v[section + 1] - g->v[section] : HUGE_VAL, v, v1);
  for (i = 0; i < 3; ++i) {
    const double *const heights = g->height + (long)rows[i]*g->across;
    double here = 0.0, by_v = 0.0;
    for (j = 0; j < 3; ++j) {
      here += v[j]*heights[sections[j]];
      by_v += v1[j]*heights[sections[j]];
    }
    z += u[i]*here;
    zv += u[i]*by_v;
    zu += u1[i]*here;
  }
  out[0] = z;
  out[1] = zu*at[2] + zv*at[4];
  out[2] = zu*at[3] + zv*at[5];
}
#endif
)c";

}  // namespace mimbre::portable
