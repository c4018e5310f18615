/* child.h: a program of Garland's own as a child process. It dies with its parent (PR_SET_PDEATHSIG), is in a
 * process group of its own (so that Ctrl-C goes to the parent alone), and is only ever signalled by its process id.
 */
#ifndef CLIENT_CHILD_H
#define CLIENT_CHILD_H

#include <stdbool.h>
#include <stddef.h>
#include <sys/types.h>

#include "base/fault.h"

typedef struct child {
    pid_t pid;  /* 0: not running */
    int output; /* read end of its standard output, -1: none */
    int status; /* as waitpid gave it, after its end */
} child_t;

/* Starts `program` (a name): from the folder of this program, or from PATH. argv[0] is filled in, the list ends
 * with null. capture: its standard output can be read from child->output. Its standard input is empty. */
fault_code_t child_start(child_t *child, const char *program, char **argv, bool capture, fault_t *fault);
/* Reads a line of its output within `seconds`, without its end. FAULT_TIMEOUT, or FAULT_IO if it ended before. */
fault_code_t child_read_line(child_t *child, double seconds, char *line, size_t size, fault_t *fault);
/* True while it runs; notes its end. */
bool child_is_running(child_t *child);
/* "exited with status 1", "was killed by signal 9 (Killed)" */
void child_describe_end(const child_t *child, char *text, size_t size);
/* SIGTERM to all that run; SIGKILL to those that still run after `seconds`; waits for all. */
void child_stop_all(child_t **children, size_t count, double seconds);

#endif
