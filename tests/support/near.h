/* near.h: |found - expected| <= tolerance, as an assertion. NaN fails; both values are printed. After cmocka.h. */
#ifndef TESTS_SUPPORT_NEAR_H
#define TESTS_SUPPORT_NEAR_H

#include <math.h>

#define assert_near(found, expected, tolerance)                                                                    \
    do {                                                                                                           \
        const double found_ = (found), expected_ = (expected), tolerance_ = (tolerance);                           \
        if (!(fabs(found_ - expected_) <= tolerance_))                                                             \
            fail_msg("%s = %.17g, expected %s = %.17g +- %g (line %d)", #found, found_, #expected, expected_,      \
                     tolerance_, __LINE__);                                                                        \
    } while (0)

#endif
