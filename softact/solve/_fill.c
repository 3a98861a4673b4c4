/* Operations of a factorisation in a given order of the pivots, before it is made.

   The rows of a factor below a pivot are found along the elimination tree, as in T. A. Davis, Direct
   Methods for Sparse Linear Systems (2006), section 4.2. */
#include <stdint.h>
#include <stdlib.h>

/* Operations of LDL^T of a symmetric matrix of blocks.

   starts (n + 1), neighbours: its graph without loops; weight (n): rows of each block; place (n) of
   each among the pivots, from 0; -1 where there is no memory. */
double operations(int32_t n, const int32_t *starts, const int32_t *neighbours,
                  const int32_t *weight, const int32_t *place)
{
    int32_t *room = malloc(4 * (size_t)n * sizeof(int32_t));
    if (!room)
        return -1.0;
    int32_t *at = room, *parent = room + n, *mark = room + 2 * n, *below = room + 3 * n;
    for (int32_t v = 0; v < n; ++v)
        at[place[v]] = v;
    for (int32_t row = 0; row < n; ++row) {
        const int32_t v = at[row];
        parent[row] = -1;
        mark[row] = row;
        below[row] = 0;
        for (int32_t k = starts[v]; k < starts[v + 1]; ++k)
            /* every pivot between an entry of the row and the row itself gets an entry there, too */
            for (int32_t pivot = place[neighbours[k]]; pivot < row && mark[pivot] != row;
                 pivot = parent[pivot]) {
                if (parent[pivot] == -1)
                    parent[pivot] = row;
                below[pivot] += weight[v];
                mark[pivot] = row;
            }
    }
    double sum = 0.0;
    for (int32_t row = 0; row < n; ++row)
        for (int32_t k = 0; k < weight[at[row]]; ++k) {
            const double r = below[row] + weight[at[row]] - 1.0 - k;
            sum += r * (r + 2.0); /* the column by its pivot, the triangle below by two columns */
        }
    free(room);
    return sum;
}
