/* The spatial equations of models/kernel/spatial*.py written by hand in C, with libm: a yardstick for the kernel's speed.

   The same state (position, quaternion, velocities, works, extensions, energies spent), the same stratified water and
   current, table over the angle of attack with lateral coefficients, cells at their own depth, full added mass and block
   solve; the same fixed-step RK4 with segments at the schedule's corners. The arrays are the kernel's own records, read
   in place. Moving masses, the other two sources of force and buoyancy that fades are left out. */
#include <math.h>
#include <stdint.h>
#include <string.h>

typedef struct {
  double gravity, density, bed_depth, mass, mass_x, mass_z, inertia_yy, volume, volume_x, volume_z;
  double a11, a13, a15, a33, a35, a55, munk_in_table, d11, d33, d55, force_scale, reference_x, reference_z, lookup_scale;
} Body;

typedef struct {
  double axis_x, axis_z, neutral, stop_low, stop_high, rate, inverse_lag, moving_mass, moving_x, moving_z;
  double x, z, core_volume, grows;
  int64_t law_start, law_count, command_start, command_count;
} Part;

typedef struct {
  double gravity, surface_level, rearm_level, bed_depth, bed_stiffness, bed_damping, mass, mass_x, mass_y, mass_z;
  double ixx, iyy, izz, ixy, ixz, iyz, water_top, per_spacing, per_reference_density;
  double reference_x, reference_y, reference_z, munk_plane, munk_lateral, munk_whole, rate_none, rate_speed, rate_speed2;
  int64_t spatial, depth, work, extensions, surface_ends, bed_ends, source, levels;
} Space;

typedef struct {
  double axis_x, axis_y, axis_z, moving_mass, base_x, base_y, base_z, perp_x, perp_y, perp_z, cross_x, cross_y, cross_z;
  double x, y, z, per_bulk, half_height, per_efficiency, recovery, moves, rolls;
} Member;

typedef struct {
  const Body *body;
  const Part *parts;
  int64_t n_parts;
  const double *volume_law; /* rows of 5 */
  const double *commands;   /* rows of 3 */
  const double *table;      /* rows of 13: cubics */
  int64_t table_rows;
  const int64_t *lookup;
  int64_t n_lookup;
  const Space *space;
  const Member *members;
  const double *solids; /* rows of 6 */
  int64_t n_solids;
  const double *added, *damping; /* 6 x 6 */
  const double *rates;           /* 6 x 3 */
  const double *lateral;
  const double *water; /* rows of 6 */
  int64_t n_water;
  const double *current; /* rows of 9 */
  const double *current_times;
  int64_t n_current_times;
} Params;

typedef struct {
  double target, slope, start;
} Drive;

typedef struct {
  double x, y, z;
} Vec;

enum { X, Y, Z, Q0, Q1, Q2, Q3, U, V, W, P, Q, R, WORK_ACTUATORS, WORK_WATER, WORK_BED, EXTENSIONS, MAX = 16 + 2 * 64 };

