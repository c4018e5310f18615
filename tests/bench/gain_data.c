#include "gain_data.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "base/file.h"

/* ---- writing ---- */

static json_t *figure_json(gain_figure_t figure)
{
    json_t *object = json_new_object();
    json_add_number(object, "value", figure.value);
    json_add_number(object, "standard_error", figure.error);
    return object;
}

static json_t *point_json(const gain_point_t *point)
{
    json_t *object = json_new_object();
    json_add_number(object, "cpu_seconds", point->cpu_seconds);
    json_add_number(object, "mutations", point->mutations);
    json_add_number(object, "relmse", point->relmse);
    json_add_number(object, "relmse_trimmed", point->trimmed);
    json_add_number(object, "brightness", point->brightness);
    return object;
}

static json_t *run_json(const gain_run_t *run, size_t point_count)
{
    json_t *object = json_new_object(), *points = json_new_array();
    json_add_u64(object, "seed", run->seed);
    json_add_number(object, "relmse_estimated", run->estimate);
    json_add_number(object, "us_per_mutation", run->us_per_mutation);
    json_add_number(object, "rays_per_mutation", run->rays_per_mutation);
    for (size_t i = 0; i < point_count; i++)
        json_append(points, point_json(&run->points[i]));
    json_add(object, "points", points);
    return object;
}

static json_t *length_json(const gain_length_t *length, size_t k)
{
    json_t *object = json_new_object(), *moves = json_new_array();
    json_add_number(object, "length", (double)k);
    json_add_number(object, "mutations", length->mutations);
    json_add_number(object, "cpu_seconds", length->cpu_seconds);
    json_add_number(object, "zero_contribution", length->zero);
    json_add_number(object, "longest_stay", length->longest_stay);
    for (size_t i = 0; i < length->move_count; i++) {
        json_t *move = json_new_object();
        json_add_string(move, "name", length->moves[i].name);
        json_add_number(move, "proposed", length->moves[i].proposed);
        json_add_number(move, "acceptance", length->moves[i].acceptance);
        json_append(moves, move);
    }
    json_add(object, "moves", moves);
    return object;
}

static json_t *entry_json(const gain_entry_t *entry, size_t point_count)
{
    json_t *object = json_new_object(), *chains = NULL;
    json_add_string(object, "name", entry->variant.name);
    json_add_string(object, "algorithm", entry->variant.algorithm);
    if (!json_parse(&chains, entry->variant.chains, strlen(entry->variant.chains), NULL))
        json_add(object, "chains", chains);
    if (entry->refused[0]) {
        json_add_string(object, "refused", entry->refused);
        return object;
    }
    json_t *runs = json_new_array(), *lengths = json_new_array();
    for (size_t i = 0; i < entry->run_count; i++)
        json_append(runs, run_json(&entry->runs[i], point_count));
    json_add(object, "runs", runs);
    json_add(object, "deviation", figure_json(entry->deviation));
    json_add(object, "deviation_99", figure_json(entry->deviation_99));
    json_add_number(object, "systematic_relmse", entry->systematic);
    json_add_number(object, "nonfinite_pixels", entry->nonfinite);
    for (size_t k = 1; k <= entry->length_count; k++)
        json_append(lengths, length_json(&entry->lengths[k], k));
    json_add(object, "lengths", lengths);
    if (entry->lengths[0].move_count > 0)
        json_add(object, "chains_of_all_lengths", length_json(&entry->lengths[0], 0));
    if (entry->report)
        json_add(object, "first_report", json_copy(entry->report));
    return object;
}

json_t *gain_scene_json(const gain_scene_t *scene)
{
    json_t *root = json_new_object(), *reference = json_new_object(), *times = json_new_array(),
           *entries = json_new_array(), *seconds = json_new_array();
    json_add_string(root, "scene", scene->name);
    json_add_number(root, "width", scene->size.width);
    json_add_number(root, "height", scene->size.height);
    json_add_number(root, "max_path_length", scene->max_path_length);
    for (size_t i = 0; i < scene->point_count; i++)
        json_append(times, json_new_number(scene->times[i]));
    json_add(root, "times", times);
    json_add_number(root, "calibration", scene->calibration);
    json_add_string(reference, "recipe", scene->recipe);
    for (int half = 0; half < 2; half++)
        json_append(seconds, json_new_number(scene->reference_seconds[half]));
    json_add(reference, "cpu_seconds", seconds);
    json_add_number(reference, "noise", scene->reference_noise);
    json_add_number(reference, "brightness_difference", scene->reference_difference);
    json_add(root, "reference", reference);
    for (size_t i = 0; i < scene->entry_count; i++)
        json_append(entries, entry_json(&scene->entries[i], scene->point_count));
    json_add(root, "variants", entries);
    return root;
}

/* ---- reading: what is missing or not finite comes back as NaN, an empty text or nothing ---- */

