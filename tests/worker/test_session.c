/* A worker's session against a master that the test plays, message by message. The session runs in a thread of its
 * own with the toy engine. */
#include <pthread.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/eventfd.h>
#include <unistd.h>
#include <cmocka.h>

#include "base/clock.h"
#include "base/file.h"
#include "base/random.h"
#include "proto/transport.h"
#include "worker/session.h"
#include "worker/toy_engine.h"

enum { PATIENCE_MS = 10000, THREADS = 2, HEARTBEAT_MS = 50, LEASE_MS = 1500, BUNDLE_SIZE = (5 << 20) / 2 + 77 };

static const char *const JOB_TEXT = "{\"scene\": \"toy\"}";

/* The worker's side. */
typedef struct worker {
    toy_t toy;
    cache_t *cache;
    session_options_t options;
    int stop_fd;
    pthread_t thread;
    fault_code_t code; /* of session_run, after joining */
    fault_t fault;
} worker_t;

static worker_t worker;
static transport_t *master;
static transport_peer_t peer; /* the worker's connection */
static transport_event_t event;
static fault_t fault;
static char address[128];
static uint8_t *bundle;
static digest_t bundle_name, job_name;

static void ok(fault_code_t code)
{
    if (code)
        fail_msg("code %d: %s", code, fault.text);
}

/* ---- the worker ---- */

static void *worker_main(void *argument)
{
    (void)argument;
    runner_t *runner = NULL;
    session_t *session = NULL;
    const engine_t engine = toy_engine(&worker.toy);
    worker.code = runner_new(&runner, &(runner_options_t){.threads = THREADS}, &engine, &worker.fault);
    if (worker.code == FAULT_NONE)
        worker.code = session_new(&session, &worker.options, runner, worker.cache, &worker.fault);
    if (worker.code == FAULT_NONE)
        worker.code = session_run(session, worker.stop_fd, &worker.fault);
    session_destroy(&session);
    runner_destroy(&runner);
    return NULL;
}

static void start_worker(double patience)
{
    worker.options = (session_options_t){
        .address = address, .host = "test", .token = "secret", .prefetch = 1, .patience = patience};
    assert_int_equal(pthread_create(&worker.thread, NULL, worker_main, NULL), 0);
}

static void join_worker(fault_code_t expected)
{
    pthread_join(worker.thread, NULL);
    if (worker.code != expected)
        fail_msg("the session ended with code %d (%s), expected %d", worker.code, worker.fault.text, expected);
}

static void stop_worker(void)
{
    eventfd_write(worker.stop_fd, 1);
    join_worker(FAULT_NONE);
}

/* ---- the master ---- */

static double beat_at;

static void send_to(transport_peer_t to, const message_t *message)
{
    ok(transport_send(master, to, message, &fault));
}

static uint64_t answered; /* octets of the bundle that were given */

/* A worker asks again for a piece that is late: on a busy machine for one that is on its way. */
static bool is_asked_again(message_type_t awaited)
{
    return awaited != MESSAGE_BUNDLE_GET && event.message.type == MESSAGE_BUNDLE_GET &&
           event.message.bundle_get.offset < answered;
}

/* The next message that is no heartbeat, while heartbeats are given. */
static void expect(message_type_t type)
{
    const double end = clock_now() + 1e-3 * PATIENCE_MS;
    for (;;) {
        if (peer && clock_now() > beat_at) {
            const message_t beat = {.type = MESSAGE_HEARTBEAT};
            transport_send(master, peer, &beat, NULL); /* may be gone just now */
            beat_at = clock_now() + 1e-3 * HEARTBEAT_MS;
        }
        const transport_event_kind_t kind = transport_receive(master, &event);
        if (kind == TRANSPORT_MALFORMED)
            fail_msg("malformed: %s", event.fault.text);
        if (kind == TRANSPORT_MESSAGE && (event.message.type != MESSAGE_HEARTBEAT || type == MESSAGE_HEARTBEAT) &&
            !is_asked_again(type))
            break;
        if (kind == TRANSPORT_NOTHING)
            ok(transport_wait(master, -1, HEARTBEAT_MS / 2, NULL, &fault));
        if (clock_now() > end)
            fail_msg("no %s within %d ms", message_type_name(type), PATIENCE_MS);
    }
    assert_string_equal(message_type_name(event.message.type), message_type_name(type));
    if (peer != TRANSPORT_NOBODY)
        assert_true(event.peer == peer);
}

