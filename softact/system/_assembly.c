/* Element loops: call a kernel on each entity and add what it gives to the global arrays.

   The kernels are FFCx's (signature of ufcx_tabulate_tensor_float64). dolfinx's own loop hands
   every element matrix to MatSetValues, which searches the row for each entry; here the place of
   each entry is found once per mesh (find_pairs) and a matrix entry costs one addition. */

#include <math.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

typedef void (*kernel_t)(double *, const double *, const double *, const double *, const int *,
                         const uint8_t *);

typedef struct {
    const double *data;   /* values of the coefficient */
    const int32_t *table; /* dofs per cell, or NULL: data lie per entity, in order */
    int32_t width;        /* values per entity */
    int32_t stride;       /* row length of the table */
} coefficient_t;

typedef struct {
    int64_t count;
    const int32_t *cells;
    const int32_t *facets; /* NULL on cells */
    const int32_t *nodes;  /* that give a cell its shape: 4, or 10 of a curved one */
    const double *points;  /* 3 per node */
    int32_t shape;         /* 4 or 10 */
    const double *constants;
    int32_t coefficient_count;
    const coefficient_t *coefficients;
} entities_t;

/* Evaluate the kernel on entity e; A must hold `size` values and is cleared first. */
static void tabulate(kernel_t kernel, const entities_t *on, int64_t e, double *w, double *A,
                     size_t size)
{
    double x[30];
    const int32_t cell = on->cells[e];
    const int32_t *nodes = on->nodes + on->shape * (int64_t)cell;
    for (int v = 0; v < on->shape; ++v)
        memcpy(x + 3 * v, on->points + 3 * (int64_t)nodes[v], 3 * sizeof(double));
    double *to = w;
    for (int k = 0; k < on->coefficient_count; ++k) {
        const coefficient_t *c = on->coefficients + k;
        if (c->table) {
            const int32_t *dofs = c->table + (int64_t)cell * c->stride;
            for (int i = 0; i < c->width; ++i)
                to[i] = c->data[dofs[i]];
        } else {
            memcpy(to, c->data + e * c->width, c->width * sizeof(double));
        }
        to += c->width;
    }
    memset(A, 0, size * sizeof(double));
    const int facet = on->facets ? on->facets[e] : 0;
    const uint8_t permutation = 0;
    kernel(A, w, on->constants, x, &facet, &permutation);
}

static double *workspace(const entities_t *on, size_t size, double **A)
{
    size_t width = 1;
    for (int k = 0; k < on->coefficient_count; ++k)
        width += on->coefficients[k].width;
    double *w = malloc((width + size) * sizeof(double));
    *A = w + width;
    return w;
}

/* Sum of a rank-0 form. */
double assemble_scalar(kernel_t kernel, const entities_t *on)
{
    double *A, sum = 0.0, *w = workspace(on, 1, &A);
    for (int64_t e = 0; e < on->count; ++e) {
        tabulate(kernel, on, e, w, A, 1);
        sum += A[0];
    }
    free(w);
    return sum;
}

/* Add a rank-1 form into `out` (local numbering); `dofs` has `stride` entries per cell. */
void assemble_vector(kernel_t kernel, const entities_t *on, const int32_t *dofs, int32_t stride,
                     int32_t size, double *out)
{
    double *A, *w = workspace(on, size, &A);
    for (int64_t e = 0; e < on->count; ++e) {
        tabulate(kernel, on, e, w, A, size);
        const int32_t *row = dofs + (int64_t)on->cells[e] * stride;
        for (int i = 0; i < size; ++i)
            out[row[i]] += A[i];
    }
    free(w);
}

/* Add a rank-2 form into CSR values.

   blocks: block number of each element dof (size), component: its place in the block (size);
   base: (cells, block_count, block_count) place of the first entry of each pair of blocks;
   row_length: (cells, block_count) entries in each row of a block;
   fixed: (local dofs) 1 where rows and columns are left out (prescribed displacement). */
