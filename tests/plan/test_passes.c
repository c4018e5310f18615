/* Passes of samples over the image that are made in parts: they are whole, exact and come back from a checkpoint; a
 * render that ends within its first pass is in time, and unbiased. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#include "base/clock.h"
#include "plan/plan_fixture.h"
#include "plan/plan_passes.h"
#include "plan/plan_state.h"
#include "support/near.h"
#include "support/sanitized.h"

/* Enough pixels for two parts a pass, or two lattices. */
#define LARGE "'film':{'width':512,'height':300}"
enum { WIDTH = 512, HEIGHT = 300, PIXELS = WIDTH * HEIGHT };

static job_t job_of(const char *algorithm, const char *film, const char *stop)
{
    char text[256];
    snprintf(text, sizeof text,
             "{'scene':'x','algorithm':'%s','max_path_length':4,%s,'chains':{'pilot_samples':512},'stop':{%s}}",
             algorithm, film, stop);
    return plan_fixture_job(text);
}

/* A plan of which only what cuts passes is known. */
static void make_plan(plan_t *plan, plan_length_t *samples, uint32_t width, uint32_t height, double seconds)
{
    *plan = (plan_t){.pixels = (size_t)width * height, .lengths = samples};
    plan->settings.width = width;
    plan->settings.height = height;
    plan->job.stop.seconds = seconds;
    *samples = (plan_length_t){.budget = UINT64_MAX, .unit_mutations = plan->pixels};
    plan_passes_init(plan);
}

static void place(plan_t *plan, work_record_t *record)
{
    *record = (work_record_t){.count = plan->lengths[0].unit_mutations};
    plan_passes_place(plan, record);
    plan->lengths[0].handed += record->count;
    plan->lengths[0].units_out++;
}

/* ---- how a pass is cut ---- */

static void parts_of_a_pass_hold_each_pixel_once(void **state)
{
    (void)state;
    static const uint32_t films[][2] = {{512, 300}, {1920, 1080}, {1, 200000},
                                        {32768, 7}, {641, 481},   {3000, 2000}};
    for (size_t f = 0; f < sizeof films / sizeof *films; f++)
        for (int timed = 0; timed < 2; timed++) {
            plan_t plan;
            plan_length_t samples;
            work_record_t record;
            make_plan(&plan, &samples, films[f][0], films[f][1], timed ? 3 : 0);
            assert_true(plan.passes.parts > 1 && (plan.passes.lattice > 0) == (timed == 1));
            uint8_t *seen = calloc(2 * plan.pixels, 1);
            while (samples.handed < 2 * plan.pixels) {
                place(&plan, &record);
                assert_true(record.count > 0 && record.count <= 1 << 17);
                for (uint64_t i = 0; i < record.count; i++)
                    seen[record.first + i * (record.skip + 1)]++;
            }
            for (size_t i = 0; i < 2 * plan.pixels; i++)
                if (seen[i] != 1)
                    fail_msg("%u x %u, timed %d: sample %zu is in %u units", films[f][0], films[f][1], timed, i,
                             seen[i]);
            assert_int_equal(samples.handed, 2 * plan.pixels); /* a pass begins where another ends */
            free(seen);
        }
}

static void small_images_have_a_unit_a_pass(void **state)
{
    (void)state;
    plan_t plan;
    plan_length_t samples;
    work_record_t record;
    make_plan(&plan, &samples, 320, 240, 3);
    assert_int_equal(plan.passes.parts, 1);
    for (uint64_t pass = 0; pass < 3; pass++) {
        place(&plan, &record);
        assert_int_equal(record.first, pass * 320 * 240);
        assert_int_equal(record.count, 320 * 240);
        assert_int_equal(record.skip, 0);
    }
}

