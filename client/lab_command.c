/* garland lab: the small experiments behind the chains (docs/laboratory.md). */
#include <errno.h>
#include <inttypes.h>
#include <stdbool.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "base/file.h"
#include "base/json.h"
#include "client/commands.h"
#include "client/lab/charted_report.h"
#include "client/lab/failure_report.h"
#include "client/lab/jump_report.h"
#include "client/options.h"
#include "client/remote.h"
#include "film/png.h"

static const char usage[] =
    "usage: garland lab [reversible-jump|proposal-failures|charts] [--steps N] [--seed N] [--large P]\n"
    "                   [--json FILE] [--svg FILE] [--png FILE]\n"
    "\n"
    "Runs Markov chains whose exact laws are known, rightly and with known mistakes, and prints how far their\n"
    "histograms or pictures are from the exact ones. Without a name: all experiments.\n"
    "\n"
    "  reversible-jump     changes of technique with and without Jacobians and parametrised intervals\n"
    "  proposal-failures   failed proposals: counted, dropped (biased), expected values, delayed rejection\n"
    "  charts              six ways to use two charts of the paths of a small scene\n"
    "  --steps N           steps for each figure, 20000 to 1000000000 (default 4000000: some 30 s for all)\n"
    "  --seed N            (default 1)\n"
    "  --large P           charts: probability of a large step, above 0 and at most 1 (default 0.1)\n"
    "  --json FILE         the figures as JSON\n"
    "  --svg FILE          histograms as a picture, with the exact curves; needs the name of one of the first two\n"
    "  --png FILE          the pictures of charts, side by side\n";

#define LEAST_STEPS UINT64_C(20000)
#define MOST_STEPS UINT64_C(1000000000)
#define DEFAULT_STEPS UINT64_C(4000000)

typedef struct experiment {
    const char *svg, *png; /* paths or null */
    uint64_t steps, seed;
    double large;
    json_t *json;
} experiment_t;

/* Digits only: no sign, no space. */
static int take_number(const char *name, const char *text, uint64_t least, uint64_t most, uint64_t *number)
{
    if (!text)
        return STATUS_SUCCESS;
    char *end = NULL;
    errno = 0;
    const unsigned long long value = text[0] >= '0' && text[0] <= '9' ? strtoull(text, &end, 10) : 0;
    if (!end || *end != '\0' || errno != 0 || value < least || value > most)
        return options_refuse("lab", "--%s: found \"%s\", expected a number from %" PRIu64 " to %" PRIu64, name,
                              text, least, most);
    *number = value;
    return STATUS_SUCCESS;
}

/* In (0,1]; digits or a point first: no sign, no space, no words. */
static int take_probability(const char *name, const char *text, double *number)
{
    if (!text)
        return STATUS_SUCCESS;
    char *end = NULL;
    const double value = strchr("0123456789.", text[0]) ? strtod(text, &end) : 0;
    if (!end || *end != '\0' || !(value > 0 && value <= 1))
        return options_refuse("lab", "--%s: found \"%s\", expected a number above 0 and at most 1", name, text);
    *number = value;
    return STATUS_SUCCESS;
}

static fault_code_t write_text(const char *path, char *text, fault_t *fault)
{
    const fault_code_t code = path ? file_write(path, text, strlen(text), fault) : FAULT_NONE;
    free(text);
    return code;
}

static fault_code_t run_jumps(experiment_t *e, fault_t *fault)
{
    jump_report_t *report = calloc(1, sizeof *report);
    if (!report)
        return fault_set(fault, FAULT_MEMORY, "out of memory");
    jump_report_run(report, e->steps, e->seed);
    jump_report_print(report, stdout);
    json_add(e->json, "reversible-jump", jump_report_json(report));
    const fault_code_t code = write_text(e->svg, jump_report_svg(report), fault);
    free(report);
    return code;
}

static fault_code_t run_failures(experiment_t *e, fault_t *fault)
{
    failure_report_t *report = calloc(1, sizeof *report);
    if (!report)
        return fault_set(fault, FAULT_MEMORY, "out of memory");
    failure_report_run(report, e->steps, e->seed);
    failure_report_print(report, stdout);
    json_add(e->json, "proposal-failures", failure_report_json(report));
    const fault_code_t code = write_text(e->svg, failure_report_svg(report), fault);
    free(report);
    return code;
}

