/* serve_worker.c: units to workers, results from them. */
#include <inttypes.h>
#include <math.h>
#include <stdlib.h>

#include "base/log.h"
#include "master/server_internal.h"

enum { PAUSE_FAILURES = 3 };
static const double pause_min = 1, pause_max = 30; /* seconds without work after a failure, doubling */

static void send_ack(server_t *server, const peer_t *peer, const message_lease_t *lease, message_ack_t outcome)
{
    message_t answer = {.type = MESSAGE_ACK};
    answer.ack.lease = *lease;
    answer.ack.outcome = (uint8_t)outcome;
    server_send(server, peer, &answer);
}

void serve_ack(void *context, uint64_t session, const message_lease_t *lease, message_ack_t outcome)
{
    server_t *server = context;
    const peer_t *peer = peers_find_session(server->peers, session);
    if (peer)
        send_ack(server, peer, lease, outcome);
}

/* A worker that fails again and again without a success between is given less and less to spoil. One or two
 * failures in a row may well be a job's own fault. */
static void note_failure(peer_t *peer, double now)
{
    peer->units_failed++;
    peer->failures_in_row++;
    if (peer->failures_in_row < PAUSE_FAILURES)
        return;
    const uint32_t doublings = peer->failures_in_row - PAUSE_FAILURES;
    peer->paused_until = now + fmin(pause_max, pause_min * (double)(1u << (doublings < 8 ? doublings : 8)));
}

static void take_result(server_t *server, peer_t *peer, const message_result_t *result, double now)
{
    run_t *run = job_table_find(server->jobs, result->lease.job);
    bool merged = false, later = false;
    message_ack_t outcome = MESSAGE_ACK_UNKNOWN;
    fault_t fault = {0};
    if (run && run_absorb(run, peer->session, &result->lease, result->bytes.data, result->bytes.size, now, &merged,
                          &later, &outcome, &fault) != FAULT_NONE) {
        log_warn("worker %s (%" PRIu32 "): result of unit %" PRIu64 " of job %" PRIu64 ": %s", peer->host,
                 peer->pid, result->lease.unit, result->lease.job, fault.text);
        note_failure(peer, now);
    }
    if (merged) {
        peer->units_done++;
        peer->failures_in_row = 0;
        peer->paused_until = 0;
    }
    if (!later)
        send_ack(server, peer, &result->lease, outcome);
}

static void take_failure(server_t *server, peer_t *peer, const message_failed_t *failed, double now)
{
    run_t *run = job_table_find(server->jobs, failed->lease.job);
    const bool running = run && run_get_state(run) == RUN_RUNNING;
    if (running) {
        if (failed->code != FAULT_CANCELLED)
            note_failure(peer, now);
        run_fail_attempt(run, &failed->lease, (fault_code_t)failed->code, failed->text);
    }
    send_ack(server, peer, &failed->lease, running ? MESSAGE_ACK_MERGED : MESSAGE_ACK_UNKNOWN);
}

static void send_bundle_piece(server_t *server, const peer_t *peer, const message_bundle_get_t *get)
{
    char path[STORE_PATH_SIZE];
    fault_t fault = {0};
    size_t got = 0;
    uint64_t total = 0, revision = 0;
    fault_code_t code = store_bundle_path(server->store, &get->digest, path, &fault);
    if (code == FAULT_NONE)
        code = store_read_piece(path, get->offset, server->chunk, get->length, &got, &total, &revision, &fault);
    if (code != FAULT_NONE) {
        server_refuse(server, peer, MESSAGE_BUNDLE_GET, 0, code, fault.text);
        return;
    }
    message_t answer = {.type = MESSAGE_BUNDLE_DATA};
    answer.chunk = (message_chunk_t){
        .digest = get->digest, .total = total, .offset = get->offset, .bytes = {server->chunk, got}};
    server_send(server, peer, &answer);
}

static void take_heartbeat(server_t *server, const peer_t *peer, const message_heartbeat_t *beat, double now)
{
    for (size_t i = 0; i < job_table_active_count(server->jobs); i++)
        run_renew(job_table_active(server->jobs, i), peer->session, &beat->leases, now,
                  now - 2 * server->heartbeat);
}

void serve_worker(server_t *server, peer_t *peer, const message_t *message, double now)
{
    switch (message->type) {
    case MESSAGE_HEARTBEAT:
        take_heartbeat(server, peer, &message->heartbeat, now);
        break;
    case MESSAGE_READY: /* so many more: those said before and not used hold */
        peer->slots += message->ready.slots;
        if (peer->slots > MESSAGE_MAX_SLOTS)
            peer->slots = MESSAGE_MAX_SLOTS;
        break;
    case MESSAGE_RESULT:
        take_result(server, peer, &message->result, now);
        break;
    case MESSAGE_FAILED:
        take_failure(server, peer, &message->failed, now);
        break;
    case MESSAGE_JOB_QUERY:
        serve_job_query(server, peer, message->job.job);
        break;
    case MESSAGE_BUNDLE_GET:
        send_bundle_piece(server, peer, &message->bundle_get);
        break;
    default:
        server_refuse(server, peer, message->type, 0, FAULT_PROTOCOL, "a worker does not send this");
    }
}

/* Sends one unit; false if there is none for this worker, or it cannot be sent now. */
static bool hand_out(server_t *server, peer_t *peer, double now)
{
    run_t *run;
    const work_record_t *record;
    message_t work = {.type = MESSAGE_WORK};
    if (!job_table_issue(server->jobs, peer->session, peers_workers(server->peers), now, &run, &work.work.lease,
                         &record))
        return false;
    fault_t fault = {0};
    uint8_t *bytes = NULL;
    size_t size = 0;
    if (work_record_encode(record, &bytes, &size, &fault) != FAULT_NONE) {
        run_fail_attempt(run, &work.work.lease, fault.code, fault.text);
        return false;
    }
    work.work.job_digest = *run_text_digest(run);
    work.work.bundle_digest = *run_bundle_digest(run);
    work.work.record = (message_bytes_t){bytes, size};
    const fault_code_t code = server_send(server, peer, &work);
    free(bytes);
    if (code != FAULT_NONE)
        run_return(run, &work.work.lease);
    else
        peer->slots--;
    return code == FAULT_NONE;
}

void serve_dispatch(server_t *server, double now)
{
    const size_t count = peers_count(server->peers);
    for (bool any = count > 0; any;) {
        any = false;
        for (size_t i = 0; i < count; i++) {
            peer_t *peer = peers_at(server->peers, (server->turn + i) % count);
            if (peer->role == MESSAGE_ROLE_WORKER && peer->slots > 0 && now >= peer->paused_until &&
                hand_out(server, peer, now))
                any = true;
        }
    }
    server->turn++;
}

void serve_cancel_work(server_t *server, uint64_t job)
{
    message_t cancel = {.type = MESSAGE_CANCEL};
    cancel.job.job = job;
    for (size_t i = 0; i < peers_count(server->peers); i++)
        if (peers_at(server->peers, i)->role == MESSAGE_ROLE_WORKER)
            server_send(server, peers_at(server->peers, i), &cancel);
}
