#include "plan/job.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <strings.h>

#include "path/walk.h"
#include "scene/scene.h"

/* Reads a name out of a list into its index; *out is left alone when the field is absent. */
static fault_code_t job_read_choice(const json_t *object, const char *path, const char *name,
                                    const char *const *choices, int count, int *out, fault_t *fault)
{
    const char *text = NULL;
    TRY(json_read_string_or(object, path, name, &text, fault));
    if (!text)
        return FAULT_NONE;
    char list[256] = "";
    for (int i = 0; i < count; i++) {
        if (strcmp(text, choices[i]) == 0) {
            *out = i;
            return FAULT_NONE;
        }
        const size_t used = strlen(list);
        snprintf(list + used, sizeof list - used, "%s\"%s\"",
                 i == 0           ? ""
                 : i + 1 == count ? " or "
                                  : ", ",
                 choices[i]);
    }
    return fault_set(fault, FAULT_UNKNOWN, "%s%s%s: \"%.100s\", expected %s", path, *path ? "." : "", name, text,
                     list);
}

static fault_code_t job_read_path(const json_t *object, const char *path, const char *name, char out[JOB_PATH_SIZE],
                                  fault_t *fault)
{
    const char *text = NULL;
    TRY(json_read_string_or(object, path, name, &text, fault));
    if (text && strlen(text) >= JOB_PATH_SIZE)
        return fault_set(fault, FAULT_LIMIT, "%s%s%s: %zu characters, expected fewer than %d", path,
                         *path ? "." : "", name, strlen(text), JOB_PATH_SIZE);
    if (text)
        snprintf(out, JOB_PATH_SIZE, "%s", text);
    return FAULT_NONE;
}

static const char *const filter_names[SCENE_FILTER_KINDS] = {"box", "triangle", "gaussian"};
enum { JOB_AUTO = SETTINGS_ALGORITHMS };
static const char *const algorithm_names[SETTINGS_ALGORITHMS + 1] = {
    "pt", "bdpt", "mmlt", "rjmlt", "cmlt", "cmlt-rex", "cmlt-ipsm", "pssmlt-mix", "pssmlt", "auto"};
static const char *const target_names[] = {"luminance", "maximum"};
static const char *const kernel_names[] = {"kelemen", "gaussian"};
static const char *const switch_names[SETTINGS_SWITCHES] = {"auto", "on", "off"};
static const char *const effect_names[SETTINGS_EFFECTS + 1] = {"caustics", "environment",    "aperture", "indirect",
                                                               "emission", "all_techniques", NULL};
static const char *const failure_names[SETTINGS_FAILURES] = {"plain", "delayed", "published"};

static fault_code_t job_read_film(const json_t *root, settings_t *settings, fault_t *fault)
{
    static const char *const names[] = {"width", "height", "filter", "filter_radius", NULL};
    const json_t *film = NULL;
    TRY(json_read_object(root, "", "film", &film, fault));
    if (!film)
        return FAULT_NONE;
    TRY(json_expect_fields(film, "film", names, fault));
    int64_t width = 0, height = 0;
    int filter = -1;
    TRY(json_read_int_or(film, "film", "width", 1, SCENE_MAX_FILM_SIZE, &width, fault));
    TRY(json_read_int_or(film, "film", "height", 1, SCENE_MAX_FILM_SIZE, &height, fault));
    TRY(job_read_choice(film, "film", "filter", filter_names, SCENE_FILTER_KINDS, &filter, fault));
    TRY(json_read_double_or(film, "film", "filter_radius", 0.5, 16, &settings->filter_radius, fault));
    if (settings->filter_radius > 0 && filter < 0)
        return fault_set(fault, FAULT_FORMAT, "film.filter_radius: goes with film.filter, which is missing");
    settings->width = (uint32_t)width;
    settings->height = (uint32_t)height;
    settings->filter = filter;
    return FAULT_NONE;
}

