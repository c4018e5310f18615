/* garland plan: what a render of a job would simulate, how, and what accuracy would cost, from a few seconds of it.
 */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "client/commands.h"
#include "client/interrupt.h"
#include "client/local_run.h"
#include "client/remote.h"

static const char usage[] =
    "usage: garland plan JOB.json [--workers N] [--seconds S] [--for N] [--json] [--quiet]\n"
    "\n"
    "Says what a job would simulate and what accuracy would cost, from a short stretch of the render itself. "
    "Writes "
    "no\n"
    "outputs.\n"
    "\n"
    "  --workers N   worker processes to measure with, each with one thread (default: one a core)\n"
    "  --seconds S   how long to measure, pilot included (default: 5)\n"
    "  --for N       the times are for N such workers (default: those measured with)\n"
    "  --json        the measured stretch's report (docs/reports.md) instead of text\n"
    "  --quiet       no progress\n"
    "\n"
    "Exit status: 0 success, 1 failure, 2 wrong usage.\n";

enum { TARGETS = 4, DEFAULT_SECONDS = 5 };
static const double target_errors[TARGETS] = {0.1, 0.05, 0.02, 0.01};

/* What an error costs; NaN: not known, or out of reach by the law. */
typedef struct target {
    double error, seconds, low, high, worker_hours;
} target_t;

static double number_of(const json_t *object, const char *name)
{
    const json_t *value = object && json_is_object(object) ? json_get(object, name) : NULL;
    return value && json_is_number(value) ? json_number(value) : (double)NAN;
}

static const char *text_of(const json_t *object, const char *name)
{
    const json_t *value = object && json_is_object(object) ? json_get(object, name) : NULL;
    const char *text = value ? json_string(value) : NULL;
    return text ? text : "-";
}

static const json_t *first_of(const json_t *object, const char *name)
{
    const json_t *value = object && json_is_object(object) ? json_get(object, name) : NULL;
    return value && json_is_array(value) ? json_first(value) : NULL;
}

/* The report's prediction; where there is none, error ~ t^-1/2 from the last estimate, with no interval. */
static bool read_targets(target_t targets[TARGETS], const json_t *report, double workers)
{
    const json_t *at = first_of(json_get(report, "prediction"), "targets");
    const bool fitted = at != NULL;
    const json_t *time = json_get(report, "time");
    const double error = number_of(json_get(report, "error"), "error"), cpu = number_of(time, "render_cpu_seconds");
    for (int i = 0; i < TARGETS; i++) {
        target_t *target = &targets[i];
        if (!fitted) {
            const double ratio = error / target_errors[i], seconds = cpu * ratio * ratio;
            *target = (target_t){target_errors[i], seconds / workers, NAN, NAN, seconds / 3600};
            continue;
        }
        *target = (target_t){number_of(at, "error"), number_of(at, "seconds"), number_of(at, "low"),
                             number_of(at, "high"), number_of(at, "worker_hours")};
        at = at ? json_next(at) : NULL;
    }
    return fitted;
}

/* Why this algorithm. */
static void print_reason(const job_t *job, const json_t *report)
{
    if (!job->automatic) {
        settings_t usual = job->settings;
        settings_auto(&usual);
        printf("  as the job says; \"auto\" would be %s, with samples beside its chains and for relative error\n",
               settings_algorithm_name(usual.algorithm));
        return;
    }
    printf(
        "  by \"auto\": samples, and beside them chains for relative error where they are worth it, best over the "
        "scenes of docs/gains.md\n");
    const double samples = number_of(json_get(report, "samples"), "share"),
                 promise = number_of(json_get(report, "samples"), "promise");
    bool alone = false;
    if (isfinite(samples))
        json_read_bool_or(json_get(report, "samples"), "samples", "alone", &alone, NULL);
    if (alone)
        printf("  by this scene's pilot samples alone: for the same error they need %.3g times the work of samples "
               "with chains, which are run from %.3g on\n",
               promise, job->settings.split_gain);
    else if (isfinite(samples))
        printf("  by this scene's pilot samples get %.3g %% of the work, chains the rest, for what samples seldom "
               "find\n",
               100 * samples);
    else
        printf("  the job is too short for samples beside the chains\n");
}

