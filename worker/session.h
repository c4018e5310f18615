/* session.h: a worker's conversation with its master: states and timing as in proto/PROTOCOL.md, sections 8 to 10.
 *
 *     TRY(session_new(&session, &options, runner, cache, fault));
 *     TRY(session_run(session, stop_fd, fault));
 *     session_destroy(&session);
 *
 * Results are kept until the master acknowledges them and sent again on every new connection; the runner goes on
 * while there is none.
 *
 * Thread rule: a session is made, run and destroyed by one thread, which is also the one that may use the runner.
 */
#ifndef WORKER_SESSION_H
#define WORKER_SESSION_H

#include "worker/cache.h"
#include "worker/runner.h"

typedef struct session session_t;

enum {
    SESSION_FINISH_SECONDS = 60 /* after SHUTDOWN and with the master silent: how long results are still offered */
};
/* Results not acknowledged, in octets, beyond which a worker asks for no more units. */
#define SESSION_UNACKNOWLEDGED_BYTES ((size_t)1 << 30)

/* Zero means the default. Strings are borrowed for the session's life. */
typedef struct session_options {
    const char *address;    /* of the master */
    const char *server_key; /* CURVE, or null */
    const char *token;      /* or null */
    const char *host;       /* this machine's name, for people; or null */
    unsigned prefetch;      /* units held beyond one a thread; default: by their pace (pace.h) */
    double patience;        /* seconds of silence after which session_run gives up; default: for ever, once the
                               first HELLO has been answered; the first within MESSAGE_HANDSHAKE_MS */
} session_options_t;

fault_code_t session_new(session_t **out, const session_options_t *options, runner_t *runner, cache_t *cache,
                         fault_t *fault);
void session_destroy(session_t **session);

/* Works until the master says SHUTDOWN and everything held is acknowledged, or stop_fd (-1: none) becomes readable:
 * then it says BYE and returns success. FAULT_TIMEOUT: the master was silent beyond patience. Others: refused, in
 * the master's words. */
fault_code_t session_run(session_t *session, int stop_fd, fault_t *fault);

#endif
