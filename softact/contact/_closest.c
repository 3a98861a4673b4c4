/* Closest points on curved facets.

   Nodes of a facet: corners, then (for quadratic facets) the middles of the edges 01 12 20. Its
   points are y(s, t) = sum_i N_i y_i with the barycentric coordinates 1 - s - t, s, t. */

#include <math.h>
#include <stdint.h>

static void shape(int nodes, double s, double t, double N[6], double D[2][6])
{
    const double r = 1 - s - t;
    if (nodes == 3) {
        N[0] = r, N[1] = s, N[2] = t;
        D[0][0] = -1, D[0][1] = 1, D[0][2] = 0;
        D[1][0] = -1, D[1][1] = 0, D[1][2] = 1;
        return;
    }
    N[0] = r * (2 * r - 1), N[1] = s * (2 * s - 1), N[2] = t * (2 * t - 1);
    N[3] = 4 * r * s, N[4] = 4 * s * t, N[5] = 4 * t * r;
    D[0][0] = 1 - 4 * r, D[0][1] = 4 * s - 1, D[0][2] = 0;
    D[0][3] = 4 * (r - s), D[0][4] = 4 * t, D[0][5] = -4 * t;
    D[1][0] = 1 - 4 * r, D[1][1] = 0, D[1][2] = 4 * t - 1;
    D[1][3] = -4 * s, D[1][4] = 4 * s, D[1][5] = 4 * (r - t);
}

static double dot(const double *a, const double *b) { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]; }

/* Second derivatives ss, st, tt of the shape functions of a quadratic facet. */
static const double SECOND[3][6] = {
    {4, 4, 0, -8, 0, 0}, {4, 0, 0, -4, 4, -4}, {4, 0, 4, 0, 0, -8}};

/* Foot of the perpendicular from x on the facet y, by Newton's method from st; the signed gap and
   the normal there. Returns 0 where there is none near the facet. */
static int foot(int nodes, const double *y, const double *x, double st[2], double *gap, double n[3])
{
    double N[6], D[2][6], a[2][3], r[3], second[3][3] = {{0}};
    if (nodes == 6)
        for (int k = 0; k < 3; ++k)
            for (int i = 0; i < 6; ++i)
                for (int c = 0; c < 3; ++c)
                    second[k][c] += SECOND[k][i] * y[3 * i + c];
    for (int iteration = 0;; ++iteration) {
        shape(nodes, st[0], st[1], N, D);
        for (int c = 0; c < 3; ++c) {
            r[c] = x[c], a[0][c] = 0, a[1][c] = 0;
            for (int i = 0; i < nodes; ++i) {
                r[c] -= N[i] * y[3 * i + c];
                a[0][c] += D[0][i] * y[3 * i + c];
                a[1][c] += D[1][i] * y[3 * i + c];
            }
        }
        const double f0 = dot(r, a[0]), f1 = dot(r, a[1]);
        const double g00 = dot(a[0], a[0]), g01 = dot(a[0], a[1]), g11 = dot(a[1], a[1]);
        double h00 = g00 - dot(r, second[0]), h01 = g01 - dot(r, second[1]);
        double h11 = g11 - dot(r, second[2]), det = h00 * h11 - h01 * h01;
        if (det < 0.05 * g00 * g11) { /* beyond the centre of curvature: go along the tangents */
            h00 = g00, h01 = g01, h11 = g11;
            det = h00 * h11 - h01 * h01;
            if (iteration > 8)
                return 0;
        }
        if (!(det > 0))
            return 0;
        const double ds = (h11 * f0 - h01 * f1) / det, dt = (h00 * f1 - h01 * f0) / det;
        st[0] += ds, st[1] += dt;
        if (!(fabs(st[0] - 0.33) < 2 && fabs(st[1] - 0.33) < 2))
            return 0;
        if (fabs(ds) + fabs(dt) < 1e-12 || (iteration >= 3 && fabs(ds) + fabs(dt) < 1e-10))
            break;
        if (iteration > 14)
            return 0;
    }
    n[0] = a[0][1] * a[1][2] - a[0][2] * a[1][1];
    n[1] = a[0][2] * a[1][0] - a[0][0] * a[1][2];
    n[2] = a[0][0] * a[1][1] - a[0][1] * a[1][0];
    const double length = sqrt(dot(n, n));
    for (int c = 0; c < 3; ++c)
        n[c] /= length;
    *gap = dot(r, n);
    return 1;
}

typedef struct {
    int32_t count;       /* nodes of a facet */
    const double *nodes; /* (facets, nodes, 3) */
    const double *balls; /* (facets, 4): centre and radius of what a foot may lie in */
} surface_t;

/* The ball that holds a facet with a tenth of it beyond its edges: that of its flat triangle, and what
   the middles stand off their edges, since their shape functions add up to no more than 1.8 there. */
void balls(int64_t facets, int32_t count, const double *nodes, double *ball)
{
    for (int64_t f = 0; f < facets; ++f, nodes += 3 * count, ball += 4) {
        double radius = 0, off = 0;
        for (int c = 0; c < 3; ++c)
            ball[c] = (nodes[c] + nodes[3 + c] + nodes[6 + c]) / 3;
        for (int i = 0; i < count; ++i) {
            const int a = i - 3, b = (i - 2) % 3;
            double square = 0;
            for (int c = 0; c < 3; ++c) {
                const double middle = i < 3 ? ball[c] : (nodes[3 * a + c] + nodes[3 * b + c]) / 2;
                square += (nodes[3 * i + c] - middle) * (nodes[3 * i + c] - middle);
            }
            if (i < 3)
                radius = fmax(radius, square);
            else
                off = fmax(off, square);
        }
        ball[3] = 1.3 * sqrt(radius) + 1.8 * sqrt(off);
    }
}

