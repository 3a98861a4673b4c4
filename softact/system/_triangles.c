/* Loops over linear and quadratic triangles in space: membranes, and the air between them.

   Each loop is written for n nodes and compiled for 3 and for 6 of them, so that the compiler knows
   how long the inner ones are. */

#include <math.h>
#include <stdint.h>
#include <string.h>

enum { RULE = 3 }; /* points of a membrane's rule */

/* slopes: (count, RULE, 2, nodes) derivatives of the shape functions along the frames; weights:
   (count, RULE) areas of the points, mm^2; places: (count, nodes, 3) mm; frames: (count, RULE, 3, 2)
   F where nothing has moved, and F is that and the derivative of the displacements, or null, and F
   is the derivative of the places; dofs: (count, nodes, 3) local unknowns. */
typedef struct {
    int64_t count;
    int32_t nodes;
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
        for (int q = 0; q < RULE; ++q, slopes += 2 * n, f += 6, c += 4) {
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

/* F (count, RULE, 3, 2) and C = F^T F (count, RULE, 2, 2) at the unknowns x. */
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
        for (int q = 0; q < RULE; ++q, slopes += 2 * n, f += 6, s += 3, ++weight)
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

/* Add the nodal forces of S (count, RULE, 3) to out (local). */
void membrane_force(const triangles_t *on, const double *f, const double *s, double *out)
{
    FOR_NODES(force_of, on, f, s, out);
}

INLINE void tangent_of(const int n, const triangles_t *on, const double *f, const double *moduli,
                       const double *carried, double *matrices)
{
    enum { FEW = 4, MOST = 20 }; /* rows are filled up to whole vectors */
    const int width = (3 * n + FEW - 1) / FEW * FEW;
    const double *slopes = on->slopes, *weight = on->weights;
    double rates[3 * RULE][3 * n], left[3 * RULE][MOST] = {{0}}, geometric[n][n];
    for (int64_t e = 0; e < on->count; ++e) {
        memset(geometric, 0, sizeof geometric);
        for (int q = 0; q < RULE; ++q, slopes += 2 * n, f += 6, moduli += 9, carried += 3, ++weight) {
            const double *one = slopes, *two = slopes + n, w = *weight;
            double(*rate)[3 * n] = rates + 3 * q, (*push)[MOST] = left + 3 * q;
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
        for (int a = 0; a < 3 * n; ++a, matrices += 3 * n) {
            double row[MOST] = {0};
            for (int i = 0; i < 3 * RULE; ++i)
                for (int b = 0; b < width; ++b)
                    row[b] += rates[i][a] * left[i][b];
            for (int l = 0; l < n; ++l)
                row[3 * l + a % 3] += geometric[a / 3][l];
            memcpy(matrices, row, 3 * n * sizeof(double));
        }
    }
}

/* Matrices (count, nodes, 3, nodes, 3) of the moduli D (count, RULE, 3, 3), and of the carried
   stress (count, RULE, 3) as geometric stiffness. */
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
void green_states(int64_t count, const double *c, double poisson, int64_t *states)
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

/* What a triangle adds to a cavity is V = sum_a sum_p T_ap (W x_a) . (x_b x x_c) over the pairs p of
   nodes b < c. Places x_b and x_c count from its first node: V does not change where they are shifted.

   table: T (nodes, pairs); first: its sum over a; flux: the diagonal of W. */
typedef struct {
    const double *table, *first, *flux;
} volume_t;

enum { PAIRS = 15 }; /* of six nodes; of three there are the first three */
static const int one_of[PAIRS] = {0, 0, 1, 0, 1, 2, 0, 1, 2, 3, 0, 1, 2, 3, 4};
static const int other_of[PAIRS] = {1, 2, 2, 3, 3, 3, 4, 4, 4, 4, 5, 5, 5, 5, 5};

/* Places from the first node in `here`, and the vectors A_p = sum_a T_ap W x_a in `areas`. */
INLINE void areas_of(const int n, const volume_t *of, const double *place, const int32_t *dof,
                     const double *x, double here[n][3], double areas[3][PAIRS])
{
    const int pairs = n * (n - 1) / 2;
    double corner[3];
    for (int d = 0; d < 3; ++d)
        corner[d] = place[d] + x[dof[d]];
    for (int a = 0; a < n; ++a)
        for (int d = 0; d < 3; ++d)
            here[a][d] = place[3 * a + d] + x[dof[3 * a + d]] - corner[d];
    for (int d = 0; d < 3; ++d) {
        double area[PAIRS];
        for (int p = 0; p < pairs; ++p)
            area[p] = of->flux[d] * corner[d] * of->first[p];
        for (int a = 1; a < n; ++a)
            for (int p = 0; p < pairs; ++p)
                area[p] += of->flux[d] * here[a][d] * of->table[a * pairs + p];
        memcpy(areas[d], area, sizeof area);
    }
}

/* x_b x x_c of all pairs. */
INLINE void normals_of(const int n, const double here[n][3], double normals[3][PAIRS])
{
    for (int p = 0; p < n * (n - 1) / 2; ++p) {
        double normal[3];
        cross(here[one_of[p]], here[other_of[p]], normal);
        for (int d = 0; d < 3; ++d)
            normals[d][p] = normal[d];
    }
}

INLINE void volume_of(const int n, const triangles_t *on, const volume_t *of, const double *x, double *out)
{
    double here[n][3], areas[3][PAIRS], normals[3][PAIRS], sum = 0.0;
    for (int64_t e = 0; e < on->count; ++e) {
        areas_of(n, of, on->places + 3 * n * e, on->dofs + 3 * n * e, x, here, areas);
        normals_of(n, here, normals);
        for (int d = 0; d < 3; ++d)
            for (int p = 0; p < n * (n - 1) / 2; ++p)
                sum += areas[d][p] * normals[d][p];
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
    const int pairs = n * (n - 1) / 2;
    double here[n][3], areas[3][PAIRS], normals[3][PAIRS], force[n][3];
    for (int64_t e = 0; e < on->count; ++e) {
        const int32_t *dof = on->dofs + 3 * n * e;
        areas_of(n, of, on->places + 3 * n * e, dof, x, here, areas);
        normals_of(n, here, normals);
        for (int a = 0; a < n; ++a)
            for (int d = 0; d < 3; ++d) {
                double sum = 0.0;
                for (int p = 0; p < pairs; ++p)
                    sum += of->table[a * pairs + p] * normals[d][p];
                force[a][d] = of->flux[d] * sum;
            }
        for (int p = 0; p < pairs; ++p) {
            const double area[3] = {areas[0][p], areas[1][p], areas[2][p]};
            double by_one[3], by_other[3];
            cross(here[other_of[p]], area, by_one);
            cross(area, here[one_of[p]], by_other);
            for (int d = 0; d < 3; ++d) {
                force[one_of[p]][d] += by_one[d];
                force[other_of[p]][d] += by_other[d];
            }
        }
        for (int a = 0; a < n; ++a)
            for (int d = 0; d < 3; ++d)
                out[dof[3 * a + d]] += factor * force[a][d];
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
    const int pairs = n * (n - 1) / 2;
    double here[n][3], areas[3][PAIRS], both[3][n][n], turns[3][n][n];
    memset(both, 0, sizeof both);
    for (int64_t e = 0; e < on->count; ++e, matrices += 9 * n * n) {
        areas_of(n, of, on->places + 3 * n * e, on->dofs + 3 * n * e, x, here, areas);
        memset(turns, 0, sizeof turns);
        for (int d = 0; d < 3; ++d)
            for (int p = 0; p < pairs; ++p) {
                const int b = one_of[p], c = other_of[p];
                both[d][b][c] = areas[d][p];
                both[d][c][b] = -areas[d][p];
                for (int a = 0; a < n; ++a) { /* sum_c T_abc x_c */
                    turns[d][b][a] += of->table[a * pairs + p] * here[c][d];
                    turns[d][c][a] -= of->table[a * pairs + p] * here[b][d];
                }
            }
        /* Of a node a and its component i, the second derivative with component j of node b, where
           i, j and d are 0, 1, 2 in turn. */
        memset(matrices, 0, 9 * n * n * sizeof(double));
        for (int d = 0; d < 3; ++d) {
            const int i = (d + 1) % 3, j = (d + 2) % 3;
            for (int a = 0; a < n; ++a)
                for (int b = 0; b < n; ++b) {
                    const double value = factor * (both[d][a][b] + of->flux[i] * turns[d][b][a]
                                                   - of->flux[j] * turns[d][a][b]);
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
