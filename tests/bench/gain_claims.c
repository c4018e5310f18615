#include "gain_claims.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "client/bench/seeds.h"

/* What is compared: of variant a, over the same of variant b where there is one. */
typedef enum claim_kind {
    CLAIM_TIME = 0,  /* mean relMSE x CPU time */
    CLAIM_MUTATIONS, /* mean relMSE x mutations */
    CLAIM_SPREAD,    /* standard deviation of relMSE x CPU time over the runs */
    CLAIM_DEVIATION, /* mean standard deviation of a pixel over the runs */
    CLAIM_COST,      /* CPU time a mutation */
    CLAIM_ACCEPTANCE /* mean acceptance of a move */
} claim_kind_t;

static const char *const kind_names[] = {"mean relMSE x time", "mean relMSE x mutations", "spread of relMSE x time",
                                         "pixels' deviation",  "CPU time a mutation",     "acceptance"};

typedef struct claim {
    const char *source, *text;
    claim_kind_t kind;
    const char *a, *b;           /* b null: the quantity itself */
    const char *move_a, *move_b; /* acceptance */
    double limit;
    bool above; /* the claim is that the quantity is above the limit; else below */
} claim_t;

static const char rjmlt_paper[] = "Reversible Jump MLT 2017";
static const char cmlt_paper[] = "Charted MLT 2017";
static const char pf_paper[] = "Rectifying Proposal Failures 2019";

static const claim_t claims[] = {
    {rjmlt_paper, "in all test scenes RJMLT has a lower average MSE than MMLT at equal time (7.2, figure 5)",
     CLAIM_TIME, "rjmlt", "mmlt", NULL, NULL, 1, false},
    {rjmlt_paper, "RJMLT's MSE varies less between runs than MMLT's (7.2, figure 5)", CLAIM_SPREAD, "rjmlt", "mmlt",
     NULL, NULL, 1, false},
    {rjmlt_paper, "in all scenes RJMLT's noise is more stable from seed to seed (7.2, temporal stability)",
     CLAIM_DEVIATION, "rjmlt", "mmlt", NULL, NULL, 1, false},
    {rjmlt_paper,
     "MMLT's changes of technique are accepted significantly more rarely than its other small steps "
     "(figure 4; here: less than half as often)",
     CLAIM_ACCEPTANCE, "mmlt", "mmlt", "technique", "small", 0.5, false},
    {rjmlt_paper, "jumps between techniques are accepted close to always (figure 4; here: above 0.95)",
     CLAIM_ACCEPTANCE, "rjmlt", NULL, "jump", NULL, 0.95, true},
    {cmlt_paper,
     "CMLT produces considerably less noise than MMLT on all scenes at equal time (figure 6); swaps by "
     "serial tempering",
     CLAIM_TIME, "cmlt", "mmlt", NULL, NULL, 1, false},
    {cmlt_paper, "the same; swaps by replica exchange", CLAIM_TIME, "cmlt-rex", "mmlt", NULL, NULL, 1, false},
    {cmlt_paper, "MMLT needs more than twice as many samples for the same RMSE (figure 7, one scene)",
     CLAIM_MUTATIONS, "cmlt", "mmlt", NULL, NULL, 0.5, false},
    {cmlt_paper, "chart swaps cost next to nothing (7.2; here: a mutation at most 5 % more than MMLT's)",
     CLAIM_COST, "cmlt", "mmlt", NULL, NULL, 1.05, false},
    {cmlt_paper,
     "charts coupled by replica exchange beat weighted chains without swaps at equal numbers of samples "
     "(table 1, one test)",
     CLAIM_MUTATIONS, "cmlt-rex", "pssmlt-mix", NULL, NULL, 1, false},
    {cmlt_paper, "inverse primary space perturbations are worse than weighted chains (table 1, one test)",
     CLAIM_MUTATIONS, "cmlt-ipsm", "pssmlt-mix", NULL, NULL, 1, true},
    {pf_paper, "leaving out failed proposals always gives a lower RMSE than MMLT in equal time (table 3)",
     CLAIM_TIME, "mmlt+published", "mmlt", NULL, NULL, 1, false},
    {pf_paper,
     "a third of the computation is saved (figure 1): relMSE x time falls below 0.72, as 28 % is the least "
     "that is named",
     CLAIM_TIME, "mmlt+published", "mmlt", NULL, NULL, 0.72, false},
    {pf_paper, "RJMLT with the remedy is better than RJMLT (figure 6)", CLAIM_TIME, "rjmlt+published", "rjmlt",
     NULL, NULL, 1, false},
    {pf_paper, "MMLT with the remedy is better than RJMLT without (figure 6)", CLAIM_TIME, "mmlt+published",
     "rjmlt", NULL, NULL, 1, false},
    {pf_paper, "RJMLT with the remedy is the best of the four (figure 6): better than MMLT with it", CLAIM_TIME,
     "rjmlt+published", "mmlt+published", NULL, NULL, 1, false},
};

