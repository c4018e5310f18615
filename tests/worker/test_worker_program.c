/* The program garland-worker as a user meets it: usage, exit status, signals. */
#include <fcntl.h>
#include <setjmp.h>
#include <signal.h>
#include <spawn.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/wait.h>
#include <unistd.h>
#include <cmocka.h>

#include "base/clock.h"
#include "proto/transport.h"

enum { PATIENCE_MS = 10000, MAX_ARGUMENTS = 12 };

extern char **environ;
static char output[16384]; /* standard output and error of the last program */
static char folder[] = "/tmp/garland-program-XXXXXX";

static pid_t start(int *out_fd, const char *const *arguments)
{
    const char *bin = getenv("GARLAND_BIN");
    char program[4096];
    snprintf(program, sizeof program, "%s/garland-worker", bin ? bin : "bin");
    char *vector[MAX_ARGUMENTS + 1] = {program};
    for (int i = 0; arguments[i]; i++)
        vector[i + 1] = strdup(arguments[i]);
    int ends[2];
    assert_int_equal(pipe2(ends, O_CLOEXEC), 0);
    posix_spawn_file_actions_t actions;
    posix_spawn_file_actions_init(&actions);
    posix_spawn_file_actions_adddup2(&actions, ends[1], STDOUT_FILENO);
    posix_spawn_file_actions_adddup2(&actions, ends[1], STDERR_FILENO);
    pid_t pid;
    const int error = posix_spawn(&pid, program, &actions, NULL, vector, environ);
    posix_spawn_file_actions_destroy(&actions);
    for (int i = 1; vector[i]; i++)
        free(vector[i]);
    close(ends[1]);
    if (error)
        fail_msg("%s: %s", program, strerror(error));
    *out_fd = ends[0];
    return pid;
}

/* Reads all the program says, waits for it; its exit status. */
static int finish(pid_t pid, int fd)
{
    size_t used = 0;
    for (ssize_t count; (count = read(fd, output + used, sizeof output - 1 - used)) > 0;)
        used += (size_t)count;
    output[used] = '\0';
    close(fd);
    int status;
    assert_int_equal(waitpid(pid, &status, 0), pid);
    assert_true(WIFEXITED(status));
    return WEXITSTATUS(status);
}

#define RUN(...) run((const char *const[]){__VA_ARGS__, NULL})

static int run(const char *const *arguments)
{
    int fd;
    const pid_t pid = start(&fd, arguments);
    return finish(pid, fd);
}

static void assert_says(const char *words)
{
    if (!strstr(output, words))
        fail_msg("\"%s\" does not say \"%s\"", output, words);
}

static void help_and_version(void **state)
{
    (void)state;
    assert_int_equal(RUN("--help"), 0);
    assert_says("--master ADDRESS");
    assert_int_equal(RUN("--version"), 0);
    assert_says(GARLAND_VERSION);
    assert_says(GARLAND_ARCH);
}

static void wrong_usage_is_explained(void **state)
{
    (void)state;
    assert_int_equal(RUN("--threads", "2"), 2);
    assert_says("--master ADDRESS is missing");
    static const char *const bad[] = {"0", "-3", "x", "2.5", "1e9", "nan", ""};
    for (size_t i = 0; i < sizeof bad / sizeof *bad; i++) {
        assert_int_equal(RUN("--master", "tcp://127.0.0.1:1", "--threads", bad[i]), 2);
        assert_says("--threads");
    }
    assert_int_equal(RUN("--master", "nonsense"), 2);
    assert_says("expected tcp://host:port or ipc://path");
    assert_int_equal(RUN("--frobnicate"), 2);
    assert_int_equal(RUN("--master", "tcp://127.0.0.1:1", "extra"), 2);
    assert_says("extra");
    assert_int_equal(RUN("--master", "tcp://127.0.0.1:1", "--token-file", "/no/such/file"), 1);
    assert_says("/no/such/file");
    assert_int_equal(RUN("--master", "tcp://127.0.0.1:1", "--cache", "/proc/no/cache"), 1);
    assert_says("/proc/no");
}