/* Moves that an algorithm does not have, and probabilities that leave none for small steps. */
static fault_code_t job_check_moves(const settings_t *s, fault_t *fault)
{
    const char *name = settings_algorithm_name(s->algorithm);
    const bool jumps = settings_jumps(s->algorithm) || s->algorithm == SETTINGS_CMLT_REX;
    if (s->failures == SETTINGS_FAILURES_PUBLISHED && s->algorithm != SETTINGS_MMLT &&
        !settings_jumps(s->algorithm))
        return fault_set(fault, FAULT_UNSUPPORTED,
                         "chains.failures: \"published\" is for mmlt, rjmlt and cmlt, not for %s", name);
    if (s->failures == SETTINGS_FAILURES_DELAYED && s->algorithm == SETTINGS_CMLT_IPSM)
        return fault_set(
            fault, FAULT_UNSUPPORTED,
            "chains.failures: \"delayed\" is not for cmlt-ipsm: its steps have no density of their own");
    if (s->auxiliary_step > 0 && s->algorithm != SETTINGS_MMLT && !settings_jumps(s->algorithm))
        return fault_set(fault, FAULT_UNSUPPORTED, "chains.auxiliary_step: is for mmlt, rjmlt and cmlt, not for %s",
                         name);
    if (s->equalize > 0 && s->failures == SETTINGS_FAILURES_PUBLISHED)
        return fault_set(fault, FAULT_UNSUPPORTED,
                         "chains.equalize: does not go with chains.failures \"published\"");
    if (s->split > 0 && s->failures == SETTINGS_FAILURES_PUBLISHED)
        return fault_set(fault, FAULT_UNSUPPORTED, "chains.split: does not go with chains.failures \"published\"");
    if (s->split > 0 && settings_joins_all(s->algorithm))
        return fault_set(fault, FAULT_UNSUPPORTED, "chains.split: is not for %s, whose chains are of all lengths",
                         name);
    if (s->auxiliary_step > 0 && s->failures == SETTINGS_FAILURES_PUBLISHED)
        return fault_set(fault, FAULT_UNSUPPORTED,
                         "chains.auxiliary_step: does not go with chains.failures \"published\"");
    if (settings_joins_all(s->algorithm) && s->failures != SETTINGS_FAILURES_PLAIN)
        return fault_set(fault, FAULT_UNSUPPORTED,
                         "chains.failures: \"%s\" is not for %s, whose failures are \"plain\"",
                         failure_names[s->failures], name);
    if (settings_joins_all(s->algorithm) && s->partial_step > 0)
        return fault_set(fault, FAULT_UNSUPPORTED,
                         "chains.partial_step: is not for %s, which joins both walks anew", name);
    if (s->adapt && settings_joins_all(s->algorithm))
        return fault_set(fault, FAULT_UNSUPPORTED, "chains.adapt: is not for %s, whose chains are of all lengths",
                         name);
    if (s->adapt && s->failures == SETTINGS_FAILURES_PUBLISHED)
        return fault_set(fault, FAULT_UNSUPPORTED, "chains.adapt: does not go with chains.failures \"published\"");
    const double left = 1 - s->large_step - s->auxiliary_step - (jumps ? s->jump_step : 0);
    if (!(left >= -1e-12))
        return fault_set(fault, FAULT_RANGE,
                         "chains: the probabilities large_step %g, auxiliary_step %g%s add up to more than 1",
                         s->large_step, s->auxiliary_step, jumps ? " and jump_step" : "");
    return FAULT_NONE;
}

