#include "portable/texts.h"

/// Functions and roads that are looked up, by hand in C99: what math/function_pieces.cpp,
/// math/function_integral.h and roads/ do.
namespace mimbre::portable {

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

const char* const formulas_text = R"c(
typedef double (*@_formula)(double x);

/* Gauss-Legendre with ten points. */
static double @_quadrature(@_formula f, double a, double b) {
  static const double nodes[] = {0.1488743389816312, 0.4333953941292472, 0.6794095682990244, 0.8650633666889845,
                                 0.9739065285171717};
  static const double weights[] = {0.2955242247147529, 0.2692667193099963, 0.2190863625159820, 0.1494513491505806,
                                   0.0666713443086881};
  const double half = 0.5*(b - a), middle = a + half;
  double sum = 0.0;
  int i;
  for (i = 0; i < 5; ++i) sum += weights[i]*(f(middle - nodes[i]*half) + f(middle + nodes[i]*half));
  return half*sum;
}

/* From 0 to x: values up to the edges of panels are known, and panels of mean width lie behind the last. */
static double @_integral_of_formula(const double *edges, const double *values, int last, @_formula f, double x) {
  const double end = edges[last];
  double sum = 0.0, panels;
  int low = 0, high = last, k, n;
  if (!(x >= 0.0)) {
    for (k = 0; k < 8; ++k) sum += @_quadrature(f, k*(x/8.0), (k + 1)*(x/8.0));
    return sum;
  }
  if (x <= end) {
    while (low < high) {
      const int middle = (low + high + 1)/2;
      if (x >= edges[middle])
        low = middle;
      else
        high = middle - 1;
    }
    return values[low] + (x > edges[low] ? @_quadrature(f, edges[low], x) : 0.0);
  }
  panels = end > 0.0 ? ceil((x - end)/end*last) : 8.0;
  n = panels < 1.0 ? 1 : panels > 10000.0 ? 10000 : (int)panels;
  sum = values[last];
  for (k = 0; k < n; ++k) sum += @_quadrature(f, end + (x - end)*k/n, end + (x - end)*(k + 1)/n);
  return sum;
}
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

const char* const meshes_text = R"c(
/* Triangles: corners, normals of these, and a tree of boxes, low and high. */
typedef struct {
  const double *vertex, *normal, *box;
  const int *triangle, *neighbour, *node;
} @_mesh;

static double @_dot3(const double *a, const double *b) { return a[0]*b[0] + a[1]*b[1] + a[2]*b[2]; }

static void @_normalise(double *x) {
  const double length = sqrt(@_dot3(x, x));
  int k;
  if (length > 0.0)
    for (k = 0; k < 3; ++k) x[k] /= length;
}

static double @_box_distance(const @_mesh *m, int node, const double *p) {
  const double *const low = m->box + 6*(long)node, *const high = low + 3;
  double sum = 0.0;
  int k;
  for (k = 0; k < 3; ++k) {
    const double below = low[k] - p[k], above = p[k] - high[k], d = below > above ? below : above;
    if (d > 0.0) sum += d*d;
  }
  return sum;
}

static void @_face_normal(const @_mesh *m, int triangle, double *n) {
  const int *const t = m->triangle + 3*(long)triangle;
  const double *const a = m->vertex + 3*(long)t[0], *const b = m->vertex + 3*(long)t[1], *const c = m->vertex + 3*(long)t[2];
  double u[3], v[3];
  int k;
  for (k = 0; k < 3; ++k) {
    u[k] = b[k] - a[k];
    v[k] = c[k] - a[k];
  }
  n[0] = u[1]*v[2] - u[2]*v[1];
  n[1] = u[2]*v[0] - u[0]*v[2];
  n[2] = u[0]*v[1] - u[1]*v[0];
  @_normalise(n);
}

/* The point of a triangle nearest to p; where it lies: 0 to 2 a corner, 3 to 5 the edge from there, 6 the face. */
static int @_nearest_in_triangle(const @_mesh *m, int triangle, const double *p, double *out) {
  const int *const t = m->triangle + 3*(long)triangle;
  const double *const a = m->vertex + 3*(long)t[0], *const b = m->vertex + 3*(long)t[1], *const c = m->vertex + 3*(long)t[2];
  double ab[3], ac[3], ap[3], bp[3], cp[3], d1, d2, d3, d4, d5, d6, of_a, of_b, of_c, v = 0.0, w = 0.0;
  int k, where = 6;
  for (k = 0; k < 3; ++k) {
    ab[k] = b[k] - a[k];
    ac[k] = c[k] - a[k];
    ap[k] = p[k] - a[k];
    bp[k] = p[k] - b[k];
    cp[k] = p[k] - c[k];
  }
  d1 = @_dot3(ab, ap);
  d2 = @_dot3(ac, ap);
  d3 = @_dot3(ab, bp);
  d4 = @_dot3(ac, bp);
  d5 = @_dot3(ab, cp);
  d6 = @_dot3(ac, cp);
  of_c = d1*d4 - d3*d2;
  of_b = d5*d2 - d1*d6;
  of_a = d3*d6 - d5*d4;
  if (d1 <= 0.0 && d2 <= 0.0)
    where = 0;
  else if (d3 >= 0.0 && d4 <= d3)
    where = 1;
  else if (d6 >= 0.0 && d5 <= d6)
    where = 2;
  else if (of_c <= 0.0 && d1 >= 0.0 && d3 <= 0.0)
    where = 3;
  else if (of_a <= 0.0 && d4 >= d3 && d5 >= d6)
    where = 4;
  else if (of_b <= 0.0 && d2 >= 0.0 && d6 <= 0.0)
    where = 5;
  if (where < 3) {
    const double *const corner = m->vertex + 3*(long)t[where];
    for (k = 0; k < 3; ++k) out[k] = corner[k];
    return where;
  }
  if (where == 4) {
    v = (d4 - d3)/((d4 - d3) + (d5 - d6));
    for (k = 0; k < 3; ++k) out[k] = b[k] + v*(c[k] - b[k]);
    return where;
  }
  if (where == 3) v = d1/(d1 - d3);
  if (where == 5) w = d2/(d2 - d6);
  if (where == 6) {
    const double all = of_a + of_b + of_c;
    v = of_b/all;
    w = of_c/all;
  }
  for (k = 0; k < 3; ++k) out[k] = a[k] + v*ab[k] + w*ac[k];
  return where;
}

/* The distance of a point, negative inside, and the normal there. */
static void @_touch(const @_mesh *m, double x, double y, double z, double *out) {
  const double p[3] = {x, y, z};
  int waiting[64], count = 0, triangle = 0, where = 6, k, i;
  double least = HUGE_VAL, found[3], point[3], n[3], away[3], length, side;
  const int *t;
  for (k = 0; k < 3; ++k) found[k] = p[k];
  waiting[count++] = 0;
  while (count > 0) {
    const int node = waiting[--count], first = m->node[2*(long)node], of = m->node[2*(long)node + 1];
    if (@_box_distance(m, node, p) >= least) continue;
    if (of == 0) {
      const int swap = @_box_distance(m, first, p) < @_box_distance(m, first + 1, p);
      waiting[count++] = first + (swap ? 1 : 0);
      waiting[count++] = first + (swap ? 0 : 1);
      continue;
    }
    for (i = first; i < first + of; ++i) {
      const int at = @_nearest_in_triangle(m, i, p, point);
      double square = 0.0;
      for (k = 0; k < 3; ++k) square += (p[k] - point[k])*(p[k] - point[k]);
      if (square >= least) continue;
      least = square;
      for (k = 0; k < 3; ++k) found[k] = point[k];
      triangle = i;
      where = at;
    }
  }
  t = m->triangle + 3*(long)triangle;
  @_face_normal(m, triangle, n);
  if (where < 3) {
    for (k = 0; k < 3; ++k) n[k] = m->normal[3*(long)t[where] + k];
    @_normalise(n);
  } else if (where < 6) {
    const int other = m->neighbour[3*(long)triangle + where - 3];
    if (other >= 0) {
      double next[3];
      @_face_normal(m, other, next);
      for (k = 0; k < 3; ++k) n[k] += next[k];
      @_normalise(n);
    }
  }
  for (k = 0; k < 3; ++k) away[k] = p[k] - found[k];
  length = sqrt(least);
  side = @_dot3(away, n) < 0.0 ? -1.0 : 1.0;
  out[0] = side*length;
  for (k = 0; k < 3; ++k) out[1 + k] = where == 6 || !(length > 0.0) ? n[k] : side/length*away[k];
}
)c";