/* How far a quadratic facet y may be from the plane of its corners, whose normal is n: the shape
   functions of the three middles add up to no more than 4/3 within it; a tenth beyond, to 1.8. */
static double bulge(int32_t count, const double *y, const double n[3])
{
    double most = 0;
    for (int i = 3; i < count; ++i)
        most = fmax(most, fabs((y[3 * i] - y[0]) * n[0] + (y[3 * i + 1] - y[1]) * n[1]
                               + (y[3 * i + 2] - y[2]) * n[2]));
    return 1.8 * most;
}

/* Whether x faces a facet: foot st within its edges (by slack), gap below reach and not deeper than
   depth, normals opposed. */
static int faces(const surface_t *on, int32_t facet, const double *x, const double *own, double reach,
                 double depth, double slack, double st[2], double *gap)
{
    const double *y = on->nodes + (int64_t)facet * on->count * 3;
    const double *ball = on->balls + (int64_t)facet * 4;
    double e0[3], e1[3], r[3], n[3];
    const double limit = fmax(reach, depth) + ball[3];
    for (int c = 0; c < 3; ++c)
        r[c] = x[c] - ball[c];
    if (dot(r, r) > limit * limit)
        return 0;
    for (int c = 0; c < 3; ++c)
        e0[c] = y[3 + c] - y[c], e1[c] = y[6 + c] - y[c], r[c] = x[c] - y[c];
    const double g00 = dot(e0, e0), g01 = dot(e0, e1), g11 = dot(e1, e1);
    const double f0 = dot(r, e0), f1 = dot(r, e1), det = g00 * g11 - g01 * g01;
    st[0] = (g11 * f0 - g01 * f1) / det, st[1] = (g00 * f1 - g01 * f0) / det;
    const double far = on->count == 6 ? 0.4 : slack; /* on the flat triangle of the corners */
    if (st[0] < -far || st[1] < -far || st[0] + st[1] > 1 + far)
        return 0;
    n[0] = e0[1] * e1[2] - e0[2] * e1[1];
    n[1] = e0[2] * e1[0] - e0[0] * e1[2];
    n[2] = e0[0] * e1[1] - e0[1] * e1[0];
    const double length = sqrt(dot(n, n));
    for (int c = 0; c < 3; ++c)
        n[c] /= length;
    const double height = dot(r, n), over = bulge(on->count, y, n);
    if (height > reach + over || height < -depth - over) /* too far, wherever the foot is */
        return 0;
    if (!foot(on->count, y, x, st, gap, n) || !(*gap < reach && *gap > -depth))
        return 0;
    if (st[0] < -slack || st[1] < -slack || st[0] + st[1] > 1 + slack)
        return 0;
    /* Not the far side of the same wall, nor the next face around an edge: bent, that one may lean
       over by some degrees, and all points near the edge are inside of it. */
    return dot(n, own) < (*gap < 0 ? -0.5 : -0.1);
}

/* For each point the facet that it faces: partner (-1: none), place on it, signed gap.

   places: (facets, points, 3); own: (facets, 3) normals of their facets; nodes: (facets, nodes, 3)
   of the facets, balls: around them, see there; start, candidate: facets that each facet may touch; reach, depth: (facets) how far
   away, and how deep inside, the other may be; slack, keep: how far beyond the edge of a facet, barycentric,
   for a new partner and for the one that stands in partner on entry; tie: of two that are equally far,
   to this part of reach, the first one counts, whatever the rounding. */
void closest(int64_t facets, int32_t points, int32_t count, const double *places, const double *own,
             const double *nodes, const double *balls, const int64_t *start, const int32_t *candidate,
             const double *reach, const double *depth, double slack, double keep, double tie, int32_t *partner,
             double *place, double *gap)
{
    const surface_t on = {count, nodes, balls};
    for (int64_t f = 0; f < facets; ++f)
        for (int q = 0; q < points; ++q) {
            const int64_t p = f * points + q;
            const double *x = places + 3 * p;
            double best = reach[f], st[2], g;
            const int32_t before = partner[p];
            partner[p] = -1, gap[p] = INFINITY, place[2 * p] = place[2 * p + 1] = 0;
            if (before >= 0 && faces(&on, before, x, own + 3 * f, best, depth[f], keep, st, &g)) {
                partner[p] = before, gap[p] = g, place[2 * p] = st[0], place[2 * p + 1] = st[1];
                continue;
            }
            for (int64_t k = start[f]; k < start[f + 1]; ++k) {
                if (!faces(&on, candidate[k], x, own + 3 * f, best, fmin(best, depth[f]), slack, st, &g))
                    continue;
                if (partner[p] >= 0 && fabs(g) > best - tie * reach[f])
                    continue;
                best = fabs(g);
                partner[p] = candidate[k], gap[p] = g;
                place[2 * p] = st[0], place[2 * p + 1] = st[1];
            }
        }
}
