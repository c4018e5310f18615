/* The server, in a thread of this process, with workers and clients that are played by the test: what each message
 * is answered with, and that whatever one peer does, the others are served. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <cmocka.h>
#include <inttypes.h>
#include <pthread.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "base/clock.h"
#include "client/link.h"
#include "master/server.h"
#include "scene/bundle.h"
#include "service/service_fixture.h"

enum { PATIENCE_MS = 20000, MUTATIONS = 20 };

static server_t *server;
static pthread_t server_thread;
static bundle_t *bundle;
static renderer_t *renderer;
static const char *server_token;

static void *serve(void *argument)
{
    (void)argument;
    fault_t fault = {0};
    if (server_run(server, &fault) != FAULT_NONE)
        print_error("server: %s\n", fault.text);
    return NULL;
}

static void start_server(void)
{
    fault_t fault = {0};
    static char address[FIXTURE_PATH + 16], state[FIXTURE_PATH + 16];
    snprintf(address, sizeof address, "ipc://%s/socket", fixture_folder);
    snprintf(state, sizeof state, "%s/state", fixture_folder);
    const server_options_t options = {
        .address = address, .state = state, .lease_seconds = 1, .token = server_token};
    if (server_new(&server, &options, &fault) != FAULT_NONE)
        fail_msg("%s", fault.text);
    assert_int_equal(pthread_create(&server_thread, NULL, serve, NULL), 0);
}

static void stop_server(void)
{
    server_stop(server);
    pthread_join(server_thread, NULL);
    server_destroy(&server);
}

static int setup(void **state)
{
    if (fixture_setup(state) != 0)
        return -1;
    fixture_renderer(&bundle, &renderer);
    return 0;
}

static int teardown(void **state)
{
    renderer_destroy(&renderer);
    bundle_destroy(&bundle);
    return fixture_teardown(state);
}

static int begin(void **state)
{
    (void)state;
    server_token = NULL;
    start_server();
    return 0;
}

static int end(void **state)
{
    (void)state;
    stop_server();
    fixture_remove("state");
    return 0;
}

/* ---- played peers ---- */

typedef struct player {
    transport_t *transport;
    uint64_t session;
    uint32_t slots; /* said, and not used yet */
    transport_event_t event;
} player_t;

static const message_hello_t worker_hello = {.garland_version = GARLAND_VERSION,
                                             .role = MESSAGE_ROLE_WORKER,
                                             .arch = GARLAND_ARCH,
                                             .host = "here",
                                             .pid = 1,
                                             .threads = 1,
                                             .token = ""};

static fault_code_t greet(player_t *player, const message_hello_t *hello, fault_t *fault)
{
    TRY(transport_hello(player->transport, hello, PATIENCE_MS, &player->event, fault));
    player->session = player->event.message.welcome.session;
    return FAULT_NONE;
}

static void connect_player(player_t *player)
{
    fault_t fault = {0};
    memset(player, 0, sizeof *player);
    if (transport_connect(&player->transport, server_address(server), &(transport_options_t){0}, &fault) !=
        FAULT_NONE)
        fail_msg("%s", fault.text);
}

static void connect_worker(player_t *player)
{
    fault_t fault = {0};
    connect_player(player);
    if (greet(player, &worker_hello, &fault) != FAULT_NONE)
        fail_msg("%s", fault.text);
}

static void leave(player_t *player)
{
    transport_destroy(&player->transport);
}

static void say(player_t *player, const message_t *message)
{
    fault_t fault = {0};
    if (transport_send(player->transport, TRANSPORT_MASTER, message, &fault) != FAULT_NONE)
        fail_msg("%s", fault.text);
}

static void be_ready(player_t *player, uint32_t slots)
{
    message_t ready = {.type = MESSAGE_READY};
    ready.ready.slots = player->slots = slots;
    say(player, &ready);
}

/* The next message. A player that a busy machine made silent for a lease is taken for gone by the server: it says
 * HELLO again and is as ready as it was. */
static fault_code_t receive(player_t *player, int timeout_ms, fault_t *fault)
{
    message_t hello = {.type = MESSAGE_HELLO, .hello = worker_hello};
    TRY(transport_receive_within(player->transport, timeout_ms, &player->event, fault));
    switch (player->event.message.type) {
    case MESSAGE_WORK:
        player->slots -= player->slots > 0;
        break;
    case MESSAGE_HELLO_WANTED:
        hello.hello.session = player->session;
        say(player, &hello);
        break;
    case MESSAGE_WELCOME:
        if (player->slots > 0)
            be_ready(player, player->slots);
        break;
    default:
        break;
    }
    return FAULT_NONE;
}