/* Waits for a heartbeat with so many leases. */
static void expect_leases(unsigned count)
{
    const double end = clock_now() + 1e-3 * PATIENCE_MS;
    do {
        expect(MESSAGE_HEARTBEAT);
        if (clock_now() > end)
            fail_msg("%u leases, expected %u", event.message.heartbeat.leases.count, count);
    } while (event.message.heartbeat.leases.count != count);
}

static void expect_hello(uint64_t session)
{
    peer = TRANSPORT_NOBODY;
    expect(MESSAGE_HELLO);
    peer = event.peer;
    assert_int_equal(event.message.hello.role, MESSAGE_ROLE_WORKER);
    assert_int_equal(event.message.hello.threads, THREADS);
    assert_string_equal(event.message.hello.token, "secret");
    assert_true(event.message.hello.session == session);
}

static void welcome(uint64_t session)
{
    message_t message = {.type = MESSAGE_WELCOME};
    message.welcome = (message_welcome_t){GARLAND_VERSION, HEARTBEAT_MS, LEASE_MS, session};
    send_to(peer, &message);
}

static void expect_ready(unsigned slots)
{
    expect(MESSAGE_READY);
    assert_int_equal(event.message.ready.slots, slots);
}

/* HELLO, WELCOME, READY of a worker without units. */
static void greet(void)
{
    answered = 0;
    expect_hello(0);
    welcome(41);
    expect_ready(THREADS + 1);
}

static void give_work(uint64_t unit, const void *record, size_t size)
{
    message_t work = {.type = MESSAGE_WORK};
    work.work.lease = (message_lease_t){5, unit, 900 + unit};
    work.work.job_digest = job_name;
    work.work.bundle_digest = bundle_name;
    work.work.record = (message_bytes_t){record, size};
    send_to(peer, &work);
}

static void answer_job(const char *text)
{
    expect(MESSAGE_JOB_QUERY);
    assert_int_equal(event.message.job.job, 5);
    message_t data = {.type = MESSAGE_JOB_DATA};
    data.job_data = (message_job_data_t){5, bundle_name, text};
    send_to(peer, &data);
}

/* Answers one BUNDLE_GET; false when that was the last piece. */
static bool answer_piece(void)
{
    expect(MESSAGE_BUNDLE_GET);
    const message_bundle_get_t get = event.message.bundle_get;
    assert_true(digest_equal(&get.digest, &bundle_name));
    assert_true(get.offset < BUNDLE_SIZE);
    const uint64_t left = BUNDLE_SIZE - get.offset;
    message_t data = {.type = MESSAGE_BUNDLE_DATA};
    data.chunk = (message_chunk_t){bundle_name, BUNDLE_SIZE, get.offset, {bundle + get.offset, 0}};
    data.chunk.bytes.size = left < get.length ? left : get.length;
    send_to(peer, &data);
    answered = get.offset + data.chunk.bytes.size;
    return left > get.length;
}

static void answer_bundle(void)
{
    while (answer_piece())
        ;
}

static void expect_result(uint64_t unit, const void *record, size_t record_size)
{
    uint8_t *expected;
    size_t size;
    toy_expected(JOB_TEXT, record, record_size, &expected, &size);
    expect(MESSAGE_RESULT);
    assert_true(message_lease_equal(&event.message.result.lease, &(message_lease_t){5, unit, 900 + unit}));
    assert_int_equal(event.message.result.bytes.size, size);
    assert_memory_equal(event.message.result.bytes.data, expected, size);
    free(expected);
}

