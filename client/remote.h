/* remote.h: what the subcommands that talk to a running master have in common: options, numbers of jobs, outputs to
 * files. */
#ifndef CLIENT_REMOTE_H
#define CLIENT_REMOTE_H

#include "client/link.h"
#include "client/options.h"
#include "plan/job.h"

typedef struct remote {
    const char *address, *token_file, *key_file; /* as given */
    char *token, *server_key;
    link_t *link;
} remote_t;

/* To be spread into a subcommand's list of options, and into its usage. */
#define REMOTE_OPTIONS(remote)                                                                                     \
    {"master", OPTION_TEXT, &(remote).address}, {"token-file", OPTION_TEXT, &(remote).token_file},                 \
    {                                                                                                              \
        "server-key", OPTION_TEXT, &(remote).server_key                                                            \
    }
#define REMOTE_USAGE                                                                                               \
    "  --master ADDR      the master, tcp://HOST:PORT or ipc://PATH (else $GARLAND_MASTER)\n"                      \
    "  --token-file FILE  the secret that the master asks for, if it does\n"                                       \
    "  --server-key FILE  the master's public key, if it encrypts\n"

/* Connects. False: *status is set, and why was said. */
bool remote_open(remote_t *remote, const char *command, int *status);
void remote_close(remote_t *remote);

/* A job's number as typed; 0 if it is none, and that was said. */
uint64_t remote_job(const char *command, const char *text);

/* Says the fault on standard error; returns STATUS_FAILURE. */
int remote_fail(const fault_t *fault);

/* Fetches every output that the job wants and writes it (job_file_output); `print`: a line for each on standard
 * output. Goes on after one that fails; the fault tells the first. */
fault_code_t remote_fetch_outputs(link_t *link, uint64_t job, const job_t *description, const char *folder,
                                  bool print, fault_t *fault);

#endif
