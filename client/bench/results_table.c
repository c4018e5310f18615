#include "client/bench/results_table.h"

#include <math.h>
#include <stdlib.h>

/* ---- text ---- */

static void put(FILE *out, int width, int digits, double value)
{
    if (isnan(value))
        fprintf(out, " %*s", width, "-");
    else
        fprintf(out, " %*.*g", width, digits, value);
}

/* "0.0123 (0.0111, 0.0142)" */
static void put_spread(FILE *out, spread_t s)
{
    char text[64];
    if (isnan(s.median))
        snprintf(text, sizeof text, "-");
    else
        snprintf(text, sizeof text, "%.4g (%.3g, %.3g)", s.median, s.min, s.max);
    fprintf(out, " %-29s", text);
}

static void put_gain(FILE *out, seeds_ratio_t gain)
{
    if (isnan(gain.value))
        fprintf(out, " -\n");
    else if (isnan(gain.low))
        fprintf(out, " %.2f\n", gain.value);
    else
        fprintf(out, " %.2f (%.2f, %.2f)\n", gain.value, gain.low, gain.high);
}

static void print_row(FILE *out, const results_t *results, size_t scene, size_t variant, size_t budget)
{
    const results_cell_t cell = results_cell(results, scene, variant, budget);
    fprintf(out, "%-24s", results->matrix->variants[variant].name);
    put(out, 8, 4, results->matrix->budgets[budget]);
    put(out, 8, 4, cell.cpu_seconds.median);
    put(out, 8, 4, cell.mutations.median);
    put_spread(out, cell.relmse);
    put(out, 9, 3, cell.trimmed.median);
    put(out, 9, 3, cell.estimate.median);
    put(out, 8, 5, cell.bias.value);
    put(out, 8, 2, cell.bias.error);
    put_gain(out, cell.gain);
}

static void print_scene(FILE *out, const results_t *results, size_t scene)
{
    const matrix_t *m = results->matrix;
    const results_scene_t *about = &results->scenes[scene];
    fprintf(out, "%s, %u x %u pixels, %zu seeds; %s%s\n", m->scenes[scene].name, about->width, about->height,
            m->seeds, about->reference[0] ? "against " : "no reference: the renders' own estimates alone",
            about->reference);
    fprintf(out, "%-24s %8s %8s %8s %-29s %9s %9s %8s %8s %s\n", "", m->by_mutations ? "budget/p" : "budget s",
            "CPU s", "/pixel", "relMSE (min, max)", "trimmed", "estimate", "bias", "+-", "gain (95 %)");
    for (size_t v = 0; v < m->variant_count; v++)
        for (size_t b = 0; b < m->budget_count; b++)
            print_row(out, results, scene, v, b);
    for (size_t v = 0; v < m->variant_count; v++) {
        const char *failure = results_failure(results, scene, v);
        if (failure)
            fprintf(out, "%-24s not every run was made: %s\n", m->variants[v].name, failure);
    }
}

void results_print(FILE *out, const results_t *results)
{
    for (size_t s = 0; s < results->matrix->scene_count; s++) {
        if (s > 0)
            fputc('\n', out);
        print_scene(out, results, s);
    }
}

/* ---- JSON ---- */

static json_t *run_json(const results_t *results, const run_figures_t *run, size_t seed)
{
    json_t *object = json_new_object(), *points = json_new_array();
    json_add_u64(object, "seed", seed + 1);
    if (!run->made)
        json_add_string(object, "failure", run->failure[0] ? run->failure : "not run");
    for (size_t b = 0; run->made && b < results->matrix->budget_count; b++)
        json_append(points, run_point_json(&run->points[b]));
    json_add(object, "points", points);
    return object;
}

