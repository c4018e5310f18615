#include "estimates.h"

#include <math.h>
#include <stdlib.h>

#include "film/compare.h"
#include "parallel.h"

static const uint64_t reference_seed = (uint64_t)1 << 32;

static double member(const json_t *object, const char *name)
{
    const json_t *value = json_get(object, name);
    return value && json_is_number(value) ? json_number(value) : NAN;
}

static const json_t *regions_of(const parallel_run_t *run)
{
    return json_get(json_get(run->report, "regions"), "values");
}

fault_code_t estimates_reference(estimates_reference_t *reference, const scene_t *scene, const job_t *job,
                                 unsigned threads, fault_t *fault)
{
    *reference = (estimates_reference_t){0};
    job_t own = *job;
    for (int half = 0; half < 2; half++) {
        parallel_run_t run;
        own.settings.seed = reference_seed + (uint64_t)half;
        const fault_code_t code = parallel_render(&run, scene, &own, threads, fault);
        if (code) {
            estimates_reference_clear(reference);
            return code;
        }
        int r = 0;
        for (const json_t *region = json_first(regions_of(&run)); region && r < PLAN_REGIONS;
             region = json_next(region), r++) {
            const double low = member(region, "low"), high = member(region, "high");
            reference->luminance[r] += member(region, "luminance") / 2;
            reference->standard_error[r] = hypot(reference->standard_error[r], (high - low) / (2 * 1.96 * 2));
        }
        reference->images[half] = run.image;
        run.image = (image_t){0};
        parallel_clear(&run);
    }
    return FAULT_NONE;
}

void estimates_reference_clear(estimates_reference_t *reference)
{
    image_clear(&reference->images[0]);
    image_clear(&reference->images[1]);
}

/* One render. */
typedef struct estimates_run {
    double relmse, estimate, low, high;
    bool reliable;
    double covered, wide; /* means over regions */
    double cpu_seconds;
} estimates_run_t;

static void run_regions(estimates_run_t *out, const parallel_run_t *run, const estimates_reference_t *reference)
{
    double covered = 0, wide = 0;
    int r = 0;
    for (const json_t *region = json_first(regions_of(run)); region && r < PLAN_REGIONS;
         region = json_next(region), r++) {
        const double low = member(region, "low"), high = member(region, "high"), truth = reference->luminance[r];
        covered += low <= truth && truth <= high;
        wide += (high - low) / (2 * truth);
    }
    out->covered = covered / PLAN_REGIONS;
    out->wide = wide / PLAN_REGIONS;
}

static fault_code_t run_one(estimates_run_t *out, const scene_t *scene, const job_t *job, unsigned threads,
                            const estimates_reference_t *reference, fault_t *fault)
{
    static compare_result_t result; /* large */
    parallel_run_t run;
    TRY(parallel_render(&run, scene, job, threads, fault));
    fault_code_t code =
        compare_images(&result, &run.image, &reference->images[0], &reference->images[1], NULL, fault);
    if (!code) {
        const json_t *error = json_get(run.report, "error"), *interval = json_get(error, "interval");
        const json_t *low = json_first(interval), *high = low ? json_next(low) : NULL;
        *out = (estimates_run_t){.relmse = result.relmse,
                                 .estimate = member(error, "relmse"),
                                 .low = low && json_is_number(low) ? json_number(low) : NAN,
                                 .high = high && json_is_number(high) ? json_number(high) : NAN,
                                 .cpu_seconds = run.cpu_seconds};
        run_regions(out, &run, reference);
        code = json_read_bool_or(error, "error", "reliable", &out->reliable, fault);
    }
    parallel_clear(&run);
    return code;
}

static estimates_figure_t figure_of(double sum, double squares, double n)
{
    const double mean = sum / n;
    return (estimates_figure_t){mean, sqrt(fmax(0, squares / n - mean * mean) / (n - 1))};
}

static void summarise(estimates_t *found, const estimates_run_t *runs, unsigned seeds)
{
    double inside = 0, interval = 0, covered = 0, covered2 = 0, off2 = 0;
    *found = (estimates_t){.seeds = seeds};
    for (unsigned i = 0; i < seeds; i++) {
        found->relmse += runs[i].relmse / seeds;
        found->estimate += runs[i].estimate / seeds;
        found->wide += runs[i].wide / seeds;
        found->cpu_seconds += runs[i].cpu_seconds;
        covered += runs[i].covered;
        covered2 += runs[i].covered * runs[i].covered;
    }
    for (unsigned i = 0; i < seeds; i++) {
        const double off = runs[i].relmse / found->relmse - runs[i].estimate / found->estimate;
        off2 += off * off;
        inside += runs[i].low <= runs[i].relmse && runs[i].relmse <= runs[i].high;
        interval += 0.5 * log(runs[i].high / runs[i].low) / seeds;
        const bool near =
            runs[i].relmse < ESTIMATES_OFF * runs[i].estimate && runs[i].estimate < ESTIMATES_OFF * runs[i].relmse;
        *(runs[i].reliable ? &found->reliable : &found->unreliable) += 1;
        *(runs[i].reliable ? &found->reliable_off : &found->unreliable_off) += !near;
    }
    const double ratio = found->relmse / found->estimate;
    found->ratio = (estimates_figure_t){ratio, ratio * sqrt(off2 / seeds / (seeds - 1))};
    found->inside = figure_of(inside, inside, seeds);
    found->interval = exp(interval);
    found->covered = figure_of(covered, covered2, seeds);
}

fault_code_t estimates_measure(estimates_t *found, const scene_t *scene, const job_t *job, unsigned seeds,
                               unsigned threads, const estimates_reference_t *reference, fault_t *fault)
{
    estimates_run_t *runs = calloc(seeds, sizeof *runs);
    fault_code_t code = runs ? FAULT_NONE : fault_set(fault, FAULT_MEMORY, "no memory for %u renders", seeds);
    for (unsigned i = 0; i < seeds && !code; i++) {
        job_t own = *job;
        own.settings.seed = i + 1;
        code = run_one(&runs[i], scene, &own, threads, reference, fault);
    }
    if (!code)
        summarise(found, runs, seeds);
    free(runs);
    return code;
}