void assemble_matrix(kernel_t kernel, const entities_t *on, const int32_t *dofs, int32_t stride,
                     int32_t size, int32_t block_count, const int32_t *block,
                     const int32_t *component, const int32_t *base, const int32_t *row_length,
                     const uint8_t *fixed, double *values)
{
    double *A, *w = workspace(on, (size_t)size * size, &A);
    for (int64_t e = 0; e < on->count; ++e) {
        tabulate(kernel, on, e, w, A, (size_t)size * size);
        const int64_t cell = on->cells[e];
        const int32_t *row = dofs + cell * stride;
        const int32_t *pairs = base + cell * block_count * block_count;
        const int32_t *lengths = row_length + cell * block_count;
        for (int i = 0; i < size; ++i) {
            if (fixed[row[i]])
                continue;
            double *to = values + (int64_t)component[i] * lengths[block[i]];
            const int32_t *places = pairs + block[i] * block_count;
            for (int j = 0; j < size; ++j)
                if (!fixed[row[j]])
                    to[places[block[j]] + component[j]] += A[i * size + j];
        }
    }
    free(w);
}

/* Add matrices of elements beside the cells, of n nodes with three unknowns each, into CSR values.

   matrices: (count, n, 3, n, 3), or (count, n, n) where `scalar`: then of each of the three, times
   `factor`; on: numbers of the elements, or NULL for all in order; of these dofs (., n, 3), base
   (., n, n) and row_length (., n) tell, as in `assemble_matrix`. */
void add_blocks(int64_t count, int32_t n, const double *matrices, int32_t scalar, double factor,
                const int64_t *on, const int32_t *dofs, const int32_t *base,
                const int32_t *row_length, const uint8_t *fixed, double *values)
{
    const int64_t size = (scalar ? 1 : 9) * (int64_t)n * n;
    for (int64_t k = 0; k < count; ++k, matrices += size) {
        const int64_t e = on ? on[k] : k;
        const int32_t *dof = dofs + 3 * n * e, *pairs = base + n * n * e, *length = row_length + n * e;
        int all_free = 1;
        for (int a = 0; a < 3 * n; ++a)
            all_free &= !fixed[dof[a]];
        for (int a = 0; a < n; ++a)
            for (int i = 0; i < 3; ++i) {
                if (fixed[dof[3 * a + i]])
                    continue;
                double *to = values + (int64_t)i * length[a];
                const int32_t *place = pairs + a * n;
                const double *row = matrices + (scalar ? a * n : (3 * a + i) * 3 * n);
                for (int b = 0; b < n; ++b)
                    if (scalar)
                        to[place[b] + i] += fixed[dof[3 * b + i]] ? 0.0 : factor * row[b];
                    else
                        for (int j = 0; j < 3; ++j)
                            to[place[b] + j] += all_free || !fixed[dof[3 * b + j]] ? row[3 * b + j] : 0.0;
            }
    }
}

/* Place of every pair of blocks of each cell in the CSR pattern of blocks: out[cell,i,j] is the
   entry of indptr/indices (columns sorted) that couples blocks[cell,i] and blocks[cell,j]. */
void find_pairs(int64_t cells, int32_t count, const int32_t *blocks, const int32_t *indptr,
                const int32_t *indices, int32_t *out)
{
    for (int64_t c = 0; c < cells; ++c)
        for (int i = 0; i < count; ++i) {
            const int32_t row = blocks[c * count + i];
            for (int j = 0; j < count; ++j) {
                const int32_t column = blocks[c * count + j];
                int32_t low = indptr[row], high = indptr[row + 1] - 1;
                while (low < high) {
                    const int32_t middle = (low + high) / 2;
                    if (indices[middle] < column)
                        low = middle + 1;
                    else
                        high = middle;
                }
                out[(c * count + i) * count + j] = low;
            }
        }
}

/* Row and column (mapped by `number`) of each scalar entry of a pattern of blocks. */
void expand_pattern(int32_t blocks, const int32_t *indptr, const int32_t *indices,
                    const int32_t *first, const int32_t *width, const int32_t *number,
                    int32_t *rows, int32_t *columns)
{
    int64_t entry = 0;
    for (int32_t a = 0; a < blocks; ++a)
        for (int c = 0; c < width[a]; ++c)
            for (int32_t k = indptr[a]; k < indptr[a + 1]; ++k)
                for (int d = 0; d < width[indices[k]]; ++d, ++entry) {
                    rows[entry] = number[first[a] + c];
                    columns[entry] = number[first[indices[k]] + d];
                }
}