static void acknowledge(uint64_t unit)
{
    message_t ack = {.type = MESSAGE_ACK};
    ack.ack = (message_acknowledge_t){{5, unit, 900 + unit}, MESSAGE_ACK_MERGED};
    send_to(peer, &ack);
}

/* ---- tests ---- */

static void a_unit_is_fetched_run_and_returned(void **state)
{
    (void)state;
    start_worker(0);
    greet();
    give_work(1, "r\3", 2);
    answer_job(JOB_TEXT);
    answer_bundle();
    expect_result(1, "r\3", 2);
    expect_ready(1);
    expect_leases(1); /* still held */
    const message_lease_t lease = message_lease_at(&event.message.heartbeat.leases, 0);
    assert_true(message_lease_equal(&lease, &(message_lease_t){5, 1, 901}));
    acknowledge(1);
    expect_leases(0);
    /* what arrived is what was sent */
    char name[DIGEST_TEXT_SIZE], path[4200];
    digest_print(&bundle_name, name);
    snprintf(path, sizeof path, "%s/%s.%ld.unchecked", cache_folder(worker.cache), name, (long)getpid());
    uint8_t *data;
    size_t size;
    ok(file_read(path, 1 << 24, &data, &size, &fault));
    assert_int_equal(size, BUNDLE_SIZE);
    assert_memory_equal(data, bundle, size);
    free(data);
    /* the second unit needs nothing fetched */
    give_work(2, "r\1", 2);
    expect_result(2, "r\1", 2);
    expect_ready(1);
    stop_worker();
    expect(MESSAGE_BYE);
}

static void a_result_is_sent_again_to_a_restarted_master(void **state)
{
    (void)state;
    start_worker(0);
    greet();
    give_work(1, "r\3", 2);
    answer_job(JOB_TEXT);
    answer_bundle();
    expect_result(1, "r\3", 2);
    expect_ready(1);
    transport_destroy(&master);
    peer = TRANSPORT_NOBODY;
    ok(transport_bind(&master, address, NULL, &fault));
    expect(MESSAGE_HEARTBEAT); /* ZeroMQ has connected again: the worker has not noticed */
    const message_t wanted = {.type = MESSAGE_HELLO_WANTED};
    send_to(event.peer, &wanted);
    expect_hello(41);
    welcome(42);
    expect_result(1, "r\3", 2);
    expect_ready(THREADS + 1); /* credits begin anew */
    acknowledge(1);
    expect_leases(0);
    stop_worker();
}

static void a_silent_master_is_left_and_called_again(void **state)
{
    (void)state;
    start_worker(0);
    greet();
    give_work(1, "r\3", 2);
    answer_job(JOB_TEXT);
    answer_bundle();
    expect_result(1, "r\3", 2);
    expect_ready(1);
    const double quiet = clock_now();
    const transport_peer_t before = peer;
    expect_hello(41); /* sends no heartbeats while it waits */
    assert_true(clock_now() - quiet > 1e-3 * LEASE_MS - 0.1);
    assert_true(peer != before);
    welcome(42);
    expect_result(1, "r\3", 2);
    stop_worker();
}

static void a_bundle_goes_on_where_the_connection_broke(void **state)
{
    (void)state;
    start_worker(0);
    greet();
    give_work(1, "r\3", 2);
    answer_job(JOB_TEXT);
    assert_true(answer_piece());
    for (uint64_t i = 1; i <= 2; i++) { /* both under way at once */
        expect(MESSAGE_BUNDLE_GET);
        assert_int_equal(event.message.bundle_get.offset, i * MESSAGE_MAX_CHUNK);
    }
    const message_t bye = {.type = MESSAGE_BYE};
    send_to(peer, &bye);
    expect_hello(41);
    welcome(42);
    expect(MESSAGE_BUNDLE_GET);
    assert_int_equal(event.message.bundle_get.offset, MESSAGE_MAX_CHUNK);
    stop_worker();
}