static double read_number(const json_t *object, const char *name)
{
    const json_t *value = json_get(object, name);
    return json_is_number(value) ? json_number(value) : NAN;
}

static void read_text(const json_t *object, const char *name, char *out, size_t size)
{
    const char *text = json_string(json_get(object, name));
    snprintf(out, size, "%s", text ? text : "");
}

static gain_figure_t read_figure(const json_t *object, const char *name)
{
    const json_t *figure = json_get(object, name);
    return (gain_figure_t){read_number(figure, "value"), read_number(figure, "standard_error")};
}

static void read_run(gain_run_t *run, const json_t *object, size_t point_count)
{
    json_read_u64_or(object, "", "seed", &run->seed, NULL);
    run->estimate = read_number(object, "relmse_estimated");
    run->us_per_mutation = read_number(object, "us_per_mutation");
    run->rays_per_mutation = read_number(object, "rays_per_mutation");
    for (size_t i = 0; i < point_count; i++) {
        const json_t *point = json_at(json_get(object, "points"), i);
        run->points[i] = (gain_point_t){read_number(point, "cpu_seconds"), read_number(point, "mutations"),
                                        read_number(point, "relmse"), read_number(point, "relmse_trimmed"),
                                        read_number(point, "brightness")};
    }
}

static void read_length(gain_length_t *length, const json_t *object)
{
    length->mutations = read_number(object, "mutations");
    length->cpu_seconds = read_number(object, "cpu_seconds");
    length->zero = read_number(object, "zero_contribution");
    length->longest_stay = read_number(object, "longest_stay");
    for (const json_t *m = json_first(json_get(object, "moves")); m && length->move_count < GAIN_MOVES;
         m = json_next(m)) {
        gain_move_t *move = &length->moves[length->move_count++];
        read_text(m, "name", move->name, sizeof move->name);
        move->proposed = read_number(m, "proposed");
        move->acceptance = read_number(m, "acceptance");
    }
}

static void read_entry(gain_entry_t *entry, const json_t *object, size_t point_count)
{
    const json_t *runs = json_get(object, "runs"), *lengths = json_get(object, "lengths");
    read_text(object, "name", entry->variant.name, sizeof entry->variant.name);
    read_text(object, "algorithm", entry->variant.algorithm, sizeof entry->variant.algorithm);
    read_text(object, "refused", entry->refused, sizeof entry->refused);
    entry->run_count = json_is_array(runs) ? json_size(runs) : 0;
    if (entry->run_count == 0 && !entry->refused[0])
        snprintf(entry->refused, sizeof entry->refused, "no runs");
    entry->runs = seeds_allocate(entry->run_count, sizeof *entry->runs);
    size_t i = 0;
    for (const json_t *m = entry->run_count ? json_first(runs) : NULL; m; m = json_next(m))
        read_run(&entry->runs[i++], m, point_count);
    entry->deviation = read_figure(object, "deviation");
    entry->deviation_99 = read_figure(object, "deviation_99");
    entry->systematic = read_number(object, "systematic_relmse");
    entry->nonfinite = read_number(object, "nonfinite_pixels");
    for (const json_t *m = json_is_array(lengths) ? json_first(lengths) : NULL;
         m && entry->length_count + 1 < GAIN_LENGTHS; m = json_next(m))
        read_length(&entry->lengths[++entry->length_count], m);
    const json_t *whole = json_get(object, "chains_of_all_lengths");
    if (json_is_object(whole))
        read_length(&entry->lengths[0], whole);
}

static fault_code_t read_scene(gain_scene_t *scene, const json_t *root, fault_t *fault)
{
    int64_t width = 0, height = 0, longest = 0;
    const json_t *times = json_get(root, "times"), *entries = json_get(root, "variants"),
                 *reference = json_get(root, "reference");
    TRY(json_read_int_or(root, "", "width", 1, IMAGE_MAX_SIDE, &width, fault));
    TRY(json_read_int_or(root, "", "height", 1, IMAGE_MAX_SIDE, &height, fault));
    TRY(json_read_int_or(root, "", "max_path_length", 1, GAIN_LENGTHS - 1, &longest, fault));
    if (!json_is_array(times) || !json_is_array(entries) || json_size(times) < 1 || json_size(times) > GAIN_POINTS)
        return fault_set(fault, FAULT_FORMAT, "times, variants: expected arrays, of 1 to %d times", GAIN_POINTS);
    scene->size = (gain_size_t){(uint32_t)width, (uint32_t)height};
    scene->max_path_length = (uint32_t)longest;
    read_text(root, "scene", scene->name, sizeof scene->name);
    scene->point_count = json_size(times);
    for (size_t i = 0; i < scene->point_count; i++)
        scene->times[i] = json_number(json_at(times, i));
    scene->calibration = read_number(root, "calibration");
    read_text(reference, "recipe", scene->recipe, sizeof scene->recipe);
    for (size_t half = 0; half < 2; half++)
        scene->reference_seconds[half] = json_number(json_at(json_get(reference, "cpu_seconds"), half));
    scene->reference_noise = read_number(reference, "noise");
    scene->reference_difference = read_number(reference, "brightness_difference");
    scene->entry_count = json_size(entries);
    scene->entries = seeds_allocate(scene->entry_count, sizeof *scene->entries);
    size_t i = 0;
    for (const json_t *m = json_first(entries); m; m = json_next(m))
        read_entry(&scene->entries[i++], m, scene->point_count);
    return FAULT_NONE;
}

