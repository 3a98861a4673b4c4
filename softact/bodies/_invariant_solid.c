/* A law of isochoric invariants in a solid.

   The law's formula(), COUNT, `used` and FAMILIES stand above, see ``softact.materials.traced``. With
   m = 1 for invariants linear in C and m = 2 for I2, the Hessian of an isochoric invariant I of the slope
   g = dI/dC is -m/3 (g B + B g) - m^2/9 I B B + m/3 I B.B, for I2 also J^(-4/3) (1 1 - 1.1); B = C^-1
   (Holzapfel, Nonlinear Solid Mechanics, 2000, ch. 6). Symmetric tensors are in the order 11, 22,
   33, 12, 13, 23. Points are taken LANES at a time, so that the compiler uses the processor's vectors. */

enum { LANES = 8, INVARIANTS = 2 + FAMILIES };

typedef double lanes_t[LANES];

#define EACH for (int p = 0; p < LANES; ++p)

static const int row[6] = {0, 1, 2, 0, 0, 1}, column[6] = {0, 1, 2, 1, 2, 2};
static const int place_of[3][3] = {{0, 3, 4}, {3, 1, 5}, {4, 5, 2}};

/* S (6) and D (6, 6), of which the entries on and above the diagonal are set, of LANES points. */
static void at_points(const double *k, const lanes_t *m, const lanes_t *c, lanes_t *s, lanes_t d[6][6])
{
    lanes_t b[6], scale, trace, value[INVARIANTS], slope[INVARIANTS][6];
    lanes_t first[COUNT], second[COUNT * COUNT];
    EACH {
        const double xx = c[0][p], yy = c[1][p], zz = c[2][p], xy = c[3][p], xz = c[4][p], yz = c[5][p];
        const double det = xx * (yy * zz - yz * yz) - xy * (xy * zz - yz * xz) + xz * (xy * yz - yy * xz);
        const double r = 1 / det;
        b[0][p] = (yy * zz - yz * yz) * r, b[1][p] = (xx * zz - xz * xz) * r, b[2][p] = (xx * yy - xy * xy) * r;
        b[3][p] = (xz * yz - xy * zz) * r, b[4][p] = (xy * yz - xz * yy) * r, b[5][p] = (xy * xz - xx * yz) * r;
        scale[p] = r;
        trace[p] = xx + yy + zz;
        value[1][p] = xx * yy + yy * zz + xx * zz - xy * xy - xz * xz - yz * yz;
    }
    EACH scale[p] = cbrt(scale[p]);
    EACH {
        value[0][p] = scale[p] * trace[p];
        value[1][p] *= scale[p] * scale[p];
    }
    for (int i = 0; i < 6; ++i)
        EACH {
            const double one = i < 3;
            slope[0][i][p] = scale[p] * one - value[0][p] * b[i][p] / 3;
            slope[1][i][p] = scale[p] * scale[p] * (trace[p] * one - c[i][p]) - 2 * value[1][p] * b[i][p] / 3;
        }
    for (int f = 0; f < FAMILIES; ++f) {
        const lanes_t *of = m + 6 * f;
        EACH value[2 + f][p] = scale[p] * (of[0][p] * c[0][p] + of[1][p] * c[1][p] + of[2][p] * c[2][p]
                                           + 2 * (of[3][p] * c[3][p] + of[4][p] * c[4][p] + of[5][p] * c[5][p]));
        for (int i = 0; i < 6; ++i)
            EACH slope[2 + f][i][p] = scale[p] * of[i][p] - value[2 + f][p] * b[i][p] / 3;
    }
    EACH {
        double at[INVARIANTS], w, one[COUNT], two[COUNT * COUNT];
        for (int n = 0; n < INVARIANTS; ++n)
            at[n] = value[n][p];
        formula(k, at, &w, one, two);
        for (int a = 0; a < COUNT; ++a)
            first[a][p] = 2 * one[a];
        for (int a = 0; a < COUNT * COUNT; ++a)
            second[a][p] = 4 * two[a];
    }
    lanes_t round = {0}, half = {0}, side[6], fourth = {0};
    for (int i = 0; i < 6; ++i)
        EACH s[i][p] = side[i][p] = 0;
    for (int a = 0; a < COUNT; ++a) {
        const double order = used[a] == 1 ? 2 : 1;
        EACH {
            const double weight = order * first[a][p] * value[used[a]][p];
            round[p] += 2 * weight / 3;
            half[p] += order * weight / 9;
        }
        for (int i = 0; i < 6; ++i)
            EACH {
                const double along = first[a][p] * slope[used[a]][i][p];
                s[i][p] += along;
                side[i][p] += 2 * order * along / 3;
            }
        if (used[a] == 1)
            EACH fourth[p] = 2 * first[a][p] * scale[p] * scale[p];
    }
    for (int i = 0; i < 6; ++i)
        EACH side[i][p] += half[p] * b[i][p];
    for (int i = 0; i < 6; ++i)
        for (int j = i; j < 6; ++j) {
            const lanes_t *b0 = b + place_of[row[i]][row[j]], *b1 = b + place_of[column[i]][column[j]];
            const lanes_t *b2 = b + place_of[row[i]][column[j]], *b3 = b + place_of[column[i]][row[j]];
            const double ones = (i < 3 && j < 3 && i != j) - 0.5 * (i >= 3 && i == j);
            EACH d[i][j][p] = round[p] * 0.5 * ((*b0)[p] * (*b1)[p] + (*b2)[p] * (*b3)[p]) + ones * fourth[p]
                              - side[i][p] * b[j][p] - b[i][p] * side[j][p];
            for (int a = 0; a < COUNT; ++a)
                for (int e = 0; e < COUNT; ++e)
                    EACH d[i][j][p] += second[a * COUNT + e][p] * slope[used[a]][i][p] * slope[used[e]][j][p];
        }
}

/* S = 2 dW/dC (count, 6) and D = 4 d2W/dCdC (count, 6, 6) at C (count, 6); fibres: (count, FAMILIES,
   3) unit vectors. */
void solid_response(int64_t count, const double *c, const double *fibres, const double *k, double *stress,
                    double *moduli)
{
    for (int64_t start = 0; start < count; start += LANES) {
        lanes_t here[6], m[6 * FAMILIES + 1], s[6], d[6][6];
        const int64_t left = count - start;
        EACH {
            const int64_t n = start + (p < left ? p : 0); /* what is left over is done again */
            for (int i = 0; i < 6; ++i)
                here[i][p] = c[6 * n + i];
            for (int f = 0; f < FAMILIES; ++f) {
                const double *a = fibres + 3 * (n * FAMILIES + f);
                for (int i = 0; i < 6; ++i)
                    m[6 * f + i][p] = a[row[i]] * a[column[i]];
            }
        }
        at_points(k, m, here, s, d);
        for (int p = 0; p < LANES && p < left; ++p) {
            double *to = stress + 6 * (start + p), *on = moduli + 36 * (start + p);
            for (int i = 0; i < 6; ++i) {
                to[i] = s[i][p];
                on[7 * i] = d[i][i][p];
                for (int j = i + 1; j < 6; ++j)
                    on[6 * i + j] = on[6 * j + i] = d[i][j][p];
            }
        }
    }
}