/* The next message of the type; others are passed over. */
static const message_t *hear(player_t *player, message_type_t type)
{
    fault_t fault = {0};
    do
        if (receive(player, PATIENCE_MS, &fault) != FAULT_NONE)
            fail_msg("waiting for %s: %s", message_type_name(type), fault.text);
    while (player->event.message.type != type);
    return &player->event.message;
}

static void send_result(player_t *player, const message_lease_t *lease, const uint8_t *data, size_t size)
{
    message_t result = {.type = MESSAGE_RESULT};
    result.result.lease = *lease;
    result.result.bytes = (message_bytes_t){data, size};
    say(player, &result);
}

static void send_failed(player_t *player, const message_lease_t *lease, const char *text)
{
    message_t failed = {.type = MESSAGE_FAILED};
    failed.failed.lease = *lease;
    failed.failed.code = FAULT_RANGE;
    failed.failed.text = text;
    say(player, &failed);
}

/* Renders the WORK that was just heard. */
static message_lease_t render(player_t *player, uint8_t **data, size_t *size)
{
    const message_work_t *work = &player->event.message.work;
    const message_lease_t lease = work->lease;
    work_record_t record;
    fault_t fault = {0};
    if (work_record_decode(&record, work->record.data, work->record.size, &fault) != FAULT_NONE)
        fail_msg("%s", fault.text);
    fixture_run_unit(renderer, &record, data, size);
    work_record_clear(&record);
    return lease;
}

static message_ack_t hear_ack(player_t *player, const message_lease_t *lease)
{
    do
        hear(player, MESSAGE_ACK);
    while (!message_lease_equal(&player->event.message.ack.lease, lease));
    return (message_ack_t)player->event.message.ack.outcome;
}

/* Takes one unit and sends it back done; *lease (may be null) is its lease. False when the job ends instead. */
static bool do_unit(player_t *player, message_lease_t *lease)
{
    fault_t fault = {0};
    uint8_t *data;
    size_t size;
    be_ready(player, 1);
    do {
        if (receive(player, PATIENCE_MS, &fault) != FAULT_NONE)
            fail_msg("waiting for work: %s", fault.text);
        if (player->event.message.type == MESSAGE_CANCEL)
            return false;
    } while (player->event.message.type != MESSAGE_WORK);
    const message_lease_t own = render(player, &data, &size);
    send_result(player, &own, data, size);
    free(data);
    if (lease)
        *lease = own;
    return true;
}

static link_t *open_link(void)
{
    link_t *link;
    fault_t fault = {0};
    if (link_open(&link, server_address(server), &(link_options_t){0}, &fault) != FAULT_NONE)
        fail_msg("%s", fault.text);
    return link;
}

static uint64_t submit_of(link_t *link, double mutations_per_pixel, int seed)
{
    uint64_t job = 0;
    fault_t fault = {0};
    if (link_submit(link, fixture_job(mutations_per_pixel, seed), fixture_bundle, &job, &fault) != FAULT_NONE)
        fail_msg("%s", fault.text);
    return job;
}

static uint64_t submit(link_t *link, int seed)
{
    return submit_of(link, MUTATIONS, seed);
}

static message_end_t await_end(link_t *link, uint64_t job, char *text, size_t size)
{
    fault_t fault = {0};
    transport_event_t event;
    bool got = false;
    const double limit = clock_now() + 1e-3 * PATIENCE_MS;
    assert_int_equal(link_subscribe(link, job, &fault), FAULT_NONE);
    do {
        if (link_next(link, 200, &event, &got, &fault) != FAULT_NONE)
            fail_msg("%s", fault.text);
        if (clock_now() > limit)
            fail_msg("no end of the job");
    } while (!got || event.message.type != MESSAGE_JOB_END);
    snprintf(text, size, "%s", event.message.job_end.text);
    return (message_end_t)event.message.job_end.state;
}

static void expect_image(link_t *link, uint64_t job, int seed)
{
    fault_t fault = {0};
    uint8_t *data;
    size_t size;
    digest_t pixels, expected;
    if (link_fetch(link, job, MESSAGE_OUTPUT_IMAGE, &data, &size, &fault) != FAULT_NONE)
        fail_msg("%s", fault.text);
    FILE *file = fopen(fixture_path("fetched.exr"), "wb");
    assert_non_null(file);
    assert_int_equal(fwrite(data, 1, size, file), size);
    fclose(file);
    free(data);
    fixture_pixels(fixture_path("fetched.exr"), &pixels);
    fixture_direct(fixture_job(MUTATIONS, seed), &expected);
    assert_true(digest_equal(&pixels, &expected));
}