static fault_code_t draw_charts(const charted_report_t *report, const char *path, fault_t *fault)
{
    image_t image;
    TRY(charted_report_montage(report, &image, fault));
    const fault_code_t code = png_write(&image, charted_report_exposure(report), path, fault);
    image_clear(&image);
    return code;
}

static fault_code_t run_charts(experiment_t *e, fault_t *fault)
{
    charted_report_t *report = calloc(1, sizeof *report);
    if (!report)
        return fault_set(fault, FAULT_MEMORY, "out of memory");
    charted_report_run(report, e->steps, e->large, e->seed);
    charted_report_print(report, stdout);
    json_add(e->json, "charts", charted_report_json(report));
    const fault_code_t code = e->png ? draw_charts(report, e->png, fault) : FAULT_NONE;
    free(report);
    return code;
}

enum { EXPERIMENTS = 3, CHARTS = 2 };
static const char *const names[EXPERIMENTS + 1] = {"reversible-jump", "proposal-failures", "charts", NULL};
static fault_code_t (*const runs[EXPERIMENTS])(experiment_t *, fault_t *) = {run_jumps, run_failures, run_charts};

/* `which` null: all. */
static fault_code_t run(experiment_t *e, const char *which, const char *json_path, fault_t *fault)
{
    for (int i = 0; i < EXPERIMENTS; i++)
        if (!which || strcmp(which, names[i]) == 0)
            TRY(runs[i](e, fault));
    return write_text(json_path, json_print(e->json, true), fault);
}

static bool is_known(const char *word)
{
    for (int i = 0; i < EXPERIMENTS; i++)
        if (strcmp(word, names[i]) == 0)
            return true;
    return false;
}

static int refuse_name(const char *word)
{
    const char *near = options_nearest(word, names);
    if (near)
        return options_refuse("lab", "unknown experiment \"%s\"; did you mean %s?", word, near);
    return options_refuse("lab", "unknown experiment \"%s\"; there are %s, %s and %s", word, names[0], names[1],
                          names[2]);
}

/* The pictures that an experiment does not draw are refused. */
static int check_pictures(const experiment_t *e, const char *which)
{
    const bool charts = which && strcmp(which, names[CHARTS]) == 0;
    if (e->svg && (!which || charts))
        return options_refuse("lab", "--svg draws one experiment; name %s or %s", names[0], names[1]);
    if (e->png && which && !charts)
        return options_refuse("lab", "--png draws %s, not %s", names[CHARTS], which);
    return STATUS_SUCCESS;
}

int command_lab(int argc, char **argv)
{
    const char *which, *steps = NULL, *seed = NULL, *json_path = NULL, *svg = NULL, *png = NULL, *large = NULL;
    int status;
    const option_t list[] = {{"steps", OPTION_TEXT, &steps},
                             {"seed", OPTION_TEXT, &seed},
                             {"json", OPTION_TEXT, &json_path},
                             {"svg", OPTION_TEXT, &svg},
                             {"png", OPTION_TEXT, &png},
                             {"large", OPTION_TEXT, &large},
                             {0}};
    if (!options_parse("lab", usage, list, argc, argv, &which, 0, 1, &status))
        return status;
    experiment_t e = {.svg = svg, .png = png, .steps = DEFAULT_STEPS, .seed = 1, .large = CHARTED_REPORT_LARGE};
    if (which && !is_known(which))
        return refuse_name(which);
    if ((status = check_pictures(&e, which)) != STATUS_SUCCESS ||
        (status = take_number("steps", steps, LEAST_STEPS, MOST_STEPS, &e.steps)) != STATUS_SUCCESS ||
        (status = take_probability("large", large, &e.large)) != STATUS_SUCCESS ||
        (status = take_number("seed", seed, 0, UINT64_MAX, &e.seed)) != STATUS_SUCCESS)
        return status;
    fault_t fault = {0};
    e.json = json_new_object();
    const fault_code_t code = run(&e, which, json_path, &fault);
    json_destroy(&e.json);
    return code == FAULT_NONE ? STATUS_SUCCESS : remote_fail(&fault);
}