gain_verdict_t gain_verdict_of(double low, double high, double limit, bool above)
{
    if (isnan(low) || isnan(high)) /* one run: no interval */
        return GAIN_UNDECIDED;
    if (low > limit)
        return above ? GAIN_HOLDS : GAIN_CONTRARY;
    if (high < limit)
        return above ? GAIN_CONTRARY : GAIN_HOLDS;
    return GAIN_UNDECIDED;
}

/* ---- measuring a claim on a scene ---- */

static gain_figure_t log_of_runs(const gain_scene_t *scene, const gain_entry_t *entry, gain_quantity_t quantity,
                                 bool spread)
{
    double *values = seeds_allocate(entry->run_count, sizeof *values);
    gain_entry_values(entry, scene->point_count - 1, quantity, values);
    const gain_figure_t figure =
        spread ? seeds_log_deviation(values, entry->run_count) : seeds_log_mean(values, entry->run_count);
    free(values);
    return figure;
}

/* Acceptance has no error to speak of: it is a mean over very many proposals. */
static gain_figure_t log_of_move(const gain_entry_t *entry, const char *name)
{
    const gain_length_t total = gain_entry_total(entry);
    const gain_move_t *move = gain_length_move(&total, name);
    return (gain_figure_t){move && move->acceptance > 0 ? log(move->acceptance) : NAN, 0};
}

/* The quantity's logarithm; `trimmed`: of errors without the worst pixels. */
static gain_figure_t claim_figure(const claim_t *claim, const gain_scene_t *scene, const gain_entry_t *entry,
                                  const char *move, bool trimmed)
{
    switch (claim->kind) {
    case CLAIM_TIME:
        return log_of_runs(scene, entry, trimmed ? GAIN_TRIMMED_CPU : GAIN_RELMSE_CPU, false);
    case CLAIM_MUTATIONS:
        return log_of_runs(scene, entry, trimmed ? GAIN_TRIMMED_MUTATIONS : GAIN_RELMSE_MUTATIONS, false);
    case CLAIM_SPREAD:
        return log_of_runs(scene, entry, trimmed ? GAIN_TRIMMED_CPU : GAIN_RELMSE_CPU, true);
    case CLAIM_DEVIATION:
        return (gain_figure_t){log(entry->deviation.value), entry->deviation.error / entry->deviation.value};
    case CLAIM_COST:
        return log_of_runs(scene, entry, GAIN_COST, false);
    default:
        return log_of_move(entry, move);
    }
}

static seeds_ratio_t claim_ratio(const claim_t *claim, const gain_scene_t *scene, bool trimmed)
{
    const gain_entry_t *a = gain_scene_find(scene, claim->a),
                       *b = claim->b ? gain_scene_find(scene, claim->b) : NULL;
    if (!a || (claim->b && !b))
        return (seeds_ratio_t){NAN, NAN, NAN};
    const gain_figure_t one = {0, 0};
    return seeds_log_ratio(claim_figure(claim, scene, a, claim->move_a, trimmed),
                           b ? claim_figure(claim, scene, b, claim->move_b, trimmed) : one);
}

/* ---- printing ---- */