/* " 0 1 3": techniques of a length that take part. */
static void print_kept(const json_t *idle, double k)
{
    for (double s = 0; s <= k; s++) {
        bool out = false;
        for (const json_t *at = idle; at; at = json_next(at))
            out = out || (json_is_number(at) && json_number(at) == s);
        if (!out)
            printf(" %.0f", s);
    }
}

static void print_techniques(const json_t *report)
{
    bool any = false;
    for (const json_t *at = first_of(report, "lengths"); at; at = json_next(at)) {
        const json_t *idle = first_of(at, "idle");
        if (!idle)
            continue;
        if (!any)
            printf(
                "Techniques that stay, by vertices made from the light; all do in lengths that are not listed\n");
        any = true;
        printf("  length %3.0f:", number_of(at, "length"));
        print_kept(idle, number_of(at, "length"));
        printf("; the others have less than %.2g %% of its light\n", 100 * number_of(at, "idle_energy"));
    }
}

static void print_effects(const json_t *report)
{
    printf("Effects\n");
    for (const json_t *at = first_of(report, "effects"); at; at = json_next(at)) {
        printf("  %-22s %-9s %s", text_of(at, "name"), text_of(at, "state"), text_of(at, "reason"));
        const double energy = number_of(at, "energy"), error = number_of(at, "energy_error");
        if (isfinite(energy) && isfinite(error))
            printf(" (%.3g +- %.2g %% of the light)", 100 * energy, 100 * error);
        else if (isfinite(energy))
            printf(" (%.3g %% of the light)", 100 * energy);
        printf("; %s\n", text_of(at, "consequence"));
    }
    const json_t *left_out = json_get(report, "left_out");
    if (isfinite(number_of(left_out, "energy")))
        printf("  The image lacks %.3g +- %.2g %% of the light that there would be.\n",
               100 * number_of(left_out, "energy"), 100 * number_of(left_out, "standard_error"));
}

/* Light of a length: of samples and chains together where the two share it. */
static double light_of(const json_t *length)
{
    const double light = number_of(length, "light");
    return isfinite(light) ? light : number_of(json_get(length, "b"), "value");
}

static void print_lengths(const json_t *report)
{
    double all = 0;
    for (const json_t *at = first_of(report, "lengths"); at; at = json_next(at))
        all += fmax(0, light_of(at));
    printf("Path lengths\n  length   light      share of mutations\n");
    for (const json_t *at = first_of(report, "lengths"); at; at = json_next(at)) {
        printf("  %6.0f   %6.2f %%", number_of(at, "length"), all > 0 ? 100 * light_of(at) / all : (double)NAN);
        if (isfinite(number_of(at, "share")))
            printf("   %6.2f %%", 100 * number_of(at, "share"));
        printf("\n");
    }
    const json_t *missed = json_get(report, "missed");
    if (first_of(missed, "lengths"))
        printf("  lengths without chains bring at most %.2g %% of the light\n", 100 * number_of(missed, "most"));
    const double samples = number_of(json_get(report, "samples"), "share");
    if (isfinite(samples))
        printf("  samples of all lengths beside the chains: %.2f %% of the mutations\n", 100 * samples);
}

