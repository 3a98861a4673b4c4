/* Which facets may touch which: by where they are, and by how far they have moved since. */

#include <math.h>
#include <stdint.h>
#include <stdlib.h>

static double dot(const double *a, const double *b) { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]; }

/* Facets in the cells of a grid. */
typedef struct {
    double low[3], width;
    int64_t count[3];
    int64_t *first, *facet; /* of each cell, the facets behind each other */
} grid_t;

static int64_t cell_along(const grid_t *in, const double *place, int axis)
{
    const int64_t cell = (int64_t)((place[axis] - in->low[axis]) / in->width);
    return cell < 0 ? 0 : cell >= in->count[axis] ? in->count[axis] - 1 : cell;
}

static int64_t cell_of(const grid_t *in, const double *place)
{
    int64_t cell = 0;
    for (int c = 0; c < 3; ++c)
        cell = cell * in->count[c] + cell_along(in, place, c);
    return cell;
}

/* Whether there was memory; width: of a cell, at least that of what is looked for, more where the
   grid would have too many cells. */
static int make_grid(int64_t facets, const double *centre, double width, grid_t *out)
{
    double high[3];
    for (int c = 0; c < 3; ++c) {
        out->low[c] = INFINITY, high[c] = -INFINITY;
        for (int64_t f = 0; f < facets; ++f) {
            out->low[c] = fmin(out->low[c], centre[3 * f + c]);
            high[c] = fmax(high[c], centre[3 * f + c]);
        }
        if (!isfinite(high[c] - out->low[c]))
            return 0;
    }
    int64_t cells;
    for (out->width = width;; out->width *= 2) {
        double total = 1;
        cells = 1;
        for (int c = 0; c < 3; ++c)
            total *= floor((high[c] - out->low[c]) / out->width) + 1;
        if (!(total <= 8.0 * (double)facets + 8))
            continue;
        for (int c = 0; c < 3; ++c)
            cells *= out->count[c] = (int64_t)((high[c] - out->low[c]) / out->width) + 1;
        break;
    }
    out->first = calloc(cells + 2, sizeof(int64_t));
    out->facet = malloc((facets + 1) * sizeof(int64_t));
    if (!out->first || !out->facet)
        return 0;
    for (int64_t f = 0; f < facets; ++f)
        ++out->first[cell_of(out, centre + 3 * f) + 2];
    for (int64_t k = 0; k <= cells; ++k)
        out->first[k + 1] += out->first[k];
    for (int64_t f = 0; f < facets; ++f)
        out->facet[out->first[cell_of(out, centre + 3 * f) + 1]++] = f;
    return 1;
}

/* In rising order; what is given is a few rising runs behind each other. */
static void sort(int32_t *values, int64_t count)
{
    for (int64_t k = 1; k < count; ++k) {
        const int32_t value = values[k];
        int64_t at = k;
        for (; at > 0 && values[at - 1] > value; --at)
            values[at] = values[at - 1];
        values[at] = value;
    }
}

/* For each facet those whose spheres (centre (facets, 3), radius) are within the farther reach of the
   two, with normals (facets, 3) whose product is below `facing`, and of another side or of none. Writes
   start (facets + 1), at most `room` facets in rising order, and whether each is among the adjoining ones
   (their own start, and facets). Returns how many there are, -1 without memory or with places that are no
   numbers. */
