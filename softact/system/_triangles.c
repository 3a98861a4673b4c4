/* Loops over linear and quadratic triangles in space: membranes, and the air between them.

   Each loop is written for n nodes and compiled for 3 and for 6 of them, so that the compiler knows
   how long the inner ones are. Points of a triangle are those of a rule of at most RULE points. */

#include <math.h>
#include <stdint.h>
#include <string.h>

enum { RULE = 6 };

/* slopes: (count, rule, 2, nodes) derivatives of the shape functions along the frames; weights:
   (count, rule) areas of the points, mm^2; places: (count, nodes, 3) mm; frames: (count, rule, 3, 2)
   F where nothing has moved, and F is that and the derivative of the displacements, or null, and F
   is the derivative of the places; dofs: (count, nodes, 3) local unknowns. */
typedef struct {
    int64_t count;
    int32_t nodes, rule;
    const double *slopes, *weights, *places, *frames;
    const int32_t *dofs;
} triangles_t;

#define INLINE static inline __attribute__((always_inline))

/* Call a loop for the number of nodes that the triangles have. */
#define FOR_NODES(loop, on, ...)                                                                   \
    do {                                                                                           \
        if ((on)->nodes == 6)                                                                      \
            loop(6, on, __VA_ARGS__);                                                              \
        else                                                                                       \
            loop(3, on, __VA_ARGS__);                                                              \
    } while (0)

INLINE void cross(const double *a, const double *b, double *c)
{
    c[0] = a[1] * b[2] - a[2] * b[1];
    c[1] = a[2] * b[0] - a[0] * b[2];
    c[2] = a[0] * b[1] - a[1] * b[0];
}

INLINE double dot(const double *a, const double *b) { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]; }

/* --- membrane ------------------------------------------------------------------------------- */

INLINE void strain_of(const int n, const triangles_t *on, const double *x, double *f, double *c)
{
    const int32_t *dof = on->dofs;
    const double *place = on->places, *slopes = on->slopes, *frames = on->frames;
    for (int64_t e = 0; e < on->count; ++e, dof += 3 * n, place += 3 * n) {
        double here[3 * n];
        for (int i = 0; i < 3 * n; ++i)
            here[i] = frames ? x[dof[i]] : place[i] + x[dof[i]];
        for (int q = 0; q < on->rule; ++q, slopes += 2 * n, f += 6, c += 4) {
            for (int d = 0; d < 3; ++d)
                for (int i = 0; i < 2; ++i) {
                    double sum = frames ? frames[2 * d + i] : 0.0;
                    for (int m = 0; m < n; ++m)
                        sum += here[3 * m + d] * slopes[i * n + m];
                    f[2 * d + i] = sum;
                }
            if (frames)
                frames += 6;
            c[0] = f[0] * f[0] + f[2] * f[2] + f[4] * f[4];
            c[1] = c[2] = f[0] * f[1] + f[2] * f[3] + f[4] * f[5];
            c[3] = f[1] * f[1] + f[3] * f[3] + f[5] * f[5];
        }
    }
}

/* F (count, rule, 3, 2) and C = F^T F (count, rule, 2, 2) at the unknowns x. */
void membrane_strain(const triangles_t *on, const double *x, double *f, double *c)
{
    FOR_NODES(strain_of, on, x, f, c);
}

INLINE void force_of(const int n, const triangles_t *on, const double *f, const double *s, double *out)
{
    const int32_t *dof = on->dofs;
    const double *slopes = on->slopes, *weight = on->weights;
    for (int64_t e = 0; e < on->count; ++e, dof += 3 * n) {
        double force[3][n];
        memset(force, 0, sizeof force);
        for (int q = 0; q < on->rule; ++q, slopes += 2 * n, f += 6, s += 3, ++weight)
            for (int d = 0; d < 3; ++d) {
                /* first Piola-Kirchhoff stress, times the point's area */
                const double one = *weight * (f[2 * d] * s[0] + f[2 * d + 1] * s[2]);
                const double two = *weight * (f[2 * d] * s[2] + f[2 * d + 1] * s[1]);
                for (int m = 0; m < n; ++m)
                    force[d][m] += one * slopes[m] + two * slopes[n + m];
            }
        for (int m = 0; m < n; ++m)
            for (int d = 0; d < 3; ++d)
                out[dof[3 * m + d]] += force[d][m];
    }
}

