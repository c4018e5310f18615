#include "client/bench/run.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "base/file.h"
#include "client/bench/solo.h"
#include "film/compare.h"
#include "film/image_file.h"
#include "film/pfm.h"

enum { RUN_BYTES = 1 << 16, SHORT_DIGITS = 12 };

json_t *run_point_json(const run_point_t *point)
{
    json_t *object = json_new_object();
    json_add_number(object, "cpu_seconds", point->cpu_seconds);
    json_add_number(object, "mutations_per_pixel", point->mutations_per_pixel);
    json_add_number(object, "relmse", point->relmse);
    json_add_number(object, "relmse_trimmed", point->trimmed);
    json_add_number(object, "relmse_estimated", point->estimate);
    json_add_number(object, "bias", point->bias);
    return object;
}

fault_code_t run_context_references(run_context_t *context, const char *const *paths, size_t count, fault_t *fault)
{
    for (size_t i = 0; i < count; i++) {
        TRY(image_file_read(&context->references[i], paths[i], fault));
        context->reference_count = i + 1;
    }
    return FAULT_NONE;
}

void run_context_clear(run_context_t *context)
{
    for (size_t i = 0; i < context->reference_count; i++)
        image_clear(&context->references[i]);
    context->reference_count = 0;
}

/* The part of the light that is in lengths whose chains are still to come. Lengths without a share have none: they
 * are left to samples. */
static double missing_light(const json_t *report)
{
    double missing = 0, total = 0;
    for (const json_t *m = json_first(json_get(report, "lengths")); m; m = json_next(m)) {
        const double b = json_number(json_get(json_get(m, "b"), "value"));
        const json_t *mutations = json_get(m, "mutations"), *share = json_get(m, "share");
        total += b;
        if (mutations && !(json_number(mutations) > 0) && !(share && json_number(share) == 0))
            missing += b;
    }
    return total > 0 ? missing / total : 0;
}

bool run_is_whole(const json_t *report)
{
    return missing_light(report) <= 0.03;
}

/* ---- keys ---- */

/* Of everything that a run's figures depend on. */
static fault_code_t make_key(const run_context_t *context, const job_t *job, char key[DIGEST_TEXT_SIZE],
                             fault_t *fault)
{
    char *job_text = job_print(job);
    char *text = NULL, digits[DIGEST_TEXT_SIZE];
    size_t size = 0;
    digest_t digest;
    FILE *out = job_text ? open_memstream(&text, &size) : NULL;
    if (!out) {
        free(job_text);
        return fault_set(fault, FAULT_MEMORY, "no memory for a run's key");
    }
    digest_print(&context->digest, digits);
    fprintf(out, "%s %s\n%s\n", GARLAND_VERSION, digits, job_text);
    for (size_t i = 0; i < context->matrix->budget_count; i++)
        fprintf(out, "%.17g\n", context->matrix->budgets[i]);
    for (size_t i = 0; i < context->reference_count; i++) {
        const image_t *image = &context->references[i];
        digest_of(&digest, image->data,
                  (size_t)image->channel_count * image->width * image->height * sizeof(float));
        digest_print(&digest, digits);
        fprintf(out, "%s\n", digits);
    }
    free(job_text);
    if (fclose(out) != 0)
        return fault_set(fault, FAULT_MEMORY, "no memory for a run's key");
    digest_of(&digest, text, size);
    digest_print(&digest, key);
    free(text);
    return FAULT_NONE;
}

/* The last budget's job, which stands for all of them beside the list of budgets. */
static fault_code_t run_key(const run_context_t *context, size_t variant, uint64_t seed, job_t *job,
                            char key[DIGEST_TEXT_SIZE], fault_t *fault)
{
    TRY(matrix_job(job, context->matrix, context->index, variant, seed, context->matrix->budget_count - 1, fault));
    return make_key(context, job, key, fault);
}

/* ---- a run ---- */

typedef struct look {
    const run_context_t *context;
    run_point_t *point;
} look_t;

static double report_number(const json_t *report, const char *group, const char *name)
{
    const json_t *value = json_get(json_get(report, group), name);
    return json_is_number(value) ? json_number(value) : NAN;
}

static fault_code_t look_compare(const run_context_t *context, const plan_t *plan, run_point_t *point,
                                 fault_t *fault)
{
    image_t image;
    compare_result_t *result = calloc(1, sizeof *result);
    if (!result)
        return fault_set(fault, FAULT_MEMORY, "no memory for a comparison");
    const compare_options_t options = {.names = {"the render", "the reference", "the second reference"}};
    fault_code_t code = plan_image(plan, &image, fault);
    if (code == FAULT_NONE) {
        code = compare_images(result, &image, &context->references[0],
                              context->reference_count > 1 ? &context->references[1] : NULL, &options, fault);
        image_clear(&image);
    }
    point->relmse = result->relmse;
    point->trimmed = result->relmse_trimmed;
    point->bias = result->bias;
    free(result);
    return code;
}

static fault_code_t look_at_run(void *user, size_t index, double cpu_seconds, const plan_t *plan, fault_t *fault)
{
    const look_t *look = user;
    run_point_t *point = look->point;
    (void)index;
    json_t *report = plan_report(plan);
    *point = (run_point_t){cpu_seconds, report_number(report, "rates", "mutations_per_pixel"),
                           NAN,         NAN,
                           NAN,         report_number(report, "error", "relmse")};
    const bool whole = run_is_whole(report);
    json_destroy(&report);
    if (!whole)
        point->estimate = NAN;
    return !whole || look->context->reference_count == 0 ? FAULT_NONE
                                                         : look_compare(look->context, plan, point, fault);
}

