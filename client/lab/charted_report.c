#include "client/lab/charted_report.h"

#include <inttypes.h>
#include <math.h>
#include <stdlib.h>

#define SHARE_POINTS (UINT64_C(1) << 18) /* a shift */

const int charted_report_runs[CHARTED_REPORT_COUNTS] = {24, 6};

const double charted_report_paper[CHARTED_REPORT_COUNTS][CHARTED_ALGORITHMS] = {
    {8.287e-2, 4.073e-2, 4.106e-2, 3.663e-2, 3.924e-2, 3.502e-2},
    {3.212e-2, 1.488e-2, 1.587e-2, 1.405e-2, 1.467e-2, 1.374e-2}};

const charted_claim_t charted_report_claims[CHARTED_REPORT_CLAIMS] = {
    {CHARTED_CMLT, CHARTED_MIX},         {CHARTED_CMLT, CHARTED_IPSM},     {CHARTED_MIX, CHARTED_IPSM},
    {CHARTED_MIX, CHARTED_AVERAGE},      {CHARTED_IPSM, CHARTED_PSSMLT_2}, {CHARTED_PSSMLT_2, CHARTED_AVERAGE},
    {CHARTED_PSSMLT_2, CHARTED_PSSMLT_1}};

/* ---- measuring ---- */

void charted_report_measure(charted_figures_t *figures, charted_algorithm_t algorithm, const charted_setup_t *setup,
                            const charted_picture_t *reference, uint64_t samples, int runs, uint64_t seed,
                            uint64_t first)
{
    charted_result_t *result = malloc(sizeof *result);
    if (!result)
        abort();
    double sum = 0, squares = 0, accepted = 0, steps = 0, swapped = 0, swaps = 0;
    for (int r = 0; r < runs; r++) {
        stream_t stream = stream_of(seed, first + (uint64_t)r);
        charted_run(result, algorithm, setup, samples, &stream);
        const double error = charted_error(&result->picture, reference);
        sum += error;
        squares += error * error;
        accepted += result->accepted;
        steps += (double)result->steps;
        swapped += result->swaps_accepted;
        swaps += (double)result->swaps;
        if (r == 0)
            figures->picture = result->picture;
    }
    free(result);
    figures->mean = sum / runs;
    figures->error = sqrt(math_max(squares / runs - figures->mean * figures->mean, 0) / (runs - 1));
    figures->accepted = accepted / steps;
    figures->swapped = swaps > 0 ? swapped / swaps : 0;
}

double charted_report_quotient(const charted_figures_t *a, const charted_figures_t *b, double *error)
{
    const double quotient = a->mean / b->mean;
    if (error)
        *error = quotient * hypot(a->error / a->mean, b->error / b->mean);
    return quotient;
}

void charted_report_run(charted_report_t *report, uint64_t steps, double large, uint64_t seed)
{
    report->samples[0] = steps / CHARTED_REPORT_RATIO;
    report->samples[1] = steps;
    report->seed = seed;
    const double b = charted_reference(&report->reference);
    report->setup = (charted_setup_t){.constants = charted_constants(b, SHARE_POINTS, seed), .large = large};
    uint64_t first = CHARTED_CHARTS * CHARTED_SHIFTS;
    for (int n = 0; n < CHARTED_REPORT_COUNTS; n++)
        for (int a = 0; a < CHARTED_ALGORITHMS; a++) {
            const int runs = charted_report_runs[n];
            charted_report_measure(&report->figures[n][a], (charted_algorithm_t)a, &report->setup,
                                   &report->reference, report->samples[n], runs, seed, first);
            first += (uint64_t)runs;
        }
}

/* ---- text ---- */

static double mean_of(const charted_picture_t *picture)
{
    double sum = 0;
    for (int p = 0; p < CHARTED_PIXELS; p++)
        for (int c = 0; c < 3; c++)
            sum += picture->rgb[p][c];
    return sum / (3 * CHARTED_PIXELS);
}

static void print_table(const charted_report_t *r, FILE *out)
{
    const charted_figures_t(*f)[CHARTED_ALGORITHMS] = r->figures;
    fprintf(out, "%-10s", "");
    for (int n = 0; n < CHARTED_REPORT_COUNTS; n++)
        fprintf(out, "  n = %-14" PRIu64, r->samples[n]);
    fprintf(out, "     over PSSMLT-2  the same, paper  accepted\n");
    for (int a = 0; a < CHARTED_ALGORITHMS; a++) {
        fprintf(out, "%-10s", charted_names[a]);
        for (int n = 0; n < CHARTED_REPORT_COUNTS; n++)
            fprintf(out, "  %.5f +- %.5f", f[n][a].mean, f[n][a].error);
        fprintf(out, "   ");
        for (int n = 0; n < CHARTED_REPORT_COUNTS; n++)
            fprintf(out, "  %.3f", charted_report_quotient(&f[n][a], &f[n][CHARTED_PSSMLT_2], NULL));
        fprintf(out, "   ");
        for (int n = 0; n < CHARTED_REPORT_COUNTS; n++)
            fprintf(out, "  %.3f", charted_report_paper[n][a] / charted_report_paper[n][CHARTED_PSSMLT_2]);
        fprintf(out, "     %.2f", f[1][a].accepted);
        if (f[1][a].swapped > 0)
            fprintf(out, ", exchanges %.2f", f[1][a].swapped);
        fputc('\n', out);
    }
}