static json_t *cell_json(const results_t *results, size_t scene, size_t variant, size_t budget)
{
    const results_cell_t cell = results_cell(results, scene, variant, budget);
    json_t *object = json_new_object(), *bias = json_new_object(), *gain = json_new_object(),
           *interval = json_new_array();
    json_add_number(object, "budget", results->matrix->budgets[budget]);
    json_add_number(object, "runs", (double)cell.runs);
    json_add(object, "cpu_seconds", spread_json(cell.cpu_seconds));
    json_add(object, "mutations_per_pixel", spread_json(cell.mutations));
    json_add(object, "relmse", spread_json(cell.relmse));
    json_add(object, "relmse_trimmed", spread_json(cell.trimmed));
    json_add(object, "relmse_estimated", spread_json(cell.estimate));
    json_add_number(bias, "value", cell.bias.value);
    json_add_number(bias, "standard_error", cell.bias.error);
    json_add(object, "bias", bias);
    json_add_number(gain, "value", cell.gain.value);
    json_append(interval, json_new_number(cell.gain.low));
    json_append(interval, json_new_number(cell.gain.high));
    json_add(gain, "interval", interval);
    json_add(object, "gain", gain);
    return object;
}

static json_t *variant_json(const results_t *results, size_t scene, size_t variant)
{
    const matrix_t *m = results->matrix;
    json_t *object = json_new_object(), *cells = json_new_array(), *runs = json_new_array();
    json_add_string(object, "name", m->variants[variant].name);
    for (size_t b = 0; b < m->budget_count; b++)
        json_append(cells, cell_json(results, scene, variant, b));
    json_add(object, "budgets", cells);
    for (size_t i = 0; i < m->seeds; i++)
        json_append(runs, run_json(results, results_run(results, scene, variant, i), i));
    json_add(object, "runs", runs);
    return object;
}

json_t *results_json(const results_t *results)
{
    const matrix_t *m = results->matrix;
    json_t *root = json_new_object(), *scenes = json_new_array();
    json_add_string(root, "garland", GARLAND_VERSION);
    json_add_string(root, "budget", m->by_mutations ? "mutations_per_pixel" : "seconds");
    for (size_t s = 0; s < m->scene_count; s++) {
        json_t *scene = json_new_object(), *variants = json_new_array();
        json_add_string(scene, "name", m->scenes[s].name);
        json_add_string(scene, "reference", results->scenes[s].reference);
        if (results->scenes[s].failure[0])
            json_add_string(scene, "failure", results->scenes[s].failure);
        for (size_t v = 0; v < m->variant_count; v++)
            json_append(variants, variant_json(results, s, v));
        json_add(scene, "variants", variants);
        json_append(scenes, scene);
    }
    json_add(root, "scenes", scenes);
    return root;
}

/* ---- CSV ---- */

static void put_field(FILE *out, double value)
{
    if (isfinite(value))
        fprintf(out, ",%.17g", value);
    else
        fputc(',', out);
}

void results_print_csv(FILE *out, const results_t *results)
{
    const matrix_t *m = results->matrix;
    fprintf(out,
            "scene,variant,%s,runs,cpu_seconds,mutations_per_pixel,relmse,relmse_min,relmse_max,"
            "relmse_trimmed,relmse_estimated,bias,bias_standard_error,gain,gain_low,gain_high\r\n",
            m->by_mutations ? "budget_mutations_per_pixel" : "budget_seconds");
    for (size_t s = 0; s < m->scene_count; s++)
        for (size_t v = 0; v < m->variant_count; v++)
            for (size_t b = 0; b < m->budget_count; b++) {
                const results_cell_t c = results_cell(results, s, v, b);
                const double fields[] = {
                    m->budgets[b], (double)c.runs, c.cpu_seconds.median, c.mutations.median, c.relmse.median,
                    c.relmse.min,  c.relmse.max,   c.trimmed.median,     c.estimate.median,  c.bias.value,
                    c.bias.error,  c.gain.value,   c.gain.low,           c.gain.high};
                fprintf(out, "%s,%s", m->scenes[s].name, m->variants[v].name); /* names need no quotes */
                for (size_t i = 0; i < sizeof fields / sizeof *fields; i++)
                    put_field(out, fields[i]);
                fputs("\r\n", out);
            }
}
