/* trial.c: chains that are run for what their films differ by: how good a length's mutations are, before the
 * render.
 *
 * With F_p what one chain (or one run of chains that exchange) adds to the luminance of pixel p, times the
 * importance there, the spread is the estimate over the U chains of
 *
 *     sum_p w_p^2 Var F_p = 1 / (U - 1) sum_p w_p^2 (sum_u F_up^2 - 1 / U (sum_u F_up)^2).
 *
 * Over the chain's mutations that is 1 for independent draws whose splats are 1, as target_t makes them, if w is 1.
 * The importance makes errors relative to what is seen in the neighbourhood. Where the length's own light stands
 * out of it, as a highlight does, its error is relative to itself: w = 1 / (1 + r), r = scale x (mean film of the
 * chains) how much brighter it is there. A chain's own film is no witness for that: the mean is over the others, of
 * those that were there: (sum_u F_up - sum_u F_up^2 / sum_u F_up) / (U - 1).
 */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "chain/unit.h"

typedef struct trial {
    work_space_t *space;
    importance_t importance;
    uint32_t chains;
} trial_t;

/* Takes in the film of a chain and clears it. */
static void trial_done(void *context)
{
    trial_t *trial = context;
    film_t *film = &trial->space->film;
    for (uint32_t y = 0; y < film->height; y++)
        for (uint32_t x = 0; x < film->width; x++) {
            const size_t p = (size_t)y * film->width + x;
            const int64_t *at = film->sums + p * FILM_CHANNELS;
            if ((at[0] | at[1] | at[2]) == 0)
                continue;
            const double g =
                trial->importance.blocks ? importance_at(&trial->importance, (vec2_t){x + 0.5, y + 0.5}) : 1;
            const double f = g * rgb_luminance(film_value(film, x, y));
            trial->space->tally[2 * p] += f;
            trial->space->tally[2 * p + 1] += f * f;
        }
    trial->chains++;
    film_reset(film);
}

/* w^2 Var F of a pixel from its sum and squares. */
static double trial_pixel(const trial_t *trial, double scale, double sum, double squares)
{
    if (!(sum > 0))
        return 0;
    const double others = trial->chains - 1.0, r = scale * (sum - squares / sum) / others,
                 w = 1 / (1 + (r > 0 ? r : 0));
    return w * w * (squares - sum * sum / trial->chains) / others;
}

fault_code_t unit_trial(work_space_t *space, const work_record_t *record, const atomic_bool *cancel,
                        work_result_t *result, fault_t *fault)
{
    const settings_t *settings = &space->renderer->settings;
    const size_t pixels = (size_t)settings->width * settings->height;
    if (!space->tally)
        space->tally = malloc(sizeof *space->tally * 2 * pixels);
    if (!space->tally)
        return fault_set(fault, FAULT_MEMORY, "no memory for a trial of %u x %u pixels", settings->width,
                         settings->height);
    memset(space->tally, 0, sizeof *space->tally * 2 * pixels);
    trial_t trial = {.space = space, .importance = unit_importance(space, record)};
    TRY(unit_run_chains(space, record, cancel, trial_done, &trial, result, fault));
    double spread = 0;
    for (size_t p = 0; p < pixels; p++)
        spread += trial_pixel(&trial, record->scale, space->tally[2 * p], space->tally[2 * p + 1]);
    result->spread = spread > 0 && isfinite(spread) ? spread : 0;
    return FAULT_NONE;
}