static const char *verdict(double quotient, double error)
{
    if (quotient < 1 - 3 * error)
        return "as published";
    return quotient > 1 + 3 * error ? "the other way round" : "not told apart";
}

static void print_claims(const charted_report_t *r, FILE *out)
{
    fprintf(out, "\nThe paper's order, as quotients of errors (told apart: three standard errors):\n\n");
    for (int k = 0; k < CHARTED_REPORT_CLAIMS; k++) {
        const charted_claim_t claim = charted_report_claims[k];
        fprintf(out, "%-10s < %-10s", charted_names[claim.better], charted_names[claim.worse]);
        for (int n = 0; n < CHARTED_REPORT_COUNTS; n++) {
            const charted_figures_t *f = r->figures[n];
            double error;
            const double quotient = charted_report_quotient(&f[claim.better], &f[claim.worse], &error);
            fprintf(out, "  %.3f +- %.3f  %-19s", quotient, error, verdict(quotient, error));
        }
        fputc('\n', out);
    }
    fputc('\n', out);
}

void charted_report_print(const charted_report_t *r, FILE *out)
{
    const charted_constants_t *b = &r->setup.constants;
    fprintf(out,
            "Charts (Pantaleoni 2017, section 7.1): %d x %d pixels of mean %.4f, large steps %g, seed %" PRIu64
            ".\n"
            "b = %.6f by quadrature; of the charts %.6f and %.6f +- %.6f by randomised quasi-Monte Carlo.\n"
            "Root mean square error: mean of %d and of %d runs, and its standard error.\n\n",
            CHARTED_SIDE, CHARTED_SIDE, mean_of(&r->reference), r->setup.large, r->seed, b->all, b->of_chart[0],
            b->of_chart[1], b->error, charted_report_runs[0], charted_report_runs[1]);
    print_table(r, out);
    print_claims(r, out);
}

/* ---- JSON ---- */

static json_t *figures_json(const charted_figures_t *f, double paper)
{
    json_t *json = json_new_object();
    json_add_number(json, "mean", f->mean);
    json_add_number(json, "standard_error", f->error);
    json_add_number(json, "accepted", f->accepted);
    json_add_number(json, "exchanged", f->swapped);
    json_add_number(json, "paper", paper);
    return json;
}

json_t *charted_report_json(const charted_report_t *r)
{
    json_t *json = json_new_object(), *counts = json_new_array();
    json_add_u64(json, "seed", r->seed);
    json_add_number(json, "large_steps", r->setup.large);
    json_add_number(json, "reference_mean", mean_of(&r->reference));
    json_add_number(json, "b", r->setup.constants.all);
    json_add_number(json, "b_light", r->setup.constants.of_chart[CHARTED_LIGHT]);
    json_add_number(json, "b_direction", r->setup.constants.of_chart[CHARTED_DIRECTION]);
    json_add_number(json, "b_standard_error", r->setup.constants.error);
    for (int n = 0; n < CHARTED_REPORT_COUNTS; n++) {
        json_t *row = json_new_object();
        json_add_u64(row, "samples", r->samples[n]);
        json_add_number(row, "runs", charted_report_runs[n]);
        for (int a = 0; a < CHARTED_ALGORITHMS; a++)
            json_add(row, charted_names[a], figures_json(&r->figures[n][a], charted_report_paper[n][a]));
        json_append(counts, row);
    }
    json_add(json, "root_mean_square_error", counts);
    return json;
}

/* ---- pictures: a column for the reference and each algorithm, a row for each count, pixels twice as large ---- */

enum { ZOOM = 2, GAP = 4, CELL = ZOOM * CHARTED_SIDE + GAP, COLUMNS = 1 + CHARTED_ALGORITHMS };

/* The upper edge of a cell is y = 1. */
static void paste(image_t *image, const charted_picture_t *picture, int column, int row)
{
    for (int y = 0; y < ZOOM * CHARTED_SIDE; y++)
        for (int x = 0; x < ZOOM * CHARTED_SIDE; x++) {
            const double *pixel = picture->rgb[(CHARTED_SIDE - 1 - y / ZOOM) * CHARTED_SIDE + x / ZOOM];
            const size_t place = (size_t)(row * CELL + GAP + y) * image->width + (size_t)(column * CELL + GAP + x);
            for (uint32_t c = 0; c < 3; c++)
                image_channel(image, c)[place] = (float)pixel[c];
        }
}

fault_code_t charted_report_montage(const charted_report_t *r, image_t *image, fault_t *fault)
{
    TRY(image_init_rgb(image, COLUMNS * CELL + GAP, CHARTED_REPORT_COUNTS * CELL + GAP, fault));
    for (int n = 0; n < CHARTED_REPORT_COUNTS; n++) {
        paste(image, &r->reference, 0, n);
        for (int a = 0; a < CHARTED_ALGORITHMS; a++)
            paste(image, &r->figures[n][a].picture, 1 + a, n);
    }
    return FAULT_NONE;
}

double charted_report_exposure(const charted_report_t *r)
{
    return 0.25 / mean_of(&r->reference);
}