/* dX_i/dxi_j of a curved cell's own shape; g: (10, 3) reference gradients at the point. */
static void curved_map(const double *points, const int32_t *nodes, const double *g, double m[3][3])
{
    memset(m, 0, 9 * sizeof(double));
    for (int n = 0; n < 10; ++n) {
        const double *x = points + 3 * (int64_t)nodes[n];
        for (int i = 0; i < 3; ++i)
            for (int j = 0; j < 3; ++j)
                m[i][j] += x[i] * g[3 * n + j];
    }
}

/* The same of a straight cell, everywhere. */
static void straight_map(const double *points, const int32_t *nodes, double m[3][3])
{
    const double *x0 = points + 3 * (int64_t)nodes[0];
    for (int j = 0; j < 3; ++j) {
        const double *xj = points + 3 * (int64_t)nodes[j + 1];
        for (int i = 0; i < 3; ++i)
            m[i][j] = xj[i] - x0[i];
    }
}

/* k = det(m) inverse(m); returns det(m). */
static double adjugate(const double m[3][3], double k[3][3])
{
    for (int i = 0; i < 3; ++i)
        for (int j = 0; j < 3; ++j) {
            const int a = (j + 1) % 3, b = (j + 2) % 3, c = (i + 1) % 3, d = (i + 2) % 3;
            k[i][j] = m[a][c] * m[b][d] - m[a][d] * m[b][c];
        }
    return m[0][0] * k[0][0] + m[0][1] * k[1][0] + m[0][2] * k[2][0];
}

/* dV/dV_ref of the cells' own shape at points: out (count, points); see `deformation_gradient`. */
void shape_determinant(int64_t count, const int32_t *cells, const int32_t *nodes, int32_t shape,
                       const double *points, int32_t rule, const double *gradients, double *out)
{
    double m[3][3], k[3][3];
    for (int64_t e = 0; e < count; ++e) {
        const int32_t *own = nodes + shape * (int64_t)cells[e];
        for (int q = 0; q < rule; ++q) {
            if (shape == 10)
                curved_map(points, own, gradients + (int64_t)q * 30, m);
            else
                straight_map(points, own, m);
            out[e * rule + q] = adjugate(m, k);
        }
    }
}

/* Deformation gradient at the points of each cell.

   shape: 4, or 10 nodes that give a cell its shape, those of its displacement.
   gradients: (points, 10, 3) reference gradients of the shape functions (`functions` of them);
   u: local unknowns; dofs: (cells, stride), the first 3*functions entries are displacements, node
   by node; out: (count, points, 3, 3). */
void deformation_gradient(int64_t count, const int32_t *cells, const int32_t *nodes, int32_t shape,
                          const double *points, int32_t rule, int32_t functions,
                          const double *gradients, const int32_t *dofs, int32_t stride,
                          const double *u, double *out)
{
    for (int64_t e = 0; e < count; ++e) {
        const int64_t cell = cells[e];
        const int32_t *own = nodes + shape * cell;
        double m[3][3], k[3][3], det = 0.0;
        if (shape == 4) {
            straight_map(points, own, m);
            det = adjugate(m, k);
        }
        for (int q = 0; q < rule; ++q) {
            double h[3][3] = {{0}}; /* du_i/dxi_j */
            const double *g = gradients + (int64_t)q * functions * 3;
            if (shape == 10) {
                curved_map(points, own, g, m);
                det = adjugate(m, k);
            }
            for (int n = 0; n < functions; ++n)
                for (int i = 0; i < 3; ++i) {
                    const double un = u[dofs[cell * stride + 3 * n + i]];
                    for (int j = 0; j < 3; ++j)
                        h[i][j] += un * g[3 * n + j];
                }
            double *f = out + 9 * (e * rule + q);
            for (int i = 0; i < 3; ++i)
                for (int j = 0; j < 3; ++j) {
                    double sum = 0.0;
                    for (int a = 0; a < 3; ++a)
                        sum += h[i][a] * k[a][j];
                    f[3 * i + j] = sum / det + (i == j);
                }
        }
    }
}

