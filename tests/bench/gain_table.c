#include "gain_table.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "client/bench/seeds.h"

static size_t last_point(const gain_scene_t *scene)
{
    return scene->point_count - 1;
}

static double median_of(const gain_scene_t *scene, const gain_entry_t *entry, gain_quantity_t quantity)
{
    return gain_entry_spread(entry, last_point(scene), quantity).median;
}

static double mean_of(const gain_scene_t *scene, const gain_entry_t *entry, gain_quantity_t quantity)
{
    double *values = seeds_allocate(entry->run_count, sizeof *values), sum = 0;
    gain_entry_values(entry, last_point(scene), quantity, values);
    for (size_t i = 0; i < entry->run_count; i++)
        sum += values[i];
    free(values);
    return sum / (double)entry->run_count;
}

/* The base's median over the entry's; NaN without a base or where one of them is lost in the reference's noise. */
static double gain_over_mmlt(const gain_scene_t *scene, const gain_entry_t *entry, gain_quantity_t quantity)
{
    const gain_entry_t *base = gain_scene_find(scene, "mmlt");
    if (!base || !entry)
        return NAN;
    const double own = median_of(scene, entry, quantity), other = median_of(scene, base, quantity);
    return own > 0 && other > 0 ? other / own : NAN;
}

/* A number in a column; "-" if it is not known. */
static void put(FILE *out, int width, int digits, double value)
{
    if (isfinite(value))
        fprintf(out, " %*.*f", width, digits, value);
    else
        fprintf(out, " %*s", width, "-");
}

/* ---- summary ---- */

static void summary_row(FILE *out, const gain_scene_t *scenes, size_t count, const char *name,
                        gain_quantity_t quantity)
{
    double logs = 0, known = 0;
    fprintf(out, "%-22s", name);
    for (size_t s = 0; s < count; s++) {
        const double gain = gain_over_mmlt(&scenes[s], gain_scene_find(&scenes[s], name), quantity);
        put(out, 13, 2, gain);
        if (gain > 0) {
            logs += log(gain);
            known++;
        }
    }
    put(out, 13, 2, known > 0 ? exp(logs / known) : NAN);
    fputc('\n', out);
}

/* Rows of all variants that any scene measured, in the order of the first that names them. */
static void summary_rows(FILE *out, const gain_scene_t *scenes, size_t count, gain_quantity_t quantity)
{
    for (size_t s = 0; s < count; s++)
        for (size_t i = 0; i < scenes[s].entry_count; i++) {
            const char *name = scenes[s].entries[i].variant.name;
            bool seen = scenes[s].entries[i].refused[0] != '\0';
            for (size_t before = 0; before < s; before++)
                seen |= gain_scene_find(&scenes[before], name) != NULL;
            if (!seen)
                summary_row(out, scenes, count, name, quantity);
        }
}

static void summary_table(FILE *out, const gain_scene_t *scenes, size_t count, const char *title,
                          gain_quantity_t quantity)
{
    fprintf(out, "%s\n%-22s", title, "");
    for (size_t s = 0; s < count; s++)
        fprintf(out, " %13s", scenes[s].name);
    fprintf(out, " %13s\n", "geom. mean");
    summary_rows(out, scenes, count, quantity);
}

void gain_print_summary(FILE *out, const gain_scene_t *scenes, size_t count)
{
    summary_table(out, scenes, count, "gain over mmlt at equal time: its relMSE x CPU seconds over theirs, medians",
                  GAIN_RELMSE_CPU);
    fputc('\n', out);
    summary_table(out, scenes, count, "the same without the worst 0.1 % of the pixels", GAIN_TRIMMED_CPU);
}

/* ---- a scene ---- */

/* Mean brightness and its standard error: of the seeds, and of the reference. */
static gain_figure_t brightness_of(const gain_scene_t *scene, const gain_entry_t *entry)
{
    double *values = seeds_allocate(entry->run_count, sizeof *values), sum = 0;
    const double n = (double)entry->run_count, mean = mean_of(scene, entry, GAIN_BRIGHTNESS);
    gain_entry_values(entry, last_point(scene), GAIN_BRIGHTNESS, values);
    for (size_t i = 0; i < entry->run_count; i++)
        sum += (values[i] - mean) * (values[i] - mean);
    free(values);
    return (gain_figure_t){mean, hypot(sqrt(sum / (n * (n - 1))), scene->reference_difference / 2)};
}

static double zero_share(const gain_length_t *length)
{
    double proposed = 0;
    for (size_t i = 0; i < length->move_count; i++)
        proposed += length->moves[i].proposed;
    return proposed > 0 ? length->zero / proposed : NAN;
}

