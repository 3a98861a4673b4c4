/* A law of isochoric principal stretches in a solid.

   The law's formula() stands above, see ``softact.materials.traced``: with f(e) of the logarithm e of an
   isochoric stretch, f', f'' and f'''. Stress and moduli are formed in the principal axes (Simo and
   Taylor, CMAME 85:273, 1991) and turned back, as in ``materials.stretches``; principal values and axes
   are found as in ``materials.eigen``, exact where values are equal. Symmetric tensors are in the order 11,
   22, 33, 12, 13, 23. */

static const int row[6] = {0, 1, 2, 0, 0, 1}, column[6] = {0, 1, 2, 1, 2, 2};

static double dot(const double *a, const double *b) { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]; }

static void apply(const double *t, const double *x, double *out)
{
    out[0] = t[0] * x[0] + t[3] * x[1] + t[4] * x[2];
    out[1] = t[3] * x[0] + t[1] * x[1] + t[5] * x[2];
    out[2] = t[4] * x[0] + t[5] * x[1] + t[2] * x[2];
}

/* Of a traceless tensor, the principal value that is farthest from the other two. */
static double simple_value(const double *t)
{
    const double a = t[0], b = t[1], c = t[2], d = t[3], e = t[4], f = t[5];
    const double norm = (a * a + b * b + c * c + 2 * (d * d + e * e + f * f)) / 6;
    const double det = a * (b * c - f * f) - d * (d * c - f * e) + e * (d * f - b * e), p = sqrt(norm);
    const double ratio = fmin(fmax(0.5 * det / (p == 0 ? 1 : p * norm), -1), 1);
    return (ratio < 0 ? -2 : 2) * p * cos(acos(fabs(ratio)) / 3);
}

/* Unit vector normal to the rows of t - value 1: the largest of their cross products. */
static void simple_axis(const double *t, double value, double *out)
{
    const double a = t[0] - value, b = t[1] - value, c = t[2] - value, d = t[3], e = t[4], f = t[5];
    const double xx = b * c - f * f, yy = a * c - e * e, zz = a * b - d * d;
    const double xy = e * f - d * c, xz = d * f - e * b, yz = d * e - a * f;
    const double p = fabs(xx), q = fabs(yy), r = fabs(zz);
    if (p >= q && p >= r)
        out[0] = xx, out[1] = xy, out[2] = xz;
    else if (q >= r)
        out[0] = xy, out[1] = yy, out[2] = yz;
    else
        out[0] = xz, out[1] = yz, out[2] = zz;
    const double length = sqrt(dot(out, out));
    if (length == 0)
        out[0] = 1, out[1] = out[2] = 0;
    else
        for (int i = 0; i < 3; ++i)
            out[i] /= length;
}

/* Principal values (3) and unit axes (3, 3) of a symmetric tensor. */
static void principal(const double *c, double *values, double axes[3][3])
{
    const double mean = (c[0] + c[1] + c[2]) / 3;
    double t[6] = {c[0] - mean, c[1] - mean, c[2] - mean, c[3], c[4], c[5]}, scale = 0;
    for (int i = 0; i < 6; ++i)
        scale = fmax(scale, fabs(t[i]));
    for (int i = 0; i < 6; ++i)
        t[i] /= scale == 0 ? 1 : scale;
    double *axis = axes[0], along[3], across[3];
    simple_axis(t, simple_value(t), axis);
    /* Two unit vectors across it (Duff et al. 2017), turned by the small angle of Jacobi's. */
    const double sign = axis[2] < 0 ? -1 : 1, a = -1 / (sign + axis[2]), b = axis[0] * axis[1] * a;
    const double u[3] = {1 + sign * axis[0] * axis[0] * a, sign * b, -sign * axis[0]};
    const double v[3] = {b, sign + axis[1] * axis[1] * a, -axis[1]};
    apply(t, u, along);
    apply(t, v, across);
    const double uu = dot(u, along), uv = dot(u, across), vv = dot(v, across);
    const double difference = 0.5 * (vv - uu), root = hypot(difference, uv);
    const double tangent = root == 0 ? 0 : uv / (difference + (difference < 0 ? -root : root));
    const double cosine = 1 / sqrt(1 + tangent * tangent), sine = tangent * cosine;
    for (int i = 0; i < 3; ++i) {
        axes[1][i] = cosine * u[i] - sine * v[i];
        axes[2][i] = sine * u[i] + cosine * v[i];
    }
    apply(t, axis, along);
    values[0] = mean + scale * dot(axis, along);
    values[1] = mean + scale * (uu - tangent * uv);
    values[2] = mean + scale * (vv + tangent * uv);
}