/* Add the nodal forces of S (count, rule, 3) to out (local). */
void membrane_force(const triangles_t *on, const double *f, const double *s, double *out)
{
    FOR_NODES(force_of, on, f, s, out);
}

INLINE void tangent_of(const int n, const triangles_t *on, const double *f, const double *moduli,
                       const double *carried, double *matrices)
{
    const double *slopes = on->slopes, *weight = on->weights;
    for (int64_t e = 0; e < on->count; ++e, matrices += 9 * n * n) {
        double rates[3 * RULE][3 * n], left[3 * RULE][3 * n], geometric[n][n];
        memset(geometric, 0, sizeof geometric);
        memset(matrices, 0, 9 * n * n * sizeof(double));
        for (int q = 0; q < on->rule; ++q, slopes += 2 * n, f += 6, moduli += 9, carried += 3, ++weight) {
            const double *one = slopes, *two = slopes + n, w = *weight;
            double(*rate)[3 * n] = rates + 3 * q, (*push)[3 * n] = left + 3 * q;
            for (int m = 0; m < n; ++m)
                for (int d = 0; d < 3; ++d) {
                    rate[0][3 * m + d] = one[m] * f[2 * d];
                    rate[1][3 * m + d] = two[m] * f[2 * d + 1];
                    rate[2][3 * m + d] = one[m] * f[2 * d + 1] + two[m] * f[2 * d];
                }
            for (int i = 0; i < 3; ++i)
                for (int a = 0; a < 3 * n; ++a)
                    push[i][a] = w * (moduli[3 * i] * rate[0][a] + moduli[3 * i + 1] * rate[1][a]
                                      + moduli[3 * i + 2] * rate[2][a]);
            for (int m = 0; m < n; ++m) {
                const double along = w * (carried[0] * one[m] + carried[2] * two[m]);
                const double across = w * (carried[2] * one[m] + carried[1] * two[m]);
                for (int l = 0; l < n; ++l)
                    geometric[m][l] += along * one[l] + across * two[l];
            }
        }
        for (int a = 0; a < 3 * n; ++a) {
            double *row = matrices + 3 * n * a;
            for (int i = 0; i < 3 * on->rule; ++i)
                for (int b = 0; b < 3 * n; ++b)
                    row[b] += rates[i][a] * left[i][b];
            for (int l = 0; l < n; ++l)
                row[3 * l + a % 3] += geometric[a / 3][l];
        }
    }
}

/* Matrices (count, nodes, 3, nodes, 3) of the moduli D (count, rule, 3, 3), and of the carried
   stress (count, rule, 3) as geometric stiffness. */
void membrane_tangent(const triangles_t *on, const double *f, const double *moduli,
                      const double *carried, double *matrices)
{
    FOR_NODES(tangent_of, on, f, moduli, carried, matrices);
}

/* S + D : sym(F^T (F' - F)) (count, 3): the stress at the deformation gradients `now`, linearised at
   f (count, 3, 2) with S (count, 3) and D (count, 3, 3). */
void membrane_linearised(int64_t count, const double *f, const double *now, const double *s,
                         const double *moduli, double *out)
{
    for (int64_t k = 0; k < count; ++k, f += 6, now += 6, s += 3, moduli += 9, out += 3) {
        double rate[3] = {0};
        for (int d = 0; d < 3; ++d) {
            const double one = now[2 * d] - f[2 * d], two = now[2 * d + 1] - f[2 * d + 1];
            rate[0] += f[2 * d] * one;
            rate[1] += f[2 * d + 1] * two;
            rate[2] += f[2 * d] * two + f[2 * d + 1] * one;
        }
        for (int i = 0; i < 3; ++i)
            out[i] = s[i] + dot(moduli + 3 * i, rate);
    }
}

/* --- St. Venant-Kirchhoff in plane stress, with a tension field or without -------------------- */

enum { TAUT, WRINKLED, SLACK };

/* 0 taut, 1 wrinkled, 2 slack, of principal strains. */
INLINE int state_of(double low, double high, double poisson)
{
    return low + poisson * high >= 0 ? TAUT : high > 0 ? WRINKLED : SLACK;
}

