/* serve_client.c: jobs from clients, status and outputs to them. */
#include <inttypes.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "base/clock.h"
#include "base/log.h"
#include "master/server_internal.h"

enum { STATUS_JOBS = 4096 }; /* the newest, so that the answer stays within MESSAGE_MAX_STATUS */

static void refuse_fault(server_t *server, const peer_t *peer, message_type_t request, uint64_t job,
                         const fault_t *fault)
{
    server_refuse(server, peer, request, job, fault->code, fault->text);
}

/* The job, or a refusal. */
static run_t *find_job(server_t *server, const peer_t *peer, message_type_t request, uint64_t job)
{
    run_t *run = job_table_find(server->jobs, job);
    if (!run) {
        char text[64];
        snprintf(text, sizeof text, "there is no job %" PRIu64, job);
        server_refuse(server, peer, request, job, FAULT_NOT_FOUND, text);
    }
    return run;
}

void serve_job_query(server_t *server, const peer_t *peer, uint64_t job)
{
    const run_t *run = find_job(server, peer, MESSAGE_JOB_QUERY, job);
    if (!run)
        return;
    message_t answer = {.type = MESSAGE_JOB_DATA};
    answer.job_data =
        (message_job_data_t){.job = job, .bundle_digest = *run_bundle_digest(run), .text = run_text(run)};
    server_send(server, peer, &answer);
}

/* ---- submission ---- */

static void submit(server_t *server, const peer_t *peer, const message_submit_t *request)
{
    fault_t fault = {0};
    job_t *job = malloc(sizeof *job);
    if (!job) {
        server_refuse(server, peer, MESSAGE_SUBMIT, 0, FAULT_MEMORY, "the master is out of memory");
        return;
    }
    const fault_code_t parsed = job_parse(job, request->text, strlen(request->text), "job", &fault);
    free(job);
    if (parsed != FAULT_NONE) {
        refuse_fault(server, peer, MESSAGE_SUBMIT, 0, &fault);
        return;
    }
    if (!store_has_bundle(server->store, &request->bundle_digest)) {
        message_t wanted = {.type = MESSAGE_BUNDLE_WANTED};
        wanted.bundle_wanted.digest = request->bundle_digest;
        const uint64_t part = store_bundle_part(server->store, &request->bundle_digest);
        wanted.bundle_wanted.offset = part < request->bundle_size ? part : 0;
        server_send(server, peer, &wanted);
        return;
    }
    run_t *run;
    if (job_table_add(server->jobs, request->text, &request->bundle_digest, &run, &fault) != FAULT_NONE) {
        refuse_fault(server, peer, MESSAGE_SUBMIT, 0, &fault);
        return;
    }
    log_info("job %" PRIu64 ": submitted from %s", run_id(run), peer->host);
    message_t answer = {.type = MESSAGE_SUBMITTED};
    answer.job.job = run_id(run);
    server_send(server, peer, &answer);
}

static void take_bundle_piece(server_t *server, const peer_t *peer, const message_chunk_t *piece)
{
    fault_t fault = {0};
    message_t answer = {.type = MESSAGE_BUNDLE_PUT_OK};
    answer.bundle_wanted.digest = piece->digest;
    if (store_put_bundle(server->store, &piece->digest, piece->total, piece->offset, piece->bytes.data,
                         piece->bytes.size, &answer.bundle_wanted.offset, &fault) != FAULT_NONE)
        refuse_fault(server, peer, MESSAGE_BUNDLE_PUT, 0, &fault);
    else
        server_send(server, peer, &answer);
}

/* ---- status ---- */

static json_t *worker_status(const server_t *server, const peer_t *peer, double now)
{
    json_t *json = json_new_object();
    json_add_string(json, "host", peer->host);
    json_add_number(json, "pid", peer->pid);
    json_add_number(json, "threads", peer->threads);
    const bool silent = now - peer->heard > 2 * server->heartbeat + 1;
    json_add_string(json, "state",
                    silent                     ? "silent"
                    : now < peer->paused_until ? "paused"
                    : peer->slots              ? "idle"
                                               : "busy");
    json_add_number(json, "slots", peer->slots);
    json_add_number(json, "units_done", (double)peer->units_done);
    json_add_number(json, "units_failed", (double)peer->units_failed);
    json_add_number(json, "connected_seconds", now - peer->since);
    json_add_number(json, "last_heard_seconds", now - peer->heard);
    return json;
}

