/* plan_passes.h: passes of samples over the image, each made by several units of work where the image is large.
 *
 * A pass is one sample in every pixel: whole, it is an estimate of the image, stratified, like every other but for
 * which points it has (plan_nets.h), and what variances between units, groups and eras are of. A pass of a large
 * image takes seconds, and a unit of work should not: it is a part of a pass. Parts are collected here, in any
 * order, in exact sums, and a pass is added to the image when it is whole, so that all pixels have the same number
 * of samples, and the image and its error have the same bits as if the pass were one unit. Not added part by part:
 * a pixel that is a sample ahead of others would be too bright by that, as the image is over the number of all
 * samples, and a number by pixel would not do for what splats bring from elsewhere.
 *
 * The first pass is different: a rule of seconds may end a render before it is whole. Where there is such a rule
 * its parts are not rows but lattices, every P-th pixel, evenly spread, in an order that begins at random (the
 * seed): after m parts of P a pixel has been sampled with probability m / P, whichever it is, so that the sums over
 * m / P are an unbiased image, at every pixel, if a dotted one. Its parts cost alike, so which of them are in when
 * time is over says nothing about what they bring. plan_passes_settle adds them at the end of such a render.
 *
 * Units of samples in the order of handing out: the first pass' parts, of which the first PASSES_EARLY share the
 * pixels of one, so that there is an image early; then those of the second pass, rows from the top; and so on. A
 * small image has one unit a pass, or several passes a unit.
 *
 * One thread at a time, as all of a plan. */
#ifndef PLAN_PLAN_PASSES_H
#define PLAN_PLAN_PASSES_H

#include "base/wire.h"
#include "chain/work.h"
#include "plan/plan.h"

enum {
    PASSES_OPEN = 16, /* at most so many are begun and not whole: each has a film */
    PASSES_EARLY = 8
};

/* A pass that is not whole. */
typedef struct plan_pass {
    uint64_t number; /* from 0 */
    uint64_t count;  /* samples that are in */
    double cpu_seconds;
    film_t film;
} plan_pass_t;

/* All zero: none. */
typedef struct plan_passes {
    uint32_t parts;   /* of a pass: 1 for a small image */
    uint32_t lattice; /* parts of the first pass, P above; 0: it is like the others */
    uint32_t begin;   /* where the lattice of the first unit begins */
    uint32_t step;    /* from part to part, modulo the lattice */
    uint32_t count;   /* open passes */
    plan_pass_t open[PASSES_OPEN];
} plan_passes_t;

/* How a pass is cut: at the render's begin. */
void plan_passes_init(plan_t *plan);
void plan_passes_clear(plan_passes_t *passes);

/* Whether the next unit of samples has to wait, as too many passes are open. */
bool plan_passes_wait(const plan_t *plan);
/* Fills in which samples are the next unit's: first, skip, and of a pass that comes in parts the count. */
void plan_passes_place(const plan_t *plan, work_record_t *record);

/* The place among the open passes of one with this number; PASSES_OPEN if it is not among them. */
uint32_t plan_passes_find(const plan_t *plan, uint64_t number);
/* Takes in a unit that is a part. *whole: the pass if it is whole with it, which then is open no longer and whose
 * film is the caller's to clear; else null sums. */
fault_code_t plan_passes_take(plan_t *plan, const work_record_t *record, const work_result_t *result,
                              plan_pass_t *whole, fault_t *fault);
/* The parts of the first pass, together, if no pass is whole; null sums if there are none. As above. */
void plan_passes_settle(plan_t *plan, plan_pass_t *parts);
/* Whether there are such parts. */
bool plan_passes_begun(const plan_t *plan);
/* Samples that are in, of passes that are not whole. */
uint64_t plan_passes_waiting(const plan_t *plan);

/* As bytes: u32 open passes; each u64 number, count, f64 cpu_seconds, film. Hostile bytes back. */
void plan_passes_put(wire_writer_t *out, const plan_t *plan);
fault_code_t plan_passes_get(wire_reader_t *in, plan_t *plan, fault_t *fault);

#endif