static void a_refused_hello_ends_the_session(void **state)
{
    (void)state;
    start_worker(0);
    expect_hello(0);
    message_t refused = {.type = MESSAGE_REFUSED};
    refused.refused = (message_refused_t){"wrong token", FAULT_USAGE, MESSAGE_HELLO, 0};
    send_to(peer, &refused);
    join_worker(FAULT_USAGE);
    assert_non_null(strstr(worker.fault.text, "wrong token"));
    assert_non_null(strstr(worker.fault.text, address));
}

static void expect_failed(uint64_t unit, fault_code_t code, const char *words)
{
    expect(MESSAGE_FAILED);
    assert_true(message_lease_equal(&event.message.failed.lease, &(message_lease_t){5, unit, 900 + unit}));
    assert_int_equal(event.message.failed.code, code);
    if (!strstr(event.message.failed.text, words))
        fail_msg("\"%s\" does not say \"%s\"", event.message.failed.text, words);
}

static void failures_are_reported_until_acknowledged(void **state)
{
    (void)state;
    start_worker(0);
    greet();
    give_work(1, "f", 1);
    answer_job(JOB_TEXT);
    answer_bundle();
    expect_failed(1, FAULT_RANGE, "toy record of 1 octets");
    expect_ready(1);
    expect_leases(1);
    acknowledge(1);
    expect_leases(0);
    stop_worker();
}

static void a_job_that_is_not_the_unit_s_is_refused(void **state)
{
    (void)state;
    start_worker(0);
    greet();
    give_work(1, "r\1", 2);
    give_work(2, "r\1", 2);
    answer_job("{\"scene\": \"another\"}");
    expect_failed(1, FAULT_FORMAT, "job 5");
    expect_failed(2, FAULT_FORMAT, "job 5");
    expect_ready(2);
    give_work(3, "r\1", 2); /* asked for anew */
    answer_job(JOB_TEXT);
    answer_bundle();
    expect_result(3, "r\1", 2);
    stop_worker();
}

static void refused_requests_fail_their_units(void **state)
{
    (void)state;
    start_worker(0);
    greet();
    give_work(1, "r\1", 2);
    expect(MESSAGE_JOB_QUERY);
    message_t refused = {.type = MESSAGE_REFUSED};
    refused.refused = (message_refused_t){"no such job", FAULT_NOT_FOUND, MESSAGE_JOB_QUERY, 5};
    send_to(peer, &refused);
    expect_failed(1, FAULT_NOT_FOUND, "no such job");
    expect_ready(1);
    give_work(2, "r\1", 2);
    answer_job(JOB_TEXT);
    expect(MESSAGE_BUNDLE_GET);
    refused.refused = (message_refused_t){"no such bundle", FAULT_NOT_FOUND, MESSAGE_BUNDLE_GET, 0};
    send_to(peer, &refused);
    expect_failed(2, FAULT_NOT_FOUND, "no such bundle");
    stop_worker();
}

static void pieces_that_do_not_fit_fail_the_bundle(void **state)
{
    (void)state;
    start_worker(0);
    greet();
    give_work(1, "r\1", 2);
    answer_job(JOB_TEXT);
    expect(MESSAGE_BUNDLE_GET);
    message_t data = {.type = MESSAGE_BUNDLE_DATA};
    data.chunk = (message_chunk_t){bundle_name, BUNDLE_SIZE, 0, {bundle, 1000}}; /* short, and not the last */
    send_to(peer, &data);
    expect_failed(1, FAULT_PROTOCOL, "1000 octets");
    stop_worker();
}

static void cancelled_units_are_dropped_and_their_credit_comes_back(void **state)
{
    (void)state;
    start_worker(0);
    greet();
    give_work(1, "w", 1);
    answer_job(JOB_TEXT);
    answer_bundle();
    expect_leases(1);
    const double end = clock_now() + 1e-3 * PATIENCE_MS;
    while (atomic_load(&worker.toy.waiting) != 1 && clock_now() < end)
        usleep(1000);
    message_t cancel = {.type = MESSAGE_CANCEL};
    cancel.job.job = 5;
    send_to(peer, &cancel);
    expect_ready(1);
    expect_leases(0);
    give_work(2, "r\1", 2); /* the job's number is not tainted */
    expect_result(2, "r\1", 2);
    stop_worker();
}