static json_t *status_of(const server_t *server, const run_t *only, double now)
{
    json_t *json = json_new_object(), *master = json_new_object(), *jobs = json_new_array(),
           *workers = json_new_array();
    json_add_string(master, "version", GARLAND_VERSION);
    json_add_string(master, "instruction_set", GARLAND_ARCH);
    json_add_number(master, "up_seconds", now - server->began);
    json_add(json, "master", master);
    const size_t count = job_table_count(server->jobs);
    for (size_t i = count > STATUS_JOBS ? count - STATUS_JOBS : 0; i < count; i++)
        if (!only || job_table_at(server->jobs, i) == only)
            json_append(jobs, run_status(job_table_at(server->jobs, i)));
    for (size_t i = 0; i < peers_count(server->peers); i++)
        if (peers_at(server->peers, i)->role == MESSAGE_ROLE_WORKER)
            json_append(workers, worker_status(server, peers_at(server->peers, i), now));
    json_add(json, "jobs", jobs);
    json_add(json, "workers", workers);
    return json;
}

static void send_status(server_t *server, const peer_t *peer, uint64_t job, double now)
{
    const run_t *only = NULL;
    if (job != 0 && !(only = find_job(server, peer, MESSAGE_STATUS, job)))
        return;
    json_t *json = status_of(server, only, now);
    char *text = json_print(json, false);
    json_destroy(&json);
    message_t answer = {.type = MESSAGE_STATUS_DATA};
    answer.report = (message_report_t){.job = job, .text = text};
    if (server_send(server, peer, &answer) != FAULT_NONE)
        server_refuse(server, peer, MESSAGE_STATUS, job, FAULT_LIMIT, "the status is too long for a message");
    free(text);
}

/* ---- outputs ---- */

static void send_output(server_t *server, const peer_t *peer, const message_fetch_t *fetch)
{
    const run_t *run = find_job(server, peer, MESSAGE_FETCH, fetch->job);
    if (!run)
        return;
    char text[STORE_PATH_SIZE];
    fault_t fault = {0};
    if (run_get_state(run) != RUN_DONE) {
        snprintf(text, sizeof text, "job %" PRIu64 " is %s: it has no outputs%s%s", fetch->job,
                 run_state_name(run_get_state(run)),
                 run_failure(run)[0]  ? "; "
                 : run_has_ended(run) ? ""
                                      : " yet",
                 run_failure(run));
        server_refuse(server, peer, MESSAGE_FETCH, fetch->job, FAULT_NOT_FOUND, text);
        return;
    }
    if (!output_wanted(run_job(run), fetch->output)) {
        snprintf(text, sizeof text, "job %" PRIu64 " does not ask for %s", fetch->job, output_file(fetch->output));
        server_refuse(server, peer, MESSAGE_FETCH, fetch->job, FAULT_NOT_FOUND, text);
        return;
    }
    message_t answer = {.type = MESSAGE_FETCH_DATA};
    message_fetch_data_t *data = &answer.fetch_data;
    *data = (message_fetch_data_t){.job = fetch->job, .output = fetch->output, .offset = fetch->offset};
    size_t got = 0;
    fault_code_t code = store_job_path(server->store, fetch->job, output_file(fetch->output), text, &fault);
    if (code == FAULT_NONE)
        code = store_read_piece(text, fetch->offset, server->chunk, fetch->length, &got, &data->total,
                                &data->revision, &fault);
    data->bytes = (message_bytes_t){server->chunk, got};
    if (code != FAULT_NONE)
        refuse_fault(server, peer, MESSAGE_FETCH, fetch->job, &fault);
    else
        server_send(server, peer, &answer);
}

/* ---- cancel and subscribe ---- */

static void send_done(server_t *server, const peer_t *peer, message_type_t request, uint64_t job)
{
    message_t answer = {.type = MESSAGE_DONE};
    answer.done = (message_done_t){.request = (uint16_t)request, .job = job};
    server_send(server, peer, &answer);
}

