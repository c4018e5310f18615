#include "client/lab/reversible_jump.h"

#include <math.h>
#include <stdbool.h>

const char *const jump_names[JUMP_VARIANTS] = {"full", "no Jacobian", "fixed point", "neither", "multiplexed"};

typedef struct state {
    int technique;
    technique_numbers_t u;
    double x, target; /* target: C */
} state_t;

static double target_of(double x)
{
    return techniques_target(x) / techniques_pdf_sum(x);
}

static state_t state_at(int technique, technique_numbers_t u)
{
    const double x = techniques_sample(technique, u);
    return (state_t){technique, u, x, target_of(x)};
}

/* A state of the exact law: x from f by rejection, the technique by its weight, its numbers by the right inverse.
 */
static state_t draw_state(stream_t *stream)
{
    double x;
    do
        x = stream_uniform(stream);
    while (stream_uniform(stream) * techniques_target(0) >= techniques_target(x));
    double rest = stream_uniform(stream) * techniques_pdf_sum(x);
    int technique = 0;
    while (technique < TECHNIQUES - 1 && rest >= techniques_pdf(technique, x))
        rest -= techniques_pdf(technique++, x);
    const double part = stream_uniform(stream), within = stream_uniform(stream);
    return state_at(technique, techniques_invert(technique, x, part, within));
}

static double wrap(double u)
{
    return math_min(u - floor(u), MATH_ONE_MINUS);
}

static void accept_by_target(state_t *state, state_t proposal, stream_t *stream)
{
    if (stream_uniform(stream) * state->target < proposal.target)
        *state = proposal;
}

static void small_step(state_t *state, double step, stream_t *stream)
{
    const technique_numbers_t v = {wrap(state->u.place + step * stream_normal(stream)),
                                   wrap(state->u.choice + step * stream_normal(stream))};
    accept_by_target(state, state_at(state->technique, v), stream);
}

static int other_technique(int technique, stream_t *stream)
{
    return (technique + 1 + (int)((TECHNIQUES - 1) * stream_uniform(stream))) % TECHNIQUES;
}

/* The point stays, and with it C; only the Jacobians are in the ratio. */
static void jump(state_t *state, bool jacobian, bool parametrised, stream_t *stream)
{
    const int technique = other_technique(state->technique, stream);
    const double part = stream_uniform(stream), within = parametrised ? stream_uniform(stream) : 0;
    const double from = techniques_pdf(state->technique, state->x), to = techniques_pdf(technique, state->x);
    if (jacobian && !(stream_uniform(stream) * from < to))
        return;
    state->technique = technique;
    state->u = techniques_invert(technique, state->x, part, within);
}

static void redraw_technique(state_t *state, stream_t *stream)
{
    accept_by_target(state, state_at(other_technique(state->technique, stream), state->u), stream);
}

void jump_run(jump_result_t *result, jump_variant_t variant, double step, uint64_t count, stream_t *stream)
{
    const bool jacobian = variant == JUMP_FULL || variant == JUMP_FIXED_POINT;
    const bool parametrised = variant == JUMP_FULL || variant == JUMP_NO_JACOBIAN;
    result->all = histogram_make(0, 1, JUMP_BINS);
    for (int t = 0; t < TECHNIQUES; t++)
        result->by[t] = histogram_make(0, 1, JUMP_BINS);
    state_t state = draw_state(stream);
    for (uint64_t i = 0; i < count; i++) {
        if (stream_uniform(stream) >= JUMP_PROBABILITY)
            small_step(&state, step, stream);
        else if (variant == JUMP_MULTIPLEXED)
            redraw_technique(&state, stream);
        else
            jump(&state, jacobian, parametrised, stream);
        histogram_add(&result->all, state.x, 1);
        histogram_add(&result->by[state.technique], state.x, 1);
    }
}

void jump_exact(double exact[JUMP_BINS])
{
    for (int k = 0; k < JUMP_BINS; k++)
        exact[k] =
            techniques_target_integral((k + 1.0) / JUMP_BINS) - techniques_target_integral((double)k / JUMP_BINS);
}
