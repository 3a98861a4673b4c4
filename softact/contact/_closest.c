/* Closest points on curved facets.

   Nodes of a facet: corners, then (for quadratic facets) the middles of the edges 01 12 20. Its
   points are y(s, t) = sum_i N_i y_i with the barycentric coordinates 1 - s - t, s, t. */

#include <math.h>
#include <stdint.h>
#include <stdlib.h>

/* A facet y(s, t) = c[0] + c[1] s + c[2] t + c[3] s^2 + c[4] s t + c[5] t^2 as it is needed at each
   of the points that look at it.

   centre, radius: of the ball that holds it with a tenth of it beyond its edges; along: of a vector r
   from its first corner, s = along[0] . r and t = along[1] . r on the flat triangle of its corners,
   rate: their lengths; normal: that triangle's; over: how far it may be from that plane, lean: and its normal from that
   one, a tenth beyond its edges, too; lies: where it lies at rest, and how far around. */
typedef struct {
    double centre[3], radius, c[6][3], along[2][3], rate[2], normal[3], over, lean, lies[4];
} facet_t;

/* Products of the normals of a facet and of a point's own below which the point faces it: from before,
   and from behind where both lie beside each other in the body at rest. */
static const double BEHIND = -0.5, BEFORE = -0.1;

double facing(void) { return BEFORE; }

int32_t facet_size(void) { return sizeof(facet_t) / sizeof(double); }

static double dot(const double *a, const double *b) { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]; }

/* Foot of the perpendicular from x on a facet, by Newton's method from st; the signed gap and the
   normal there. Returns 0 where there is none near the facet. */
