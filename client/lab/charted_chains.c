#include "client/lab/charted_chains.h"

#include <math.h>
#include <string.h>

const char *const charted_names[CHARTED_ALGORITHMS] = {"PSSMLT-1",   "PSSMLT-2",  "PSSMLT-AVG",
                                                       "PSSMLT-MIX", "CMLT-IPSM", "CMLT"};

/* ---- draws from the exact law ---- */

/* f* / p_2 is the radiance or nothing, so bounded: rejection. */
static charted_path_t draw_path(stream_t *stream)
{
    const double bound = charted_radiance_bound();
    for (;;) {
        double u[CHARTED_NUMBERS];
        for (int d = 0; d < CHARTED_NUMBERS; d++)
            u[d] = stream_uniform(stream);
        const charted_path_t path = charted_sample(CHARTED_DIRECTION, u);
        if (path.target > 0 && stream_uniform(stream) * bound * path.density[CHARTED_DIRECTION] < path.target)
            return path;
    }
}

charted_path_t charted_draw(int chart, stream_t *stream)
{
    charted_path_t path = draw_path(stream);
    while (chart >= 0 && stream_uniform(stream) >= charted_weight(&path, chart))
        path = draw_path(stream);
    return path;
}

/* ---- steps ---- */

static double wrap(double u)
{
    return math_min(u - floor(u), MATH_ONE_MINUS);
}

/* Kelemen et al. 2002, section 3.3 (figure 6): s2 exp(-log(s2/s1) r) either way. */
static double small_step(double u, stream_t *stream)
{
    const double farthest = 1.0 / 64, ratio = log(16.0); /* 1/64 over 1/1024 */
    const double r = 2 * stream_uniform(stream);
    return wrap(r < 1 ? u + farthest * exp(-ratio * r) : u - farthest * exp(-ratio * (r - 1)));
}

static void propose(const double u[CHARTED_NUMBERS], double v[CHARTED_NUMBERS], double large, stream_t *stream)
{
    const bool fresh = stream_uniform(stream) < large;
    for (int d = 0; d < CHARTED_NUMBERS; d++)
        v[d] = fresh ? stream_uniform(stream) : small_step(u[d], stream);
}

typedef struct run {
    charted_algorithm_t algorithm;
    const charted_setup_t *setup;
    charted_result_t *result;
    stream_t *stream;
    double scale[CHARTED_CHARTS]; /* of a sample of the chain: b of its law over its number of samples, per pixel */
} run_t;

static bool is_weighted(charted_algorithm_t algorithm)
{
    return algorithm == CHARTED_MIX || algorithm == CHARTED_CMLT;
}

/* The law of a chain on its numbers, up to a factor. */
static double law(const run_t *run, const charted_path_t *path, int chart)
{
    if (is_weighted(run->algorithm))
        return path->target / (path->density[0] + path->density[1]);
    if (run->setup->mistake == CHARTED_WITHOUT_DENSITY)
        return path->target;
    return path->target / path->density[chart];
}

static void record(const run_t *run, const charted_path_t *path, int chart, double weight)
{
    const double share = run->algorithm == CHARTED_AVERAGE ? charted_weight(path, chart) : 1;
    const double value = weight * share * run->scale[chart];
    const rgb_t colour = charted_colour(path->light, path->across);
    run->result->samples[chart] += weight;
    run->result->weights[chart] += weight * charted_weight(path, CHARTED_LIGHT);
    double *pixel = run->result->picture.rgb[charted_pixel(path->x, path->y)];
    pixel[0] += value * colour.r;
    pixel[1] += value * colour.g;
    pixel[2] += value * colour.b;
}

