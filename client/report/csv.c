#include "client/report/csv.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "base/file.h"

/* ---- fields ---- */

static void put_number(FILE *out, double value, const char *after)
{
    if (isfinite(value))
        fprintf(out, "%.17g", value);
    fputs(after, out);
}

/* In quotes where it holds what a table is made of. */
static void put_text(FILE *out, const char *text, const char *after)
{
    if (text && text[strcspn(text, ",\"\r\n")] != '\0') {
        fputc('"', out);
        for (const char *c = text; *c; c++)
            fputs(*c == '"' ? "\"\"" : (char[]){*c, '\0'}, out);
        fputc('"', out);
    } else if (text) {
        fputs(text, out);
    }
    fputs(after, out);
}

/* ---- tables ---- */

#define LINE_END "\r\n"

static void put_history(FILE *out, const report_t *report)
{
    for (uint32_t i = 0; i < report->history_count; i++) {
        const report_point_t *point = &report->history[i];
        put_number(out, point->seconds, ",");
        put_number(out, point->cpu_seconds, ",");
        put_number(out, point->mutations, ",");
        put_number(out, point->relmse, ",");
        put_number(out, point->error, LINE_END);
    }
}

static void put_lengths(FILE *out, const report_t *report)
{
    for (uint32_t i = 0; i < report->length_count; i++) {
        const report_length_t *k = &report->lengths[i];
        put_number(out, k->length, ",");
        put_number(out, k->b, ",");
        put_number(out, k->b_error, ",");
        put_number(out, k->relmse, ",");
        put_number(out, k->share, ",");
        put_number(out, k->mutations, ",");
        put_number(out, k->chains, ",");
        put_number(out, k->cpu_seconds, ",");
        put_number(out, k->zero_contribution, ",");
        put_number(out, k->longest_stay, ",");
        put_number(out, k->light, ",");
        put_number(out, k->cap, ",");
        put_number(out, k->inefficiency, ",");
        put_number(out, k->rays, ",");
        put_number(out, k->steps, ",");
        put_number(out, k->large_step, ",");
        put_number(out, k->most, LINE_END);
    }
}

static void put_moves_of(FILE *out, const report_length_t *length)
{
    for (uint32_t i = 0; i < length->move_count; i++) {
        put_number(out, length->length, ",");
        put_text(out, length->moves[i].name, ",");
        put_number(out, length->moves[i].proposed, ",");
        put_number(out, length->moves[i].acceptance, LINE_END);
    }
}

static void put_moves(FILE *out, const report_t *report)
{
    put_moves_of(out, &report->all);
    for (uint32_t i = 0; i < report->length_count; i++)
        put_moves_of(out, &report->lengths[i]);
}

static void put_techniques(FILE *out, const report_t *report)
{
    for (uint32_t i = 0; i < report->length_count; i++)
        for (uint32_t j = 0; j < report->lengths[i].technique_count; j++) {
            const report_technique_t *technique = &report->lengths[i].techniques[j];
            put_number(out, report->lengths[i].length, ",");
            put_number(out, technique->s, ",");
            put_number(out, report->lengths[i].length + 1 - technique->s, ",");
            put_number(out, technique->value, ",");
            put_number(out, technique->standard_error, LINE_END);
        }
}

static void put_effects(FILE *out, const report_t *report)
{
    for (uint32_t i = 0; i < report->effect_count; i++) {
        const report_effect_t *effect = &report->effects[i];
        put_text(out, effect->name, ",");
        put_text(out, effect->state, ",");
        put_text(out, effect->reason, ",");
        put_number(out, effect->energy, ",");
        put_text(out, effect->consequence, ",");
        put_number(out, effect->energy_error, LINE_END);
    }
}

static void put_regions(FILE *out, const report_t *report)
{
    for (uint32_t i = 0; i < report->region_columns * report->region_rows; i++) {
        put_number(out, i / report->region_columns + 1, ",");
        put_number(out, i % report->region_columns + 1, ",");
        put_number(out, report->regions[i].luminance, ",");
        put_number(out, report->regions[i].low, ",");
        put_number(out, report->regions[i].high, LINE_END);
    }
}

static const struct {
    const char *name, *columns;
    void (*put)(FILE *out, const report_t *report);
} tables[CSV_TABLES] = {
    [CSV_HISTORY] = {"history.csv", "seconds,cpu_seconds,mutations,relmse,error", put_history},
    [CSV_LENGTHS] =
        {"lengths.csv",
         "length,b,b_standard_error,relmse,share,mutations,chains,cpu_seconds,zero_contribution,longest_stay,"
         "light,cap,inefficiency,rays,steps,large_step,most",
         put_lengths},
    [CSV_MOVES] = {"moves.csv", "length,move,proposed,acceptance", put_moves},
    [CSV_TECHNIQUES] = {"techniques.csv", "length,s,t,value,standard_error", put_techniques},
    [CSV_REGIONS] = {"regions.csv", "row,column,luminance,low,high", put_regions},
    [CSV_EFFECTS] = {"effects.csv", "name,state,reason,energy,consequence,energy_error", put_effects},
};

const char *csv_name(csv_table_t table)
{
    return tables[table].name;
}

char *csv_print(const report_t *report, csv_table_t table)
{
    char *text = NULL;
    size_t size;
    FILE *out = open_memstream(&text, &size);
    if (!out)
        return NULL;
    fputs(tables[table].columns, out);
    fputs(LINE_END, out);
    tables[table].put(out, report);
    const int failed = ferror(out);
    if (fclose(out) == 0 && !failed)
        return text;
    free(text);
    return NULL;
}

fault_code_t csv_write(const report_t *report, const char *folder, fault_t *fault)
{
    TRY(file_make_folder(folder, fault));
    for (int table = 0; table < CSV_TABLES; table++) {
        char path[4096];
        TRY(file_join(path, sizeof path, folder, csv_name((csv_table_t)table), fault));
        char *text = csv_print(report, (csv_table_t)table);
        if (!text)
            return fault_set(fault, FAULT_MEMORY, "%s: no memory", path);
        const fault_code_t code = file_write(path, text, strlen(text), fault);
        free(text);
        TRY(code);
    }
    return FAULT_NONE;
}
