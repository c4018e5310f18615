#include "service/service_fixture.h"

#include <setjmp.h>
#include <stdarg.h>
#include <cmocka.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "client/scene_source.h"
#include "client/temp_folder.h"
#include "film/exr.h"

char fixture_folder[FIXTURE_PATH], fixture_bundle[FIXTURE_PATH];
digest_t fixture_digest;

int fixture_setup(void **state)
{
    (void)state;
    char scene[FIXTURE_PATH], folder[TEMP_FOLDER_SIZE];
    const char *tests = getenv("GARLAND_TESTS");
    fault_t fault = {0};
    if (access("/dev/shm", W_OK) == 0)
        setenv("TMPDIR", "/dev/shm", 1); /* a disk that others keep busy makes syncs slow */
    snprintf(scene, sizeof scene, "%s/scenes/diffuse.pbrt", tests ? tests : "tests");
    if (temp_folder_make(folder, &fault) != FAULT_NONE) {
        print_error("%s\n", fault.text);
        return -1;
    }
    snprintf(fixture_folder, sizeof fixture_folder, "%s", folder);
    snprintf(fixture_bundle, sizeof fixture_bundle, "%s/scene.bundle", folder);
    if (scene_source_pack(scene, fixture_bundle, NULL, &fixture_digest, NULL, &fault) != FAULT_NONE) {
        print_error("%s\n", fault.text);
        return -1;
    }
    return 0;
}

int fixture_teardown(void **state)
{
    (void)state;
    temp_folder_remove(fixture_folder);
    return 0;
}

const char *fixture_path(const char *name)
{
    static char paths[5][2 * FIXTURE_PATH];
    static int turn;
    char *path = paths[turn++ % 5];
    snprintf(path, sizeof paths[0], "%s/%s", fixture_folder, name);
    return path;
}

void fixture_remove(const char *name)
{
    temp_folder_remove(fixture_path(name));
}

const char *fixture_job(double mutations_per_pixel, int seed)
{
    static char text[512];
    snprintf(text, sizeof text,
             "{\"scene\": \"diffuse.pbrt\", \"algorithm\": \"mmlt\", \"max_path_length\": 4, \"seed\": \"%d\", "
             "\"stop\": {\"mutations_per_pixel\": %g}, \"output\": {\"image\": \"o.exr\", \"preview\": \"o.png\", "
             "\"report\": \"o.json\"}}",
             seed, mutations_per_pixel);
    return text;
}

void fixture_renderer(bundle_t **bundle, renderer_t **renderer)
{
    fault_t fault = {0};
    const char *text = fixture_job(1, 1);
    job_t *job = malloc(sizeof *job);
    assert_int_equal(job_parse(job, text, strlen(text), "job", &fault), FAULT_NONE);
    assert_int_equal(bundle_open(bundle, fixture_bundle, &fault), FAULT_NONE);
    assert_int_equal(renderer_new(renderer, bundle_scene(*bundle), &job->settings, &fault), FAULT_NONE);
    free(job);
}

void fixture_run_unit(renderer_t *renderer, const work_record_t *record, uint8_t **data, size_t *size)
{
    fault_t fault = {0};
    work_space_t *space;
    work_result_t result;
    atomic_bool cancel;
    atomic_init(&cancel, false);
    assert_int_equal(work_space_new(&space, renderer, &fault), FAULT_NONE);
    if (work_run(space, record, &cancel, &result, &fault) != FAULT_NONE)
        fail_msg("work_run: %s", fault.text);
    assert_int_equal(work_result_encode(&result, data, size, &fault), FAULT_NONE);
    work_space_destroy(&space);
}

static void digest_image(const image_t *image, digest_t *pixels)
{
    const float *planes[3];
    const size_t plane = (size_t)image->width * image->height * sizeof(float);
    digest_t parts[3];
    fault_t fault = {0};
    assert_int_equal(image_find_rgb(image, planes, &fault), FAULT_NONE);
    for (int c = 0; c < 3; c++)
        digest_of(&parts[c], planes[c], plane);
    digest_of(pixels, parts, sizeof parts);
}

void fixture_direct(const char *text, digest_t *pixels)
{
    fault_t fault = {0};
    job_t *job = malloc(sizeof *job);
    bundle_t *bundle;
    plan_t *plan;
    renderer_t *renderer;
    assert_int_equal(job_parse(job, text, strlen(text), "job", &fault), FAULT_NONE);
    assert_int_equal(bundle_open(&bundle, fixture_bundle, &fault), FAULT_NONE);
    assert_int_equal(plan_new(&plan, job, bundle_scene(bundle), &fault), FAULT_NONE);
    assert_int_equal(renderer_new(&renderer, bundle_scene(bundle), &job->settings, &fault), FAULT_NONE);
    uint64_t unit;
    const work_record_t *record;
    while (plan_next(plan, &unit, &record)) {
        uint8_t *data;
        size_t size;
        plan_absorbed_t how;
        fixture_run_unit(renderer, record, &data, &size);
        assert_int_equal(plan_absorb(plan, unit, data, size, &how, &fault), FAULT_NONE);
        assert_int_equal(how, PLAN_MERGED);
        free(data);
    }
    plan_check_stop(plan, 1);
    assert_true(plan_finished(plan));
    image_t image;
    assert_int_equal(plan_image(plan, &image, &fault), FAULT_NONE);
    digest_image(&image, pixels);
    image_clear(&image);
    renderer_destroy(&renderer);
    plan_destroy(&plan);
    bundle_destroy(&bundle);
    free(job);
}

void fixture_pixels(const char *path, digest_t *pixels)
{
    fault_t fault = {0};
    image_t image;
    if (exr_read(&image, path, &fault) != FAULT_NONE)
        fail_msg("%s", fault.text);
    digest_image(&image, pixels);
    image_clear(&image);
}
