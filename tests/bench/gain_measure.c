#include "gain_measure.h"

#include <math.h>
#include <pthread.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "calibrate.h"
#include "film/compare.h"
#include "math/vec.h"
#include "parallel.h"
#include "client/bench/run.h"
#include "client/bench/seeds.h"
#include "client/bench/solo.h"

/* Images of one variant. */
typedef struct images {
    double *sums;      /* [3][pixels], over the seeds */
    float *luminances; /* [seeds][pixels] */
} images_t;

typedef struct measure {
    gain_scene_t *scene;
    const peer_loaded_t *loaded;
    const gain_reference_t *reference;
    const gain_options_t *options;
    size_t pixels;
    images_t *images;     /* of each entry */
    size_t next;          /* run to be made */
    pthread_mutex_t lock; /* of next, the entries and the sums */
} measure_t;

/* ---- one run ---- */

typedef struct run {
    measure_t *measure;
    gain_run_t *figures;
    image_t image;  /* the last */
    json_t *report; /* the last */
    double nonfinite;
} run_t;

static gain_point_t run_point(const compare_result_t *result, const json_t *report, double cpu_seconds)
{
    gain_point_t point = {.cpu_seconds = cpu_seconds,
                          .mutations = json_number(json_get(json_get(report, "rates"), "mutations")),
                          .relmse = result->relmse,
                          .trimmed = result->relmse_trimmed,
                          .brightness = result->bias};
    if (!run_is_whole(report))
        point.relmse = point.trimmed = NAN;
    return point;
}

/* Compares the image as it stands; keeps the last with its report. */
static fault_code_t run_look(void *user, size_t index, double cpu_seconds, const plan_t *plan, fault_t *fault)
{
    run_t *run = user;
    const gain_reference_t *reference = run->measure->reference;
    image_t image;
    TRY(plan_image(plan, &image, fault));
    json_t *report = plan_report(plan);
    compare_result_t *result = seeds_allocate(1, sizeof *result);
    const fault_code_t code =
        compare_images(result, &image, &reference->halves[0], &reference->halves[1], NULL, fault);
    run->figures->points[index] = run_point(result, report, cpu_seconds);
    if (index + 1 == run->measure->scene->point_count) {
        run->nonfinite = (double)result->nonfinite;
        run->report = report;
        run->image = image;
    } else {
        json_destroy(&report);
        image_clear(&image);
    }
    free(result);
    return code;
}

static double report_number(const json_t *report, const char *group, const char *name)
{
    const json_t *value = json_get(json_get(report, group), name);
    return json_is_number(value) ? json_number(value) : NAN;
}

static void run_figures(gain_run_t *figures, const json_t *report)
{
    figures->estimate = report_number(report, "error", "relmse");
    figures->us_per_mutation = 1e6 / report_number(report, "rates", "mutations_per_cpu_second");
    figures->rays_per_mutation =
        report_number(report, "rates", "rays") / report_number(report, "rates", "mutations");
}

static void length_add(gain_length_t *length, const json_t *m)
{
    length->mutations += json_number(json_get(m, "mutations"));
    length->cpu_seconds += json_number(json_get(m, "cpu_seconds"));
    length->zero += json_number(json_get(m, "zero_contribution"));
    length->longest_stay = fmax(length->longest_stay, json_number(json_get(m, "longest_stay")));
    for (const json_t *move = json_first(json_get(m, "moves")); move; move = json_next(move))
        gain_length_add(length, json_name(move), json_number(json_get(move, "proposed")),
                        json_number(json_get(move, "acceptance")));
}

/* Adds what the report says of the path lengths, and of chains of all lengths at once. */
static void entry_add_lengths(gain_entry_t *entry, const json_t *report)
{
    const json_t *whole = json_get(report, "chains");
    if (whole)
        length_add(&entry->lengths[0], whole);
    for (const json_t *m = json_first(json_get(report, "lengths")); m; m = json_next(m)) {
        const size_t k = (size_t)json_number(json_get(m, "length"));
        if (k < 1 || k >= GAIN_LENGTHS)
            continue;
        length_add(&entry->lengths[k], m);
        entry->length_count = k > entry->length_count ? k : entry->length_count;
    }
}