static void scene_row(FILE *out, const gain_scene_t *scene, const gain_entry_t *entry)
{
    const spread_t error = gain_entry_spread(entry, last_point(scene), GAIN_RELMSE);
    const gain_figure_t bright = brightness_of(scene, entry);
    const gain_length_t total = gain_entry_total(entry);
    fprintf(out, "%-22s %6.2f %8.1f %9.4g (%.4g, %.4g)%*s", entry->variant.name, median_of(scene, entry, GAIN_CPU),
            median_of(scene, entry, GAIN_MUTATIONS) / scene->size.width / scene->size.height, error.median,
            error.min, error.max, 22 - snprintf(NULL, 0, "(%.4g, %.4g)", error.min, error.max), "");
    fprintf(out, " %9.4g", median_of(scene, entry, GAIN_TRIMMED));
    put(out, 6, 2, gain_over_mmlt(scene, entry, GAIN_RELMSE_CPU));
    put(out, 6, 2, gain_over_mmlt(scene, entry, GAIN_TRIMMED_CPU));
    put(out, 7, 3, entry->deviation.value);
    put(out, 7, 2, entry->deviation_99.value);
    put(out, 7, 4, bright.value);
    put(out, 6, 4, bright.error);
    put(out, 5, 0, 100 * entry->systematic / mean_of(scene, entry, GAIN_RELMSE));
    put(out, 7, 2, median_of(scene, entry, GAIN_COST));
    put(out, 6, 1, median_of(scene, entry, GAIN_RAYS));
    put(out, 6, 1, 100 * zero_share(&total));
    fputc(' ', out);
    for (size_t i = 0; i < total.move_count; i++)
        fprintf(out, " %s %.3f", total.moves[i].name, total.moves[i].acceptance);
    fputc('\n', out);
}

static void scene_table(FILE *out, const gain_scene_t *scene)
{
    size_t seeds = 0;
    for (size_t i = 0; i < scene->entry_count; i++)
        if (!scene->entries[i].refused[0] && scene->entries[i].run_count > seeds)
            seeds = scene->entries[i].run_count;
    fprintf(
        out,
        "%s, %u x %u, up to %u segments; %zu runs of %g CPU s, calibration %.3f\nreference: %s, %.0f and %.0f CPU "
        "s, its own relMSE %.3g, brightness of the halves %.4f apart\n",
        scene->name, scene->size.width, scene->size.height, scene->max_path_length, seeds,
        scene->times[last_point(scene)], scene->calibration, scene->recipe, scene->reference_seconds[0],
        scene->reference_seconds[1], scene->reference_noise, scene->reference_difference);
    fprintf(out, "%-22s %6s %8s %9s %-22s %9s %6s %6s %7s %7s %7s %6s %5s %7s %6s %6s  %s\n", "", "CPU s", "/pixel",
            "relMSE", "(min, max)", "trimmed", "gain", "trim.", "dev.", "99 %", "bright", "+-", "syst%", "us/mut",
            "rays", "zero%", "acceptance");
    for (size_t i = 0; i < scene->entry_count; i++)
        if (!scene->entries[i].refused[0])
            scene_row(out, scene, &scene->entries[i]);
    for (size_t i = 0; i < scene->entry_count; i++)
        if (scene->entries[i].refused[0])
            fprintf(out, "%-22s not measured: %s\n", scene->entries[i].variant.name, scene->entries[i].refused);
}

void gain_print_scenes(FILE *out, const gain_scene_t *scenes, size_t count)
{
    for (size_t s = 0; s < count; s++) {
        if (s > 0)
            fputc('\n', out);
        scene_table(out, &scenes[s]);
    }
}

/* ---- by path length ---- */

static void moves_row(FILE *out, const gain_entry_t *entry, const char *move, uint32_t longest)
{
    fprintf(out, "%-22s %-12s", entry->variant.name, move);
    for (uint32_t k = 1; k <= longest; k++) {
        const gain_move_t *m = gain_length_move(&entry->lengths[k], move);
        put(out, 6, 3, m ? m->acceptance : NAN);
    }
    fputc('\n', out);
}

/* Chains of all lengths at once: one column, of all of them. */
static void moves_whole(FILE *out, const gain_entry_t *entry)
{
    const gain_length_t *whole = &entry->lengths[0];
    for (size_t i = 0; i < whole->move_count; i++)
        fprintf(out, "%-22s %-12s %6.3f (all lengths at once)\n", entry->variant.name, whole->moves[i].name,
                whole->moves[i].acceptance);
    fprintf(out, "%-22s %-12s %6.1f\n%-22s %-12s %6.2f\n", entry->variant.name, "zero %", 100 * zero_share(whole),
            entry->variant.name, "us/mutation", 1e6 * whole->cpu_seconds / whole->mutations);
}

static void moves_entry(FILE *out, const gain_entry_t *entry, uint32_t longest)
{
    if (entry->lengths[0].move_count > 0) {
        moves_whole(out, entry);
        return;
    }
    const gain_length_t total = gain_entry_total(entry);
    if (total.move_count == 0) /* independent samples */
        return;
    for (size_t i = 0; i < total.move_count; i++)
        moves_row(out, entry, total.moves[i].name, longest);
    fprintf(out, "%-22s %-12s", entry->variant.name, "zero %");
    for (uint32_t k = 1; k <= longest; k++)
        put(out, 6, 1, 100 * zero_share(&entry->lengths[k]));
    fprintf(out, "\n%-22s %-12s", entry->variant.name, "us/mutation");
    for (uint32_t k = 1; k <= longest; k++)
        put(out, 6, 2, 1e6 * entry->lengths[k].cpu_seconds / entry->lengths[k].mutations);
    fputc('\n', out);
}

void gain_print_moves(FILE *out, const gain_scene_t *scenes, size_t count)
{
    for (size_t s = 0; s < count; s++) {
        fprintf(out, "%s%-35s", s > 0 ? "\n" : "", scenes[s].name);
        for (uint32_t k = 1; k <= scenes[s].max_path_length; k++)
            fprintf(out, " %6u", k);
        fputc('\n', out);
        for (size_t i = 0; i < scenes[s].entry_count; i++)
            if (!scenes[s].entries[i].refused[0])
                moves_entry(out, &scenes[s].entries[i], scenes[s].max_path_length);
    }
}