static void cancel(server_t *server, const peer_t *peer, uint64_t job)
{
    run_t *run = find_job(server, peer, MESSAGE_CANCEL_JOB, job);
    if (!run)
        return;
    if (run_has_ended(run)) {
        char text[96];
        snprintf(text, sizeof text, "job %" PRIu64 " has ended: it is %s", job, run_state_name(run_get_state(run)));
        server_refuse(server, peer, MESSAGE_CANCEL_JOB, job, FAULT_USAGE, text);
        return;
    }
    run_cancel(run);
    send_done(server, peer, MESSAGE_CANCEL_JOB, job);
}

static void subscribe(server_t *server, peer_t *peer, uint64_t job)
{
    if (!find_job(server, peer, MESSAGE_SUBSCRIBE, job))
        return;
    bool known = false;
    for (uint32_t i = 0; i < peer->subscription_count; i++)
        known |= peer->subscriptions[i] == job;
    if (!known && peer->subscription_count == PEERS_SUBSCRIPTIONS) {
        server_refuse(server, peer, MESSAGE_SUBSCRIBE, job, FAULT_LIMIT,
                      "too many subscriptions on one connection");
        return;
    }
    if (!known)
        peer->subscriptions[peer->subscription_count++] = job;
    send_done(server, peer, MESSAGE_SUBSCRIBE, job);
}

static bool send_end(server_t *server, const peer_t *peer, const run_t *run)
{
    message_t end = {.type = MESSAGE_JOB_END};
    const run_state_t state = run_get_state(run);
    end.job_end.job = run_id(run);
    end.job_end.state = state == RUN_DONE     ? MESSAGE_END_FINISHED
                        : state == RUN_FAILED ? MESSAGE_END_FAILED
                                              : MESSAGE_END_CANCELLED;
    end.job_end.text = run_failure(run);
    return server_send(server, peer, &end) != FAULT_LIMIT;
}

static void send_progress(server_t *server, const peer_t *peer, const run_t *run)
{
    json_t *json = run_status(run);
    json_add_number(json, "workers", (double)peers_workers(server->peers));
    char *text = json_print(json, false);
    json_destroy(&json);
    message_t progress = {.type = MESSAGE_PROGRESS};
    progress.report = (message_report_t){.job = run_id(run), .text = text};
    server_send(server, peer, &progress);
    free(text);
}

void serve_subscribers(server_t *server, bool progress)
{
    for (size_t i = 0; i < peers_count(server->peers); i++) {
        peer_t *peer = peers_at(server->peers, i);
        uint32_t kept = 0;
        for (uint32_t j = 0; j < peer->subscription_count; j++) {
            const uint64_t job = peer->subscriptions[j];
            const run_t *run = job_table_find(server->jobs, job);
            if (!run)
                continue;
            if (progress)
                send_progress(server, peer, run);
            if (!run_has_ended(run) || !send_end(server, peer, run))
                peer->subscriptions[kept++] = job;
        }
        peer->subscription_count = kept;
    }
}

void serve_client(server_t *server, peer_t *peer, const message_t *message, double now)
{
    switch (message->type) {
    case MESSAGE_HEARTBEAT:
        break;
    case MESSAGE_SUBMIT:
        submit(server, peer, &message->submit);
        break;
    case MESSAGE_BUNDLE_PUT:
        take_bundle_piece(server, peer, &message->chunk);
        break;
    case MESSAGE_STATUS:
        send_status(server, peer, message->job.job, now);
        break;
    case MESSAGE_FETCH:
        send_output(server, peer, &message->fetch);
        break;
    case MESSAGE_CANCEL_JOB:
        cancel(server, peer, message->job.job);
        break;
    case MESSAGE_SUBSCRIBE:
        subscribe(server, peer, message->job.job);
        break;
    case MESSAGE_JOB_QUERY:
        serve_job_query(server, peer, message->job.job);
        break;
    default:
        server_refuse(server, peer, message->type, 0, FAULT_PROTOCOL, "a client does not send this");
    }
}