/* Adds a finished run to its entry; called with the lock held. Takes the report of the first seed. */
static fault_code_t entry_add(measure_t *m, gain_entry_t *entry, images_t *images, unsigned seed, run_t *run,
                              fault_t *fault)
{
    const float *planes[3];
    TRY(image_find_rgb(&run->image, planes, fault));
    for (size_t c = 0; c < 3; c++)
        for (size_t i = 0; i < m->pixels; i++)
            images->sums[c * m->pixels + i] += (double)planes[c][i];
    for (size_t i = 0; i < m->pixels; i++)
        images->luminances[seed * m->pixels + i] =
            (float)rgb_luminance(rgb((double)planes[0][i], (double)planes[1][i], (double)planes[2][i]));
    entry_add_lengths(entry, run->report);
    entry->nonfinite += run->nonfinite;
    if (seed == 0) {
        entry->report = run->report;
        run->report = NULL;
    }
    return FAULT_NONE;
}

static fault_code_t run_make(run_t *run, const gain_entry_t *entry, fault_t *fault)
{
    const measure_t *m = run->measure;
    job_t job;
    TRY(gain_job(&job, m->loaded->entry, m->scene->size, &entry->variant, run->figures->seed, m->options->seconds,
                 fault));
    TRY(solo_render(&m->loaded->scene, &job, m->scene->times, m->scene->point_count, run_look, run, fault));
    run_figures(run->figures, run->report);
    return FAULT_NONE;
}

static void run_print(const measure_t *m, const gain_entry_t *entry, const gain_run_t *figures)
{
    const gain_point_t *last = &figures->points[m->scene->point_count - 1];
    fprintf(stderr, "%-14s %-22s seed %llu: %.2f CPU s, %.1f a pixel, relMSE %.5g (%.5g), brightness %.4f\n",
            m->scene->name, entry->variant.name, (unsigned long long)figures->seed, last->cpu_seconds,
            last->mutations / (double)m->pixels, last->relmse, last->trimmed, last->brightness);
}

/* One run from beginning to end; called with the lock held, which it gives up while it renders. */
static void measure_one(measure_t *m, size_t index, unsigned seed)
{
    gain_entry_t *entry = &m->scene->entries[index];
    fault_t fault = {0};
    run_t run = {.measure = m, .figures = &entry->runs[seed]};
    if (entry->refused[0])
        return;
    run.figures->seed = m->options->first_seed + seed;
    pthread_mutex_unlock(&m->lock);
    fault_code_t code = run_make(&run, entry, &fault);
    pthread_mutex_lock(&m->lock);
    if (!code)
        code = entry_add(m, entry, &m->images[index], seed, &run, &fault);
    if (code) {
        snprintf(entry->refused, sizeof entry->refused, "seed %llu: %.200s", (unsigned long long)run.figures->seed,
                 fault.text);
        fprintf(stderr, "%s: %s: %s\n", m->scene->name, entry->variant.name, entry->refused);
    } else {
        run_print(m, entry, run.figures);
    }
    image_clear(&run.image);
    json_destroy(&run.report);
}

static void *measure_thread(void *user)
{
    measure_t *m = user;
    const size_t variants = m->scene->entry_count, runs = variants * m->options->seeds;
    pthread_mutex_lock(&m->lock);
    while (m->next < runs) {
        const size_t run = m->next++, seed = run / variants;
        measure_one(m, (run + seed) % variants, (unsigned)seed);
    }
    pthread_mutex_unlock(&m->lock);
    return NULL;
}

/* ---- all runs ---- */

/* relMSE of the seeds' mean is b + v/n, the mean of their relMSE b + v: b is what is common to all of them. */
static fault_code_t entry_systematic(gain_entry_t *entry, const images_t *images, const measure_t *m,
                                     fault_t *fault)
{
    const double n = (double)entry->run_count;
    double single = 0;
    image_t mean;
    TRY(image_init_rgb(&mean, m->scene->size.width, m->scene->size.height, fault));
    for (size_t i = 0; i < 3 * m->pixels; i++)
        mean.data[i] = (float)(images->sums[i] / n);
    for (size_t i = 0; i < entry->run_count; i++)
        single += entry->runs[i].points[m->scene->point_count - 1].relmse / n;
    compare_result_t *result = seeds_allocate(1, sizeof *result);
    const fault_code_t code =
        compare_images(result, &mean, &m->reference->halves[0], &m->reference->halves[1], NULL, fault);
    entry->systematic = n > 1 ? (n * result->relmse - single) / (n - 1) : NAN;
    free(result);
    image_clear(&mean);
    return code;
}

