/* gain_reference.h: references of bench_gain: long renders of the project's own in two independent halves, kept in
 * a folder outside the repository.
 *
 * A half is a mean of parts, each a render of some CPU seconds with a seed of its own in a file of its own,
 * FOLDER/SCENE-WxH-HALF-ALGORITHM-SECONDSs-INDEX.pfm. So a reference can be made bit by bit, interrupted at any
 * time, and made better later. Parts weigh by their CPU seconds; where two algorithms share a half, their means are
 * joined with weights fixed beforehand (gain_list.h), each getting half of the time. */
#ifndef TESTS_BENCH_GAIN_REFERENCE_H
#define TESTS_BENCH_GAIN_REFERENCE_H

#include "gain_list.h"

typedef struct gain_reference {
    image_t halves[2];
    double seconds[2]; /* CPU, of each half */
    char recipe[64];   /* "bdpt", or the weights of what was joined */
    double noise;      /* relMSE of the mean of the halves: from their difference */
    double difference; /* of the halves' brightness, over the mean's */
} gain_reference_t;

/* What there is in the folder; the caller clears. FAULT_NOT_FOUND says how references are made. */
fault_code_t gain_reference_read(gain_reference_t *reference, const peer_scene_t *entry, gain_size_t size,
                                 const char *folder, fault_t *fault);
void gain_reference_clear(gain_reference_t *reference);

/* Renders parts, `threads` at a time, until each half of each scene has `seconds` CPU seconds, counting what is
 * there. Scenes take turns, so that all are equally good when it is interrupted. */
fault_code_t gain_reference_make(peer_loaded_t *const *scenes, size_t count, uint32_t width, const char *folder,
                                 double seconds, double part, unsigned threads, fault_t *fault);

#endif