/* TAUT, WRINKLED or SLACK (count) at C (count, 2, 2). */
void green_states(int64_t count, const double *c, double poisson, double *states)
{
    for (int64_t k = 0; k < count; ++k, c += 4) {
        const double e0 = (c[0] - 1) / 2, e1 = (c[3] - 1) / 2, e2 = c[1] / 2;
        const double mean = (e0 + e1) / 2, radius = sqrt((e0 - e1) * (e0 - e1) / 4 + e2 * e2);
        states[k] = state_of(mean - radius, mean + radius, poisson);
    }
}

/* Energy (count), stress (count, 3) and moduli (count, 3, 3) of ``softact.bodies.green_sheet``. */
void green_response(int64_t count, const double *c, double young, double poisson, int32_t relaxed,
                    double kept, double *energy, double *stress, double *moduli)
{
    const double a = young / (1 - poisson * poisson), b = a * poisson, g = a * (1 - poisson) / 2;
    for (int64_t k = 0; k < count; ++k, c += 4, stress += 3, moduli += 9) {
        const double e0 = (c[0] - 1) / 2, e1 = (c[3] - 1) / 2, e2 = c[1] / 2;
        const double s0 = a * e0 + b * e1, s1 = b * e0 + a * e1, s2 = 2 * g * e2;
        const double w = (s0 * e0 + s1 * e1 + 2 * s2 * e2) / 2;
        const double mean = (e0 + e1) / 2, half = (e0 - e1) / 2, radius = sqrt(half * half + e2 * e2);
        const double high = mean + radius;
        const int state = relaxed ? state_of(mean - radius, high, poisson) : TAUT;
        const double part = state == TAUT ? 1.0 : kept, rest = state == WRINKLED ? 1.0 - kept : 0.0;
        energy[k] = part * w;
        stress[0] = part * s0, stress[1] = part * s1, stress[2] = part * s2;
        moduli[0] = moduli[4] = part * a;
        moduli[1] = moduli[3] = part * b;
        moduli[8] = part * g;
        moduli[2] = moduli[5] = moduli[6] = moduli[7] = 0.0;
        if (state != WRINKLED)
            continue;
        /* Cosine and sine of twice the angle of the first principal direction n; m is across it. */
        const double cosine = half / radius, sine = e2 / radius;
        const double along[3] = {(1 + cosine) / 2, (1 - cosine) / 2, sine / 2}; /* n n */
        const double turning[3] = {-sine, sine, cosine};                       /* n m + m n */
        const double pull = rest * young * high, turned = pull / (4 * radius);
        energy[k] += pull * high / 2;
        for (int i = 0; i < 3; ++i) {
            stress[i] += pull * along[i];
            for (int j = 0; j < 3; ++j)
                moduli[3 * i + j] += rest * young * along[i] * along[j] + turned * turning[i] * turning[j];
        }
    }
}

/* --- the air between sheets ------------------------------------------------------------------ */

/* What a triangle adds to a cavity is V = sum_a sum_(b < c) T_abc (W x_a) . (x_b x x_c). Places x_b
   and x_c count from its first node: sum_b T_abc = 0.

   table: T as (a, c, b); first: sum_a T_abc as (c, b); flux: the diagonal of W. */
typedef struct {
    const double *table, *first, *flux;
} volume_t;

/* Places from the first node in `here`, and the vectors A_bc = sum_a T_abc W x_a in `areas`. */
INLINE void areas_of(const int n, const volume_t *of, const double *place, const int32_t *dof,
                     const double *x, double here[n][3], double areas[3][n][n])
{
    double corner[3];
    for (int d = 0; d < 3; ++d)
        corner[d] = place[d] + x[dof[d]];
    for (int a = 0; a < n; ++a)
        for (int d = 0; d < 3; ++d)
            here[a][d] = place[3 * a + d] + x[dof[3 * a + d]] - corner[d];
    for (int d = 0; d < 3; ++d) {
        double *area = &areas[d][0][0];
        for (int bc = 0; bc < n * n; ++bc)
            area[bc] = of->flux[d] * corner[d] * of->first[bc];
        for (int a = 1; a < n; ++a) {
            const double along = of->flux[d] * here[a][d];
            for (int bc = 0; bc < n * n; ++bc)
                area[bc] += along * of->table[a * n * n + bc];
        }
    }
}