/* ---- tests ---- */

static void a_job_goes_from_submission_to_image(void **state)
{
    (void)state;
    char text[256];
    player_t worker;
    link_t *link = open_link();
    connect_worker(&worker);
    const uint64_t job = submit(link, 1);
    while (do_unit(&worker, NULL))
        continue;
    assert_int_equal(await_end(link, job, text, sizeof text), MESSAGE_END_FINISHED);
    expect_image(link, job, 1);
    leave(&worker);
    link_close(&link);
}

static void workers_of_another_version_or_machine_are_refused(void **state)
{
    (void)state;
    player_t player;
    fault_t fault = {0};
    message_hello_t hello = worker_hello;
    connect_player(&player);
    hello.garland_version = "99.9";
    assert_int_equal(greet(&player, &hello, &fault), FAULT_VERSION);
    assert_non_null(strstr(fault.text, "99.9"));
    assert_non_null(strstr(fault.text, GARLAND_VERSION));
    hello = worker_hello;
    hello.arch = "vax";
    assert_int_equal(greet(&player, &hello, &fault), FAULT_VERSION);
    assert_non_null(strstr(fault.text, "vax"));
    assert_int_equal(greet(&player, &worker_hello, &fault), FAULT_NONE);
    leave(&player);
}

static void a_wrong_token_is_refused(void **state)
{
    stop_server();
    server_token = "open sesame";
    start_server();
    player_t player;
    fault_t fault = {0};
    message_hello_t hello = worker_hello;
    connect_player(&player);
    const char *const wrong[] = {"", "open sesam", "open sesamo", "open sesame!"};
    for (int i = 0; i < 4; i++) {
        hello.token = wrong[i];
        assert_int_equal(greet(&player, &hello, &fault), FAULT_USAGE);
        assert_non_null(strstr(fault.text, "token"));
    }
    hello.token = server_token;
    assert_int_equal(greet(&player, &hello, &fault), FAULT_NONE);
    leave(&player);
    (void)state;
}

static void who_has_not_said_hello_is_asked_to(void **state)
{
    (void)state;
    player_t player;
    connect_player(&player);
    be_ready(&player, 1);
    hear(&player, MESSAGE_HELLO_WANTED);
    leave(&player);
}

static void requests_about_unknown_things_are_refused(void **state)
{
    (void)state;
    player_t player;
    fault_t fault = {0};
    link_t *link = open_link();
    json_t *status;
    uint8_t *data;
    size_t size;
    char *text;
    assert_int_equal(link_status(link, 12345, &status, &fault), FAULT_NOT_FOUND);
    assert_int_equal(link_cancel(link, 12345, &fault), FAULT_NOT_FOUND);
    assert_int_equal(link_job_text(link, 12345, &text, &fault), FAULT_NOT_FOUND);
    assert_int_equal(link_fetch(link, 12345, MESSAGE_OUTPUT_IMAGE, &data, &size, &fault), FAULT_NOT_FOUND);
    assert_int_equal(link_subscribe(link, 12345, &fault), FAULT_NOT_FOUND);
    assert_non_null(strstr(fault.text, "12345"));
    link_close(&link);

    connect_worker(&player);
    const message_lease_t nowhere = {.job = 12345, .unit = 3, .attempt = 4};
    send_result(&player, &nowhere, (const uint8_t *)"x", 1);
    assert_int_equal(hear_ack(&player, &nowhere), MESSAGE_ACK_UNKNOWN);
    send_failed(&player, &nowhere, "no");
    assert_int_equal(hear_ack(&player, &nowhere), MESSAGE_ACK_UNKNOWN);
    message_t get = {.type = MESSAGE_BUNDLE_GET};
    get.bundle_get = (message_bundle_get_t){.digest = fixture_digest, .length = 100};
    say(&player, &get);
    assert_int_equal(hear(&player, MESSAGE_REFUSED)->refused.code, FAULT_NOT_FOUND);
    message_t submit_as_worker = {.type = MESSAGE_SUBMIT};
    submit_as_worker.submit.text = "{}";
    say(&player, &submit_as_worker);
    assert_int_equal(hear(&player, MESSAGE_REFUSED)->refused.code, FAULT_PROTOCOL);
    leave(&player);
}