const char* const table_of_two_text = R"c(
/* The last line that has another behind it and is not after x, or the first. */
static int @_cell(const double *lines, int count, double x) {
  int k = 0;
  while (k + 2 < count && x >= lines[k + 1]) ++k;
  return k;
}
/* Bilinear, with the slopes: lines in x, in y, and values by rows of x. */
static void @_table_of_two(const double *x, int nx, int ny, double at_x, double at_y, double *out) {
  const double *const y = x + nx;
  const int i = @_cell(x, nx, at_x), j = @_cell(y, ny, at_y);
  const double *const low = y + ny + (long)i*ny + j, *const high = low + ny;
  const double width = x[i + 1] - x[i], height = y[j + 1] - y[j];
  const double s = (at_x - x[i])/width, t = (at_y - y[j])/height;
  const double at_low = low[0] + t*(low[1] - low[0]), at_high = high[0] + t*(high[1] - high[0]);
  out[0] = at_low + s*(at_high - at_low);
  out[1] = (at_high - at_low)/width;
  out[2] = ((1.0 - s)*(low[1] - low[0]) + s*(high[1] - high[0]))/height;
}
)c";

const char* const noise_text = R"c(
static unsigned long long @_mixed(unsigned long long x) {
  x = (x ^ (x >> 30))*0xbf58476d1ce4e5b9ull;
  x = (x ^ (x >> 27))*0x94d049bb133111ebull;
  return x ^ (x >> 31);
}
/* In (0, 1): number `place` of SplitMix64's sequence. */
static double @_uniform(unsigned long long seed, unsigned long long place) {
  const unsigned long long golden = 0x9e3779b97f4a7c15ull;
  const unsigned long long bits = @_mixed(@_mixed(seed + golden) + (place + 1ull)*golden);
  return ((double)(bits >> 11) + 0.5)/9007199254740992.0;
}
/* Of mean 0 and deviation 1, uniform or normal (Box and Muller). */
static double @_noise(unsigned long long seed, int uniform, double instant) {
  const unsigned long long place = 2ull*(unsigned long long)(long long)instant;
  const double a = @_uniform(seed, place), b = @_uniform(seed, place + 1ull);
  if (uniform) return sqrt(3.0)*(2.0*a - 1.0);
  return sqrt(-2.0*log(a))*cos(6.283185307179586*b);
}
)c";

}  // namespace mimbre::portable
