/* solo.h: a whole job on the calling thread, measured and ended by CPU time instead of wall time: what a comparison
 * at equal time needs on a machine that does other things too.
 *
 *     const double times[] = {1, 2, 4};
 *     TRY(solo_render(&scene, &job, times, 3, look, &state, fault));
 *
 * The job needs the rule "seconds" with the last of the times; solo_render_mutations takes mutations a pixel
 * instead, and the rule "mutations_per_pixel". Counted is what workers and master do: pilot, feature layers, units,
 * packing and merging them, stop rules; not the acceleration structure and not what `look` does. */
#ifndef CLIENT_BENCH_SOLO_H
#define CLIENT_BENCH_SOLO_H

#include "plan/plan.h"

/* Called for each of the times when the first unit that reaches it is in, with the CPU seconds until then; after
 * the last of them the plan is finished. The plan may be looked at, not changed. */
typedef fault_code_t solo_look_t(void *user, size_t index, double cpu_seconds, const plan_t *plan, fault_t *fault);

/* `times`: `count` CPU seconds, ascending. A render looked at has at least one unit behind the pilot; the last look
 * waits until each path length has one, so it may come late: that is why it is told the time. */
fault_code_t solo_render(const scene_t *scene, const job_t *job, const double *times, size_t count,
                         solo_look_t *look, void *user, fault_t *fault);
/* The same with mutations (or samples) a pixel in place of CPU seconds; looks are told CPU seconds all the same. */
fault_code_t solo_render_mutations(const scene_t *scene, const job_t *job, const double *mutations, size_t count,
                                   solo_look_t *look, void *user, fault_t *fault);

#endif