static inline Vec cross(Vec a, Vec b) {
  return (Vec){a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}
static inline Vec add(Vec a, Vec b) { return (Vec){a.x + b.x, a.y + b.y, a.z + b.z}; }
static inline Vec sub(Vec a, Vec b) { return (Vec){a.x - b.x, a.y - b.y, a.z - b.z}; }
static inline Vec scaled(double s, Vec a) { return (Vec){s * a.x, s * a.y, s * a.z}; }
static inline double dot(Vec a, Vec b) { return a.x * b.x + a.y * b.y + a.z * b.z; }
static inline double positive(double x) { return x > 0.0 ? x : 0.0; }

static inline void times6(const double *A, Vec v, Vec w, Vec *force, Vec *moment) {
  double out[6];
  for (int i = 0; i < 6; i++, A += 6)
    out[i] = A[0] * v.x + A[1] * v.y + A[2] * v.z + A[3] * w.x + A[4] * w.y + A[5] * w.z;
  *force = (Vec){out[0], out[1], out[2]};
  *moment = (Vec){out[3], out[4], out[5]};
}

static inline void water_at(double z, const Params *p, double *density, double *pressure) {
  const Space *s = p->space;
  int64_t k = (int64_t)floor((z - s->water_top) * s->per_spacing) + 1;
  if (k < 0) k = 0;
  if (k > p->n_water - 1) k = p->n_water - 1;
  const double *row = p->water + 6 * k;
  double h = z - row[0];
  *density = row[1] + h * (row[2] + h * (row[3] + h * row[4]));
  *pressure = row[5] + s->gravity * h * (row[1] + h * (0.5 * row[2] + h * (row[3] / 3.0 + h * 0.25 * row[4])));
}

static inline void current_row(const double *c, double z, double *value, double *slope) {
  double h = z - c[0];
  value[0] = c[1] + h * (c[2] + h * (c[3] + h * c[4]));
  value[1] = c[5] + h * (c[6] + h * (c[7] + h * c[8]));
  slope[0] = c[2] + h * (2.0 * c[3] + h * 3.0 * c[4]);
  slope[1] = c[6] + h * (2.0 * c[7] + h * 3.0 * c[8]);
}

/* The current north and east, its change with depth and with time. */
static inline void current_at(double z, double t, const Params *p, double *value, double *slope, double *change) {
  int64_t last = p->n_current_times - 1, j = 0, levels = p->space->levels;
  while (j < last && t >= p->current_times[j + 1]) j++;
  int64_t low = 0, high = levels;
  while (high - low > 1) {
    int64_t middle = (low + high) / 2;
    if (p->current[9 * (j * levels + middle)] <= z) low = middle;
    else high = middle;
  }
  const double *row = p->current + 9 * (j * levels + low);
  current_row(row, z, value, slope);
  change[0] = change[1] = 0.0;
  if (j == last || t < p->current_times[0]) return;
  double value1[2], slope1[2], per_time = 1.0 / (p->current_times[j + 1] - p->current_times[j]);
  double share = (t - p->current_times[j]) * per_time;
  current_row(row + 9 * levels, z, value1, slope1);
  for (int i = 0; i < 2; i++) {
    change[i] = (value1[i] - value[i]) * per_time;
    value[i] += share * (value1[i] - value[i]);
    slope[i] += share * (slope1[i] - slope[i]);
  }
}

static inline void law(double alpha, const Params *p, double *lift, double *drag, double *moment) {
  int64_t bucket = (int64_t)((alpha + M_PI) * p->body->lookup_scale);
  if (bucket < 0) bucket = 0;
  if (bucket > p->n_lookup - 1) bucket = p->n_lookup - 1;
  int64_t k = p->lookup[bucket];
  if (alpha >= p->table[13 * (k + 1)]) k++;
  if (k > p->table_rows - 2) k = p->table_rows - 2;
  const double *row = p->table + 13 * k;
  double s = alpha - row[0];
  *lift = row[1] + s * (row[2] + s * (row[3] + s * row[4]));
  *drag = row[5] + s * (row[6] + s * (row[7] + s * row[8]));
  *moment = row[9] + s * (row[10] + s * (row[11] + s * row[12]));
}

/* Force and moment of the source, relieved of the Munk moment that it holds. */
static inline void source(Vec v, Vec w, double density, const Params *p, Vec *force, Vec *moment) {
  const Space *b = p->space;
  const double *A = p->added, *c = p->lateral, *r = p->rates;
  double in_plane = v.x * v.x + v.z * v.z, v2 = in_plane + v.y * v.y, speed = sqrt(v2);
  double per_chord = 1.0 / (sqrt(in_plane) + 1e-300), ca = v.x * per_chord, sa = v.z * per_chord;
  double lift, drag, pitching;
  law(atan2(v.z, v.x), p, &lift, &drag, &pitching);
  double across = speed * v.y, crossed = fabs(v.y) * v.y;
  double x = (lift * sa - drag * ca) * in_plane, z = -(drag * sa + lift * ca) * in_plane;
  double turning = b->rate_none + b->rate_speed * speed + b->rate_speed2 * v2;
  double wx = turning * w.x, wy = turning * w.y, wz = turning * w.z, share = density * b->per_reference_density;
  double f[6] = {
      x, c[0] * across + c[1] * crossed, z, c[2] * across + c[3] * crossed,
      pitching * in_plane + b->reference_z * x - b->reference_x * z, c[4] * across + c[5] * crossed,
  };
  for (int i = 0; i < 6; i++) f[i] = share * (f[i] + r[3 * i] * wx + r[3 * i + 1] * wy + r[3 * i + 2] * wz);
  Vec momentum = {
      A[0] * v.x + A[1] * v.y + A[2] * v.z, A[6] * v.x + A[7] * v.y + A[8] * v.z,
      A[12] * v.x + A[13] * v.y + A[14] * v.z,
  };
  Vec munk = cross(v, momentum);
  double plane = v.z * (A[0] * v.x + A[2] * v.z) - v.x * (A[12] * v.x + A[14] * v.z);
  double lateral = b->munk_whole + b->munk_lateral;
  *force = (Vec){f[0], f[1], f[2]};
  *moment = (Vec){
      f[3] + lateral * munk.x, f[4] + b->munk_whole * munk.y + b->munk_plane * plane, f[5] + lateral * munk.z};
}

static inline void volume_and_slope(const Part *part, double e, const Params *p, double *V_, double *slope) {
  int64_t k = part->law_start, last = part->law_start + part->law_count - 1;
  while (k < last && e >= p->volume_law[5 * (k + 1)]) k++;
  const double *row = p->volume_law + 5 * k;
  double h = e - row[0];
  *V_ = row[1] + h * (row[2] + h * (row[3] + h * row[4]));
  *slope = row[2] + h * (2.0 * row[3] + h * 3.0 * row[4]);
}

/* Displaced mass and its first moment; the rates of extensions and of energy spent, and the power of the actuators. */
static inline double buoyancy(double t, const double *y, const Params *p, const Drive *drive, Vec k, double *dy,
                              double *mass, Vec *moment) {
  double B = 0.0, power = 0.0;
  Vec M = {0.0, 0.0, 0.0};
  for (int64_t i = 0; i < p->n_solids; i++) {
    const double *row = p->solids + 6 * i;
    Vec r = {row[1], row[2], row[3]};
    double density, head;
    water_at(y[Z] + dot(k, r), p, &density, &head);
    double share = density * row[0] * (1.0 - positive(head) * row[4]);
    B += share;
    M = add(M, scaled(share, r));
  }
  for (int64_t i = 0; i < p->n_parts; i++) {
    const Part *part = p->parts + i;
    const Member *m = p->members + i;
    double e = y[EXTENSIONS + i], travel = e - part->neutral, volume, slope, density, head;
    volume_and_slope(part, e, p, &volume, &slope);
    double per_volume = volume > 0.0 ? 1.0 / volume : 0.0, stack = (volume - part->core_volume) * per_volume;
    double shift = 0.5 * part->grows * travel * stack;
    Vec axis = {m->axis_x, m->axis_y, m->axis_z}, r = {m->x, m->y, m->z};
    r = add(r, scaled(shift, axis));
    water_at(y[Z] + dot(k, r), p, &density, &head);
    double pressed = positive(head), squeezed = pressed * m->per_bulk;
    double share = density * volume * (1.0 - squeezed);
    B += share;
    M = add(M, scaled(share, r));
    double rate = (drive[i].target + drive[i].slope * (t - drive[i].start) - e) * part->inverse_lag;
    rate = rate > part->rate ? part->rate : rate < -part->rate ? -part->rate : rate;
    double moves = 0.5 * part->grows * (stack + travel * slope * part->core_volume * per_volume * per_volume);
    double potential = slope * (head - 0.5 * squeezed * pressed);
    potential += share * p->space->gravity * moves * dot(k, axis);
    double work = rate * slope * pressed * (1.0 - squeezed);
    power += rate * potential;
    dy[EXTENSIONS + i] = rate;
    dy[EXTENSIONS + p->n_parts + i] = work * (work > 0.0 ? m->per_efficiency : m->recovery);
  }
  *mass = B, *moment = M;
  return power;
}

typedef struct {
  double xx, yy, zz, xy, xz, yz;
} Sym;

static inline Vec times_sym(Sym s, Vec v) {
  return (Vec){
      s.xx * v.x + s.xy * v.y + s.xz * v.z, s.xy * v.x + s.yy * v.y + s.yz * v.z, s.xz * v.x + s.yz * v.y + s.zz * v.z};
}

static inline Sym inverse(Sym m) {
  double xx = m.yy * m.zz - m.yz * m.yz, yy = m.xx * m.zz - m.xz * m.xz, zz = m.xx * m.yy - m.xy * m.xy;
  double xy = m.xz * m.yz - m.xy * m.zz, xz = m.xy * m.yz - m.xz * m.yy, yz = m.xy * m.xz - m.xx * m.yz;
  double d = 1.0 / (m.xx * xx + m.xy * xy + m.xz * xz);
  return (Sym){d * xx, d * yy, d * zz, d * xy, d * xz, d * yz};
}

static inline Vec solve3(Sym m, Vec r) {
  double per_m11 = 1.0 / m.xx, f12 = m.xy * per_m11, f13 = m.xz * per_m11;
  double per_s22 = 1.0 / (m.yy - f12 * m.xy), s23 = m.yz - f12 * m.xz, f23 = s23 * per_s22, y2 = r.y - f12 * r.x;
  double per_s33 = 1.0 / (m.zz - f13 * m.xz - f23 * s23), x3 = (r.z - f13 * r.x - f23 * y2) * per_s33;
  double x2 = (y2 - s23 * x3) * per_s22;
  return (Vec){(r.x - m.xy * x2 - m.xz * x3) * per_m11, x2, x3};
}

/* Solve (M_RB + M_A) nu' = forces by blocks: the linear part first, then its Schur complement. */
static inline void solve6(double m, Vec S, Sym I, const double *A, Vec f, Vec g, Vec *dv, Vec *dw) {
  Sym inv = inverse((Sym){m + A[0], m + A[7], m + A[14], A[1], A[2], A[8]});
  Vec b1 = {A[3], A[9] - S.z, A[15] + S.y}; /* columns of the upper right block */
  Vec b2 = {A[4] + S.z, A[10], A[16] - S.x};
  Vec b3 = {A[5] - S.y, A[11] + S.x, A[17]};
  Vec c1 = times_sym(inv, b1), c2 = times_sym(inv, b2), c3 = times_sym(inv, b3), a = times_sym(inv, f);
  Sym schur = {
      I.xx + A[21] - dot(b1, c1), I.yy + A[28] - dot(b2, c2), I.zz + A[35] - dot(b3, c3),
      I.xy + A[22] - dot(b1, c2), I.xz + A[23] - dot(b1, c3), I.yz + A[29] - dot(b2, c3),
  };
  Vec w = solve3(schur, (Vec){g.x - dot(b1, a), g.y - dot(b2, a), g.z - dot(b3, a)});
  *dw = w;
  *dv = sub(a, add(add(scaled(w.x, c1), scaled(w.y, c2)), scaled(w.z, c3)));
}

static void derivative(double t, const double *y, const Params *p, const Drive *drive, double *dy) {
  const Space *s = p->space;
  const double *A = p->added;
  Vec v = {y[U], y[V], y[W]}, w = {y[P], y[Q], y[R]};
  double q0 = y[Q0], q1 = y[Q1], q2 = y[Q2], q3 = y[Q3];
  double n = 2.0 / (q0 * q0 + q1 * q1 + q2 * q2 + q3 * q3), a = n * q1, b = n * q2, c = n * q3;
  Vec north = {1.0 - (q2 * b + q3 * c), q1 * b - q0 * c, q1 * c + q0 * b}; /* rows of R, body to world */
  Vec east = {q1 * b + q0 * c, 1.0 - (q1 * a + q3 * c), q2 * c - q0 * a};
  Vec k = {q1 * c - q0 * b, q2 * c + q0 * a, 1.0 - (q1 * a + q2 * b)};
  double sink = dot(k, v), flow[2], shear[2], change[2];
  current_at(y[Z], t, p, flow, shear, change);
  Vec vc = add(scaled(flow[0], north), scaled(flow[1], east));
  Vec sheared = add(scaled(shear[0] * sink, north), scaled(shear[1] * sink, east));
  Vec changed = add(scaled(change[0], north), scaled(change[1], east));
  Vec vr = sub(v, vc);

  double B, density, pressure;
  Vec M, F, G, D, E;
  double power = buoyancy(t, y, p, drive, k, dy, &B, &M);
  water_at(y[Z], p, &density, &pressure);
  source(vr, w, density, p, &F, &G);
  times6(p->damping, vr, w, &D, &E);
  F = add(sub(F, D), scaled(B, changed));
  G = add(sub(G, E), cross(M, changed));

  double depth = y[Z] - s->bed_depth, bed = 0.0;
  if (s->bed_ends == 0 && depth > 0.0)
    bed = positive(s->bed_stiffness * depth + s->bed_damping * sink * depth / (depth + 1e-3));
  Vec S = {s->mass_x, s->mass_y, s->mass_z};
  Sym I = {s->ixx, s->iyy, s->izz, s->ixy, s->ixz, s->iyz};
  Vec weight = scaled(s->gravity * (s->mass - B) - bed, k), righting = cross(sub(S, M), scaled(s->gravity, k));

  Vec linear = add(scaled(s->mass, v), cross(w, S)), angular = add(times_sym(I, w), cross(S, v)), Pa, La;
  times6(A, vr, w, &Pa, &La);
  Vec f = sub(add(F, weight), cross(w, add(linear, Pa)));
  Vec g = sub(add(G, righting), cross(w, add(angular, La)));
  g = sub(g, add(cross(v, linear), cross(vr, Pa)));
  Vec water = sub(add(sheared, changed), cross(w, vc)), carried, turned;
  times6(A, water, (Vec){0.0, 0.0, 0.0}, &carried, &turned);
  Vec dv, dw;
  solve6(s->mass, S, I, A, add(f, carried), add(g, turned), &dv, &dw);

  dy[X] = dot(north, v), dy[Y] = dot(east, v), dy[Z] = sink;
  dy[Q0] = 0.5 * (-q1 * w.x - q2 * w.y - q3 * w.z);
  dy[Q1] = 0.5 * (q0 * w.x + q2 * w.z - q3 * w.y);
  dy[Q2] = 0.5 * (q0 * w.y + q3 * w.x - q1 * w.z);
  dy[Q3] = 0.5 * (q0 * w.z + q1 * w.y - q2 * w.x);
  dy[U] = dv.x, dy[V] = dv.y, dy[W] = dv.z, dy[P] = dw.x, dy[Q] = dw.y, dy[R] = dw.z;
  Vec inertial, unused;
  times6(A, sub(dv, water), dw, &inertial, &unused);
  dy[WORK_ACTUATORS] = power;
  dy[WORK_WATER] = dot(v, F) + dot(w, G) - dot(vc, add(inertial, cross(w, Pa)));
  dy[WORK_BED] = -bed * sink;
}

/* Advance y from t by `steps` steps of h within one segment, in which each command is one line; save every `every`-th
   state into `states`. */
int64_t rk4(double *y, const Params *p, double t, double h, int64_t steps, int64_t every, double *states) {
  double k1[MAX], k2[MAX], k3[MAX], k4[MAX], temporary[MAX];
  Drive drive[64];
  int64_t n = EXTENSIONS + 2 * p->n_parts, saved = 0;
  for (int64_t i = 0; i < p->n_parts; i++) {
    int64_t row = p->parts[i].command_start, end = row + p->parts[i].command_count;
    while (row + 1 < end && p->commands[3 * (row + 1)] <= t + 1e-12 * fmax(1.0, t)) row++;
    const double *command = p->commands + 3 * row;
    drive[i] = (Drive){command[1] + command[2] * (t - command[0]), command[2], t};
  }
  double start = t;
  for (int64_t step = 0; step < steps; step++, t = start + step * h) {
    if (step % every == 0) memcpy(states + n * saved++, y, n * sizeof(double));
    derivative(t, y, p, drive, k1);
    for (int64_t j = 0; j < n; j++) temporary[j] = y[j] + 0.5 * h * k1[j];
    derivative(t + 0.5 * h, temporary, p, drive, k2);
    for (int64_t j = 0; j < n; j++) temporary[j] = y[j] + 0.5 * h * k2[j];
    derivative(t + 0.5 * h, temporary, p, drive, k3);
    for (int64_t j = 0; j < n; j++) temporary[j] = y[j] + h * k3[j];
    derivative(t + h, temporary, p, drive, k4);
    for (int64_t j = 0; j < n; j++) y[j] += h / 6.0 * (k1[j] + 2.0 * (k2[j] + k3[j]) + k4[j]);
    double per_length = 1.0 / sqrt(y[Q0] * y[Q0] + y[Q1] * y[Q1] + y[Q2] * y[Q2] + y[Q3] * y[Q3]);
    for (int64_t j = Q0; j <= Q3; j++) y[j] *= per_length;
  }
  return saved;
}