static void print_cost(const json_t *report, int workers, int wanted)
{
    target_t targets[TARGETS];
    const bool fitted = read_targets(targets, report, workers);
    /* The prediction's workers are CPU seconds a second: fewer than the processes on a busy machine. */
    const double pace = number_of(json_get(report, "prediction"), "workers");
    const double scale = wanted > 0 ? (fitted && pace > 0 ? pace : workers) / wanted : 1;
    printf("Cost on %d worker%s (%s)\n", wanted > 0 ? wanted : workers,
           (wanted > 0 ? wanted : workers) == 1 ? "" : "s",
           fitted ? "by the law fitted to the measured stretch"
                  : "taking the error to fall as the root of the time");
    for (int i = 0; i < TARGETS; i++) {
        const target_t *target = &targets[i];
        if (!isfinite(target->error))
            continue;
        printf("  error %3.0f %%   ", 100 * target->error);
        if (!isfinite(target->seconds)) {
            printf("not known\n");
            continue;
        }
        printf("%.3g s", target->seconds * scale);
        if (isfinite(target->low) || isfinite(target->high))
            printf(" (95 %%: %.3g to %.3g s)", target->low * scale, target->high * scale);
        printf(", %.3g worker-hours\n", target->worker_hours);
    }
    if (wanted > 0)
        printf(
            "  Worker-hours stay the same on any number of workers, and the time divides; the master's part of the "
            "work\n  is left out.\n");
}

static void print_plan(const job_t *job, const json_t *report, int workers, int wanted)
{
    printf("Algorithm: %s, %.0f x %.0f pixels, paths of at most %.0f segments\n", text_of(report, "algorithm"),
           number_of(report, "width"), number_of(report, "height"), number_of(report, "max_path_length"));
    print_reason(job, report);
    print_effects(report);
    print_techniques(report);
    print_lengths(report);
    print_cost(report, workers, wanted);
}

/* The job as it is measured: ended by time alone, no output for people. */
static void shorten(job_t *job, int seconds)
{
    job->stop = (job_stop_t){.seconds = seconds};
    snprintf(job->image, sizeof job->image, "plan.exr");
    snprintf(job->report, sizeof job->report, "plan.json");
    job->preview[0] = job->page[0] = 0;
}

static fault_code_t measure(local_run_t *run, json_t **report, fault_t *fault)
{
    uint8_t *data;
    size_t size;
    TRY(local_run_start(run, fault));
    TRY(local_run_watch(run, fault));
    progress_bar_end(&run->bar);
    TRY(link_fetch(run->link, run->job, MESSAGE_OUTPUT_REPORT, &data, &size, fault));
    const fault_code_t code = json_parse(report, (const char *)data, size, fault);
    free(data);
    return code;
}

static int run_plan(local_run_t *run, int wanted, bool json, bool quiet)
{
    fault_t fault = {0};
    json_t *report = NULL;
    progress_bar_begin(&run->bar, quiet);
    const fault_code_t code = measure(run, &report, &fault);
    progress_bar_end(&run->bar);
    local_run_end(run, false);
    if (code != FAULT_NONE)
        return remote_fail(&fault);
    char *text = json ? json_print(report, true) : NULL;
    if (text)
        puts(text);
    else if (!json)
        print_plan(&run->file.job, report, run->workers, wanted);
    free(text);
    json_destroy(&report);
    return STATUS_SUCCESS;
}

int command_plan(int argc, char **argv)
{
    local_run_t *run = calloc(1, sizeof *run);
    const char *job = NULL;
    fault_t fault = {0};
    int status = STATUS_FAILURE, seconds = DEFAULT_SECONDS, wanted = 0;
    bool json = false, quiet = false;
    if (!run) {
        fprintf(stderr, "garland: out of memory\n");
        return status;
    }
    const option_t list[] = {{"workers", OPTION_COUNT, &run->workers}, {"seconds", OPTION_COUNT, &seconds},
                             {"for", OPTION_COUNT, &wanted},           {"json", OPTION_FLAG, &json},
                             {"quiet", OPTION_FLAG, &quiet},           {0}};
    if (options_parse("plan", usage, list, argc, argv, &job, 1, 1, &status)) {
        interrupt_catch();
        if (run->workers == 0)
            run->workers = local_run_cores();
        if (job_file_read(&run->file, job, &fault) != FAULT_NONE) {
            status = remote_fail(&fault);
        } else {
            shorten(&run->file.job, seconds);
            status = run_plan(run, wanted, json, quiet);
        }
    }
    free(run);
    return status;
}
