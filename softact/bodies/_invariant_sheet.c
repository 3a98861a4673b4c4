/* A law of invariants in a sheet of constant volume, with fine wrinkles or without.

   The law's formula(), COUNT, `used` and FAMILIES stand above, see ``softact.materials.traced``, and
   so do MOST_ITERATIONS, TOLERANCE, FLOOR, ROUNDING and NOISE of ``materials.tension_field``. In
   the sheet's plane C33 = g = 1/det C, and all invariants are isochoric: Ī1 = tr C + g, Ī2 = 1/g + g
   tr C, Ī4 = M : C. Symmetric tensors are in the order 11, 22, 12. */

enum { TAUT, WRINKLED, SLACK };

/* W, S = 2 dW/dC and D = 4 d2W/dCdC at C; not numbers where det C <= 0. */
static void at_point(const double *k, const double *fibres, const double c[3], double *w, double s[3],
                     double d[3][3])
{
    const double one[3] = {1, 1, 0}, trace = c[0] + c[1], det = c[0] * c[1] - c[2] * c[2];
    const double g = det > 0 ? 1 / det : NAN;
    const double b[3] = {c[1] * g, c[0] * g, -c[2] * g}; /* the inverse of C */
    const double square[3][3] = {{b[0] * b[0], b[2] * b[2], b[0] * b[2]},
                                 {b[2] * b[2], b[1] * b[1], b[1] * b[2]},
                                 {b[0] * b[2], b[1] * b[2], (b[0] * b[1] + b[2] * b[2]) / 2}};
    double invariants[2 + FAMILIES], slopes[2 + FAMILIES][3], first[COUNT], second[COUNT * COUNT];
    invariants[0] = trace + g;
    invariants[1] = det + g * trace;
    for (int i = 0; i < 3; ++i) {
        slopes[0][i] = one[i] - g * b[i];
        slopes[1][i] = (det - g * trace) * b[i] + g * one[i];
    }
    for (int f = 0; f < FAMILIES; ++f) {
        const double *m = fibres + 3 * f;
        invariants[2 + f] = m[0] * c[0] + m[1] * c[1] + 2 * m[2] * c[2];
        for (int i = 0; i < 3; ++i)
            slopes[2 + f][i] = m[i];
    }
    formula(k, invariants, w, first, second);
    for (int i = 0; i < 3; ++i) {
        s[i] = 0;
        for (int a = 0; a < COUNT; ++a)
            s[i] += 2 * first[a] * slopes[used[a]][i];
        for (int j = 0; j < 3; ++j) {
            const double both = b[i] * b[j];
            double sum = 0;
            for (int a = 0; a < COUNT; ++a) {
                for (int e = 0; e < COUNT; ++e)
                    sum += second[a * COUNT + e] * slopes[used[a]][i] * slopes[used[e]][j];
                if (used[a] == 0)
                    sum += first[a] * g * (both + square[i][j]);
                if (used[a] == 1)
                    sum += first[a] * (det * (both - square[i][j]) + g * trace * (both + square[i][j])
                                       - g * (b[i] * one[j] + one[i] * b[j]));
            }
            d[i][j] = 4 * sum;
        }
    }
}

static void principal(const double s[3], double *low, double *high)
{
    const double mean = (s[0] + s[1]) / 2, radius = hypot((s[0] - s[1]) / 2, s[2]);
    *low = mean - radius, *high = mean + radius;
}

static int state_of(const double c[3], const double s[3])
{
    double low, high, least, most;
    principal(s, &low, &high);
    principal(c, &least, &most);
    return low >= 0 ? TAUT : most <= 1 ? SLACK : WRINKLED;
}

/* Wrinkles along the smaller principal stretch that take up to its natural width. */
static void first_guess(const double c[3], double poisson, double a[2])
{
    double low, high;
    principal(c, &low, &high);
    const double angle = atan2(c[2], (c[0] - c[1]) / 2) / 2; /* of the larger one */
    const double size = sqrt(fmax(pow(high, -poisson) - low, 1e-8));
    a[0] = -sin(angle) * size, a[1] = cos(angle) * size;
}

