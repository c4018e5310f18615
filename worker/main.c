/* garland-worker: connects to a master and renders what it is given. */
#include <errno.h>
#include <getopt.h>
#include <math.h>
#include <sched.h>
#include <signal.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/eventfd.h>
#include <unistd.h>

#include "base/file.h"
#include "base/log.h"
#include "worker/render.h"
#include "worker/session.h"

enum { EXIT_FAULT = 1, EXIT_USAGE = 2, HOST_SIZE = 256, SECRET_SIZE = MESSAGE_MAX_TOKEN + 1 };

static const char HELP[] =
    "usage: garland-worker --master ADDRESS [options]\n"
    "\n"
    "Renders units of jobs for a Garland master until it is told to stop.\n"
    "\n"
    "  --master ADDRESS     tcp://host:port or ipc://path of the master\n"
    "  --threads N          threads that render (default: the processors it may use)\n"
    "  --cache DIR          keeps bundles there (default: a temporary folder, removed at the end)\n"
    "  --cache-limit GB     removes the oldest bundles beyond so many gigabytes (default 64)\n"
    "  --patience SECONDS   gives up when the master is silent for so long (default: never, but\n"
    "                       30 s for the first answer)\n"
    "  --token-file FILE    holds the secret that the master asks for\n"
    "  --server-key FILE    holds the master's public key (40 characters): the connection is encrypted\n"
    "  --quiet, --verbose   say less, say more\n"
    "  --help, --version\n"
    "\n"
    "SIGTERM or SIGINT: leaves at once and gives its units back; a second one does not wait for that.\n"
    "Exit status: 0 finished or stopped, 1 failed, 2 wrong usage.\n";

typedef struct options {
    session_options_t session;
    unsigned threads;
    const char *cache, *token_file, *key_file;
    uint64_t cache_limit;
    log_level_t level;
    char token[SECRET_SIZE], key[SECRET_SIZE], host[HOST_SIZE];
} options_t;

/* ---- the command line ---- */

static unsigned processors(void)
{
    cpu_set_t set;
    int count = sched_getaffinity(0, sizeof set, &set) == 0 ? CPU_COUNT(&set) : 1;
    if (count < 1)
        count = 1;
    return count < RUNNER_MAX_THREADS ? (unsigned)count : RUNNER_MAX_THREADS;
}

static fault_code_t read_number(const char *option, const char *text, double lo, double hi, double *out,
                                fault_t *fault)
{
    char *end;
    const double value = strtod(text, &end);
    if (end == text || *end || !(value >= lo && value <= hi))
        return fault_set(fault, FAULT_USAGE, "--%s \"%s\": expected a number from %g to %g", option, text, lo, hi);
    *out = value;
    return FAULT_NONE;
}

typedef enum option_id {
    OPTION_MASTER = 256,
    OPTION_THREADS,
    OPTION_CACHE,
    OPTION_CACHE_LIMIT,
    OPTION_PATIENCE,
    OPTION_TOKEN_FILE,
    OPTION_SERVER_KEY,
    OPTION_QUIET,
    OPTION_VERBOSE,
    OPTION_HELP,
    OPTION_VERSION
} option_id_t;

static const struct option OPTIONS[] = {
    {"master", required_argument, NULL, OPTION_MASTER},
    {"threads", required_argument, NULL, OPTION_THREADS},
    {"cache", required_argument, NULL, OPTION_CACHE},
    {"cache-limit", required_argument, NULL, OPTION_CACHE_LIMIT},
    {"patience", required_argument, NULL, OPTION_PATIENCE},
    {"token-file", required_argument, NULL, OPTION_TOKEN_FILE},
    {"server-key", required_argument, NULL, OPTION_SERVER_KEY},
    {"quiet", no_argument, NULL, OPTION_QUIET},
    {"verbose", no_argument, NULL, OPTION_VERBOSE},
    {"help", no_argument, NULL, OPTION_HELP},
    {"version", no_argument, NULL, OPTION_VERSION},
    {NULL, 0, NULL, 0},
};

static fault_code_t read_threads(options_t *options, fault_t *fault)
{
    double number;
    TRY(read_number("threads", optarg, 1, RUNNER_MAX_THREADS, &number, fault));
    if (number != floor(number))
        return fault_set(fault, FAULT_USAGE, "--threads \"%s\": expected a whole number", optarg);
    options->threads = (unsigned)number;
    return FAULT_NONE;
}

