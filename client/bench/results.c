#include "client/bench/results.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

fault_code_t results_new(results_t **out, const matrix_t *matrix, fault_t *fault)
{
    results_t *results = calloc(1, sizeof *results);
    if (results)
        results->runs = calloc(matrix->scene_count * matrix->variant_count * matrix->seeds, sizeof *results->runs);
    *out = results;
    if (!results || !results->runs) {
        results_destroy(out);
        return fault_set(fault, FAULT_MEMORY, "no memory for the results of %zu runs",
                         matrix->scene_count * matrix->variant_count * matrix->seeds);
    }
    results->matrix = matrix;
    return FAULT_NONE;
}

void results_destroy(results_t **results)
{
    if (*results)
        free((*results)->runs);
    free(*results);
    *results = NULL;
}

run_figures_t *results_run(const results_t *results, size_t scene, size_t variant, size_t seed)
{
    const matrix_t *m = results->matrix;
    return &results->runs[(scene * m->variant_count + variant) * m->seeds + seed];
}

/* ---- over the seeds ---- */

typedef double quantity_t(const results_t *results, size_t scene, const run_point_t *point);

static double cpu_of(const results_t *results, size_t scene, const run_point_t *point)
{
    (void)results;
    (void)scene;
    return point->cpu_seconds;
}

static double mutations_of(const results_t *results, size_t scene, const run_point_t *point)
{
    (void)results;
    (void)scene;
    return point->mutations_per_pixel;
}

static double relmse_of(const results_t *results, size_t scene, const run_point_t *point)
{
    (void)results;
    (void)scene;
    return point->relmse;
}

static double trimmed_of(const results_t *results, size_t scene, const run_point_t *point)
{
    (void)results;
    (void)scene;
    return point->trimmed;
}

static double estimate_of(const results_t *results, size_t scene, const run_point_t *point)
{
    (void)results;
    (void)scene;
    return point->estimate;
}

static double bias_of(const results_t *results, size_t scene, const run_point_t *point)
{
    (void)results;
    (void)scene;
    return point->bias;
}

/* Of the runs that were made; how many. */
static size_t collect(const results_t *results, size_t scene, size_t variant, size_t budget, quantity_t *quantity,
                      double values[MATRIX_SEEDS])
{
    size_t count = 0;
    for (size_t i = 0; i < results->matrix->seeds; i++) {
        const run_figures_t *run = results_run(results, scene, variant, i);
        if (run->made)
            values[count++] = quantity(results, scene, &run->points[budget]);
    }
    return count;
}

/* All NaN if a value is. */
static spread_t spread_within(const results_t *results, size_t scene, size_t variant, size_t budget,
                              quantity_t *quantity)
{
    double values[MATRIX_SEEDS];
    const size_t count = collect(results, scene, variant, budget, quantity, values);
    for (size_t i = 0; i < count; i++)
        if (isnan(values[i]))
            return (spread_t){NAN, NAN, NAN};
    return spread_of(values, count);
}

static seeds_figure_t mean_of(const double *values, size_t count)
{
    double mean = 0, sum = 0;
    for (size_t i = 0; i < count; i++)
        mean += values[i] / (double)count;
    for (size_t i = 0; i < count; i++)
        sum += (values[i] - mean) * (values[i] - mean);
    return (seeds_figure_t){count > 0 ? mean : NAN,
                            count > 1 ? sqrt(sum / ((double)count * (double)(count - 1))) : NAN};
}

double results_error(const results_t *results, size_t scene, const run_point_t *point)
{
    return results->scenes[scene].reference[0] ? point->relmse : point->estimate;
}

spread_t results_error_spread(const results_t *results, size_t scene, size_t variant, size_t budget)
{
    return spread_within(results, scene, variant, budget, results_error);
}

static double work_of(const results_t *results, size_t scene, const run_point_t *point)
{
    return results_error(results, scene, point) * point->cpu_seconds;
}

static seeds_ratio_t gain_of(const results_t *results, size_t scene, size_t variant, size_t budget)
{
    double first[MATRIX_SEEDS], this[MATRIX_SEEDS];
    const size_t n = collect(results, scene, 0, budget, work_of, first),
                 m = collect(results, scene, variant, budget, work_of, this);
    if (variant == 0 || n == 0 || m == 0)
        return variant == 0 && n > 0 ? (seeds_ratio_t){1, 1, 1} : (seeds_ratio_t){NAN, NAN, NAN};
    const seeds_figure_t a = seeds_log_mean(first, n), b = seeds_log_mean(this, m);
    return seeds_log_ratio_within(a, b, seeds_width(n < m ? n : m));
}

results_cell_t results_cell(const results_t *results, size_t scene, size_t variant, size_t budget)
{
    double values[MATRIX_SEEDS];
    const size_t count = collect(results, scene, variant, budget, bias_of, values);
    return (results_cell_t){.runs = count,
                            .cpu_seconds = spread_within(results, scene, variant, budget, cpu_of),
                            .mutations = spread_within(results, scene, variant, budget, mutations_of),
                            .relmse = spread_within(results, scene, variant, budget, relmse_of),
                            .trimmed = spread_within(results, scene, variant, budget, trimmed_of),
                            .estimate = spread_within(results, scene, variant, budget, estimate_of),
                            .bias = mean_of(values, count),
                            .gain = gain_of(results, scene, variant, budget)};
}

const char *results_failure(const results_t *results, size_t scene, size_t variant)
{
    if (results->scenes[scene].failure[0])
        return results->scenes[scene].failure;
    for (size_t i = 0; i < results->matrix->seeds; i++) {
        const run_figures_t *run = results_run(results, scene, variant, i);
        if (!run->made)
            return run->failure[0] ? run->failure : "not run";
    }
    return NULL;
}
