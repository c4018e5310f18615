#include "client/bench/spread.h"

#include <math.h>
#include <stdlib.h>

static int ascending(const void *a, const void *b)
{
    const double x = *(const double *)a, y = *(const double *)b;
    return (x > y) - (x < y);
}

spread_t spread_of(double *values, size_t count)
{
    if (count == 0)
        return (spread_t){NAN, NAN, NAN};
    qsort(values, count, sizeof *values, ascending);
    return (spread_t){0.5 * (values[(count - 1) / 2] + values[count / 2]), values[0], values[count - 1]};
}

json_t *spread_json(spread_t spread)
{
    json_t *object = json_new_object();
    json_add_number(object, "median", spread.median);
    json_add_number(object, "min", spread.min);
    json_add_number(object, "max", spread.max);
    return object;
}