INLINE void volume_of(const int n, const triangles_t *on, const volume_t *of, const double *x, double *out)
{
    double here[n][3], areas[3][n][n], sum = 0.0;
    for (int64_t e = 0; e < on->count; ++e) {
        areas_of(n, of, on->places + 3 * n * e, on->dofs + 3 * n * e, x, here, areas);
        for (int b = 0; b < n; ++b)
            for (int c = b + 1; c < n; ++c) {
                double normal[3];
                cross(here[b], here[c], normal);
                for (int d = 0; d < 3; ++d)
                    sum += areas[d][c][b] * normal[d];
            }
    }
    *out += sum;
}

/* Add the volume, mm^3, to *out. */
void cavity_volume(const triangles_t *on, const volume_t *of, const double *x, double *out)
{
    FOR_NODES(volume_of, on, of, x, out);
}

INLINE void gradient_of(const int n, const triangles_t *on, const volume_t *of, const double *x,
                        double factor, double *out)
{
    double here[n][3], areas[3][n][n], force[3][n], normals[3][n][n];
    for (int64_t e = 0; e < on->count; ++e) {
        const int32_t *dof = on->dofs + 3 * n * e;
        areas_of(n, of, on->places + 3 * n * e, dof, x, here, areas);
        memset(force, 0, sizeof force);
        for (int c = 0; c < n; ++c)
            for (int b = 0; b < n; ++b)
                for (int d = 0; d < 3; ++d) {
                    const int i = (d + 1) % 3, j = (d + 2) % 3;
                    force[d][b] += here[c][i] * areas[j][c][b] - here[c][j] * areas[i][c][b];
                    normals[d][c][b] = here[b][i] * here[c][j] - here[b][j] * here[c][i];
                }
        for (int a = 0; a < n; ++a)
            for (int d = 0; d < 3; ++d) {
                double sum = 0.0;
                for (int bc = 0; bc < n * n; ++bc)
                    sum += of->table[a * n * n + bc] * (&normals[d][0][0])[bc];
                out[dof[3 * a + d]] += factor * (force[d][a] + of->flux[d] * sum / 2);
            }
    }
}

/* Add `factor` times the derivative of the volume with respect to the unknowns to out (local). */
void cavity_gradient(const triangles_t *on, const volume_t *of, const double *x, double factor,
                     double *out)
{
    FOR_NODES(gradient_of, on, of, x, factor, out);
}

INLINE void second_of(const int n, const triangles_t *on, const volume_t *of, const double *x,
                      double factor, double *matrices)
{
    double here[n][3], areas[3][n][n], turns[3][n][n];
    for (int64_t e = 0; e < on->count; ++e, matrices += 9 * n * n) {
        areas_of(n, of, on->places + 3 * n * e, on->dofs + 3 * n * e, x, here, areas);
        for (int a = 0; a < n; ++a)
            for (int d = 0; d < 3; ++d) {
                double turn[n]; /* sum_c T_abc x_c */
                memset(turn, 0, sizeof turn);
                for (int c = 1; c < n; ++c)
                    for (int b = 0; b < n; ++b)
                        turn[b] += of->table[(a * n + c) * n + b] * here[c][d];
                memcpy(turns[d][a], turn, sizeof turn);
            }
        /* Of a node b and a component i of a, the second derivative with component j of b, where i,
           j and d are 0, 1, 2 in turn: A_ab as (d, b, a), and W's of both nodes. */
        memset(matrices, 0, 9 * n * n * sizeof(double));
        for (int d = 0; d < 3; ++d) {
            const int i = (d + 1) % 3, j = (d + 2) % 3;
            for (int a = 0; a < n; ++a)
                for (int b = 0; b < n; ++b) {
                    const double value = factor * (areas[d][b][a] + of->flux[i] * turns[d][a][b]
                                                   - of->flux[j] * turns[d][b][a]);
                    matrices[((3 * a + i) * n + b) * 3 + j] = value;
                    matrices[((3 * b + j) * n + a) * 3 + i] = value;
                }
        }
    }
}

/* Matrices (count, nodes, 3, nodes, 3): `factor` times the second derivative of the volume. */
void cavity_second(const triangles_t *on, const volume_t *of, const double *x, double factor,
                   double *matrices)
{
    FOR_NODES(second_of, on, of, x, factor, matrices);
}
