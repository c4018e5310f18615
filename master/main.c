/* garland-master: takes jobs from clients, hands their units to workers, adds up the results. */
#include <errno.h>
#include <fcntl.h>
#include <getopt.h>
#include <signal.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "base/file.h"
#include "base/log.h"
#include "master/server.h"
#include "proto/transport.h"

enum { EXIT_USAGE = 2 };

static const char usage[] =
    "usage: garland-master --listen ADDR --state DIR [options]\n"
    "\n"
    "Takes jobs (garland submit), hands their units to workers (garland-worker) and adds up the results. When it "
    "is\n"
    "ready it prints \"listening on ADDR\" on standard output. SIGTERM or SIGINT: saves its state and exits.\n"
    "\n"
    "  --listen ADDR      tcp://HOST:PORT or ipc://PATH; port * means any free one. tcp://127.0.0.1:PORT is for "
    "this\n"
    "                     machine only; beyond it, use --key-file and --token-file\n"
    "  --state DIR        where jobs, scenes and results are kept; one master at a time\n"
    "  --lease SECONDS    how long a silent worker keeps its work (default 15)\n"
    "  --token-file FILE  peers must send the secret in this file's first line\n"
    "  --key-file FILE    encrypt: peers must know the public key that belongs to this file's secret one\n"
    "  --new-key FILE     write a new secret key to FILE, print its public key and exit\n"
    "  --no-sync          do not wait for the disk: the state does not survive a power cut\n"
    "  --quiet, --verbose\n"
    "  --help, --version\n";

static server_t *running;

static void on_signal(int number)
{
    (void)number;
    if (running)
        server_stop(running);
}

static void catch_signals(void)
{
    struct sigaction action = {.sa_handler = on_signal};
    sigaction(SIGTERM, &action, NULL);
    sigaction(SIGINT, &action, NULL);
    sigaction(SIGHUP, &action, NULL);
    signal(SIGPIPE, SIG_IGN);
    signal(SIGXFSZ, SIG_IGN); /* a file-size limit is a failed write, not a death */
}

/* The first line of a small file, without its end. */
static char *first_line(const char *path)
{
    uint8_t *data;
    size_t size;
    fault_t fault = {0};
    if (file_read(path, 4096, &data, &size, &fault) != FAULT_NONE) {
        fprintf(stderr, "garland-master: %s\n", fault.text);
        exit(EXIT_FAILURE);
    }
    char *line = (char *)data;
    line[strcspn(line, "\r\n")] = '\0';
    if (line[0] == '\0') {
        fprintf(stderr, "garland-master: %s: its first line is empty\n", path);
        exit(EXIT_FAILURE);
    }
    return line;
}

static int make_key(const char *path)
{
    char public_key[TRANSPORT_KEY_SIZE], secret_key[TRANSPORT_KEY_SIZE];
    fault_t fault = {0};
    if (transport_make_keys(public_key, secret_key, &fault) != FAULT_NONE) {
        fprintf(stderr, "garland-master: %s\n", fault.text);
        return EXIT_FAILURE;
    }
    const int file = open(path, O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, 0600);
    if (file < 0 || dprintf(file, "%s\n", secret_key) < 0 || close(file) != 0) {
        fprintf(stderr, "garland-master: %s: %s\n", path, strerror(errno));
        return EXIT_FAILURE;
    }
    printf("%s\n", public_key);
    return EXIT_SUCCESS;
}

static int refuse(const char *text)
{
    fprintf(stderr, "garland-master: %s\nTry: garland-master --help\n", text);
    return EXIT_USAGE;
}

static int serve(const server_options_t *options)
{
    fault_t fault = {0};
    server_t *server = NULL;
    catch_signals();
    if (server_new(&server, options, &fault) != FAULT_NONE) {
        fprintf(stderr, "garland-master: %s\n", fault.text);
        return EXIT_FAILURE;
    }
    running = server;
    printf("listening on %s\n", server_address(server));
    fflush(stdout);
    const fault_code_t code = server_run(server, &fault);
    running = NULL;
    server_destroy(&server);
    if (code != FAULT_NONE)
        fprintf(stderr, "garland-master: %s\n", fault.text);
    return code == FAULT_NONE ? EXIT_SUCCESS : EXIT_FAILURE;
}

/* A positive number of seconds, or 0. */
static double seconds_of(const char *text)
{
    char *end;
    const double value = strtod(text, &end);
    const double least = MESSAGE_MIN_INTERVAL_MS / 1000.0, most = MESSAGE_MAX_INTERVAL_MS / 1000.0;
    return *end == '\0' && value >= least && value <= most ? value : 0;
}

int main(int argc, char **argv)
{
    static const struct option names[] = {
        {"listen", required_argument, NULL, 'l'},   {"state", required_argument, NULL, 's'},
        {"lease", required_argument, NULL, 'L'},    {"token-file", required_argument, NULL, 't'},
        {"key-file", required_argument, NULL, 'k'}, {"new-key", required_argument, NULL, 'K'},
        {"no-sync", no_argument, NULL, 'n'},        {"quiet", no_argument, NULL, 'q'},
        {"verbose", no_argument, NULL, 'v'},        {"help", no_argument, NULL, 'h'},
        {"version", no_argument, NULL, 'V'},        {NULL, 0, NULL, 0}};
    server_options_t options = {0};
    char *token = NULL, *key = NULL;
    log_level_t level = LOG_INFO;
    for (int option; (option = getopt_long(argc, argv, "", names, NULL)) != -1;)
        switch (option) {
        case 'l':
            options.address = optarg;
            break;
        case 's':
            options.state = optarg;
            break;
        case 'L':
            options.lease_seconds = seconds_of(optarg);
            if (options.lease_seconds == 0)
                return refuse("--lease: expected seconds from 0.05 to 3600");
            break;
        case 't':
            free(token);
            token = first_line(optarg);
            break;
        case 'k':
            free(key);
            key = first_line(optarg);
            break;
        case 'K':
            return make_key(optarg);
        case 'n':
            options.no_sync = true;
            break;
        case 'q':
            level = LOG_WARN;
            break;
        case 'v':
            level = LOG_DEBUG;
            break;
        case 'h':
            fputs(usage, stdout);
            return EXIT_SUCCESS;
        case 'V':
            puts("garland-master " GARLAND_VERSION " (" GARLAND_ARCH ")");
            return EXIT_SUCCESS;
        default:
            return refuse("wrong usage");
        }
    if (optind < argc)
        return refuse("unexpected argument");
    if (!options.address || !options.state)
        return refuse(options.address ? "--state DIR is missing" : "--listen ADDR is missing");
    options.token = token;
    options.secret_key = key;
    log_open("garland-master", level);
    const int status = serve(&options);
    free(token);
    free(key);
    return status;
}