static void a_bad_job_is_refused_before_its_scene_is_sent(void **state)
{
    (void)state;
    fault_t fault = {0};
    uint64_t job;
    link_t *link = open_link();
    assert_int_not_equal(link_submit(link, "{\"scene\": \"a\", \"sceen\": 1}", fixture_bundle, &job, &fault),
                         FAULT_NONE);
    assert_non_null(strstr(fault.text, "sceen"));
    json_t *status;
    assert_int_equal(link_status(link, 0, &status, &fault), FAULT_NONE);
    assert_int_equal(json_size(json_get(status, "jobs")), 0);
    json_destroy(&status);
    link_close(&link);
}

static void a_result_counts_once_however_often_it_comes(void **state)
{
    (void)state;
    player_t worker;
    char text[256];
    uint8_t *data;
    size_t size;
    link_t *link = open_link();
    connect_worker(&worker);
    const uint64_t job = submit(link, 1);
    be_ready(&worker, 1);
    hear(&worker, MESSAGE_WORK);
    const message_lease_t lease = render(&worker, &data, &size);
    for (int i = 0; i < 4; i++) {
        send_result(&worker, &lease, data, size);
        assert_int_equal(hear_ack(&worker, &lease), i == 0 ? MESSAGE_ACK_MERGED : MESSAGE_ACK_DUPLICATE);
    }
    free(data);
    while (do_unit(&worker, NULL))
        continue;
    assert_int_equal(await_end(link, job, text, sizeof text), MESSAGE_END_FINISHED);
    expect_image(link, job, 1);
    leave(&worker);
    link_close(&link);
}

static void a_silent_worker_s_unit_goes_to_another(void **state)
{
    (void)state;
    player_t silent, busy;
    char text[256];
    uint8_t *data;
    size_t size;
    fault_t fault = {0};
    link_t *link = open_link();
    connect_worker(&silent);
    const uint64_t job = submit(link, 1);
    be_ready(&silent, 1);
    hear(&silent, MESSAGE_WORK);
    const message_lease_t lease = render(&silent, &data, &size);
    connect_worker(&busy);
    while (do_unit(&busy, NULL)) /* needs the silent one's unit before it can come to an end */
        continue;
    assert_int_equal(await_end(link, job, text, sizeof text), MESSAGE_END_FINISHED);
    expect_image(link, job, 1);
    assert_int_equal(greet(&silent, &worker_hello, &fault), FAULT_NONE);
    send_result(&silent, &lease, data, size);
    assert_int_equal(hear_ack(&silent, &lease), MESSAGE_ACK_UNKNOWN);
    free(data);
    leave(&silent);
    leave(&busy);
    link_close(&link);
}

static void a_lease_that_a_heartbeat_does_not_name_is_given_away(void **state)
{
    (void)state;
    player_t forgetful, other;
    uint8_t packed[MESSAGE_LEASE_SIZE];
    link_t *link = open_link();
    connect_worker(&forgetful);
    submit(link, 1);
    be_ready(&forgetful, 2);
    const message_lease_t dropped = hear(&forgetful, MESSAGE_WORK)->work.lease;
    const message_lease_t kept = hear(&forgetful, MESSAGE_WORK)->work.lease;
    message_lease_pack(packed, 0, &kept);
    message_t beat = {.type = MESSAGE_HEARTBEAT};
    beat.heartbeat.leases = (message_leases_t){packed, 1};
    connect_worker(&other);
    bool seen = false;
    for (int i = 0; i < 40 && !seen; i++) {
        const message_t empty = {.type = MESSAGE_HEARTBEAT};
        say(&forgetful, &beat);
        say(&other, &empty);
        usleep(50000);
        fault_t fault = {0};
        be_ready(&other, 1);
        while (!seen && receive(&other, 20, &fault) == FAULT_NONE)
            seen = other.event.message.type == MESSAGE_WORK && other.event.message.work.lease.unit == dropped.unit;
    }
    assert_true(seen);
    assert_int_not_equal(other.event.message.work.lease.attempt, dropped.attempt);
    leave(&forgetful);
    leave(&other);
    link_close(&link);
}

static void a_worker_that_reconnects_keeps_its_session(void **state)
{
    (void)state;
    player_t worker;
    connect_worker(&worker);
    message_hello_t hello = worker_hello;
    const uint64_t session = hello.session = worker.session;
    leave(&worker);
    connect_player(&worker);
    fault_t fault = {0};
    assert_int_equal(greet(&worker, &hello, &fault), FAULT_NONE);
    assert_true(worker.session == session);
    leave(&worker);
}