/* S (6) and D (6, 6) at C (6). */
static void at_point(const double *k, const double *c, double *stress, double *moduli)
{
    static const int one[3] = {0, 0, 1}, other[3] = {1, 2, 2};
    double squares[3], axes[3][3], logs[3], t[3], s[3], r[3], beta[3], inverse[3];
    principal(c, squares, axes);
    double mean = 0, mean_t = 0, mean_s = 0;
    for (int i = 0; i < 3; ++i)
        logs[i] = 0.5 * log(squares[i]), mean += logs[i] / 3, inverse[i] = 1 / squares[i];
    for (int i = 0; i < 3; ++i) {
        logs[i] -= mean;
        formula(k, logs[i], t + i, s + i, r + i);
        mean_t += t[i] / 3, mean_s += s[i] / 9;
    }
    double normal[3][3], shear[3], n[6][6], left[6][6];
    for (int i = 0; i < 3; ++i)
        beta[i] = t[i] - mean_t;
    for (int i = 0; i < 3; ++i)
        for (int j = i; j < 3; ++j) {
            const double gamma = mean_s - (s[i] + s[j]) / 3 + (i == j ? s[i] - 2 * beta[i] : 0);
            normal[i][j] = normal[j][i] = gamma * inverse[i] * inverse[j];
        }
    for (int p = 0; p < 3; ++p) {
        const int i = one[p], j = other[p];
        const double step = logs[i] - logs[j];
        /* Hermite's rule for the mean of f'' between two stretches that are near each other. */
        const double rise = fabs(step) < NEAR ? 0.5 * (s[i] + s[j]) - (r[i] - r[j]) * step / 12
                                              : (t[i] - t[j]) / step;
        const double slope = step == 0 ? 1 : 2 * step / expm1(2 * step);
        shear[p] = (rise * slope * 0.5 * inverse[j] - beta[j] * inverse[j]) * inverse[i];
    }
    for (int a = 0; a < 6; ++a)
        for (int p = 0; p < 3; ++p) {
            const double *v = axes[p], *x = axes[one[p]], *y = axes[other[p]];
            n[p][a] = v[row[a]] * v[column[a]];
            n[3 + p][a] = x[row[a]] * y[column[a]] + x[column[a]] * y[row[a]];
        }
    for (int a = 0; a < 6; ++a) {
        stress[a] = beta[0] * inverse[0] * n[0][a] + beta[1] * inverse[1] * n[1][a] + beta[2] * inverse[2] * n[2][a];
        for (int p = 0; p < 3; ++p) {
            left[p][a] = normal[p][0] * n[0][a] + normal[p][1] * n[1][a] + normal[p][2] * n[2][a];
            left[3 + p][a] = shear[p] * n[3 + p][a];
        }
    }
    for (int a = 0; a < 6; ++a)
        for (int b = a; b < 6; ++b) {
            double sum = 0;
            for (int p = 0; p < 6; ++p)
                sum += left[p][a] * n[p][b];
            moduli[6 * a + b] = moduli[6 * b + a] = sum;
        }
}

/* S = 2 dW/dC (count, 6) and D = 4 d2W/dCdC (count, 6, 6) at C (count, 6); no fibres. */
void solid_response(int64_t count, const double *c, const double *fibres, const double *k, double *stress,
                    double *moduli)
{
    (void)fibres;
    for (int64_t n = 0; n < count; ++n)
        at_point(k, c + 6 * n, stress + 6 * n, moduli + 36 * n);
}