static fault_code_t measure_sum_up(measure_t *m, fault_t *fault)
{
    for (size_t i = 0; i < m->scene->entry_count; i++) {
        gain_entry_t *entry = &m->scene->entries[i];
        if (entry->refused[0])
            continue;
        seeds_deviation(m->images[i].luminances, m->options->seeds, m->pixels, &entry->deviation,
                        &entry->deviation_99);
        TRY(entry_systematic(entry, &m->images[i], m, fault));
    }
    return FAULT_NONE;
}

/* Entries of all variants; those that the job reader refuses get the reason. */
static void measure_entries(measure_t *m)
{
    const gain_options_t *o = m->options;
    gain_scene_t *scene = m->scene;
    scene->entry_count = o->variants->count;
    scene->entries = seeds_allocate(scene->entry_count, sizeof *scene->entries);
    m->images = seeds_allocate(scene->entry_count, sizeof *m->images);
    for (size_t i = 0; i < scene->entry_count; i++) {
        gain_entry_t *entry = &scene->entries[i];
        fault_t fault = {0};
        job_t job;
        entry->variant = o->variants->items[i];
        entry->run_count = o->seeds;
        entry->runs = seeds_allocate(o->seeds, sizeof *entry->runs);
        if (gain_job(&job, m->loaded->entry, scene->size, &entry->variant, 1, o->seconds, &fault)) {
            snprintf(entry->refused, sizeof entry->refused, "%.*s", (int)sizeof entry->refused - 1, fault.text);
            continue;
        }
        m->images[i].sums = seeds_allocate(3 * m->pixels, sizeof(double));
        m->images[i].luminances = seeds_allocate(o->seeds * m->pixels, sizeof(float));
    }
}

static void measure_scene(measure_t *m)
{
    const gain_options_t *o = m->options;
    gain_scene_t *scene = m->scene;
    const peer_scene_t *entry = m->loaded->entry;
    *scene = (gain_scene_t){.max_path_length = entry->max_path_length,
                            .size = gain_size_of(entry, o->width),
                            .point_count = o->points,
                            .calibration = calibrate_run(),
                            .reference_seconds = {m->reference->seconds[0], m->reference->seconds[1]},
                            .reference_noise = m->reference->noise,
                            .reference_difference = m->reference->difference};
    snprintf(scene->name, sizeof scene->name, "%s", entry->name);
    snprintf(scene->recipe, sizeof scene->recipe, "%s", m->reference->recipe);
    for (size_t i = 0; i < o->points; i++)
        scene->times[i] = ldexp(o->seconds, (int)i + 1 - (int)o->points);
    m->pixels = (size_t)scene->size.width * scene->size.height;
}

fault_code_t gain_measure(gain_scene_t *out, const peer_loaded_t *loaded, const gain_reference_t *reference,
                          const gain_options_t *options, fault_t *fault)
{
    pthread_t ids[PARALLEL_MAX_THREADS];
    unsigned started = 0;
    measure_t m = {.scene = out,
                   .loaded = loaded,
                   .reference = reference,
                   .options = options,
                   .lock = PTHREAD_MUTEX_INITIALIZER};
    measure_scene(&m);
    measure_entries(&m);
    while (started + 1 < options->threads && started < PARALLEL_MAX_THREADS &&
           !pthread_create(&ids[started], NULL, measure_thread, &m))
        started++;
    measure_thread(&m);
    for (unsigned i = 0; i < started; i++)
        pthread_join(ids[i], NULL);
    const fault_code_t code = measure_sum_up(&m, fault);
    for (size_t i = 0; i < out->entry_count; i++) {
        free(m.images[i].sums);
        free(m.images[i].luminances);
    }
    free(m.images);
    if (code)
        gain_scene_clear(out);
    return code;
}