/* Fails every unit of one job, does those of the other. */
static void a_failing_job_disturbs_no_other(void **state)
{
    (void)state;
    player_t workers[2];
    char text[FAULT_TEXT_SIZE];
    link_t *link = open_link();
    const uint64_t bad = submit(link, 2), good = submit(link, 1);
    for (int i = 0; i < 2; i++) {
        connect_worker(&workers[i]);
        be_ready(&workers[i], 1);
    }
    bool ended = false;
    const double limit = clock_now() + 60;
    for (int turn = 0; !ended; turn++) {
        player_t *worker = &workers[turn % 2];
        fault_t fault = {0};
        const message_t beat = {.type = MESSAGE_HEARTBEAT};
        assert_true(clock_now() < limit);
        if (receive(worker, 50, &fault) != FAULT_NONE) {
            say(worker, &beat);
            continue;
        }
        const message_t *message = &worker->event.message;
        if (message->type == MESSAGE_WORK && message->work.lease.job == bad) {
            const message_lease_t lease = message->work.lease;
            send_failed(worker, &lease, "this one never works");
            be_ready(worker, 1);
        } else if (message->type == MESSAGE_WORK) {
            uint8_t *data;
            size_t size;
            const message_lease_t lease = render(worker, &data, &size);
            send_result(worker, &lease, data, size);
            free(data);
            be_ready(worker, 1);
        }
        ended = message->type == MESSAGE_CANCEL && message->job.job == good;
    }
    assert_int_equal(await_end(link, good, text, sizeof text), MESSAGE_END_FINISHED);
    expect_image(link, good, 1);
    assert_int_equal(await_end(link, bad, text, sizeof text), MESSAGE_END_FAILED);
    assert_non_null(strstr(text, "this one never works"));
    leave(&workers[0]);
    leave(&workers[1]);
    link_close(&link);
}

/* A worker that waited says again and again how many more it would take. */
static void credits_add_up(void **state)
{
    (void)state;
    player_t worker;
    link_t *link = open_link();
    connect_worker(&worker);
    be_ready(&worker, 2);
    be_ready(&worker, 1);
    submit_of(link, 60000, 1); /* whose pilot begins with as many units */
    for (int i = 0; i < 3; i++)
        hear(&worker, MESSAGE_WORK);
    leave(&worker);
    link_close(&link);
}

static void two_jobs_get_equal_shares(void **state)
{
    (void)state;
    enum { SLOTS = 6, LONG = 60000 }; /* so long that the first part of the pilot alone has more units */
    player_t worker;
    int share[2] = {0};
    link_t *link = open_link();
    const uint64_t jobs[2] = {submit_of(link, LONG, 1), submit_of(link, LONG, 2)};
    for (bool running = false; !running;) { /* both are set up */
        json_t *status;
        fault_t fault = {0};
        assert_int_equal(link_status(link, 0, &status, &fault), FAULT_NONE);
        const json_t *list = json_get(status, "jobs");
        running = true;
        for (size_t i = 0; i < json_size(list); i++)
            running &= strcmp(json_string(json_get(json_at(list, i), "state")), "running") == 0;
        json_destroy(&status);
    }
    connect_worker(&worker);
    be_ready(&worker, SLOTS);
    for (int i = 0; i < SLOTS; i++) {
        const uint64_t job = hear(&worker, MESSAGE_WORK)->work.lease.job;
        assert_true(job == jobs[0] || job == jobs[1]);
        share[job == jobs[1]]++;
    }
    assert_int_equal(share[0], SLOTS / 2);
    assert_int_equal(share[1], SLOTS / 2);
    leave(&worker);
    link_close(&link);
}

static void a_cancelled_job_is_taken_back_from_workers(void **state)
{
    (void)state;
    player_t worker;
    char text[256];
    fault_t fault = {0};
    link_t *link = open_link();
    connect_worker(&worker);
    const uint64_t job = submit(link, 1);
    be_ready(&worker, 1);
    hear(&worker, MESSAGE_WORK);
    assert_int_equal(link_cancel(link, job, &fault), FAULT_NONE);
    assert_true(hear(&worker, MESSAGE_CANCEL)->job.job == job);
    assert_int_equal(await_end(link, job, text, sizeof text), MESSAGE_END_CANCELLED);
    assert_int_equal(link_cancel(link, job, &fault), FAULT_USAGE);
    leave(&worker);
    link_close(&link);
}

