/* ledger.h: who has which unit of a job, under which attempt, and until when.
 *
 * A unit is in the ledger from its first issue until its result is merged. While there it is leased (to one worker,
 * or to two near the end of a job) or lost (its last lease expired, failed, or went down with its worker); a lost
 * unit is issued again before any new one. The ledger decides nothing about results: a late result of an expired
 * lease is as good as any, and the plan merges each unit once.
 *
 *     ledger_issue -> { ledger_finish | ledger_fail | ledger_expire | ledger_drop_worker -> ledger_next_lost }
 *
 * An attempt id is never given twice, not even after a restart, provided first_attempt grows from run to run. A
 * worker's heartbeat renews the leases that it names, however long the unit takes.
 *
 * One thread at a time. Times are seconds on any clock that does not step back.
 */
#ifndef MASTER_LEDGER_H
#define MASTER_LEDGER_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "base/fault.h"

enum { LEDGER_COPIES = 2, LEDGER_MAX_FAILURES = 3 };

typedef struct ledger ledger_t;

/* lease: seconds from issue or renewal to expiry. Null when out of memory. */
ledger_t *ledger_new(uint64_t first_attempt, double lease);
void ledger_destroy(ledger_t **ledger);

/* Leases the unit to a worker. FAULT_RANGE if it is out in LEDGER_COPIES copies. */
fault_code_t ledger_issue(ledger_t *ledger, uint64_t unit, uint64_t worker, double now, uint64_t *attempt,
                          fault_t *fault);
/* Notes a unit that is handed out by the plan but with nobody: after a restart. */
fault_code_t ledger_add_lost(ledger_t *ledger, uint64_t unit, fault_t *fault);

/* The lost unit with the smallest id; false if there is none. A unit that has failed with `worker` is left to
 * others, if there are any of the `workers` that are connected that it has not failed with. */
bool ledger_next_lost(const ledger_t *ledger, uint64_t worker, size_t workers, uint64_t *unit);
/* The unit that has been out longest, in a single copy, not with `worker`, for at least min_age seconds. */
bool ledger_next_straggler(const ledger_t *ledger, uint64_t worker, double now, double min_age, uint64_t *unit);

/* The unit is merged: it leaves the ledger with all its leases. False if it was not there. */
bool ledger_finish(ledger_t *ledger, uint64_t unit);
/* An attempt ended with a fault: its lease ends. Returns how many attempts of the unit have failed so far, 0 if
 * there is no such attempt. */
uint32_t ledger_fail(ledger_t *ledger, uint64_t unit, uint64_t attempt);
/* The worker still has the attempt: its lease begins anew. False if there is no such attempt with this worker. */
bool ledger_renew(ledger_t *ledger, uint64_t unit, uint64_t attempt, uint64_t worker, double now);
/* Ends the worker's leases that were issued before `before` and not renewed at `now`: it has named all that it
 * holds, and they were not among them. Returns how many. */
size_t ledger_drop_unnamed(ledger_t *ledger, uint64_t worker, double now, double before);
/* Ends an attempt through no fault of the unit (it could not be sent). False if there is no such attempt. */
bool ledger_return(ledger_t *ledger, uint64_t unit, uint64_t attempt);
/* Ends every lease of the worker that went away; returns how many. */
size_t ledger_drop_worker(ledger_t *ledger, uint64_t worker);
/* Ends every lease that is past its time; returns how many. */
size_t ledger_expire(ledger_t *ledger, double now);

size_t ledger_leases(const ledger_t *ledger); /* leases that run */
size_t ledger_lost(const ledger_t *ledger);   /* units that are lost */
/* Mean seconds from issue to merge of the units so far; 0 before the first. */
double ledger_mean_age(const ledger_t *ledger);
/* Tells the ledger how old the unit's oldest lease is as it is merged; call before ledger_finish. */
void ledger_note_age(ledger_t *ledger, uint64_t unit, double now);

#endif