static void a_master_that_is_not_there_is_reported(void **state)
{
    (void)state;
    assert_int_equal(RUN("--master", "tcp://127.0.0.1:1", "--threads", "1", "--patience", "0.3"), 1);
    assert_says("tcp://127.0.0.1:1 has not answered");
}

static transport_event_t event;
static fault_t fault;

static transport_peer_t expect(transport_t *master, message_type_t type)
{
    const double end = clock_now() + 1e-3 * PATIENCE_MS;
    for (;;) {
        if (transport_receive(master, &event) == TRANSPORT_MESSAGE && event.message.type == type)
            return event.peer;
        if (event.kind == TRANSPORT_NOTHING)
            transport_wait(master, -1, 50, NULL, &fault);
        if (clock_now() > end)
            fail_msg("no %s within %d ms", message_type_name(type), PATIENCE_MS);
    }
}

static void a_signal_makes_it_say_bye(void **state)
{
    (void)state;
    char address[128], secret[128];
    snprintf(address, sizeof address, "ipc://%s/socket", folder);
    snprintf(secret, sizeof secret, "%s/token", folder);
    FILE *file = fopen(secret, "w");
    fputs("swordfish\n", file);
    fclose(file);
    const int signals[] = {SIGTERM, SIGINT};
    for (int i = 0; i < 2; i++) {
        transport_t *master;
        if (transport_bind(&master, address, NULL, &fault))
            fail_msg("%s", fault.text);
        int fd;
        const pid_t pid =
            start(&fd, (const char *const[]){"--master", address, "--threads", "1", "--token-file", secret, NULL});
        const transport_peer_t peer = expect(master, MESSAGE_HELLO);
        assert_string_equal(event.message.hello.token, "swordfish");
        assert_int_equal(event.message.hello.pid, pid);
        message_t welcome = {.type = MESSAGE_WELCOME};
        welcome.welcome = (message_welcome_t){GARLAND_VERSION, MESSAGE_HEARTBEAT_MS, MESSAGE_LEASE_MS, 1};
        transport_send(master, peer, &welcome, NULL);
        expect(master, MESSAGE_READY);
        kill(pid, signals[i]);
        expect(master, MESSAGE_BYE);
        assert_int_equal(finish(pid, fd), 0);
        assert_says("stopping");
        transport_destroy(&master);
    }
    unlink(secret);
}

static void a_refusal_is_reported_in_the_masters_words(void **state)
{
    (void)state;
    char address[128];
    snprintf(address, sizeof address, "ipc://%s/socket", folder);
    transport_t *master;
    if (transport_bind(&master, address, NULL, &fault))
        fail_msg("%s", fault.text);
    int fd;
    const pid_t pid = start(&fd, (const char *const[]){"--master", address, "--threads", "1", NULL});
    const transport_peer_t peer = expect(master, MESSAGE_HELLO);
    message_t refused = {.type = MESSAGE_REFUSED};
    refused.refused = (message_refused_t){"no vacancies", FAULT_LIMIT, MESSAGE_HELLO, 0};
    transport_send(master, peer, &refused, NULL);
    assert_int_equal(finish(pid, fd), 1);
    assert_says("no vacancies");
    transport_destroy(&master);
}

static int make_folder(void **state)
{
    (void)state;
    return mkdtemp(folder) ? 0 : -1;
}

static int remove_folder(void **state)
{
    (void)state;
    char path[128];
    snprintf(path, sizeof path, "%s/socket", folder);
    unlink(path);
    return rmdir(folder);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(help_and_version),
        cmocka_unit_test(wrong_usage_is_explained),
        cmocka_unit_test(a_master_that_is_not_there_is_reported),
        cmocka_unit_test(a_signal_makes_it_say_bye),
        cmocka_unit_test(a_refusal_is_reported_in_the_masters_words),
    };
    return cmocka_run_group_tests(tests, make_folder, remove_folder);
}