/* Rows of the displacements of one cell's matrix, filled up to whole vectors. */
enum { NODES = 10, COLUMNS = 32, PRESSURES = 4 };

/* Add B^T (w D) B and the geometric stiffness of T to the upper triangle of blocks.

   f: F; g: (n, 3) gradients of the n shape functions. */
static void add_stiffness(int n, const double f[3][3], double g[NODES][3], double w,
                          const double *d, const double *t, double a[3 * NODES][COLUMNS])
{
    double b[6][COLUMNS] = {{0}}, db[6][COLUMNS];
    for (int k = 0; k < n; ++k)
        for (int i = 0; i < 3; ++i) {
            const int c = 3 * k + i;
            for (int v = 0; v < 3; ++v)
                b[v][c] = f[i][v] * g[k][v];
            b[3][c] = f[i][0] * g[k][1] + f[i][1] * g[k][0];
            b[4][c] = f[i][0] * g[k][2] + f[i][2] * g[k][0];
            b[5][c] = f[i][1] * g[k][2] + f[i][2] * g[k][1];
        }
    const int width = n == NODES ? COLUMNS : 16;
    for (int v = 0; v < 6; ++v) {
        const double *row = d + 6 * v;
        for (int c = 0; c < width; ++c)
            db[v][c] = w * (row[0] * b[0][c] + row[1] * b[1][c] + row[2] * b[2][c]
                            + row[3] * b[3][c] + row[4] * b[4][c] + row[5] * b[5][c]);
    }
    for (int k = 0; k < n; ++k) {
        for (int i = 0; i < 3; ++i) {
            double *restrict row = a[3 * k + i];
            const double p[6] = {b[0][3 * k + i], b[1][3 * k + i], b[2][3 * k + i],
                                 b[3][3 * k + i], b[4][3 * k + i], b[5][3 * k + i]};
            for (int c = 3 * k & ~7; c < width; ++c)
                row[c] += p[0] * db[0][c] + p[1] * db[1][c] + p[2] * db[2][c]
                        + p[3] * db[3][c] + p[4] * db[4][c] + p[5] * db[5][c];
        }
        const double *o = g[k];
        const double tg[3] = {w * (t[0] * o[0] + t[3] * o[1] + t[4] * o[2]),
                              w * (t[3] * o[0] + t[1] * o[1] + t[5] * o[2]),
                              w * (t[4] * o[0] + t[5] * o[1] + t[2] * o[2])};
        for (int l = k; l < n; ++l) {
            const double s = tg[0] * g[l][0] + tg[1] * g[l][1] + tg[2] * g[l][2];
            for (int i = 0; i < 3; ++i)
                a[3 * k + i][3 * l + i] += s;
        }
    }
}

/* Add w p times the second derivative of J = det F: of the blocks k < l, for those of one node are
   zero. */
static void add_second_of_volume(int n, const double f[3][3], double g[NODES][3], double wp,
                                 double a[3 * NODES][COLUMNS])
{
    for (int k = 0; k < n; ++k)
        for (int l = k + 1; l < n; ++l) {
            const double *p = g[k], *q = g[l];
            const double c[3] = {wp * (p[1] * q[2] - p[2] * q[1]), wp * (p[2] * q[0] - p[0] * q[2]),
                                 wp * (p[0] * q[1] - p[1] * q[0])};
            double v[3];
            for (int i = 0; i < 3; ++i)
                v[i] = f[i][0] * c[0] + f[i][1] * c[1] + f[i][2] * c[2];
            double *x = a[3 * k] + 3 * l, *y = a[3 * k + 1] + 3 * l, *z = a[3 * k + 2] + 3 * l;
            x[1] += v[2], x[2] -= v[1];
            y[0] -= v[2], y[2] += v[0];
            z[0] += v[1], z[1] -= v[0];
        }
}

