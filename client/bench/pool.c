#include "client/bench/pool.h"

#include <errno.h>
#include <fcntl.h>
#include <signal.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/prctl.h>
#include <sys/wait.h>
#include <unistd.h>

#include "base/clock.h"

enum { LOOK_US = 10000 };

typedef struct pool_child {
    pid_t pid; /* 0: none */
    int words; /* read end of the pipe that a fault's text comes through */
    size_t task;
    double end; /* of its time */
    bool late;
} pool_child_t;

typedef struct pool {
    pool_child_t children[POOL_MOST];
    pool_work_t *work;
    pool_done_t *done;
    void *user;
    const pool_options_t *options;
} pool_t;

/* In the child: never returns. */
static void child_work(const pool_t *pool, size_t task, pid_t parent, int words)
{
    prctl(PR_SET_PDEATHSIG, SIGKILL);
    if (getppid() != parent)
        _exit(EXIT_FAILURE);
    setpgid(0, 0);
    signal(SIGINT, SIG_DFL);
    signal(SIGTERM, SIG_DFL);
    fault_t fault = {0};
    if (pool->work(pool->user, task, &fault) == FAULT_NONE)
        _exit(EXIT_SUCCESS);
    const ssize_t told = write(words, fault.text, strlen(fault.text));
    (void)told;
    _exit(EXIT_FAILURE);
}

static fault_code_t child_begin(pool_t *pool, pool_child_t *child, size_t task, fault_t *fault)
{
    int words[2];
    if (pipe2(words, O_CLOEXEC) != 0)
        return fault_set(fault, FAULT_IO, "cannot start a run: %s", strerror(errno));
    fflush(NULL);
    const pid_t parent = getpid(), pid = fork();
    if (pid == 0)
        child_work(pool, task, parent, words[1]);
    const int error = errno;
    close(words[1]);
    if (pid < 0) {
        close(words[0]);
        return fault_set(fault, FAULT_IO, "cannot start a run: %s", strerror(error));
    }
    *child = (pool_child_t){pid, words[0], task, clock_now() + pool->options->limit_seconds, false};
    return FAULT_NONE;
}

/* Tells how it ended. */
static void child_end(pool_t *pool, pool_child_t *child, int status)
{
    char text[FAULT_TEXT_SIZE] = "";
    const ssize_t got = read(child->words, text, sizeof text - 1);
    text[got > 0 ? got : 0] = '\0';
    if (child->late)
        snprintf(text, sizeof text, "was ended after its limit of %g s", pool->options->limit_seconds);
    else if (WIFSIGNALED(status))
        snprintf(text, sizeof text, "was killed by signal %d (%s)", WTERMSIG(status), strsignal(WTERMSIG(status)));
    else if (WEXITSTATUS(status) != EXIT_SUCCESS && !text[0])
        snprintf(text, sizeof text, "exited with status %d", WEXITSTATUS(status));
    const bool success = WIFEXITED(status) && WEXITSTATUS(status) == EXIT_SUCCESS;
    close(child->words);
    child->pid = 0;
    pool->done(pool->user, child->task, success ? NULL : text);
}

/* Sees whether it has ended or is late; true while it runs. */
static bool child_look(pool_t *pool, pool_child_t *child)
{
    int status;
    const pid_t got = waitpid(child->pid, &status, WNOHANG);
    if (got == child->pid) {
        child_end(pool, child, status);
        return false;
    }
    if (!child->late && clock_now() > child->end) {
        child->late = true;
        kill(child->pid, SIGKILL);
    }
    return true;
}

static void pool_end_all(pool_t *pool)
{
    for (int i = 0; i < pool->options->workers; i++) {
        pool_child_t *child = &pool->children[i];
        if (child->pid == 0)
            continue;
        kill(child->pid, SIGKILL);
        while (waitpid(child->pid, NULL, 0) < 0 && errno == EINTR)
            continue;
        close(child->words);
        child->pid = 0;
    }
}

static fault_code_t pool_loop(pool_t *pool, size_t tasks, fault_t *fault)
{
    size_t next = 0;
    for (;;) {
        int running = 0;
        for (int i = 0; i < pool->options->workers; i++) {
            pool_child_t *child = &pool->children[i];
            if (child->pid != 0 && child_look(pool, child))
                running++;
            if (child->pid == 0 && next < tasks) {
                TRY(child_begin(pool, child, next++, fault));
                running++;
            }
        }
        if (running == 0)
            return FAULT_NONE;
        if (pool->options->stop && pool->options->stop())
            return fault_set(fault, FAULT_CANCELLED, "interrupted");
        usleep(LOOK_US);
    }
}

fault_code_t pool_run(size_t tasks, pool_work_t *work, pool_done_t *done, void *user, const pool_options_t *options,
                      fault_t *fault)
{
    if (options->workers < 1 || options->workers > POOL_MOST)
        return fault_set(fault, FAULT_RANGE, "workers: found %d, expected 1 to %d", options->workers, POOL_MOST);
    pool_t *pool = calloc(1, sizeof *pool);
    if (!pool)
        return fault_set(fault, FAULT_MEMORY, "no memory for a pool of processes");
    pool->work = work;
    pool->done = done;
    pool->user = user;
    pool->options = options;
    const fault_code_t code = pool_loop(pool, tasks, fault);
    pool_end_all(pool);
    free(pool);
    return code;
}