static void step(const run_t *run, charted_chain_t *chain, int chart)
{
    double v[CHARTED_NUMBERS];
    propose(chain->u, v, run->setup->large, run->stream);
    const charted_path_t proposal = charted_sample(chart, v);
    double a = 0;
    if (proposal.target > 0) {
        a = math_min(law(run, &proposal, chart) / law(run, &chain->path, chart), 1);
        record(run, &proposal, chart, a);
    }
    record(run, &chain->path, chart, 1 - a);
    run->result->accepted += a;
    run->result->steps++;
    if (stream_uniform(run->stream) >= a)
        return;
    memcpy(chain->u, v, sizeof v);
    chain->path = proposal;
}

bool charted_swap(charted_chain_t chains[CHARTED_CHARTS], charted_mistake_t mistake, stream_t *stream)
{
    const charted_path_t x = chains[0].path, y = chains[1].path;
    const double a =
        mistake == CHARTED_SWAP_ALWAYS ? 1 : y.density[0] / x.density[0] * (x.density[1] / y.density[1]);
    if (stream_uniform(stream) >= a)
        return false;
    chains[0].path = y;
    chains[1].path = x;
    for (int i = 0; i < CHARTED_CHARTS; i++)
        charted_invert(i, &chains[i].path, chains[i].u);
    return true;
}

/* ---- algorithms ---- */

static charted_chain_t start(int chart, bool weighted, stream_t *stream)
{
    charted_chain_t chain = {.path = charted_draw(weighted ? chart : -1, stream)};
    charted_invert(chart, &chain.path, chain.u);
    return chain;
}

static void run_one(run_t *run, int chart, uint64_t samples)
{
    run->scale[chart] = run->setup->constants.all * CHARTED_PIXELS / (double)samples;
    charted_chain_t chain = start(chart, false, run->stream);
    for (uint64_t i = 0; i < samples; i++)
        step(run, &chain, chart);
}

/* The state is the path; a chart's numbers are found when its turn comes. */
static void run_paths(run_t *run, uint64_t samples)
{
    for (int chart = 0; chart < CHARTED_CHARTS; chart++)
        run->scale[chart] = run->setup->constants.all * CHARTED_PIXELS / (double)samples;
    charted_chain_t chain = start(0, false, run->stream);
    for (uint64_t i = 0; i < samples; i++) {
        const int chart = (int)(i % CHARTED_CHARTS);
        charted_invert(chart, &chain.path, chain.u);
        step(run, &chain, chart);
    }
}

static void run_two(run_t *run, uint64_t samples)
{
    const bool weighted = is_weighted(run->algorithm);
    const uint64_t each = samples / CHARTED_CHARTS;
    charted_chain_t chains[CHARTED_CHARTS];
    for (int i = 0; i < CHARTED_CHARTS; i++) {
        const charted_constants_t *b = &run->setup->constants;
        run->scale[i] = (weighted ? b->of_chart[i] : b->all) * CHARTED_PIXELS / (double)each;
        chains[i] = start(i, weighted, run->stream);
    }
    for (uint64_t n = 1; n <= each; n++) {
        for (int i = 0; i < CHARTED_CHARTS; i++)
            step(run, &chains[i], i);
        if (run->algorithm == CHARTED_CMLT && n % CHARTED_SWAP_EVERY == 0) {
            run->result->swaps++;
            run->result->swaps_accepted += charted_swap(chains, run->setup->mistake, run->stream);
        }
    }
}

void charted_run(charted_result_t *result, charted_algorithm_t algorithm, const charted_setup_t *setup,
                 uint64_t samples, stream_t *stream)
{
    memset(result, 0, sizeof *result);
    run_t run = {.algorithm = algorithm, .setup = setup, .result = result, .stream = stream};
    switch (algorithm) {
    case CHARTED_PSSMLT_1:
        run_one(&run, CHARTED_LIGHT, samples);
        break;
    case CHARTED_PSSMLT_2:
        run_one(&run, CHARTED_DIRECTION, samples);
        break;
    case CHARTED_IPSM:
        run_paths(&run, samples);
        break;
    default:
        run_two(&run, samples);
    }
}
