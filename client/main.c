/* garland: the command that people and scripts use. */
#include <stdio.h>
#include <string.h>

#include "base/log.h"
#include "client/commands.h"
#include "client/options.h"

static const char usage[] =
    "usage: garland COMMAND ...\n"
    "\n"
    "On this machine:\n"
    "  render JOB.json [--workers N] [--out DIR]   render a job, from scene file to picture\n"
    "  plan JOB.json [--workers N] [--for N]       what a job would simulate, and what accuracy would cost\n"
    "  pack SCENE -o FILE                          a scene as one checked file\n"
    "  compare IMAGE REFERENCE [--json]            how far an image, or a folder of them, is from references\n"
    "  bench FILE.json [--out DIR]                 scenes, algorithms and settings compared at equal time\n"
    "  report REPORT.json -o PAGE.html             a report as a page to look at, or as tables (--csv)\n"
    "  lab [EXPERIMENT]                            Markov chains with known laws, right and wrong\n"
    "\n"
    "With a master (garland-master) and its workers (garland-worker):\n"
    "  submit JOB.json --master ADDR               send a job; prints its number\n"
    "  status [ID] --master ADDR [--json]          jobs and workers\n"
    "  fetch ID --master ADDR [--out DIR] [--wait] a job's outputs\n"
    "  cancel ID --master ADDR                     end a job\n"
    "\n"
    "garland COMMAND --help says more; docs/jobs.md describes jobs. Exit status: 0 success, 1 failure, 2 wrong "
    "usage.\n";

typedef struct command {
    const char *name;
    int (*run)(int argc, char **argv);
} command_t;

static const command_t commands[] = {
    {"render", command_render}, {"plan", command_plan},       {"pack", command_pack},
    {"submit", command_submit}, {"status", command_status},   {"fetch", command_fetch},
    {"cancel", command_cancel}, {"compare", command_compare}, {"bench", command_bench},
    {"report", command_report}, {"lab", command_lab}};
enum { COMMANDS = sizeof commands / sizeof commands[0] };

static int refuse(const char *word)
{
    const char *names[COMMANDS + 1] = {NULL};
    for (int i = 0; i < COMMANDS; i++)
        names[i] = commands[i].name;
    const char *near = options_nearest(word, names);
    if (near)
        return options_refuse("", "unknown command \"%s\"; did you mean %s?", word, near);
    return options_refuse("", "unknown command \"%s\"", word);
}

int main(int argc, char **argv)
{
    log_open("garland", LOG_WARN);
    if (argc < 2) {
        fputs(usage, stderr);
        return STATUS_USAGE;
    }
    const char *word = argv[1];
    if (strcmp(word, "--help") == 0 || strcmp(word, "-h") == 0 || strcmp(word, "help") == 0) {
        fputs(usage, stdout);
        return STATUS_SUCCESS;
    }
    if (strcmp(word, "--version") == 0) {
        puts("garland " GARLAND_VERSION " (" GARLAND_ARCH ")");
        return STATUS_SUCCESS;
    }
    for (int i = 0; i < COMMANDS; i++)
        if (strcmp(word, commands[i].name) == 0)
            return commands[i].run(argc - 2, argv + 2);
    return refuse(word);
}