static void shutdown_waits_for_results_to_be_acknowledged(void **state)
{
    (void)state;
    start_worker(0);
    greet();
    give_work(1, "r\1", 2);
    answer_job(JOB_TEXT);
    message_t down = {.type = MESSAGE_SHUTDOWN};
    down.farewell.text = "maintenance";
    send_to(peer, &down);
    answer_bundle();
    expect_result(1, "r\1", 2);
    expect_leases(1);
    acknowledge(1);
    expect(MESSAGE_BYE); /* and no READY before it */
    join_worker(FAULT_NONE);
}

static void duplicate_work_is_run_once(void **state)
{
    (void)state;
    start_worker(0);
    greet();
    give_work(1, "r\1", 2);
    give_work(1, "r\1", 2);
    answer_job(JOB_TEXT);
    expect_ready(1); /* the second took a credit and no place */
    answer_bundle();
    expect_result(1, "r\1", 2);
    expect_ready(1);
    give_work(2, "r\2", 2);
    expect_result(2, "r\2", 2);
    stop_worker();
}

static void patience_has_an_end(void **state)
{
    (void)state;
    const double start = clock_now();
    start_worker(0.3);
    join_worker(FAULT_TIMEOUT);
    assert_true(clock_now() - start >= 0.3);
    assert_non_null(strstr(worker.fault.text, "has not answered"));
    assert_non_null(strstr(worker.fault.text, address));
}

/* ---- each test has its own master, cache and worker ---- */

static int set_up(void **state)
{
    (void)state;
    memset(&worker, 0, sizeof worker);
    peer = TRANSPORT_NOBODY;
    beat_at = 0;
    worker.stop_fd = eventfd(0, EFD_CLOEXEC | EFD_NONBLOCK);
    if (cache_open(&worker.cache, NULL, 0, &fault) || transport_bind(&master, "tcp://127.0.0.1:0", NULL, &fault))
        return -1;
    snprintf(address, sizeof address, "%s", transport_address(master));
    return 0;
}

static int tear_down(void **state)
{
    (void)state;
    transport_destroy(&master);
    cache_close(&worker.cache);
    close(worker.stop_fd);
    return 0;
}

static int make_contents(void **state)
{
    (void)state;
    bundle = malloc(BUNDLE_SIZE);
    for (size_t i = 0; i < BUNDLE_SIZE; i++)
        bundle[i] = (uint8_t)random_u64(3, i);
    digest_of(&bundle_name, bundle, BUNDLE_SIZE);
    digest_of(&job_name, JOB_TEXT, strlen(JOB_TEXT));
    return 0;
}

static int free_contents(void **state)
{
    (void)state;
    free(bundle);
    return 0;
}

#define SESSION_TEST(name) cmocka_unit_test_setup_teardown(name, set_up, tear_down)

int main(void)
{
    const struct CMUnitTest tests[] = {
        SESSION_TEST(a_unit_is_fetched_run_and_returned),
        SESSION_TEST(a_result_is_sent_again_to_a_restarted_master),
        SESSION_TEST(a_silent_master_is_left_and_called_again),
        SESSION_TEST(a_bundle_goes_on_where_the_connection_broke),
        SESSION_TEST(a_refused_hello_ends_the_session),
        SESSION_TEST(failures_are_reported_until_acknowledged),
        SESSION_TEST(a_job_that_is_not_the_unit_s_is_refused),
        SESSION_TEST(refused_requests_fail_their_units),
        SESSION_TEST(pieces_that_do_not_fit_fail_the_bundle),
        SESSION_TEST(cancelled_units_are_dropped_and_their_credit_comes_back),
        SESSION_TEST(shutdown_waits_for_results_to_be_acknowledged),
        SESSION_TEST(duplicate_work_is_run_once),
        SESSION_TEST(patience_has_an_end),
    };
    return cmocka_run_group_tests(tests, make_contents, free_contents);
}
