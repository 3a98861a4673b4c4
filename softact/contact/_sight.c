/* How much nearer facets have come to others that were out of reach. */

#include <math.h>
#include <stdint.h>

typedef struct {
    int32_t members;       /* of each group */
    const int64_t *groups; /* (groups, members) facets */
    const double *centre, *motion; /* (facets, 3) */
    const double *radius;  /* (facets,) of a sphere that also holds what nodes move against it */
    const double *still;   /* (facets,) the same without that */
    const double *reach;   /* (facets,) */
    const int64_t *side;   /* (facets,) */
} facets_t;

/* How much nearer one of two facets that were out of reach came to the other, on a straight way,
   relative to how far apart they were; 0 where they were within reach, or do not come nearer,
   infinite where the motion of their nodes alone may have bridged the distance. */
static double nearer(const facets_t *of, int64_t a, int64_t b)
{
    double square = 0, along = 0, gone = 0;
    for (int c = 0; c < 3; ++c) {
        const double d = of->centre[3 * a + c] - of->centre[3 * b + c];
        const double w = of->motion[3 * a + c] - of->motion[3 * b + c];
        square += d * d, along += d * w, gone += w * w;
    }
    if (of->side[a] == of->side[b] && of->side[a] >= 0)
        return 0;
    const double start = sqrt(square);
    /* Nearer ones were looked at, and are watched from iteration to iteration. */
    if (start - of->still[a] - of->still[b] <= fmax(of->reach[a], of->reach[b]))
        return 0;
    const double apart = start - of->radius[a] - of->radius[b];
    if (apart <= 0)
        return INFINITY;
    if (along >= 0)
        return 0;
    const double t = fmin(-along / gone, 1);
    const double nearest = sqrt(fmax(square + t * (2 * along + t * gone), 0));
    return (start - nearest) / apart;
}

/* Largest such ratio, `largest` at least, among the members of pairs (pairs, 2) of groups, none of
   which has a larger one than the bound (pairs,) in falling order. */
double strayed(int64_t pairs, const int32_t *pair, const double *bound, const facets_t *of,
               double largest)
{
    for (int64_t p = 0; p < pairs && bound[p] > largest; ++p)
        for (int32_t m = 0; m < of->members; ++m)
            for (int32_t n = 0; n < of->members; ++n) {
                const int64_t a = of->groups[(int64_t)pair[2 * p] * of->members + m];
                const int64_t b = of->groups[(int64_t)pair[2 * p + 1] * of->members + n];
                largest = fmax(largest, nearer(of, a, b));
            }
    return largest;
}

/* Writes at most `room` pairs (room, 2) of facets whose ratio is above 1, and returns how many there
   are; a pair may come twice. */
int64_t met(int64_t pairs, const int32_t *pair, const double *bound, const facets_t *of,
            int64_t room, int32_t *found)
{
    int64_t count = 0;
    for (int64_t p = 0; p < pairs && bound[p] > 1; ++p)
        for (int32_t m = 0; m < of->members; ++m)
            for (int32_t n = 0; n < of->members; ++n) {
                const int64_t a = of->groups[(int64_t)pair[2 * p] * of->members + m];
                const int64_t b = of->groups[(int64_t)pair[2 * p + 1] * of->members + n];
                if (!(nearer(of, a, b) > 1))
                    continue;
                if (count < room)
                    found[2 * count] = (int32_t)a, found[2 * count + 1] = (int32_t)b;
                ++count;
            }
    return count;
}