static void a_restarted_server_goes_on_and_takes_old_results(void **state)
{
    (void)state;
    player_t worker;
    char text[256];
    uint8_t *data;
    size_t size;
    fault_t fault = {0};
    link_t *link = open_link();
    connect_worker(&worker);
    const uint64_t job = submit(link, 1);
    for (int i = 0; i < 3; i++)
        assert_true(do_unit(&worker, NULL));
    be_ready(&worker, 1);
    hear(&worker, MESSAGE_WORK);
    const message_lease_t lease = render(&worker, &data, &size);
    leave(&worker);
    stop_server();
    start_server();
    connect_worker(&worker);
    for (bool running = false; !running;) {
        json_t *status;
        if (link_status(link, job, &status, &fault) != FAULT_NONE)
            fail_msg("%s", fault.text);
        running = strcmp(json_string(json_get(json_at(json_get(status, "jobs"), 0), "state")), "running") == 0;
        json_destroy(&status);
    }
    send_result(&worker, &lease, data, size);
    assert_int_equal(hear_ack(&worker, &lease), MESSAGE_ACK_MERGED);
    free(data);
    while (do_unit(&worker, NULL))
        continue;
    assert_int_equal(await_end(link, job, text, sizeof text), MESSAGE_END_FINISHED);
    expect_image(link, job, 1);
    leave(&worker);
    link_close(&link);
}

static void status_tells_jobs_and_workers(void **state)
{
    (void)state;
    player_t worker;
    fault_t fault = {0};
    json_t *status;
    link_t *link = open_link();
    connect_worker(&worker);
    const uint64_t job = submit(link, 1);
    message_lease_t lease;
    assert_true(do_unit(&worker, &lease));
    assert_int_equal(hear_ack(&worker, &lease), MESSAGE_ACK_MERGED);
    assert_int_equal(link_status(link, job, &status, &fault), FAULT_NONE);
    const json_t *jobs = json_get(status, "jobs"), *workers = json_get(status, "workers");
    char number[32];
    snprintf(number, sizeof number, "%" PRIu64, job);
    assert_int_equal(json_size(jobs), 1);
    assert_string_equal(json_string(json_get(json_at(jobs, 0), "id")), number);
    assert_string_equal(json_string(json_get(json_at(jobs, 0), "state")), "running");
    assert_string_equal(json_string(json_get(json_at(jobs, 0), "phase")), "pilot");
    assert_true(json_number(json_get(json_at(jobs, 0), "units_in")) == 1);
    assert_int_equal(json_size(workers), 1);
    assert_string_equal(json_string(json_get(json_at(workers, 0), "host")), "here");
    assert_true(json_number(json_get(json_at(workers, 0), "units_done")) == 1);
    json_destroy(&status);
    leave(&worker);
    link_close(&link);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_setup_teardown(a_job_goes_from_submission_to_image, begin, end),
        cmocka_unit_test_setup_teardown(workers_of_another_version_or_machine_are_refused, begin, end),
        cmocka_unit_test_setup_teardown(a_wrong_token_is_refused, begin, end),
        cmocka_unit_test_setup_teardown(who_has_not_said_hello_is_asked_to, begin, end),
        cmocka_unit_test_setup_teardown(requests_about_unknown_things_are_refused, begin, end),
        cmocka_unit_test_setup_teardown(a_bad_job_is_refused_before_its_scene_is_sent, begin, end),
        cmocka_unit_test_setup_teardown(a_result_counts_once_however_often_it_comes, begin, end),
        cmocka_unit_test_setup_teardown(a_silent_worker_s_unit_goes_to_another, begin, end),
        cmocka_unit_test_setup_teardown(a_lease_that_a_heartbeat_does_not_name_is_given_away, begin, end),
        cmocka_unit_test_setup_teardown(a_worker_that_reconnects_keeps_its_session, begin, end),
        cmocka_unit_test_setup_teardown(a_failing_job_disturbs_no_other, begin, end),
        cmocka_unit_test_setup_teardown(credits_add_up, begin, end),
        cmocka_unit_test_setup_teardown(two_jobs_get_equal_shares, begin, end),
        cmocka_unit_test_setup_teardown(a_cancelled_job_is_taken_back_from_workers, begin, end),
        cmocka_unit_test_setup_teardown(a_restarted_server_goes_on_and_takes_old_results, begin, end),
        cmocka_unit_test_setup_teardown(status_tells_jobs_and_workers, begin, end)};
    return cmocka_run_group_tests(tests, setup, teardown);
}