/* Over all the places where the order of parts may begin, each pixel is in the first m parts equally often. */
static void any_pixel_may_be_in_any_part(void **state)
{
    (void)state;
    plan_t plan;
    plan_length_t samples;
    make_plan(&plan, &samples, WIDTH, HEIGHT, 3);
    const uint32_t begins = PASSES_EARLY * plan.passes.lattice;
    const uint64_t units = PASSES_EARLY + plan.passes.lattice - 1;
    for (uint64_t m = 1; m <= units; m++) {
        uint32_t *often = calloc(PIXELS, sizeof *often);
        for (plan.passes.begin = 0; plan.passes.begin < begins; plan.passes.begin++) {
            samples.handed = samples.units_out = 0;
            for (uint64_t unit = 0; unit < m; unit++) {
                work_record_t record;
                place(&plan, &record);
                for (uint64_t i = 0; i < record.count; i++)
                    often[record.first + i * (record.skip + 1)]++;
            }
        }
        const uint32_t expected = (uint32_t)(m <= PASSES_EARLY ? m : PASSES_EARLY * (m - PASSES_EARLY + 1));
        for (size_t p = 0; p < PIXELS; p++)
            assert_int_equal(often[p], expected);
        free(often);
    }
}

/* No two pixels of a lattice of some twenty parts are nearer than half of what they were in a square grid. */
static void pixels_of_a_part_are_spread(void **state)
{
    (void)state;
    static const uint32_t widths[] = {1920, 3840, 1280, 1024, 4096, 1000, 777};
    for (size_t i = 0; i < sizeof widths / sizeof *widths; i++) {
        plan_t plan;
        plan_length_t samples;
        make_plan(&plan, &samples, widths[i], (32u << 16) / widths[i], 3);
        const int64_t parts = plan.passes.lattice;
        int64_t nearest = INT64_MAX;
        for (int64_t y = 0; y < 8; y++)
            for (int64_t x = -8; x <= 8; x++)
                if ((y > 0 || x > 0) && (x + y * widths[i]) % parts == 0 && x * x + y * y < nearest)
                    nearest = x * x + y * y;
        if (nearest < parts / 4)
            fail_msg("width %u: a part of %d has pixels at a distance of the root of %d", widths[i], (int)parts,
                     (int)nearest);
    }
}

/* ---- exact sums ---- */

/* The next unit, run; false if there is none now. */
typedef struct ran {
    uint64_t unit;
    uint8_t *data;
    size_t size;
    bool samples;
} ran_t;

static bool run_next(plan_t *plan, plan_worker_t *worker, ran_t *ran)
{
    const work_record_t *record;
    if (!plan_next(plan, &ran->unit, &record))
        return false;
    ran->samples = record->kind == WORK_SAMPLES;
    ran->data = plan_worker_run(worker, record, &ran->size);
    return true;
}

static void take(plan_t *plan, ran_t *ran)
{
    plan_absorbed_t how;
    fault_t fault = {0};
    if (plan_absorb(plan, ran->unit, ran->data, ran->size, &how, &fault))
        fail_msg("%s", fault.text);
    assert_int_equal(how, PLAN_MERGED);
    free(ran->data);
}

/* Until the render has begun. */
static void run_pilot(plan_t *plan, plan_worker_t *worker)
{
    while (plan->phase == PLAN_PILOT)
        assert_true(plan_fixture_step(plan, worker));
}

static void restart(plan_t **plan, const job_t *job, const scene_t *scene)
{
    uint8_t *data, *again;
    size_t size, size_again;
    fault_t fault = {0};
    assert_int_equal(plan_save(*plan, &data, &size, &fault), FAULT_NONE);
    plan_destroy(plan);
    if (plan_restore(plan, job, scene, data, size, &fault))
        fail_msg("%s", fault.text);
    assert_int_equal(plan_save(*plan, &again, &size_again, &fault), FAULT_NONE);
    assert_int_equal(size_again, size);
    assert_memory_equal(data, again, size);
    data[size / 2] ^= 0x10; /* and what is not one is refused, or is another: it does no harm */
    plan_t *other = NULL;
    if (plan_restore(&other, job, scene, data, size, &fault) == FAULT_NONE)
        plan_destroy(&other);
    free(data);
    free(again);
}