static fault_code_t write_run(const run_context_t *context, const run_point_t *points, const char *key,
                              const char *path, fault_t *fault)
{
    json_t *root = json_new_object(), *list = json_new_array();
    json_add_string(root, "key", key);
    for (size_t i = 0; i < context->matrix->budget_count; i++)
        json_append(list, run_point_json(&points[i]));
    json_add(root, "points", list);
    char *text = json_print(root, true);
    json_destroy(&root);
    const fault_code_t code = file_write(path, text, strlen(text), fault);
    free(text);
    return code;
}

static fault_code_t render_budget(const run_context_t *context, size_t variant, uint64_t seed, size_t budget,
                                  job_t *job, run_point_t *point, fault_t *fault)
{
    const matrix_t *matrix = context->matrix;
    look_t look = {context, point};
    TRY(matrix_job(job, matrix, context->index, variant, seed, budget, fault));
    return (matrix->by_mutations ? solo_render_mutations : solo_render)(
        context->scene, job, &matrix->budgets[budget], 1, look_at_run, &look, fault);
}

fault_code_t run_render(const run_context_t *context, size_t variant, uint64_t seed, const char *path,
                        fault_t *fault)
{
    char key[DIGEST_TEXT_SIZE];
    run_point_t points[MATRIX_BUDGETS];
    job_t *job = calloc(1, sizeof *job);
    if (!job)
        return fault_set(fault, FAULT_MEMORY, "no memory for a job");
    fault_code_t code = run_key(context, variant, seed, job, key, fault);
    for (size_t b = 0; b < context->matrix->budget_count && code == FAULT_NONE; b++)
        code = render_budget(context, variant, seed, b, job, &points[b], fault);
    free(job);
    return code == FAULT_NONE ? write_run(context, points, key, path, fault) : code;
}

static double read_number(const json_t *object, const char *name)
{
    const json_t *value = json_get(object, name);
    return value && json_is_number(value) ? json_number(value) : NAN;
}

static bool read_run(run_figures_t *figures, const json_t *root, const char *key, size_t budgets)
{
    const json_t *list = json_is_object(root) ? json_get(root, "points") : NULL,
                 *found = list ? json_get(root, "key") : NULL;
    const char *text = found ? json_string(found) : NULL;
    if (!text || strcmp(text, key) != 0 || !json_is_array(list) || json_size(list) != budgets)
        return false;
    size_t i = 0;
    for (const json_t *m = json_first(list); m; m = json_next(m))
        figures->points[i++] = (run_point_t){read_number(m, "cpu_seconds"), read_number(m, "mutations_per_pixel"),
                                             read_number(m, "relmse"),      read_number(m, "relmse_trimmed"),
                                             read_number(m, "bias"),        read_number(m, "relmse_estimated")};
    figures->made = true;
    figures->failure[0] = '\0';
    return true;
}

bool run_load(run_figures_t *figures, const run_context_t *context, size_t variant, uint64_t seed, const char *path)
{
    char key[DIGEST_TEXT_SIZE];
    uint8_t *text;
    size_t size;
    json_t *root = NULL;
    job_t *job = calloc(1, sizeof *job);
    const bool known = job && run_key(context, variant, seed, job, key, NULL) == FAULT_NONE;
    free(job);
    if (!known || file_read(path, RUN_BYTES, &text, &size, NULL) != FAULT_NONE)
        return false;
    const bool good = json_parse(&root, (const char *)text, size, NULL) == FAULT_NONE &&
                      read_run(figures, root, key, context->matrix->budget_count);
    json_destroy(&root);
    free(text);
    return good;
}

/* ---- references ---- */

static fault_code_t look_at_reference(void *user, size_t index, double cpu_seconds, const plan_t *plan,
                                      fault_t *fault)
{
    (void)index;
    (void)cpu_seconds;
    return plan_image(plan, user, fault);
}

fault_code_t run_render_reference(const run_context_t *context, int half, const char *path, fault_t *fault)
{
    image_t image = {0};
    job_t *job = calloc(1, sizeof *job);
    if (!job)
        return fault_set(fault, FAULT_MEMORY, "no memory for a job");
    fault_code_t code = matrix_reference_job(job, context->matrix, context->index, half, fault);
    if (code == FAULT_NONE)
        code = solo_render(context->scene, job, &context->matrix->reference_seconds, 1, look_at_reference, &image,
                           fault);
    if (code == FAULT_NONE)
        code = pfm_write(&image, path, fault);
    image_clear(&image);
    free(job);
    return code;
}

fault_code_t run_reference_name(const run_context_t *context, int half, char *name, size_t size, fault_t *fault)
{
    char key[DIGEST_TEXT_SIZE];
    job_t *job = calloc(1, sizeof *job);
    if (!job)
        return fault_set(fault, FAULT_MEMORY, "no memory for a job");
    run_context_t bare = *context; /* a reference does not depend on references, nor on the runs' budgets */
    matrix_t *matrix = malloc(sizeof *matrix);
    fault_code_t code = matrix ? matrix_reference_job(job, context->matrix, context->index, half, fault)
                               : fault_set(fault, FAULT_MEMORY, "no memory for a bench");
    if (code == FAULT_NONE) {
        *matrix = *context->matrix;
        matrix->budget_count = 0;
        bare.matrix = matrix;
        bare.reference_count = 0;
        code = make_key(&bare, job, key, fault);
    }
    free(matrix);
    free(job);
    TRY(code);
    const int length = snprintf(name, size, "%s-%c-%.*s.pfm", context->matrix->scenes[context->index].name,
                                half ? 'b' : 'a', SHORT_DIGITS, key);
    return (size_t)length < size ? FAULT_NONE : fault_set(fault, FAULT_LIMIT, "a reference's name is too long");
}
