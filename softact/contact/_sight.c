/* How much nearer facets may have come to others that were out of reach. */

#include <math.h>
#include <stdint.h>

/* Largest ratio of how much nearer one of a pair of facets came to the other, on a straight way, to
   how far apart they were, `largest` at least. The pairs are those of the members (groups, members)
   of pairs (pairs, 2) of groups, of which none has a larger ratio than the bound (pairs,) in
   falling order. Of facets: centre and motion (facets, 3), radius (facets,) of a sphere that also
   holds what its nodes move against the centre, still (facets,) without that, reach (facets,) and
   side (facets,). */
double strayed(
    int64_t pairs, int32_t members, const int64_t *groups, const int32_t *pair,
    const double *bound, const double *centre, const double *motion, const double *radius,
    const double *still, const double *reach, const int64_t *side, double largest)
{
    for (int64_t p = 0; p < pairs && bound[p] > largest; ++p) {
        const int64_t *first = groups + (int64_t)pair[2 * p] * members;
        const int64_t *second = groups + (int64_t)pair[2 * p + 1] * members;
        for (int32_t m = 0; m < members; ++m)
            for (int32_t n = 0; n < members; ++n) {
                const int64_t a = first[m], b = second[n];
                double square = 0, along = 0, gone = 0;
                for (int c = 0; c < 3; ++c) {
                    const double d = centre[3 * a + c] - centre[3 * b + c];
                    const double w = motion[3 * a + c] - motion[3 * b + c];
                    square += d * d, along += d * w, gone += w * w;
                }
                if (along >= 0 || (side[a] == side[b] && side[a] >= 0))
                    continue;
                const double start = sqrt(square);
                /* Nearer ones were looked at, and are watched from iteration to iteration. */
                if (start - still[a] - still[b] <= fmax(reach[a], reach[b]))
                    continue;
                const double t = fmin(-along / gone, 1);
                const double nearest = sqrt(fmax(square + t * (2 * along + t * gone), 0));
                const double apart = start - radius[a] - radius[b];
                if (start - nearest > largest * apart)
                    largest = apart > 0 ? (start - nearest) / apart : INFINITY;
            }
    }
    return largest;
}
