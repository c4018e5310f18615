#include "client/child.h"

#include <errno.h>
#include <fcntl.h>
#include <poll.h>
#include <signal.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/prctl.h>
#include <sys/wait.h>
#include <unistd.h>

#include "base/clock.h"

enum { PATH_SIZE = 4096, LOOK_US = 10000, EXIT_NO_PROGRAM = 127 };

/* The program beside this one, if it is there; else its bare name, for PATH. */
static void find_program(const char *program, char path[PATH_SIZE])
{
    const ssize_t length = readlink("/proc/self/exe", path, PATH_SIZE - 1);
    if (length > 0) {
        path[length] = '\0';
        char *last = strrchr(path, '/');
        const size_t folder = last ? (size_t)(last + 1 - path) : 0;
        if (last && folder + strlen(program) < PATH_SIZE) {
            strcpy(path + folder, program);
            if (access(path, X_OK) == 0)
                return;
        }
    }
    snprintf(path, PATH_SIZE, "%s", program);
}

/* In the child: never returns. */
static void become(const char *path, char **argv, int output, pid_t parent, int failure)
{
    prctl(PR_SET_PDEATHSIG, SIGTERM);
    if (getppid() != parent)
        _exit(EXIT_NO_PROGRAM);
    setpgid(0, 0);
    const int nothing = open("/dev/null", O_RDWR);
    if (nothing >= 0)
        dup2(nothing, STDIN_FILENO);
    if (output >= 0)
        dup2(output, STDOUT_FILENO);
    else if (nothing >= 0)
        dup2(nothing, STDOUT_FILENO);
    signal(SIGPIPE, SIG_DFL);
    signal(SIGXFSZ, SIG_DFL);
    if (strchr(path, '/'))
        execv(path, argv);
    else
        execvp(path, argv);
    const int error = errno;
    const ssize_t told = write(failure, &error, sizeof error);
    (void)told;
    _exit(EXIT_NO_PROGRAM);
}

/* Forks; `failure` is a pipe that closes when the program has begun, or carries errno when it cannot. */
static fault_code_t fork_program(child_t *child, const char *path, char **argv, int output, const int failure[2],
                                 fault_t *fault)
{
    const pid_t parent = getpid();
    child->pid = fork();
    if (child->pid < 0) {
        child->pid = 0;
        return fault_set(fault, FAULT_IO, "cannot start %s: %s", argv[0], strerror(errno));
    }
    if (child->pid == 0)
        become(path, argv, output, parent, failure[1]);
    return FAULT_NONE;
}

static fault_code_t await_program(child_t *child, const char *program, int failure, fault_t *fault)
{
    int error = 0;
    ssize_t got;
    do
        got = read(failure, &error, sizeof error);
    while (got < 0 && errno == EINTR);
    if (got != sizeof error)
        return FAULT_NONE;
    waitpid(child->pid, &child->status, 0);
    child->pid = 0;
    return fault_set(fault, FAULT_NOT_FOUND, "cannot start %s (looked beside this program and in PATH): %s",
                     program, strerror(error));
}

fault_code_t child_start(child_t *child, const char *program, char **argv, bool capture, fault_t *fault)
{
    char path[PATH_SIZE], *name;
    int output[2] = {-1, -1}, failure[2] = {-1, -1};
    *child = (child_t){.output = -1};
    find_program(program, path);
    name = strdup(program);
    argv[0] = name;
    fault_code_t code = FAULT_NONE;
    if (!name || pipe2(failure, O_CLOEXEC) != 0 || (capture && pipe2(output, O_CLOEXEC) != 0))
        code = fault_set(fault, FAULT_IO, "cannot start %s: %s", program, strerror(errno));
    if (code == FAULT_NONE)
        code = fork_program(child, path, argv, output[1], failure, fault);
    if (failure[1] >= 0)
        close(failure[1]);
    if (output[1] >= 0)
        close(output[1]);
    if (code == FAULT_NONE)
        code = await_program(child, program, failure[0], fault);
    if (failure[0] >= 0)
        close(failure[0]);
    if (code == FAULT_NONE)
        child->output = output[0];
    else if (output[0] >= 0)
        close(output[0]);
    argv[0] = NULL;
    free(name);
    return code;
}

fault_code_t child_read_line(child_t *child, double seconds, char *line, size_t size, fault_t *fault)
{
    const double end = clock_now() + seconds;
    size_t used = 0;
    while (used + 1 < size) {
        struct pollfd item = {.fd = child->output, .events = POLLIN};
        const double left = end - clock_now();
        if (left <= 0)
            return fault_set(fault, FAULT_TIMEOUT, "said nothing for %g s", seconds);
        const int ready = poll(&item, 1, (int)(1e3 * left) + 1);
        if (ready < 0 && errno != EINTR)
            return fault_set(fault, FAULT_IO, "poll: %s", strerror(errno));
        if (ready <= 0)
            continue;
        const ssize_t got = read(child->output, line + used, 1);
        if (got <= 0)
            return fault_set(fault, FAULT_IO, "ended before it was ready");
        if (line[used] == '\n')
            break;
        used++;
    }
    line[used] = '\0';
    return FAULT_NONE;
}

static void note_end(child_t *child)
{
    child->pid = 0;
    if (child->output >= 0)
        close(child->output);
    child->output = -1;
}

bool child_is_running(child_t *child)
{
    if (child->pid == 0)
        return false;
    pid_t got;
    do
        got = waitpid(child->pid, &child->status, WNOHANG);
    while (got < 0 && errno == EINTR);
    if (got == 0)
        return true;
    note_end(child);
    return false;
}

void child_describe_end(const child_t *child, char *text, size_t size)
{
    if (WIFSIGNALED(child->status))
        snprintf(text, size, "was killed by signal %d (%s)", WTERMSIG(child->status),
                 strsignal(WTERMSIG(child->status)));
    else
        snprintf(text, size, "exited with status %d", WEXITSTATUS(child->status));
}

static bool any_running(child_t **children, size_t count)
{
    bool any = false;
    for (size_t i = 0; i < count; i++)
        any |= child_is_running(children[i]);
    return any;
}

void child_stop_all(child_t **children, size_t count, double seconds)
{
    const double end = clock_now() + seconds;
    for (size_t i = 0; i < count; i++)
        if (child_is_running(children[i]))
            kill(children[i]->pid, SIGTERM);
    while (any_running(children, count) && clock_now() < end)
        usleep(LOOK_US);
    for (size_t i = 0; i < count; i++)
        if (child_is_running(children[i])) {
            kill(children[i]->pid, SIGKILL);
            while (waitpid(children[i]->pid, &children[i]->status, 0) < 0 && errno == EINTR)
                continue;
            note_end(children[i]);
        }
}