static int foot(const facet_t *on, const double *x, double st[2], double *gap, double n[3])
{
    double a[2][3], r[3], second[3][3];
    for (int i = 0; i < 3; ++i) {
        second[0][i] = 2 * on->c[3][i];
        second[1][i] = on->c[4][i];
        second[2][i] = 2 * on->c[5][i];
    }
    for (int iteration = 0;; ++iteration) {
        const double s = st[0], t = st[1];
        for (int i = 0; i < 3; ++i) {
            r[i] = x[i] - (on->c[0][i] + s * (on->c[1][i] + s * on->c[3][i] + t * on->c[4][i])
                           + t * (on->c[2][i] + t * on->c[5][i]));
            a[0][i] = on->c[1][i] + s * second[0][i] + t * second[1][i];
            a[1][i] = on->c[2][i] + s * second[1][i] + t * second[2][i];
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
    for (int i = 0; i < 3; ++i)
        n[i] /= length;
    *gap = dot(r, n);
    return 1;
}

/* The polynomial of a facet of 3 or 6 nodes y (nodes, 3). */
static void polynomial(int32_t count, const double *y, double c[6][3])
{
    for (int i = 0; i < 3; ++i) {
        const double y0 = y[i], y1 = y[3 + i], y2 = y[6 + i];
        c[0][i] = y0, c[1][i] = y1 - y0, c[2][i] = y2 - y0;
        c[3][i] = c[4][i] = c[5][i] = 0;
        if (count == 6) {
            const double a = y[9 + i], b = y[12 + i], d = y[15 + i]; /* middles of 01, 12, 20 */
            c[1][i] = 4 * a - 3 * y0 - y1, c[2][i] = 4 * d - 3 * y0 - y2;
            c[3][i] = 2 * (y0 + y1) - 4 * a, c[5][i] = 2 * (y0 + y2) - 4 * d;
            c[4][i] = 4 * (y0 + b - a - d);
        }
    }
}

/* The ball: that of the flat triangle, and what the middles stand off their edges, since their shape
   functions add up to no more than 1.8 a tenth of the facet beyond its edges. */
static void enclose(int32_t count, const double *y, facet_t *on)
{
    double radius = 0, off = 0;
    for (int c = 0; c < 3; ++c)
        on->centre[c] = (y[c] + y[3 + c] + y[6 + c]) / 3;
    for (int i = 0; i < count; ++i) {
        const int a = i - 3, b = (i - 2) % 3;
        double square = 0;
        for (int c = 0; c < 3; ++c) {
            const double middle = i < 3 ? on->centre[c] : (y[3 * a + c] + y[3 * b + c]) / 2;
            square += (y[3 * i + c] - middle) * (y[3 * i + c] - middle);
        }
        if (i < 3)
            radius = fmax(radius, square);
        else
            off = fmax(off, square);
    }
    on->radius = 1.3 * sqrt(radius) + 1.8 * sqrt(off);
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

static double length_of(const double *a) { return sqrt(dot(a, a)); }

/* How far the unit normal of a facet with the polynomial c may be from that of its corners, which has
   the edges e0 and e1 and whose product has this length: with a = e0 + d, b = e1 + e along s and t,
   a x b - e0 x e1 = d x e1 + e0 x e + d x e. */
static double lean(double c[6][3], const double *e0, const double *e1, double length)
{
    double first[3], second[3];
    for (int i = 0; i < 3; ++i)
        first[i] = c[1][i] - e0[i], second[i] = c[2][i] - e1[i];
    const double d = length_of(first) + 2.4 * length_of(c[3]) + 1.2 * length_of(c[4]);
    const double e = length_of(second) + 2.4 * length_of(c[5]) + 1.2 * length_of(c[4]);
    const double turned = (d * length_of(e1) + e * length_of(e0) + d * e) / length;
    return turned < 0.5 ? 1.1 * turned : INFINITY;
}

/* Of facets with nodes (facets, count, 3): the unit normals (facets, 3) of the flat triangles of their
   corners, and how far (facets,) theirs may be from these, a tenth beyond their edges, too. */
void directions(int64_t facets, int32_t count, const double *nodes, double *normal, double *leaning)
{
    for (int64_t f = 0; f < facets; ++f, nodes += 3 * count, normal += 3) {
        double c[6][3], e0[3], e1[3];
        polynomial(count, nodes, c);
        for (int a = 0; a < 3; ++a)
            e0[a] = nodes[3 + a] - nodes[a], e1[a] = nodes[6 + a] - nodes[a];
        normal[0] = e0[1] * e1[2] - e0[2] * e1[1];
        normal[1] = e0[2] * e1[0] - e0[0] * e1[2];
        normal[2] = e0[0] * e1[1] - e0[1] * e1[0];
        const double length = length_of(normal);
        for (int a = 0; a < 3; ++a)
            normal[a] /= length;
        leaning[f] = lean(c, e0, e1, length);
    }
}

/* The facets of these nodes (facets, count, 3), for `closest`; lies: (facets, 4), see there. */
void prepare(int64_t facets, int32_t count, const double *nodes, const double *lies, facet_t *out)
{
    for (int64_t f = 0; f < facets; ++f, nodes += 3 * count, lies += 4) {
        facet_t *on = out + f;
        double e0[3], e1[3], *n = on->normal;
        polynomial(count, nodes, on->c);
        enclose(count, nodes, on);
        for (int c = 0; c < 3; ++c)
            e0[c] = nodes[3 + c] - nodes[c], e1[c] = nodes[6 + c] - nodes[c];
        const double g00 = dot(e0, e0), g01 = dot(e0, e1), g11 = dot(e1, e1);
        const double det = g00 * g11 - g01 * g01;
        for (int c = 0; c < 3; ++c) {
            on->along[0][c] = (g11 * e0[c] - g01 * e1[c]) / det;
            on->along[1][c] = (g00 * e1[c] - g01 * e0[c]) / det;
        }
        for (int c = 0; c < 2; ++c)
            on->rate[c] = length_of(on->along[c]);
        n[0] = e0[1] * e1[2] - e0[2] * e1[1];
        n[1] = e0[2] * e1[0] - e0[0] * e1[2];
        n[2] = e0[0] * e1[1] - e0[1] * e1[0];
        const double length = length_of(n);
        for (int c = 0; c < 3; ++c)
            n[c] /= length;
        for (int c = 0; c < 4; ++c)
            on->lies[c] = lies[c];
        on->over = bulge(count, nodes, n);
        on->lean = lean(on->c, e0, e1, length);
    }
}

/* Whether points within the ball (centre x, radius) may have a foot on a facet: near it, and near its
   plane wherever the foot is; st: that of x on the flat triangle of its corners. curved: whether it
   has middles. */
static int near_facet(const facet_t *on, int curved, const double *x, double radius, double reach,
                      double depth, double slack, double st[2])
{
    double r[3];
    const double limit = fmax(reach, depth) + on->radius + radius;
    for (int c = 0; c < 3; ++c)
        r[c] = x[c] - on->centre[c];
    if (dot(r, r) > limit * limit)
        return 0;
    for (int c = 0; c < 3; ++c)
        r[c] = x[c] - on->c[0][c];
    const double height = dot(r, on->normal), over = on->over + radius;
    if (height > reach + over || height < -depth - over)
        return 0;
    st[0] = dot(on->along[0], r), st[1] = dot(on->along[1], r);
    const double far = curved ? 0.4 : slack, s = radius * on->rate[0], t = radius * on->rate[1];
    return !(st[0] < -far - s || st[1] < -far - t || st[0] + st[1] > 1 + far + s + t);
}

/* Whether two facets lie beside each other at rest. */
static int beside(const double *a, const double *b)
{
    double square = 0;
    for (int c = 0; c < 3; ++c)
        square += (a[c] - b[c]) * (a[c] - b[c]);
    return square < (a[3] + b[3]) * (a[3] + b[3]);
}

/* Whether x faces a facet: foot st within its edges (by slack), gap below reach and not deeper than
   depth, normals opposed. own, lies: of the facet of x. */
static int faces(const facet_t *on, int curved, const double *x, const double *own, const double *lies,
                 double reach, double depth, double slack, double st[2], double *gap)
{
    double n[3];
    if (!near_facet(on, curved, x, 0, reach, depth, slack, st))
        return 0;
    if (!foot(on, x, st, gap, n) || !(*gap < reach && *gap > -depth))
        return 0;
    if (st[0] < -slack || st[1] < -slack || st[0] + st[1] > 1 + slack)
        return 0;
    /* Not the next face around an edge: bent, that one may lean over by some degrees, and all points
       near the edge are inside of it. */
    return dot(n, own) < (*gap < 0 && beside(lies, on->lies) ? BEHIND : BEFORE);
}

/* The facets in sight of points (count, 3) of one with the normal `own`; returns how many. */
static int64_t sought(const facet_t *on, int curved, int32_t count, const double *points,
                      const double *own, double reach, double depth, double slack,
                      const int32_t *candidate, int64_t candidates, int32_t *found)
{
    double middle[3] = {0}, square = 0, st[2];
    for (int q = 0; q < count; ++q)
        for (int c = 0; c < 3; ++c)
            middle[c] += points[3 * q + c] / count;
    for (int q = 0; q < count; ++q) {
        double r[3];
        for (int c = 0; c < 3; ++c)
            r[c] = points[3 * q + c] - middle[c];
        square = fmax(square, dot(r, r));
    }
    const double radius = (1 + 1e-9) * sqrt(square);
    int64_t number = 0;
    for (int64_t k = 0; k < candidates; ++k)
        if (dot(on[candidate[k]].normal, own) <= on[candidate[k]].lean + BEFORE
            && near_facet(on + candidate[k], curved, middle, radius, reach, depth, slack, st))
            found[number++] = candidate[k];
    return number;
}

/* For each point the facet that it faces: partner (-1: none), place on it, signed gap.

   places: (facets, points, 3); own: (facets, 3) normals of their facets, lies: (facets, 4) where these
   are at rest and how far around others are beside them; on: the facets that they may
   face, see `prepare`, count: their nodes; start, candidate: facets that each facet may touch; reach, depth: (facets) how far
   away, and how deep inside, the other may be; slack, keep: how far beyond the edge of a facet, barycentric,
   for a new partner and for the one that stands in partner on entry; tie: of two that are equally far,
   to this part of reach, the first one counts, whatever the rounding. */
void closest(int64_t facets, int32_t points, int32_t count, const double *places, const double *own,
             const double *lies, const facet_t *on, const int64_t *start, const int32_t *candidate,
             const double *reach, const double *depth, double slack, double keep, double tie, int32_t *partner,
             double *place, double *gap)
{
    const int curved = count == 6;
    int64_t most = 0;
    for (int64_t f = 0; f < facets; ++f)
        most = start[f + 1] - start[f] > most ? start[f + 1] - start[f] : most;
    int32_t *near = malloc((most + 1) * sizeof(int32_t));
    for (int64_t f = 0; f < facets; ++f) {
        int64_t number = -1; /* of those that are near: not sought yet */
        for (int q = 0; q < points; ++q) {
            const int64_t p = f * points + q;
            const double *x = places + 3 * p;
            double best = reach[f], st[2], g;
            const int32_t before = partner[p];
            partner[p] = -1, gap[p] = INFINITY, place[2 * p] = place[2 * p + 1] = 0;
            if (before >= 0 && faces(on + before, curved, x, own + 3 * f, lies + 4 * f, best, depth[f], keep, st, &g)) {
                partner[p] = before, gap[p] = g, place[2 * p] = st[0], place[2 * p + 1] = st[1];
                continue;
            }
            if (number < 0)
                number = sought(on, curved, points, places + 3 * f * points, own + 3 * f, reach[f],
                                depth[f], slack, candidate + start[f], start[f + 1] - start[f], near);
            for (int64_t k = 0; k < number; ++k) {
                if (!faces(on + near[k], curved, x, own + 3 * f, lies + 4 * f, best, fmin(best, depth[f]), slack, st, &g))
                    continue;
                if (partner[p] >= 0 && fabs(g) > best - tie * reach[f])
                    continue;
                best = fabs(g);
                partner[p] = near[k], gap[p] = g;
                place[2 * p] = st[0], place[2 * p + 1] = st[1];
            }
        }
    }
    free(near);
}
