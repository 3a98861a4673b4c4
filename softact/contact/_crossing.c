/* Points of facets that end behind flat triangles of others in front of which they began. */

#include <math.h>
#include <stdint.h>

static double height(const double *p, const double *corner, const double *normal)
{
    return (p[0] - corner[0]) * normal[0] + (p[1] - corner[1]) * normal[1]
         + (p[2] - corner[2]) * normal[2];
}

static double apart(const double *a, const double *b)
{
    const double x = a[0] - b[0], y = a[1] - b[1], z = a[2] - b[2];
    return sqrt(x * x + y * y + z * z);
}

/* Finds (facet, candidate, piece, point) for points (facets, points, 3) that begin no deeper than
   `overlapping` behind the plane of a piece, end deeper than `behind` behind it, in sizes of the
   candidate, and end near it. Of the pieces: centre (facets, pieces, 3) at the end and how far
   (facets, pieces) their corners went; corner and normal (facets, pieces, 3) at both times. Writes
   at most `room` of them and returns how many there are. */
int64_t behind(
    int64_t facets, int32_t points, int32_t pieces, const int64_t *start, const int32_t *candidate,
    const double *first, const double *last, const double *corner_first,
    const double *corner_last, const double *normal_first, const double *normal_last,
    const double *centre, const double *moved, const double *size, double overlapping,
    double deeper, int64_t room, int32_t *found)
{
    int64_t count = 0;
    for (int64_t i = 0; i < facets; ++i)
        for (int64_t k = start[i]; k < start[i + 1]; ++k) {
            const int64_t j = candidate[k];
            for (int32_t q = 0; q < points; ++q) {
                const double *p = first + 3 * (i * points + q), *e = last + 3 * (i * points + q);
                for (int32_t t = 0; t < pieces; ++t) {
                    const int64_t at = j * pieces + t;
                    if (height(e, corner_last + 3 * at, normal_last + 3 * at) >= -deeper * size[j])
                        continue;
                    if (height(p, corner_first + 3 * at, normal_first + 3 * at)
                        < -overlapping * size[j])
                        continue;
                    if (apart(e, centre + 3 * at) >= 2 * size[j] + apart(e, p) + moved[at])
                        continue;
                    if (count < room) {
                        int32_t *row = found + 4 * count;
                        row[0] = (int32_t)i, row[1] = (int32_t)j, row[2] = t, row[3] = q;
                    }
                    ++count;
                }
            }
        }
    return count;
}