int64_t candidates(int64_t facets, const double *centre, const double *radius, const double *reach,
                   const double *normal, const int64_t *side, const int64_t *adjoining_start,
                   const int32_t *adjoining, double facing, int64_t *start, int64_t room, int32_t *found,
                   uint8_t *joined)
{
    double width = 0;
    for (int64_t f = 0; f < facets; ++f)
        width = fmax(width, 2 * (radius[f] + reach[f]));
    grid_t grid = {.first = NULL, .facet = NULL};
    int64_t count = 0;
    if (!isfinite(width) || !(width > 0) || !make_grid(facets, centre, width, &grid))
        count = -1;
    for (int64_t i = 0; i < facets && count >= 0; ++i) {
        start[i] = count;
        int64_t from[3], to[3];
        for (int c = 0; c < 3; ++c) {
            const int64_t at = cell_along(&grid, centre + 3 * i, c);
            from[c] = at > 0 ? at - 1 : 0;
            to[c] = at + 1 < grid.count[c] ? at + 1 : at;
        }
        for (int64_t x = from[0]; x <= to[0]; ++x)
            for (int64_t y = from[1]; y <= to[1]; ++y) {
                const int64_t row = (x * grid.count[1] + y) * grid.count[2];
                for (int64_t k = grid.first[row + from[2]]; k < grid.first[row + to[2] + 1]; ++k) {
                    const int64_t j = grid.facet[k];
                    double r[3];
                    for (int c = 0; c < 3; ++c)
                        r[c] = centre[3 * i + c] - centre[3 * j + c];
                    const double limit = radius[i] + radius[j] + fmax(reach[i], reach[j]);
                    if (j == i || dot(r, r) >= limit * limit)
                        continue;
                    if (dot(normal + 3 * i, normal + 3 * j) >= facing
                        || (side[i] == side[j] && side[i] >= 0))
                        continue;
                    if (count < room)
                        found[count] = (int32_t)j;
                    ++count;
                }
            }
        if (count > room)
            continue;
        sort(found + start[i], count - start[i]);
        for (int64_t k = start[i]; k < count; ++k) {
            joined[k] = 0;
            for (int64_t l = adjoining_start[i]; l < adjoining_start[i + 1]; ++l)
                joined[k] |= adjoining[l] == found[k];
        }
    }
    if (count >= 0)
        start[facets] = count;
    free(grid.first), free(grid.facet);
    return count;
}

/* A facet as one that others may touch, a tenth of it beyond its edges included.

   radius: of a sphere about centre; corner, normal: plane of its corners; over: how far it may be from
   that plane; off: how far, in any direction, from the flat triangle. */
typedef struct {
    double centre[3], radius, corner[3][3], normal[3], over, off;
} body_t;

int32_t body_size(void) { return sizeof(body_t) / sizeof(double); }

/* The shape functions of the middles of six nodes add up to no more than this, a tenth beyond. */
static const double MIDDLES = 1.8;

void bodies(int64_t facets, int32_t count, const double *nodes, body_t *out)
{
    for (int64_t f = 0; f < facets; ++f, nodes += 3 * count) {
        body_t *on = out + f;
        double e0[3], e1[3], *n = on->normal, square = 0, off = 0, over = 0;
        for (int c = 0; c < 3; ++c) {
            for (int a = 0; a < 3; ++a)
                on->corner[a][c] = nodes[3 * a + c];
            e0[c] = nodes[3 + c] - nodes[c], e1[c] = nodes[6 + c] - nodes[c];
            on->centre[c] = (nodes[c] + nodes[3 + c] + nodes[6 + c]) / 3;
        }
        n[0] = e0[1] * e1[2] - e0[2] * e1[1];
        n[1] = e0[2] * e1[0] - e0[0] * e1[2];
        n[2] = e0[0] * e1[1] - e0[1] * e1[0];
        const double length = sqrt(dot(n, n));
        for (int c = 0; c < 3; ++c)
            n[c] /= length;
        for (int a = 0; a < 3; ++a) {
            double r[3];
            for (int c = 0; c < 3; ++c)
                r[c] = nodes[3 * a + c] - on->centre[c];
            square = fmax(square, dot(r, r));
        }
        for (int a = 3; a < count; ++a) {
            double r[3];
            for (int c = 0; c < 3; ++c)
                r[c] = nodes[3 * a + c] - (nodes[3 * (a - 3) + c] + nodes[3 * ((a - 2) % 3) + c]) / 2;
            off = fmax(off, dot(r, r));
            over = fmax(over, fabs(dot(r, n)));
        }
        on->off = MIDDLES * sqrt(off), on->over = MIDDLES * over;
        on->radius = 1.3 * sqrt(square) + on->off;
    }
}