static fault_code_t read_option(options_t *options, int id, fault_t *fault)
{
    double number;
    switch (id) {
    case OPTION_MASTER:
        options->session.address = optarg;
        return FAULT_NONE;
    case OPTION_THREADS:
        return read_threads(options, fault);
    case OPTION_CACHE:
        options->cache = optarg;
        return FAULT_NONE;
    case OPTION_CACHE_LIMIT:
        TRY(read_number("cache-limit", optarg, 1e-3, 1e6, &number, fault));
        options->cache_limit = (uint64_t)(number * 1e9);
        return FAULT_NONE;
    case OPTION_PATIENCE:
        return read_number("patience", optarg, 0.1, 1e9, &options->session.patience, fault);
    case OPTION_TOKEN_FILE:
        options->token_file = optarg;
        return FAULT_NONE;
    case OPTION_SERVER_KEY:
        options->key_file = optarg;
        return FAULT_NONE;
    case OPTION_QUIET:
        options->level = LOG_WARN;
        return FAULT_NONE;
    case OPTION_VERBOSE:
        options->level = LOG_DEBUG;
        return FAULT_NONE;
    case OPTION_HELP:
        fputs(HELP, stdout);
        exit(EXIT_SUCCESS);
    case OPTION_VERSION:
        printf("garland-worker %s (%s, protocol %d)\n", GARLAND_VERSION, GARLAND_ARCH, MESSAGE_PROTOCOL_VERSION);
        exit(EXIT_SUCCESS);
    default:
        return fault_set(fault, FAULT_USAGE, "see garland-worker --help"); /* getopt has said what is wrong */
    }
}

/* The first line of a small file, without the white space around it. */
static fault_code_t read_secret(const char *path, char secret[SECRET_SIZE], fault_t *fault)
{
    uint8_t *data;
    size_t size;
    TRY(file_read(path, 4096, &data, &size, fault));
    const char *text = (const char *)data;
    const size_t start = strspn(text, " \t\r\n"), length = strcspn(text + start, " \t\r\n");
    const bool fits = length > 0 && length < SECRET_SIZE;
    if (fits) {
        memcpy(secret, text + start, length);
        secret[length] = '\0';
    }
    memset(data, 0, size);
    free(data);
    if (!fits)
        return fault_set(fault, FAULT_FORMAT, "%s: expected 1 to %d characters, found %zu", path, SECRET_SIZE - 1,
                         length);
    return FAULT_NONE;
}

static fault_code_t read_options(options_t *options, int count, char **arguments, fault_t *fault)
{
    *options = (options_t){.threads = processors(), .level = LOG_INFO};
    for (int id; (id = getopt_long(count, arguments, "", OPTIONS, NULL)) != -1;)
        TRY(read_option(options, id, fault));
    if (optind < count)
        return fault_set(fault, FAULT_USAGE, "\"%s\" is no option; see garland-worker --help", arguments[optind]);
    if (!options->session.address)
        return fault_set(fault, FAULT_USAGE, "--master ADDRESS is missing; see garland-worker --help");
    if (options->token_file) {
        TRY(read_secret(options->token_file, options->token, fault));
        options->session.token = options->token;
    }
    if (options->key_file) {
        TRY(read_secret(options->key_file, options->key, fault));
        options->session.server_key = options->key;
    }
    if (gethostname(options->host, sizeof options->host - 1) == 0)
        options->session.host = options->host;
    return FAULT_NONE;
}

/* ---- signals ---- */

static int stop_fd = -1;
static volatile sig_atomic_t signals;

static void on_signal(int number)
{
    if (signals++ > 0)
        _exit(128 + number);
    const uint64_t one = 1;
    const ssize_t written = write(stop_fd, &one, sizeof one);
    (void)written; /* eight octets into a fresh eventfd */
}

static fault_code_t catch_signals(fault_t *fault)
{
    stop_fd = eventfd(0, EFD_CLOEXEC | EFD_NONBLOCK);
    if (stop_fd < 0)
        return fault_set(fault, FAULT_IO, "cannot make an eventfd: %s", strerror(errno));
    struct sigaction action = {.sa_handler = on_signal};
    sigemptyset(&action.sa_mask);
    sigaction(SIGTERM, &action, NULL);
    sigaction(SIGINT, &action, NULL);
    action.sa_handler = SIG_IGN;
    sigaction(SIGPIPE, &action, NULL);
    return FAULT_NONE;
}

/* ---- all together ---- */

static fault_code_t serve(const options_t *options, fault_t *fault)
{
    cache_t *cache = NULL;
    runner_t *runner = NULL;
    session_t *session = NULL;
    fault_code_t code = cache_open(&cache, options->cache, options->cache_limit, fault);
    if (code)
        goto cleanup;
    const engine_t engine = render_engine(cache);
    code = runner_new(&runner, &(runner_options_t){.threads = options->threads}, &engine, fault);
    if (code)
        goto cleanup;
    code = session_new(&session, &options->session, runner, cache, fault);
    if (code)
        goto cleanup;
    log_info("%u threads, bundles in %s", options->threads, cache_folder(cache));
    code = session_run(session, stop_fd, fault);
cleanup:
    session_destroy(&session);
    runner_destroy(&runner);
    cache_close(&cache);
    return code;
}

int main(int count, char **arguments)
{
    static options_t options;
    static fault_t fault;
    log_open("garland-worker", LOG_INFO);
    fault_code_t code = read_options(&options, count, arguments, &fault);
    if (code == FAULT_NONE) {
        log_open("garland-worker", options.level);
        code = catch_signals(&fault);
    }
    if (code == FAULT_NONE)
        code = serve(&options, &fault);
    if (code == FAULT_NONE)
        return EXIT_SUCCESS;
    fprintf(stderr, "garland-worker: %s\n", fault.text);
    return code == FAULT_USAGE ? EXIT_USAGE : EXIT_FAULT;
}