static fault_code_t job_read_chains(const json_t *root, settings_t *settings, fault_t *fault)
{
    static const char *const names[] = {
        "split",          "split_gain",    "equalize", "large_step", "technique_step", "jump_step", "partial_step",
        "auxiliary_step", "adapt",         "shift",    "failures",   "kernel",         "step_min",  "step_max",
        "length",         "pilot_samples", NULL};
    const json_t *chains = NULL;
    TRY(json_read_object(root, "", "chains", &chains, fault));
    if (!chains)
        return FAULT_NONE;
    TRY(json_expect_fields(chains, "chains", names, fault));
    int kernel = settings->kernel;
    int64_t length = 0, pilot = 0;
    TRY(json_read_double_or(chains, "chains", "large_step", 0, 1, &settings->large_step, fault));
    TRY(json_read_double_or(chains, "chains", "technique_step", 0, 1, &settings->technique_step, fault));
    TRY(json_read_double_or(chains, "chains", "jump_step", 0, 1, &settings->jump_step, fault));
    int failures = settings->failures;
    TRY(json_read_double_or(chains, "chains", "partial_step", 0, 1, &settings->partial_step, fault));
    TRY(json_read_double_or(chains, "chains", "auxiliary_step", 0, 1, &settings->auxiliary_step, fault));
    TRY(json_read_double_or(chains, "chains", "equalize", 0, 1, &settings->equalize, fault));
    TRY(json_read_double_or(chains, "chains", "split", 0, 1e6, &settings->split, fault));
    TRY(json_read_double_or(chains, "chains", "split_gain", 1, 1e6, &settings->split_gain, fault));
    TRY(json_read_bool_or(chains, "chains", "adapt", &settings->adapt, fault));
    TRY(json_read_bool_or(chains, "chains", "shift", &settings->shift, fault));
    TRY(job_read_choice(chains, "chains", "failures", failure_names, SETTINGS_FAILURES, &failures, fault));
    settings->failures = (settings_failures_t)failures;
    TRY(job_check_moves(settings, fault));
    TRY(job_read_choice(chains, "chains", "kernel", kernel_names, 2, &kernel, fault));
    TRY(json_read_double_or(chains, "chains", "step_min", 1e-9, 0.5, &settings->step_min, fault));
    TRY(json_read_double_or(chains, "chains", "step_max", 1e-9, 0.5, &settings->step_max, fault));
    if (settings->step_min > settings->step_max)
        return fault_set(fault, FAULT_RANGE, "chains.step_min: %g, expected at most chains.step_max, which is %g",
                         settings->step_min, settings->step_max);
    TRY(json_read_int_or(chains, "chains", "length", 1, INT64_C(1) << 32, &length, fault));
    TRY(json_read_int_or(chains, "chains", "pilot_samples", 1, INT64_C(1) << 24, &pilot, fault));
    settings->kernel = (settings_kernel_t)kernel;
    settings->chain_length = (uint64_t)length;
    settings->pilot_samples = (uint64_t)pilot;
    return FAULT_NONE;
}

static fault_code_t job_read_effects(const json_t *root, settings_t *settings, fault_t *fault)
{
    const json_t *effects = NULL;
    TRY(json_read_object(root, "", "effects", &effects, fault));
    if (!effects)
        return FAULT_NONE;
    TRY(json_expect_fields(effects, "effects", effect_names, fault));
    for (int i = 0; i < SETTINGS_EFFECTS; i++) {
        int choice = SETTINGS_SWITCH_AUTO;
        TRY(job_read_choice(effects, "effects", effect_names[i], switch_names, SETTINGS_SWITCHES, &choice, fault));
        settings->effects[i] = (uint8_t)choice;
    }
    if (settings_forbids(settings, SETTINGS_ALL_TECHNIQUES))
        return fault_set(fault, FAULT_FORMAT, "effects.all_techniques: \"off\", expected \"auto\" or \"on\"");
    return FAULT_NONE;
}

