/* gain_claims.h: what the papers say of their algorithms, each beside what was measured here. */
#ifndef TESTS_BENCH_GAIN_CLAIMS_H
#define TESTS_BENCH_GAIN_CLAIMS_H

#include <stdio.h>

#include "gain_data.h"

typedef enum gain_verdict {
    GAIN_UNKNOWN = 0, /* not measured */
    GAIN_HOLDS,       /* the whole interval is on the claim's side of its limit */
    GAIN_CONTRARY,    /* the whole interval is on the other side */
    GAIN_UNDECIDED
} gain_verdict_t;

/* How an interval lies to a limit. */
gain_verdict_t gain_verdict_of(double low, double high, double limit, bool above);

/* Each claim with its quantity on every scene and a plain sentence on where it was reproduced. */
void gain_print_claims(FILE *out, const gain_scene_t *scenes, size_t count);

#endif
