/* The point of a surface of triangles that is nearest to each of some points, by a tree of boxes. */

#include <math.h>
#include <stdint.h>

#define DEEPEST 128 /* nodes that wait, of a tree that halves its triangles each time */

static double dot(const double *a, const double *b)
{
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

static double box_distance(const double *x, const double *box)
{
    double square = 0;
    for (int c = 0; c < 3; ++c) {
        const double below = box[c] - x[c], above = x[c] - box[3 + c];
        const double d = below > 0 ? below : above > 0 ? above : 0;
        square += d * d;
    }
    return square;
}

/* The nearest point p of the triangle t to x (Ericson, Real-Time Collision Detection, 2005, section
   5.1.5). Returns where it is: 0 within; 1, 2, 3 the corners; 4, 5, 6 the edges from each to the
   next. */
static int on_triangle(const double *x, const double *t, double *p)
{
    double ab[3], ac[3], bc[3], ax[3], bx[3], cx[3];
    for (int i = 0; i < 3; ++i) {
        ab[i] = t[3 + i] - t[i], ac[i] = t[6 + i] - t[i], bc[i] = t[6 + i] - t[3 + i];
        ax[i] = x[i] - t[i], bx[i] = x[i] - t[3 + i], cx[i] = x[i] - t[6 + i];
    }
    const double d1 = dot(ab, ax), d2 = dot(ac, ax), d3 = dot(ab, bx), d4 = dot(ac, bx);
    const double d5 = dot(ab, cx), d6 = dot(ac, cx);
    const double va = d3 * d6 - d5 * d4, vb = d5 * d2 - d1 * d6, vc = d1 * d4 - d3 * d2;
    int where;
    double v, w;
    if (d1 <= 0 && d2 <= 0)
        where = 1, v = 0, w = 0;
    else if (d3 >= 0 && d4 <= d3)
        where = 2, v = 1, w = 0;
    else if (d6 >= 0 && d5 <= d6)
        where = 3, v = 0, w = 1;
    else if (vc <= 0 && d1 >= 0 && d3 <= 0)
        where = 4, v = d1 / (d1 - d3), w = 0;
    else if (va <= 0 && d4 - d3 >= 0 && d5 - d6 >= 0)
        where = 5, w = (d4 - d3) / ((d4 - d3) + (d5 - d6)), v = 1 - w;
    else if (vb <= 0 && d2 >= 0 && d6 <= 0)
        where = 6, v = 0, w = d2 / (d2 - d6);
    else
        where = 0, v = vb / (va + vb + vc), w = vc / (va + vb + vc);
    for (int i = 0; i < 3; ++i)
        p[i] = t[i] + v * ab[i] + w * ac[i];
    return where;
}

/* Of n points x: the nearest triangle, where it is on that, and the nearest point. boxes: (nodes,
   6) lower and upper corners; links: (nodes, 2) both children, or of a leaf −1 − the first triangle
   and how many there are. */
void nearest(int64_t n, const double *x, const double *triangles, const double *boxes,
             const int32_t *links, int32_t *which, int32_t *where, double *points)
{
    for (int64_t i = 0; i < n; ++i) {
        const double *here = x + 3 * i;
        double best = INFINITY;
        int32_t stack[DEEPEST];
        int waiting = 0;
        stack[waiting++] = 0;
        while (waiting) {
            const int32_t node = stack[--waiting];
            if (box_distance(here, boxes + 6 * node) >= best)
                continue;
            const int32_t one = links[2 * node], other = links[2 * node + 1];
            if (one >= 0) {
                const double d = box_distance(here, boxes + 6 * one);
                const double e = box_distance(here, boxes + 6 * other);
                stack[waiting++] = d < e ? other : one;
                stack[waiting++] = d < e ? one : other;
                continue;
            }
            for (int32_t k = -1 - one; k < -1 - one + other; ++k) {
                double p[3], square = 0;
                const int found = on_triangle(here, triangles + 9 * k, p);
                for (int c = 0; c < 3; ++c)
                    square += (here[c] - p[c]) * (here[c] - p[c]);
                if (square < best) {
                    best = square, which[i] = k, where[i] = found;
                    for (int c = 0; c < 3; ++c)
                        points[3 * i + c] = p[c];
                }
            }
        }
    }
}