static fault_code_t job_read_stop(const json_t *root, job_stop_t *stop, fault_t *fault)
{
    static const char *const names[] = {"mutations_per_pixel", "seconds", "error", NULL};
    const json_t *object = NULL;
    TRY(json_read_object(root, "", "stop", &object, fault));
    if (object) {
        TRY(json_expect_fields(object, "stop", names, fault));
        TRY(json_read_double_or(object, "stop", "mutations_per_pixel", 1e-3, 1e9, &stop->mutations_per_pixel,
                                fault));
        TRY(json_read_double_or(object, "stop", "seconds", 1e-3, 1e9, &stop->seconds, fault));
        TRY(json_read_double_or(object, "stop", "error", 1e-6, 10, &stop->error, fault));
    }
    if (stop->mutations_per_pixel == 0 && stop->seconds == 0 && stop->error == 0)
        stop->seconds = 30;
    return FAULT_NONE;
}

/* A name is free, but for one that promises another kind of picture than `ending` is. */
static fault_code_t job_read_picture(const json_t *output, const char *field, const char *ending, char *path,
                                     fault_t *fault)
{
    static const char *const endings[] = {".exr", ".png", ".pfm", ".hdr", ".jpg", ".jpeg", ".tif", ".tiff", NULL};
    TRY(job_read_path(output, "output", field, path, fault));
    const char *dot = strrchr(path, '.');
    for (int i = 0; dot && endings[i]; i++)
        if (strcasecmp(dot, endings[i]) == 0 && strcmp(endings[i], ending) != 0)
            return fault_set(fault, FAULT_UNSUPPORTED, "output.%s: \"%.200s\", expected a name that ends in %s",
                             field, path, ending);
    return FAULT_NONE;
}

static fault_code_t job_read_output(const json_t *root, job_t *job, fault_t *fault)
{
    static const char *const names[] = {"image", "preview", "report", "page", "preview_exposure", NULL};
    const json_t *output = NULL;
    TRY(json_read_object(root, "", "output", &output, fault));
    snprintf(job->image, JOB_PATH_SIZE, "image.exr");
    if (!output)
        return FAULT_NONE;
    TRY(json_expect_fields(output, "output", names, fault));
    TRY(job_read_picture(output, "image", ".exr", job->image, fault));
    TRY(job_read_picture(output, "preview", ".png", job->preview, fault));
    TRY(job_read_path(output, "output", "report", job->report, fault));
    TRY(job_read_path(output, "output", "page", job->page, fault));
    return json_read_double_or(output, "output", "preview_exposure", -30, 30, &job->preview_exposure, fault);
}

static fault_code_t job_read(job_t *job, const json_t *root, fault_t *fault)
{
    static const char *const names[] = {"scene",  "film",    "algorithm", "max_path_length", "seed", "target",
                                        "chains", "effects", "stop",      "output",          NULL};
    settings_t *settings = &job->settings;
    settings_default(settings);
    if (!json_is_object(root))
        return fault_set(fault, FAULT_TYPE, "the job is not an object: expected {\"scene\": ...}");
    TRY(json_expect_fields(root, "", names, fault));
    TRY(job_read_path(root, "", "scene", job->scene, fault));
    if (job->scene[0] == '\0')
        return fault_set(fault, FAULT_FORMAT, "scene: missing, expected the path of a scene file or bundle");
    int algorithm = JOB_AUTO, target = settings->target;
    int64_t length = 0;
    TRY(job_read_film(root, settings, fault));
    TRY(job_read_choice(root, "", "algorithm", algorithm_names, SETTINGS_ALGORITHMS + 1, &algorithm, fault));
    TRY(json_read_int_or(root, "", "max_path_length", 1, PATH_MAX_LENGTH, &length, fault));
    TRY(json_read_u64_or(root, "", "seed", &settings->seed, fault));
    TRY(job_read_choice(root, "", "target", target_names, 2, &target, fault));
    job->automatic = algorithm == JOB_AUTO;
    if (job->automatic)
        settings_auto(settings);
    else
        settings->algorithm = (settings_algorithm_t)algorithm;
    settings->target = (settings_target_t)target;
    settings->max_path_length = (uint32_t)length;
    if (settings_joins_all(settings->algorithm)) { /* it has no such moves, whatever the others' defaults */
        settings->failures = SETTINGS_FAILURES_PLAIN;
        settings->partial_step = settings->auxiliary_step = 0;
    }
    TRY(job_read_chains(root, settings, fault));
    TRY(job_read_effects(root, settings, fault));
    TRY(job_read_stop(root, &job->stop, fault));
    return job_read_output(root, job, fault);
}

