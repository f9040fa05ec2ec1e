/* The planar equations of models/kernel/planar.py written by hand in C, with libm: a yardstick for the kernel's speed.

   The same state (position, pitch, velocities, works, extensions), the same law and table, the same fixed-step RK4 with
   segments at the schedule's steps. The arrays are the kernel's own records, read in place. */
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
  const Body *body;
  const Part *parts;
  int64_t n_parts;
  const double *volume_law; /* rows of 5 */
  const double *commands;   /* rows of 3 */
  const double *table;      /* rows of `columns` */
  int64_t table_rows, columns;
  const int64_t *lookup;
  int64_t n_lookup;
} Params;

enum { X, Z, THETA, U, W, Q, WORK_ACTUATORS, WORK_WATER, EXTENSIONS, MAX = 8 + 64 };

static void law(double alpha, const Params *p, double *lift, double *drag, double *moment) {
  int64_t bucket = (int64_t)((alpha + M_PI) * p->body->lookup_scale);
  if (bucket < 0) bucket = 0;
  if (bucket > p->n_lookup - 1) bucket = p->n_lookup - 1;
  int64_t k = p->lookup[bucket];
  if (alpha >= p->table[(k + 1) * p->columns]) k++;
  if (k > p->table_rows - 2) k = p->table_rows - 2;
  const double *row = p->table + k * p->columns;
  int64_t n = (p->columns - 1) / 3;
  double s = alpha - row[0], L = 0, D = 0, M = 0;
  if (n == 4) {
    *lift = row[1] + s * (row[2] + s * (row[3] + s * row[4]));
    *drag = row[5] + s * (row[6] + s * (row[7] + s * row[8]));
    *moment = row[9] + s * (row[10] + s * (row[11] + s * row[12]));
    return;
  }
  for (int64_t j = n; j > 0; j--) {
    L = L * s + row[j];
    D = D * s + row[n + j];
    M = M * s + row[2 * n + j];
  }
  *lift = L, *drag = D, *moment = M;
}

static void volume_and_slope(const Part *part, double e, const Params *p, double *V, double *slope) {
  int64_t k = part->law_start, last = part->law_start + part->law_count - 1;
  while (k < last && e >= p->volume_law[5 * (k + 1)]) k++;
  const double *row = p->volume_law + 5 * k;
  double h = e - row[0];
  *V = row[1] + h * (row[2] + h * (row[3] + h * row[4]));
  *slope = row[2] + h * (2.0 * row[3] + h * 3.0 * row[4]);
}