/* Add the tangents of the cells of a solid into CSR values: `softact.system.forms.solid`.

   The first arguments are those of `deformation_gradient`. weights: (points) of the rule; moduli:
   (count, points, 36), symmetric; stress: (count, points, 6) of the geometric stiffness; shares:
   (points, pressures) values of the functions of the pressure, whose unknowns follow those of the
   displacement, in blocks of one; compliance, logarithmic: 1/K and beta. The rest is as in
   `assemble_matrix`. */
void solid_tangent(int64_t count, const int32_t *cells, const int32_t *nodes, int32_t shape,
                   const double *points, int32_t rule, int32_t functions, const double *gradients,
                   const int32_t *dofs, int32_t stride, const double *u, const double *weights,
                   const double *moduli, const double *stress, int32_t pressures,
                   const double *shares, double compliance, double logarithmic,
                   int32_t block_count, const int32_t *base, const int32_t *row_length,
                   const uint8_t *fixed, double *values)
{
    const int n = functions, m = pressures;
    for (int64_t e = 0; e < count; ++e) {
        const int64_t cell = cells[e];
        const int32_t *own = nodes + shape * cell, *dof = dofs + cell * stride;
        double a[3 * NODES][COLUMNS] = {{0}}; /* displacements by displacements */
        double up[PRESSURES][3 * NODES] = {{0}}, pp[PRESSURES][PRESSURES] = {{0}};
        double map[3][3], k[3][3], det = 0.0, at[NODES][3], p[PRESSURES];
        for (int c = 0; c < n; ++c)
            for (int i = 0; i < 3; ++i)
                at[c][i] = u[dof[3 * c + i]];
        for (int c = 0; c < m; ++c)
            p[c] = u[dof[3 * n + c]];
        if (shape == 4) {
            straight_map(points, own, map);
            det = adjugate(map, k);
        }
        for (int q = 0; q < rule; ++q) {
            const double *reference = gradients + (int64_t)q * n * 3;
            if (shape == 10) {
                curved_map(points, own, reference, map);
                det = adjugate(map, k);
            }
            double g[NODES][3], f[3][3] = {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
            for (int c = 0; c < n; ++c)
                for (int j = 0; j < 3; ++j) {
                    const double *r = reference + 3 * c;
                    g[c][j] = (r[0] * k[0][j] + r[1] * k[1][j] + r[2] * k[2][j]) / det;
                    for (int i = 0; i < 3; ++i)
                        f[i][j] += at[c][i] * g[c][j];
                }
            const double w = fabs(det) * weights[q];
            const int64_t point = e * rule + q;
            add_stiffness(n, f, g, w, moduli + 36 * point, stress + 6 * point, a);
            if (!m)
                continue;
            const double *share = shares + q * m;
            double cofactor[3][3], pressure = 0.0;
            adjugate(f, cofactor); /* transposed */
            for (int c = 0; c < m; ++c)
                pressure += share[c] * p[c];
            add_second_of_volume(n, f, g, w * pressure, a);
            for (int c = 0; c < n; ++c)
                for (int i = 0; i < 3; ++i) {
                    const double by = w * (cofactor[0][i] * g[c][0] + cofactor[1][i] * g[c][1]
                                           + cofactor[2][i] * g[c][2]);
                    for (int l = 0; l < m; ++l)
                        up[l][3 * c + i] += share[l] * by;
                }
            const double swelling = compliance * pressure;
            const double grows = compliance * (1 + logarithmic * swelling
                                               / sqrt(1 + logarithmic * swelling * swelling));
            for (int c = 0; c < m; ++c)
                for (int l = 0; l < m; ++l)
                    pp[c][l] -= w * grows * share[c] * share[l];
        }
        for (int b = 0; b < 3 * n; ++b)
            for (int c = 0; c < b; ++c)
                a[b][c] = a[c][b];
        int any_fixed = 0;
        for (int b = 0; b < 3 * n; ++b)
            any_fixed |= fixed[dof[b]];
        for (int b = 0; any_fixed && b < 3 * n; ++b)
            if (fixed[dof[b]]) {
                memset(a[b], 0, sizeof a[b]);
                for (int c = 0; c < 3 * n; ++c)
                    a[c][b] = 0.0;
                for (int c = 0; c < m; ++c)
                    up[c][b] = 0.0;
            }
        const int32_t *place = base + cell * block_count * block_count;
        const int32_t *length = row_length + cell * block_count;
        for (int b = 0; b < n; ++b, place += block_count) {
            const double *x = a[3 * b], *y = a[3 * b + 1], *z = a[3 * b + 2];
            for (int c = 0; c < n; ++c) {
                double *to = values + place[c];
                for (int j = 0; j < 3; ++j) {
                    to[j] += x[3 * c + j];
                    to[length[b] + j] += y[3 * c + j];
                    to[2 * length[b] + j] += z[3 * c + j];
                }
            }
            for (int c = 0; c < m; ++c)
                for (int i = 0; i < 3; ++i)
                    values[place[n + c] + i * length[b]] += up[c][3 * b + i];
        }
        for (int b = 0; b < m; ++b, place += block_count) {
            for (int c = 0; c < n; ++c)
                for (int j = 0; j < 3; ++j)
                    values[place[c] + j] += up[b][3 * c + j];
            for (int c = 0; c < m; ++c)
                values[place[n + c]] += pp[b][c];
        }
    }
}

/* Voigt's order 11, 22, 33, 12, 13, 23 in a full tensor. */
static const int place_of[3][3] = {{0, 3, 4}, {3, 1, 5}, {4, 5, 2}};

static double determinant(const double *f)
{
    return f[0] * (f[4] * f[8] - f[5] * f[7]) - f[1] * (f[3] * f[8] - f[5] * f[6])
         + f[2] * (f[3] * f[7] - f[4] * f[6]);
}

/* J (count) of deformation gradients f (count, 9). */
void jacobians(int64_t count, const double *f, double *out)
{
    for (int64_t n = 0; n < count; ++n)
        out[n] = determinant(f + 9 * n);
}

/* C = F^T F: out (count, 6). f: (count, 9). */
void right_cauchy_green(int64_t count, const double *f, double *out)
{
    for (int64_t n = 0; n < count; ++n, f += 9, out += 6)
        for (int a = 0; a < 3; ++a)
            for (int b = a; b < 3; ++b)
                out[place_of[a][b]] = f[a] * f[b] + f[3 + a] * f[3 + b] + f[6 + a] * f[6 + b];
}

/* S + D : sym(F0^T (F - F0)) in Voigt pairs: out (count, 6). f0, f: (count, 9); s: (count, 6); d:
   (count, 6, 6), of which each shear strain counts twice. */
void carried_stress(int64_t count, const double *f0, const double *f, const double *s, const double *d,
                    double *out)
{
    for (int64_t n = 0; n < count; ++n, f0 += 9, f += 9, s += 6, d += 36, out += 6) {
        double along[3][3], e[6];
        for (int a = 0; a < 3; ++a)
            for (int b = 0; b < 3; ++b)
                along[a][b] = f0[a] * (f[b] - f0[b]) + f0[3 + a] * (f[3 + b] - f0[3 + b])
                              + f0[6 + a] * (f[6 + b] - f0[6 + b]);
        for (int a = 0; a < 3; ++a)
            for (int b = a; b < 3; ++b)
                e[place_of[a][b]] = a == b ? along[a][a] : along[a][b] + along[b][a];
        for (int a = 0; a < 6; ++a) {
            double sum = s[a];
            for (int b = 0; b < 6; ++b)
                sum += d[6 * a + b] * e[b];
            out[a] = sum;
        }
    }
}

/* S + D : (C - C0)/2 in Voigt pairs: out (count, 6). c, c0, s: (count, 6); d: (count, 6, 6), of
   which each shear strain counts twice. */
void linearised_stress(int64_t count, const double *c, const double *c0, const double *s,
                       const double *d, double *out)
{
    for (int64_t n = 0; n < count; ++n, c += 6, c0 += 6, s += 6, d += 36, out += 6) {
        double e[6];
        for (int a = 0; a < 6; ++a)
            e[a] = (a < 3 ? 0.5 : 1.0) * (c[a] - c0[a]);
        for (int a = 0; a < 6; ++a) {
            double sum = s[a];
            for (int b = 0; b < 6; ++b)
                sum += d[6 * a + b] * e[b];
            out[a] = sum;
        }
    }
}

/* Force of a solid whose stress is S + D : (C - C0)/2, see `linearised_stress`: added to out (local
   unknowns). Returns the smallest J.

   weights: (points) of the rule; c0, s: (count, points, 6); d: (count, points, 6, 6); corners: 0,
   or how many pressure unknowns a cell has behind its displacements, with their shape functions
   `values` (points, corners) and the constants of the volumetric equation J = c p + sqrt(1 + l (c
   p)^2). The rest as in `deformation_gradient`. */
double force_beside(int64_t count, const int32_t *cells, const int32_t *nodes, int32_t shape,
                    const double *points, int32_t rule, int32_t functions, const double *gradients,
                    const int32_t *dofs, int32_t stride, const double *u, const double *weights,
                    int32_t corners, const double *values, double c, double l, const double *c0,
                    const double *s, const double *d, double *out)
{
    double smallest = INFINITY;
    for (int64_t e = 0; e < count; ++e) {
        const int64_t cell = cells[e];
        const int32_t *own = nodes + shape * cell, *row = dofs + cell * stride;
        const int32_t *of_pressure = row + 3 * functions;
        double m[3][3], k[3][3], det = 0.0, here[10][3], force[10][3] = {{0}}, lacks[4] = {0};
        for (int n = 0; n < functions; ++n)
            for (int i = 0; i < 3; ++i)
                here[n][i] = u[row[3 * n + i]];
        if (shape == 4) {
            straight_map(points, own, m);
            det = adjugate(m, k);
        }
        for (int q = 0; q < rule; ++q, c0 += 6, s += 6, d += 36) {
            const double *g = gradients + (int64_t)q * functions * 3;
            double slopes[10][3], f[9] = {1, 0, 0, 0, 1, 0, 0, 0, 1}, strain[6], stress[6];
            if (shape == 10) {
                curved_map(points, own, g, m);
                det = adjugate(m, k);
            }
            const double inverse = 1.0 / det;
            double map[3][3];
            for (int i = 0; i < 3; ++i)
                for (int j = 0; j < 3; ++j)
                    map[i][j] = inverse * k[i][j];
            for (int n = 0; n < functions; ++n) {
                for (int j = 0; j < 3; ++j)
                    slopes[n][j] = g[3 * n] * map[0][j] + g[3 * n + 1] * map[1][j]
                                   + g[3 * n + 2] * map[2][j];
                for (int i = 0; i < 3; ++i)
                    for (int j = 0; j < 3; ++j)
                        f[3 * i + j] += here[n][i] * slopes[n][j];
            }
            right_cauchy_green(1, f, strain);
            linearised_stress(1, strain, c0, s, d, stress);
            const double jacobian = determinant(f), size = weights[q] * fabs(det);
            smallest = jacobian < smallest || isnan(jacobian) ? jacobian : smallest;
            double p = 0.0, full[3][3], cofactor[3][3];
            for (int a = 0; a < corners; ++a)
                p += values[q * corners + a] * u[of_pressure[a]];
            if (corners) {
                const double swelling = c * p;
                const double gap = jacobian - swelling - sqrt(1.0 + l * swelling * swelling);
                memcpy(full, f, sizeof full);
                adjugate(full, cofactor); /* transposed */
                for (int a = 0; a < corners; ++a)
                    lacks[a] += size * values[q * corners + a] * gap;
            }
            double push[3][3];
            for (int i = 0; i < 3; ++i)
                for (int j = 0; j < 3; ++j) {
                    double sum = corners ? p * cofactor[j][i] : 0.0;
                    for (int a = 0; a < 3; ++a)
                        sum += f[3 * i + a] * stress[place_of[a][j]];
                    push[i][j] = size * sum;
                }
            for (int n = 0; n < functions; ++n)
                for (int i = 0; i < 3; ++i)
                    for (int j = 0; j < 3; ++j)
                        force[n][i] += push[i][j] * slopes[n][j];
        }
        for (int n = 0; n < functions; ++n)
            for (int i = 0; i < 3; ++i)
                out[row[3 * n + i]] += force[n][i];
        for (int a = 0; a < corners; ++a)
            out[of_pressure[a]] += lacks[a];
    }
    return smallest;
}

/* Energy S : E + E : D : E/2 of the strain E = (C - C0)/2: out (count); the rest as in
   `linearised_stress`. */
void energy_beside(int64_t count, const double *c, const double *c0, const double *s,
                   const double *d, double *out)
{
    for (int64_t n = 0; n < count; ++n, c += 6, c0 += 6, s += 6, d += 36) {
        double stress[6];
        linearised_stress(1, c, c0, s, d, stress);
        out[n] = 0.0;
        for (int a = 0; a < 6; ++a)
            out[n] += (a < 3 ? 0.25 : 0.5) * (c[a] - c0[a]) * (s[a] + stress[a]);
    }
}

/* Cauchy stress F S F^T/J + p 1: out (count, 9). f: (count, 9); s: (count, 6); p: (count) or null. */
void cauchy_stress(int64_t count, const double *f, const double *s, const double *p, double *out)
{
    for (int64_t n = 0; n < count; ++n, f += 9, s += 6, out += 9) {
        const double scale = 1.0 / determinant(f);
        double fs[3][3] = {{0}};
        for (int i = 0; i < 3; ++i)
            for (int b = 0; b < 3; ++b)
                for (int a = 0; a < 3; ++a)
                    fs[i][b] += f[3 * i + a] * s[place_of[a][b]];
        for (int i = 0; i < 3; ++i)
            for (int j = 0; j < 3; ++j) {
                double sum = 0.0;
                for (int b = 0; b < 3; ++b)
                    sum += fs[i][b] * f[3 * j + b];
                out[3 * i + j] = sum * scale + (p && i == j ? p[n] : 0.0);
            }
    }
}

/* The rotation R of F = V R with det F > 0: Newton's iteration for the polar decomposition (Higham
   1986, SIAM J. Sci. Stat. Comput. 7:1160). Ten steps do for stretches of 20. */
static void rotation(const double *f, double r[3][3])
{
    double k[3][3];
    memcpy(r, f, 9 * sizeof(double));
    for (int step = 0; step < 64; ++step) {
        const double det = adjugate(r, k);
        double change = 0.0;
        for (int i = 0; i < 3; ++i)
            for (int j = 0; j < 3; ++j) {
                const double next = 0.5 * (r[i][j] + k[j][i] / det);
                change += (next - r[i][j]) * (next - r[i][j]);
                r[i][j] = next;
            }
        if (!(change > 1e-18)) /* the error is about its square by now */
            return;
    }
}

/* sym(J sigma V^-1) = sym(sigma R adj F): out (count, 6). f: (count, 9); sigma: (count, 9). */
void nominal_stress(int64_t count, const double *f, const double *sigma, double *out)
{
    for (int64_t n = 0; n < count; ++n, f += 9, sigma += 9, out += 6) {
        double r[3][3], m[3][3], k[3][3], turned[3][3] = {{0}}, p[3][3] = {{0}};
        memcpy(m, f, sizeof m);
        adjugate(m, k);
        rotation(f, r);
        for (int i = 0; i < 3; ++i)
            for (int j = 0; j < 3; ++j)
                for (int a = 0; a < 3; ++a)
                    turned[i][j] += r[i][a] * k[a][j];
        for (int i = 0; i < 3; ++i)
            for (int j = 0; j < 3; ++j)
                for (int a = 0; a < 3; ++a)
                    p[i][j] += sigma[3 * i + a] * turned[a][j];
        for (int i = 0; i < 3; ++i)
            for (int j = i; j < 3; ++j)
                out[place_of[i][j]] = 0.5 * (p[i][j] + p[j][i]);
    }
}