/* The energy of least a in C + a a: W, S and condensed D there, as ``TensionField`` finds it. */
static void relax(const double *k, const double *fibres, const double c[3], double poisson, double *w,
                  double s[3], double d[3][3])
{
    double a[2], best = INFINITY, step[2] = {0, 0}, coupling[3][2], hessian[3], inverse[3];
    first_guess(c, poisson, a);
    for (int iteration = 0; iteration < MOST_ITERATIONS; ++iteration) {
        const double here[3] = {c[0] + a[0] * a[0], c[1] + a[1] * a[1], c[2] + a[0] * a[1]};
        at_point(k, fibres, here, w, s, d);
        const double out[2] = {s[0] * a[0] + s[2] * a[1], s[2] * a[0] + s[1] * a[1]};
        for (int i = 0; i < 3; ++i) { /* dS/da */
            coupling[i][0] = d[i][0] * a[0] + d[i][2] * a[1];
            coupling[i][1] = d[i][2] * a[0] + d[i][1] * a[1];
        }
        hessian[0] = s[0] + a[0] * coupling[0][0] + a[1] * coupling[2][0];
        hessian[1] = s[1] + a[0] * coupling[2][1] + a[1] * coupling[1][1];
        hessian[2] = s[2] + a[0] * coupling[0][1] + a[1] * coupling[2][1];
        const double det = hessian[0] * hessian[1] - hessian[2] * hessian[2];
        const double factor = det == 0 ? 0 : 1 / det; /* there a = 0, and nothing is coupled */
        inverse[0] = hessian[1] * factor, inverse[1] = hessian[0] * factor;
        inverse[2] = -hessian[2] * factor;
        const double across = hypot(out[0], out[1]) / hypot(a[0], a[1]);
        const double largest = fmax(fabs(s[0]), fmax(fabs(s[1]), fabs(s[2])));
        /* Half of the last step back where the energy rose; along the gradient where it is not
           convex, as it is not near a = 0. */
        const int worse = !(*w <= best * (1 + ROUNDING) + NOISE * d[0][0]);
        if (worse) {
            step[0] /= 2, step[1] /= 2;
        } else {
            best = *w;
            for (int i = 0; i < 2; ++i)
                step[i] = det > 0 ? -(inverse[i] * out[i] + inverse[2] * out[1 - i])
                                  : -out[i] / fmax(across, 1e-300);
        }
        /* Without an energy at its first guess a point has none anywhere. */
        if (across <= TOLERANCE * largest + FLOOR * d[0][0] || !isfinite(best))
            break;
        for (int i = 0; i < 2; ++i)
            a[i] += worse ? -step[i] : step[i];
    }
    for (int i = 0; i < 3; ++i)
        for (int j = 0; j < 3; ++j)
            d[i][j] -= coupling[i][0] * (inverse[0] * coupling[j][0] + inverse[2] * coupling[j][1])
                     + coupling[i][1] * (inverse[2] * coupling[j][0] + inverse[1] * coupling[j][1]);
}

/* Energy (count), stress (count, 3) and moduli (count, 3, 3) at C (count, 2, 2). fibres: (count,
   FAMILIES, 3) M of each; kept: part of the unrelaxed energy that is kept, 1 without wrinkles. */
void sheet_response(int64_t count, const double *c, const double *fibres, const double *k,
                    double poisson, double kept, double *energy, double *stress, double *moduli)
{
    for (int64_t p = 0; p < count; ++p, c += 4, fibres += 3 * FAMILIES, stress += 3, moduli += 9) {
        const double here[3] = {c[0], c[3], c[1]};
        double w, s[3], d[3][3], part = 1, rest = 0, relaxed_w = 0, relaxed_s[3] = {0};
        double relaxed_d[3][3] = {{0}};
        at_point(k, fibres, here, &w, s, d);
        const int state = kept < 1 ? state_of(here, s) : TAUT;
        if (state != TAUT)
            part = kept;
        if (state == WRINKLED) {
            rest = 1 - kept;
            relax(k, fibres, here, poisson, &relaxed_w, relaxed_s, relaxed_d);
        }
        energy[p] = part * w + rest * relaxed_w;
        for (int i = 0; i < 3; ++i) {
            stress[i] = part * s[i] + rest * relaxed_s[i];
            for (int j = 0; j < 3; ++j)
                moduli[3 * i + j] = part * d[i][j] + rest * relaxed_d[i][j];
        }
    }
}

/* TAUT, WRINKLED or SLACK (count). */
void sheet_states(int64_t count, const double *c, const double *fibres, const double *k,
                  int64_t *states)
{
    for (int64_t p = 0; p < count; ++p, c += 4, fibres += 3 * FAMILIES) {
        const double here[3] = {c[0], c[3], c[1]};
        double w, s[3], d[3][3];
        at_point(k, fibres, here, &w, s, d);
        states[p] = state_of(here, s);
    }
}
