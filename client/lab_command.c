/* garland lab: the one-dimensional experiments behind the chains (docs/laboratory.md). */
#include <errno.h>
#include <inttypes.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "base/file.h"
#include "base/json.h"
#include "client/commands.h"
#include "client/lab/failure_report.h"
#include "client/lab/jump_report.h"
#include "client/options.h"
#include "client/remote.h"

static const char usage[] =
    "usage: garland lab [reversible-jump|proposal-failures] [--steps N] [--seed N] [--json FILE] [--svg FILE]\n"
    "\n"
    "Runs one-dimensional Markov chains whose exact laws are known, rightly and with known mistakes, and prints "
    "how far\n"
    "their histograms are from the exact ones. Without a name: both experiments.\n"
    "\n"
    "  reversible-jump     changes of technique with and without Jacobians and parametrised intervals\n"
    "  proposal-failures   failed proposals: counted, dropped (biased), expected values, delayed rejection\n"
    "  --steps N           steps for each figure, 20000 to 1000000000 (default 4000000: some 6 s for both)\n"
    "  --seed N            (default 1)\n"
    "  --json FILE         the figures as JSON\n"
    "  --svg FILE          histograms as a picture, with the exact curves; needs one experiment's name\n";

#define LEAST_STEPS UINT64_C(20000)
#define MOST_STEPS UINT64_C(1000000000)
#define DEFAULT_STEPS UINT64_C(4000000)

typedef struct experiment {
    const char *svg; /* path or null */
    uint64_t steps, seed;
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

static const char *const names[] = {"reversible-jump", "proposal-failures", NULL};

/* `which` null: both. */
static fault_code_t run(experiment_t *e, const char *which, const char *json_path, fault_t *fault)
{
    if (!which || strcmp(which, names[0]) == 0)
        TRY(run_jumps(e, fault));
    if (!which || strcmp(which, names[1]) == 0)
        TRY(run_failures(e, fault));
    return write_text(json_path, json_print(e->json, true), fault);
}

static int refuse_name(const char *word)
{
    const char *near = options_nearest(word, names);
    if (near)
        return options_refuse("lab", "unknown experiment \"%s\"; did you mean %s?", word, near);
    return options_refuse("lab", "unknown experiment \"%s\"; there are %s and %s", word, names[0], names[1]);
}

int command_lab(int argc, char **argv)
{
    const char *which, *steps = NULL, *seed = NULL, *json_path = NULL, *svg = NULL;
    int status;
    const option_t list[] = {{"steps", OPTION_TEXT, &steps},
                             {"seed", OPTION_TEXT, &seed},
                             {"json", OPTION_TEXT, &json_path},
                             {"svg", OPTION_TEXT, &svg},
                             {0}};
    if (!options_parse("lab", usage, list, argc, argv, &which, 0, 1, &status))
        return status;
    experiment_t e = {.svg = svg, .steps = DEFAULT_STEPS, .seed = 1};
    if (which && strcmp(which, names[0]) != 0 && strcmp(which, names[1]) != 0)
        return refuse_name(which);
    if (svg && !which)
        return options_refuse("lab", "--svg draws one experiment; name %s or %s", names[0], names[1]);
    if ((status = take_number("steps", steps, LEAST_STEPS, MOST_STEPS, &e.steps)) != STATUS_SUCCESS ||
        (status = take_number("seed", seed, 0, UINT64_MAX, &e.seed)) != STATUS_SUCCESS)
        return status;
    fault_t fault = {0};
    e.json = json_new_object();
    const fault_code_t code = run(&e, which, json_path, &fault);
    json_destroy(&e.json);
    return code == FAULT_NONE ? STATUS_SUCCESS : remote_fail(&fault);
}