/* Parts come in backwards, three passes at once, with a restart amid them: the film is that of one unit of all. */
static void parts_add_up_to_the_pass(void **state)
{
    (void)state;
    small_scene_t small;
    small_scene_diffuse(&small);
    const job_t job = job_of("bdpt", LARGE, "'mutations_per_pixel':3");
    plan_worker_t worker;
    plan_worker_make(&worker, &job, &small.scene);
    plan_t *plan = plan_fixture_new(&job, &small.scene);
    run_pilot(plan, &worker);
    work_record_t whole = {.kind = WORK_SAMPLES, .count = PIXELS, .scale = plan->scale};
    ran_t ran[8];
    int count = 0;
    while (count < 8 && run_next(plan, &worker, &ran[count]))
        count += ran[count].samples;
    assert_int_equal(count, 6);
    for (int i = count - 1; i >= 0; i--) {
        assert_false(plan_check_stop(plan, 1));
        take(plan, &ran[i]);
        assert_int_equal(plan->lengths[0].merged % PIXELS, 0);
        assert_int_equal(plan->lengths[0].merged / PIXELS, (count - i) / 2);
        if (i == 3)
            restart(&plan, &job, &small.scene);
    }
    assert_true(plan_check_stop(plan, 1));
    assert_string_equal(plan->stopped_by, "mutations_per_pixel");
    const atomic_bool go = false;
    work_result_t result;
    fault_t fault = {0};
    film_t film;
    assert_int_equal(film_init(&film, WIDTH, HEIGHT, &fault), FAULT_NONE);
    for (uint32_t pass = 0; pass < 3; pass++) { /* points of two sequences in turn */
        whole.first = pass * PIXELS;
        whole.sequence = pass % 2;
        whole.point = pass / 2;
        assert_int_equal(work_run(worker.space, &whole, &go, &result, &fault), FAULT_NONE);
        film_add(&film, &result.film);
        if (pass == 1)
            assert_memory_equal(result.film.sums, plan->nets.second.sums, sizeof(int64_t) * FILM_CHANNELS * PIXELS);
    }
    assert_memory_equal(film.sums, plan->lengths[0].film.sums, sizeof(int64_t) * FILM_CHANNELS * PIXELS);
    assert_memory_equal(&film.counts, &plan->film_counts, sizeof plan->film_counts);
    film_clear(&film);
    plan_destroy(&plan);
    plan_worker_clear(&worker);
    small_scene_clear(&small);
}

/* Passes that a lost part holds open are only so many. */
static void few_passes_are_open(void **state)
{
    (void)state;
    small_scene_t small;
    small_scene_diffuse(&small);
    const job_t job = job_of("pt", LARGE, "'mutations_per_pixel':40");
    plan_worker_t worker;
    plan_worker_make(&worker, &job, &small.scene);
    plan_t *plan = plan_fixture_new(&job, &small.scene);
    run_pilot(plan, &worker);
    ran_t first;
    assert_true(run_next(plan, &worker, &first));
    uint64_t parts = 1;
    const work_record_t *record;
    for (uint64_t unit; plan_next(plan, &unit, &record);)
        parts += record->kind == WORK_SAMPLES;
    assert_int_equal(parts, 2 * PASSES_OPEN);
    take(plan, &first);
    assert_int_equal(plan_passes_waiting(plan), PIXELS / 2);
    plan_destroy(&plan);
    plan_worker_clear(&worker);
    small_scene_clear(&small);
}

/* ---- ends ---- */

/* Luminance of the image's blocks, each mean over its pixels. */
enum { BLOCKS = 12 };
static void add_blocks(const plan_t *plan, double sums[BLOCKS])
{
    image_t image;
    fault_t fault = {0};
    assert_int_equal(plan_image(plan, &image, &fault), FAULT_NONE);
    for (uint32_t p = 0; p < image.width * image.height; p++) {
        const uint32_t x = p % image.width * 4 / image.width, y = p / image.width * 3 / image.height;
        sums[4 * y + x] += BLOCKS *
                           rgb_luminance(rgb(image_channel(&image, 0)[p], image_channel(&image, 1)[p],
                                             image_channel(&image, 2)[p])) /
                           (image.width * image.height);
    }
    image_clear(&image);
}

/* Renders over seeds against one of other seeds; every block within 5.5 standard errors, which with 14 degrees
 * of freedom or more is a false alarm in 1 of 1 000 runs. `steps`: units of samples after which time is over; 0:
 * none. */
