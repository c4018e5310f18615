/* histogram.h: weighted histograms over an interval, and how far they are from exact probabilities.
 *
 * Weight outside the interval counts in the total and in no bin. Independent chains give one histogram each: their
 * differences tell the sampling noise of their mean without knowing the right answer.
 *
 *     histogram_t h = histogram_make(0, 1, 100);
 *     histogram_add(&h, x, 1);
 *     double distance = histogram_total_variation(&h, exact);
 */
#ifndef LAB_HISTOGRAM_H
#define LAB_HISTOGRAM_H

enum { HISTOGRAM_BINS = 100 };

typedef struct histogram {
    int bins; /* at most HISTOGRAM_BINS */
    double lo, hi, total;
    double weight[HISTOGRAM_BINS];
} histogram_t;

static inline histogram_t histogram_make(double lo, double hi, int bins)
{
    return (histogram_t){.bins = bins, .lo = lo, .hi = hi};
}

/* x finite. */
static inline void histogram_add(histogram_t *h, double x, double weight)
{
    const double place = (x - h->lo) / (h->hi - h->lo) * h->bins;
    if (place >= 0 && place < h->bins)
        h->weight[(int)place] += weight;
    h->total += weight;
}

/* The sum of histograms of the same bins. */
histogram_t histogram_sum(const histogram_t *parts, int count);
/* Half the sum of |share - exact| over the bins. */
double histogram_total_variation(const histogram_t *h, const double *exact);
/* The mean over the bins of (share - exact)^2. */
double histogram_mean_square(const histogram_t *h, const double *exact);
/* The total variation that sampling noise alone gives the sum of `count` >= 2 independent histograms of about the
 * same total, by expectation: 1/2 sqrt(2/pi) times the sum over the bins of the standard error (between the
 * histograms) of the bin's share, as E|z| = sqrt(2/pi) of a standard normal z. */
double histogram_noise(const histogram_t *parts, int count);

#endif
