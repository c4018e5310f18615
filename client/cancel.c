/* garland cancel: ends a job without outputs. */
#include <stdio.h>

#include "client/commands.h"
#include "client/remote.h"

static const char usage[] = "usage: garland cancel ID --master ADDR\n"
                            "\n"
                            "Ends a job; what was rendered of it is dropped.\n"
                            "\n" REMOTE_USAGE;

int command_cancel(int argc, char **argv)
{
    remote_t remote = {0};
    const char *id;
    int status;
    fault_t fault = {0};
    const option_t list[] = {REMOTE_OPTIONS(remote), {0}};
    if (!options_parse("cancel", usage, list, argc, argv, &id, 1, 1, &status))
        return status;
    const uint64_t job = remote_job("cancel", id);
    if (job == 0)
        return STATUS_USAGE;
    if (!remote_open(&remote, "cancel", &status))
        return status;
    status = STATUS_SUCCESS;
    if (link_cancel(remote.link, job, &fault) != FAULT_NONE)
        status = remote_fail(&fault);
    remote_close(&remote);
    return status;
}