static void check_blocks(const char *algorithm, const char *film, const char *stop, int steps, int seeds,
                         const char *reference)
{
    double sums[2][BLOCKS] = {{0}, {0}}, squares[2][BLOCKS] = {{0}, {0}};
    small_scene_t small;
    small_scene_diffuse(&small);
    for (int s = 0; s < seeds + 8; s++) {
        const int is = s >= seeds; /* the reference */
        double blocks[BLOCKS] = {0};
        job_t job = job_of(algorithm, film, is ? reference : stop);
        job.settings.seed = (uint64_t)s + 1;
        plan_worker_t worker;
        plan_worker_make(&worker, &job, &small.scene);
        plan_t *plan = plan_fixture_new(&job, &small.scene);
        if (is || steps == 0) {
            plan_fixture_run(plan, &worker, 0);
        } else {
            run_pilot(plan, &worker);
            for (int i = 0; i < steps; i++)
                assert_true(plan_fixture_step(plan, &worker));
            assert_int_equal(plan->lengths[0].units_in, 0);
            assert_true(plan_check_stop(plan, 100));
            assert_int_equal(plan->lengths[0].units_in, 1);
            assert_int_equal(plan->passes.count, 0);
        }
        add_blocks(plan, blocks);
        for (int i = 0; i < BLOCKS; i++) {
            sums[is][i] += blocks[i];
            squares[is][i] += blocks[i] * blocks[i];
        }
        plan_destroy(&plan);
        plan_worker_clear(&worker);
    }
    small_scene_clear(&small);
    for (int i = 0; i < BLOCKS; i++) {
        double mean[2], variance[2];
        for (int is = 0; is < 2; is++) {
            const double n = is ? 8 : seeds;
            mean[is] = sums[is][i] / n;
            variance[is] = fmax(0, squares[is][i] / n - mean[is] * mean[is]) / (n - 1);
        }
        assert_near(mean[0], mean[1], 5.5 * sqrt(variance[0] + variance[1]));
    }
}

/* Two of the nine units of the first pass. */
static void an_end_within_the_first_pass_is_unbiased(void **state)
{
    (void)state;
    if (SANITIZED)
        skip();
    check_blocks("bdpt", "'film':{'width':300,'height':512}", "'seconds':3", 2, 10, "'mutations_per_pixel':1");
}

/* Less than a mutation a pixel is one, and a half more is rounded up: with a part of a pass alone the first rows
 * would have samples that the last have not. */
static void fractions_of_a_pass_are_rounded_up(void **state)
{
    (void)state;
    if (SANITIZED)
        skip();
    check_blocks("bdpt", "'film':{'width':4,'height':3}", "'mutations_per_pixel':0.3", 0, 500,
                 "'mutations_per_pixel':1000");
    check_blocks("bdpt", "'film':{'width':4,'height':3}", "'mutations_per_pixel':1.5", 0, 300,
                 "'mutations_per_pixel':1000");
}

/* A large image under a rule of seconds, by the clock of the thread: late by a unit or so. */
static void large_images_end_in_time(void **state)
{
    (void)state;
    if (SANITIZED)
        skip();
    small_scene_t small;
    small_scene_diffuse(&small);
    const job_t job = job_of("bdpt", "'film':{'width':1920,'height':1080}", "'seconds':3");
    plan_worker_t worker;
    plan_worker_make(&worker, &job, &small.scene);
    plan_t *plan = plan_fixture_new(&job, &small.scene);
    const double begin = clock_thread_cpu();
    double now, before = 0, longest = 0;
    while (!plan_check_stop(plan, now = clock_thread_cpu() - begin)) {
        assert_true(plan_fixture_step(plan, &worker));
        longest = fmax(longest, now - before);
        before = now;
    }
    print_message("ended after %.3f s, %.3f passes, no unit longer than %.3f s\n", now,
                  (double)plan->lengths[0].merged / (1920 * 1080), longest);
    assert_string_equal(plan->stopped_by, "seconds");
    assert_near(now, 3, 0.5);
    assert_true(plan->lengths[0].merged > 0);
    plan_destroy(&plan);
    plan_worker_clear(&worker);
    small_scene_clear(&small);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(parts_of_a_pass_hold_each_pixel_once),
        cmocka_unit_test(small_images_have_a_unit_a_pass),
        cmocka_unit_test(any_pixel_may_be_in_any_part),
        cmocka_unit_test(pixels_of_a_part_are_spread),
        cmocka_unit_test(parts_add_up_to_the_pass),
        cmocka_unit_test(few_passes_are_open),
        cmocka_unit_test(an_end_within_the_first_pass_is_unbiased),
        cmocka_unit_test(fractions_of_a_pass_are_rounded_up),
        cmocka_unit_test(large_images_end_in_time),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