fault_code_t gain_scene_read(gain_scene_t *scene, const char *path, fault_t *fault)
{
    uint8_t *data;
    size_t size;
    json_t *root = NULL;
    *scene = (gain_scene_t){0};
    TRY(file_read(path, JSON_MAX_BYTES, &data, &size, fault));
    fault_code_t code = json_parse(&root, (const char *)data, size, fault);
    if (!code)
        code = read_scene(scene, root, fault);
    json_destroy(&root);
    free(data);
    if (code)
        gain_scene_clear(scene);
    return fault_prefix(fault, code, "%s", path);
}

void gain_scene_clear(gain_scene_t *scene)
{
    for (size_t i = 0; i < scene->entry_count; i++) {
        free(scene->entries[i].runs);
        json_destroy(&scene->entries[i].report);
    }
    free(scene->entries);
    *scene = (gain_scene_t){0};
}

/* ---- looking things up ---- */

const gain_entry_t *gain_scene_find(const gain_scene_t *scene, const char *name)
{
    for (size_t i = 0; i < scene->entry_count; i++)
        if (strcmp(scene->entries[i].variant.name, name) == 0 && !scene->entries[i].refused[0])
            return &scene->entries[i];
    return NULL;
}

static double run_value(const gain_run_t *run, size_t point, gain_quantity_t quantity)
{
    const gain_point_t *p = &run->points[point];
    switch (quantity) {
    case GAIN_CPU:
        return p->cpu_seconds;
    case GAIN_RELMSE:
        return p->relmse;
    case GAIN_TRIMMED:
        return p->trimmed;
    case GAIN_BRIGHTNESS:
        return p->brightness;
    case GAIN_MUTATIONS:
        return p->mutations;
    case GAIN_RELMSE_CPU:
        return p->relmse * p->cpu_seconds;
    case GAIN_TRIMMED_CPU:
        return p->trimmed * p->cpu_seconds;
    case GAIN_RELMSE_MUTATIONS:
        return p->relmse * p->mutations;
    case GAIN_TRIMMED_MUTATIONS:
        return p->trimmed * p->mutations;
    case GAIN_COST:
        return run->us_per_mutation;
    default:
        return run->rays_per_mutation;
    }
}

void gain_entry_values(const gain_entry_t *entry, size_t point, gain_quantity_t quantity, double *values)
{
    for (size_t i = 0; i < entry->run_count; i++)
        values[i] = run_value(&entry->runs[i], point, quantity);
}

spread_t gain_entry_spread(const gain_entry_t *entry, size_t point, gain_quantity_t quantity)
{
    double *values = seeds_allocate(entry->run_count, sizeof *values);
    gain_entry_values(entry, point, quantity, values);
    bool known = true;
    for (size_t i = 0; i < entry->run_count; i++)
        known &= !isnan(values[i]);
    const spread_t spread = spread_of(values, known ? entry->run_count : 0);
    free(values);
    return spread;
}

const gain_move_t *gain_length_move(const gain_length_t *length, const char *name)
{
    for (size_t i = 0; i < length->move_count; i++)
        if (strcmp(length->moves[i].name, name) == 0 && length->moves[i].proposed > 0)
            return &length->moves[i];
    return NULL;
}

void gain_length_add(gain_length_t *length, const char *name, double proposed, double acceptance)
{
    size_t i = 0;
    while (i < length->move_count && strcmp(length->moves[i].name, name) != 0)
        i++;
    if (i == GAIN_MOVES || !(proposed > 0))
        return;
    gain_move_t *move = &length->moves[i];
    if (i == length->move_count) {
        snprintf(move->name, sizeof move->name, "%s", name);
        length->move_count++;
    }
    const double accepted = move->proposed * move->acceptance + proposed * acceptance;
    move->proposed += proposed;
    move->acceptance = accepted / move->proposed;
}

gain_length_t gain_entry_total(const gain_entry_t *entry)
{
    gain_length_t total = {0};
    for (size_t k = 0; k <= entry->length_count; k++) {
        const gain_length_t *length = &entry->lengths[k];
        total.mutations += length->mutations;
        total.cpu_seconds += length->cpu_seconds;
        total.zero += length->zero;
        total.longest_stay = fmax(total.longest_stay, length->longest_stay);
        for (size_t i = 0; i < length->move_count; i++)
            gain_length_add(&total, length->moves[i].name, length->moves[i].proposed, length->moves[i].acceptance);
    }
    return total;
}