static void derivative(const double *y, const Params *p, const double *rates, double *dy) {
  const Body *b = p->body;
  double u = y[U], w = y[W], q = y[Q], s = sin(y[THETA]), c = cos(y[THETA]);
  double mass_x = b->mass_x, mass_z = b->mass_z, inertia = b->inertia_yy;
  double volume = b->volume, volume_x = b->volume_x, volume_z = b->volume_z;
  double power = 0.0;
  for (int64_t i = 0; i < p->n_parts; i++) {
    const Part *part = p->parts + i;
    double e = y[EXTENSIONS + i], travel = e - part->neutral, V, slope;
    volume_and_slope(part, e, p, &V, &slope);
    double xm = part->moving_x + travel * part->axis_x, zm = part->moving_z + travel * part->axis_z;
    mass_x += part->moving_mass * xm;
    mass_z += part->moving_mass * zm;
    inertia += part->moving_mass * (xm * xm + zm * zm);
    double growth = 0.5 * part->grows * travel * (V - part->core_volume);
    volume += V;
    volume_x += V * part->x + growth * part->axis_x;
    volume_z += V * part->z + growth * part->axis_z;
    double swelling = 0.5 * part->grows * (travel * slope + V - part->core_volume);
    double net_x = part->moving_mass * part->axis_x - b->density * (slope * part->x + swelling * part->axis_x);
    double net_z = part->moving_mass * part->axis_z - b->density * (slope * part->z + swelling * part->axis_z);
    double potential = b->gravity * (b->density * slope * y[Z] + s * net_x - c * net_z);
    double along = part->axis_x * xm + part->axis_z * zm;
    double kinetic = part->moving_mass * q * (u * part->axis_z - w * part->axis_x + q * along);
    dy[EXTENSIONS + i] = rates[i];
    power += rates[i] * (potential + kinetic);
  }
  double v2 = u * u + w * w, per_speed = 1.0 / (sqrt(v2) + 1e-300), ca = u * per_speed, sa = w * per_speed;
  double lift, drag, moment;
  law(atan2(w, u), p, &lift, &drag, &moment);
  double scale = b->force_scale * v2;
  lift *= scale, drag *= scale;
  double Xh = -drag * ca + lift * sa, Zh = -drag * sa - lift * ca;
  moment = moment * scale + b->reference_z * Xh - b->reference_x * Zh;
  moment -= b->munk_in_table * ((b->a33 - b->a11) * u * w + b->a13 * (u * u - w * w));
  double Xw = Xh - b->d11 * u, Zw = Zh - b->d33 * w, Mw = moment - b->d55 * q;
  double heaviness = b->gravity * (b->mass - b->density * volume);
  double arm_x = mass_x - b->density * volume_x, arm_z = mass_z - b->density * volume_z;
  double m11 = b->mass + b->a11, m33 = b->mass + b->a33, m15 = mass_z + b->a15, m35 = b->a35 - mass_x;
  double Px = m11 * u + b->a13 * w + m15 * q, Pz = b->a13 * u + m33 * w + m35 * q;
  double r1 = Xw - s * heaviness - q * Pz, r2 = Zw + c * heaviness + q * Px;
  double r3 = Mw - b->gravity * (arm_z * s + arm_x * c) - (w * Px - u * Pz);
  double per_m11 = 1.0 / m11, f12 = b->a13 * per_m11, f13 = m15 * per_m11;
  double per_s22 = 1.0 / (m33 - f12 * b->a13), s23 = m35 - f12 * m15, f23 = s23 * per_s22;
  double s33 = inertia + b->a55 - f13 * m15, y2 = r2 - f12 * r1;
  double per_s33 = 1.0 / (s33 - f23 * s23), dq = (r3 - f13 * r1 - f23 * y2) * per_s33, dw = (y2 - s23 * dq) * per_s22;
  dy[X] = c * u + s * w;
  dy[Z] = -s * u + c * w;
  dy[THETA] = q;
  dy[U] = (r1 - b->a13 * dw - m15 * dq) * per_m11;
  dy[W] = dw;
  dy[Q] = dq;
  dy[WORK_ACTUATORS] = power;
  dy[WORK_WATER] = u * Xw + w * Zw + q * Mw;
}

/* Advance y by `steps` steps of h, saving every `every`-th state into `states`; rates are the extensions' in this segment. */
int64_t rk4(double *y, const Params *p, const double *rates, double h, int64_t steps, int64_t every, double *states) {
  double k1[MAX], k2[MAX], k3[MAX], k4[MAX], t[MAX];
  int64_t n = EXTENSIONS + p->n_parts, saved = 0;
  for (int64_t step = 0; step < steps; step++) {
    if (step % every == 0) memcpy(states + n * saved++, y, n * sizeof(double));
    derivative(y, p, rates, k1);
    for (int64_t j = 0; j < n; j++) t[j] = y[j] + 0.5 * h * k1[j];
    derivative(t, p, rates, k2);
    for (int64_t j = 0; j < n; j++) t[j] = y[j] + 0.5 * h * k2[j];
    derivative(t, p, rates, k3);
    for (int64_t j = 0; j < n; j++) t[j] = y[j] + h * k3[j];
    derivative(t, p, rates, k4);
    for (int64_t j = 0; j < n; j++) y[j] += h / 6.0 * (k1[j] + 2.0 * (k2[j] + k3[j]) + k4[j]);
  }
  return saved;
}