/* How far b is in front of the plane of a, at least, or deeper behind it than depth: between, it may
   overlap with a. */
static double off_plane(const body_t *a, const body_t *b, double depth)
{
    double low = INFINITY, high = -INFINITY;
    for (int k = 0; k < 3; ++k) {
        double r[3];
        for (int c = 0; c < 3; ++c)
            r[c] = b->corner[k][c] - a->corner[0][c];
        const double height = dot(r, a->normal);
        low = fmin(low, height), high = fmax(high, height);
    }
    const double beyond = 0.2 * (high - low) + a->over + b->off;
    return fmax(low, -high - depth) - beyond;
}

/* How far (pairs,) facets are from touching their candidates, at least: apart, or deeper in each other
   than depth (facets,), where they do not look; start, candidate: see above. */
void apart(int64_t facets, const body_t *of, const int64_t *start, const int32_t *candidate,
           const double *depth, double *distance)
{
    for (int64_t i = 0; i < facets; ++i)
        for (int64_t k = start[i]; k < start[i + 1]; ++k) {
            const body_t *a = of + i, *b = of + candidate[k];
            double r[3];
            for (int c = 0; c < 3; ++c)
                r[c] = a->centre[c] - b->centre[c];
            const double balls = sqrt(dot(r, r)) - a->radius - b->radius;
            const double deep = fmax(depth[i], depth[candidate[k]]);
            distance[k] = fmax(balls, fmax(off_plane(a, b, deep), off_plane(b, a, deep)));
        }
}

/* Motion of facets from `before` to `now` (facets, count, 3): of their centres (facets, 3), and by how
   much (facets,) that of another of their points differs, a tenth beyond their edges included. */
void motion(int64_t facets, int32_t count, const double *before, const double *now, double *centre,
            double *spread)
{
    for (int64_t f = 0; f < facets; ++f) {
        double moved[6][3], corners = 0, middles = 0, *mean = centre + 3 * f;
        for (int a = 0; a < count; ++a)
            for (int c = 0; c < 3; ++c)
                moved[a][c] = now[3 * (f * count + a) + c] - before[3 * (f * count + a) + c];
        for (int c = 0; c < 3; ++c)
            mean[c] = (moved[0][c] + moved[1][c] + moved[2][c]) / 3;
        for (int a = 0; a < count; ++a) {
            double r[3];
            for (int c = 0; c < 3; ++c)
                r[c] = moved[a][c] - (a < 3 ? mean[c] : (moved[a - 3][c] + moved[(a - 2) % 3][c]) / 2);
            if (a < 3)
                corners = fmax(corners, dot(r, r));
            else
                middles = fmax(middles, dot(r, r));
        }
        spread[f] = 1.3 * sqrt(corners) + MIDDLES * sqrt(middles);
    }
}

/* Marks (pairs,) which candidates may have come nearer than `within` (facets,) to a facet, that were
   apart by `distance` before they moved, and may face it: with no normals, whichever way they look.
   Returns how many. */
int64_t near(int64_t facets, const int64_t *start, const int32_t *candidate, const double *distance,
             const double *centre, const double *spread, const double *within,
             const double *normal, const double *leaning, double facing, uint8_t *mark)
{
    int64_t count = 0;
    for (int64_t i = 0; i < facets; ++i)
        for (int64_t k = start[i]; k < start[i + 1]; ++k) {
            const int64_t j = candidate[k];
            const double left = distance[k] - spread[i] - spread[j] - within[i];
            double r[3];
            for (int c = 0; c < 3; ++c)
                r[c] = centre[3 * i + c] - centre[3 * j + c];
            mark[k] = left < 0 || dot(r, r) > left * left;
            if (mark[k] && normal)
                mark[k] = dot(normal + 3 * i, normal + 3 * j) < facing + leaning[j];
            count += mark[k];
        }
    return count;
}