fault_code_t job_parse(job_t *job, const char *text, size_t length, const char *name, fault_t *fault)
{
    *job = (job_t){0};
    json_t *root = NULL;
    fault_code_t code = json_parse(&root, text, length, fault);
    if (!code)
        code = job_read(job, root, fault);
    json_destroy(&root);
    return fault_prefix(fault, code, "%s", name);
}

char *job_print(const job_t *job)
{
    const settings_t *s = &job->settings;
    json_t *root = json_new_object();
    json_add_string(root, "scene", job->scene);
    json_t *film = json_new_object();
    if (s->width)
        json_add_number(film, "width", s->width);
    if (s->height)
        json_add_number(film, "height", s->height);
    if (s->filter >= 0)
        json_add_string(film, "filter", filter_names[s->filter]);
    if (s->filter_radius > 0)
        json_add_number(film, "filter_radius", s->filter_radius);
    json_add(root, "film", film);
    json_add_string(root, "algorithm", job->automatic ? "auto" : settings_algorithm_name(s->algorithm));
    if (s->max_path_length)
        json_add_number(root, "max_path_length", s->max_path_length);
    json_add_u64(root, "seed", s->seed);
    json_add_string(root, "target", target_names[s->target]);
    json_t *chains = json_new_object();
    json_add_number(chains, "large_step", s->large_step);
    json_add_number(chains, "technique_step", s->technique_step);
    json_add_number(chains, "jump_step", s->jump_step);
    json_add_number(chains, "partial_step", s->partial_step);
    json_add_number(chains, "auxiliary_step", s->auxiliary_step);
    json_add_number(chains, "equalize", s->equalize);
    json_add_number(chains, "split", s->split);
    json_add_number(chains, "split_gain", s->split_gain);
    json_add_bool(chains, "adapt", s->adapt);
    json_add_bool(chains, "shift", s->shift);
    json_add_string(chains, "failures", failure_names[s->failures]);
    json_add_string(chains, "kernel", kernel_names[s->kernel]);
    json_add_number(chains, "step_min", s->step_min);
    json_add_number(chains, "step_max", s->step_max);
    if (s->chain_length)
        json_add_number(chains, "length", (double)s->chain_length);
    if (s->pilot_samples)
        json_add_number(chains, "pilot_samples", (double)s->pilot_samples);
    json_add(root, "chains", chains);
    json_t *effects = json_new_object();
    for (int i = 0; i < SETTINGS_EFFECTS; i++)
        if (s->effects[i] != SETTINGS_SWITCH_AUTO)
            json_add_string(effects, effect_names[i], switch_names[s->effects[i]]);
    json_add(root, "effects", effects);
    json_t *stop = json_new_object();
    if (job->stop.mutations_per_pixel > 0)
        json_add_number(stop, "mutations_per_pixel", job->stop.mutations_per_pixel);
    if (job->stop.seconds > 0)
        json_add_number(stop, "seconds", job->stop.seconds);
    if (job->stop.error > 0)
        json_add_number(stop, "error", job->stop.error);
    json_add(root, "stop", stop);
    json_t *output = json_new_object();
    json_add_string(output, "image", job->image);
    json_add_string(output, "preview", job->preview);
    json_add_string(output, "report", job->report);
    json_add_string(output, "page", job->page);
    json_add_number(output, "preview_exposure", job->preview_exposure);
    json_add(root, "output", output);
    char *text = json_print(root, false);
    json_destroy(&root);
    return text;
}