static gain_verdict_t print_cell(FILE *out, const claim_t *claim, const gain_scene_t *scene, bool trimmed)
{
    static const char marks[] = " +-?";
    const seeds_ratio_t ratio = claim_ratio(claim, scene, trimmed);
    if (!isfinite(ratio.value)) {
        fprintf(out, " %13s", "-  ");
        return GAIN_UNKNOWN;
    }
    const gain_verdict_t verdict = gain_verdict_of(ratio.low, ratio.high, claim->limit, claim->above);
    fprintf(out, " %11.3f %c", ratio.value, marks[verdict]);
    return verdict;
}

static void print_where(FILE *out, const gain_scene_t *scenes, size_t count, const gain_verdict_t *verdicts,
                        gain_verdict_t which, const char *words)
{
    size_t found = 0;
    for (size_t s = 0; s < count; s++)
        if (verdicts[s] == which)
            fprintf(out, "%s%s", found++ ? ", " : words, scenes[s].name);
}

static void print_verdict(FILE *out, const gain_scene_t *scenes, size_t count, const gain_verdict_t *verdicts)
{
    size_t measured = 0, holds = 0, contrary = 0;
    for (size_t s = 0; s < count; s++) {
        measured += verdicts[s] != GAIN_UNKNOWN;
        holds += verdicts[s] == GAIN_HOLDS;
        contrary += verdicts[s] == GAIN_CONTRARY;
    }
    fprintf(out, "    => ");
    if (measured == 0)
        fprintf(out, "not measured");
    else if (holds == measured)
        fprintf(out, "reproduced on all %zu scenes", measured);
    else if (holds > 0 && contrary == 0)
        fprintf(out, "reproduced on %zu of %zu scenes", holds, measured);
    else if (holds > 0)
        fprintf(out, "NOT REPRODUCED in general: holds on %zu of %zu scenes", holds, measured);
    else
        fprintf(out, "NOT REPRODUCED on any of %zu scenes", measured);
    if (contrary > 0)
        print_where(out, scenes, count, verdicts, GAIN_CONTRARY, "; the opposite on ");
    if (measured > 0)
        print_where(out, scenes, count, verdicts, GAIN_UNDECIDED, "; undecided on ");
    fprintf(out, "\n");
}

static void print_claim(FILE *out, const gain_scene_t *scenes, size_t count, size_t number)
{
    const claim_t *claim = &claims[number];
    const bool errors = claim->kind <= CLAIM_SPREAD;
    gain_verdict_t *verdicts = seeds_allocate(count, sizeof *verdicts);
    fprintf(out, "\n%2zu. %s: %s\n    %s of %s%s%s", number + 1, claim->source, claim->text,
            kind_names[claim->kind], claim->a, claim->move_a ? " " : "", claim->move_a ? claim->move_a : "");
    if (claim->b)
        fprintf(out, " over that of %s%s%s", claim->b, claim->move_b ? " " : "",
                claim->move_b ? claim->move_b : "");
    fprintf(out, ", expected %s %g\n    %-18s", claim->above ? "above" : "below", claim->limit,
            errors ? "all pixels" : "");
    for (size_t s = 0; s < count; s++)
        verdicts[s] = print_cell(out, claim, &scenes[s], false);
    if (errors) {
        fprintf(out, "\n    %-18s", "trimmed");
        for (size_t s = 0; s < count; s++)
            print_cell(out, claim, &scenes[s], true);
    }
    fputc('\n', out);
    print_verdict(out, scenes, count, verdicts);
    free(verdicts);
}

void gain_print_claims(FILE *out, const gain_scene_t *scenes, size_t count)
{
    fprintf(out, "+ holds, - the opposite, ? undecided: the limit is within %.1f standard errors\n%-22s",
            SEEDS_WIDTH, "");
    for (size_t s = 0; s < count; s++)
        fprintf(out, " %13s", scenes[s].name);
    fputc('\n', out);
    for (size_t i = 0; i < sizeof claims / sizeof *claims; i++)
        print_claim(out, scenes, count, i);
}
