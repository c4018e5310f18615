#include "plan/plan_passes.h"

#include <math.h>
#include <stdlib.h>

#include "base/random.h"
#include "plan/plan_state.h"

enum {
    PART_USUAL = 1 << 17 /* samples: half a second or so; packing a film of two million pixels takes a tenth */
};

/* ---- how a pass is cut ---- */

/* The shortest distance of two pixels x + width y = 0 (mod parts), squared, over what the best lattice has. */
static double lattice_quality(uint32_t width, uint32_t parts)
{
    double shortest = (double)parts * parts;
    for (uint64_t y = 1; (double)(y * y) < 2.0 * parts; y++) {
        const uint64_t right = (parts - y * width % parts) % parts,
                       x = right < parts - right ? right : parts - right;
        shortest = fmin(shortest, (double)(x * x + y * y));
    }
    return shortest / parts;
}

/* So many parts or up to half as many more, such that every so-many-th pixel is spread evenly over the image, not
 * in columns. */
static uint32_t lattice_parts(uint32_t width, uint32_t least)
{
    uint32_t best = least;
    for (uint32_t parts = least; parts < least + least / 2; parts++)
        if (lattice_quality(width, parts) > lattice_quality(width, best))
            best = parts;
    return best;
}

/* From one part to the next: about the golden section, so that any number of them in a row is spread evenly, and
 * none in common with the number of parts, so that all are met. */
static uint32_t lattice_step(uint32_t parts)
{
    for (uint32_t step = (uint32_t)(0.6180339887 * parts + 0.5);; step++) {
        uint32_t a = parts, b = step;
        while (b > 0) {
            const uint32_t rest = a % b;
            a = b;
            b = rest;
        }
        if (a == 1)
            return step;
    }
}

void plan_passes_init(plan_t *plan)
{
    plan_passes_t *passes = &plan->passes;
    passes->parts = (uint32_t)((plan->pixels + PART_USUAL - 1) / PART_USUAL);
    passes->lattice = 0;
    if (!(plan->job.stop.seconds > 0) || passes->parts == 1)
        return;
    const uint64_t key = random_key(plan->settings.seed, RANDOM_PURPOSE_PASSES, 0, 0);
    passes->lattice = lattice_parts(plan->settings.width, passes->parts);
    passes->begin = (uint32_t)(random_u64(key, 0) % (PASSES_EARLY * passes->lattice));
    passes->step = lattice_step(passes->lattice);
}

void plan_passes_clear(plan_passes_t *passes)
{
    for (uint32_t i = 0; i < passes->count; i++)
        film_clear(&passes->open[i].film);
    *passes = (plan_passes_t){0};
}

/* ---- handing out ---- */

/* Units of the first pass. */
static uint64_t passes_first(const plan_passes_t *passes)
{
    return passes->lattice > 0 ? PASSES_EARLY + passes->lattice - 1 : passes->parts;
}

bool plan_passes_wait(const plan_t *plan)
{
    const plan_passes_t *passes = &plan->passes;
    const plan_length_t *samples = &plan->lengths[0];
    if (passes->parts == 1)
        return false;
    return samples->handed % plan->pixels == 0 && samples->handed / plan->pixels >= samples->units_in + PASSES_OPEN;
}

void plan_passes_place(const plan_t *plan, work_record_t *record)
{
    const plan_passes_t *passes = &plan->passes;
    const plan_length_t *samples = &plan->lengths[0];
    const uint64_t pixels = plan->pixels, unit = samples->units_out;
    if (passes->parts == 1) { /* whole passes, one or several */
        record->first = samples->handed;
    } else if (unit >= passes_first(passes) || passes->lattice == 0) {
        const uint64_t rest = passes->lattice > 0 ? unit - passes_first(passes) : unit,
                       pass = rest / passes->parts + (passes->lattice > 0), part = rest % passes->parts,
                       begin = pixels * part / passes->parts;
        record->first = pixels * pass + begin;
        record->count = pixels * (part + 1) / passes->parts - begin;
    } else {
        const bool early = unit < PASSES_EARLY;
        const uint64_t stride = early ? PASSES_EARLY * passes->lattice : passes->lattice,
                       turn = early ? unit * passes->lattice : (unit - PASSES_EARLY + 1) * passes->step;
        record->first = (passes->begin + turn) % stride;
        record->skip = stride - 1;
        record->count = (pixels - record->first + stride - 1) / stride;
    }
}

/* ---- taking in ---- */

uint32_t plan_passes_find(const plan_t *plan, uint64_t number)
{
    for (uint32_t i = 0; i < plan->passes.count; i++)
        if (plan->passes.open[i].number == number)
            return i;
    return PASSES_OPEN;
}

/* The pass of this number, which may be open already; else it is opened. */
static fault_code_t passes_open(plan_t *plan, uint64_t number, plan_pass_t **out, fault_t *fault)
{
    plan_passes_t *passes = &plan->passes;
    const uint32_t found = plan_passes_find(plan, number);
    plan_pass_t *pass = &passes->open[found < PASSES_OPEN ? found : passes->count % PASSES_OPEN];
    *out = pass;
    if (found < PASSES_OPEN)
        return FAULT_NONE;
    if (passes->count == PASSES_OPEN)
        return fault_set(fault, FAULT_LIMIT, "more than %d passes over the image are open", PASSES_OPEN);
    *pass = (plan_pass_t){.number = number};
    TRY(film_init(&pass->film, plan->settings.width, plan->settings.height, fault));
    passes->count++;
    return FAULT_NONE;
}

static void passes_close(plan_passes_t *passes, plan_pass_t *pass, plan_pass_t *out)
{
    *out = *pass;
    *pass = passes->open[--passes->count];
}

fault_code_t plan_passes_take(plan_t *plan, const work_record_t *record, const work_result_t *result,
                              plan_pass_t *whole, fault_t *fault)
{
    plan_pass_t *pass = NULL;
    *whole = (plan_pass_t){0};
    TRY(passes_open(plan, record->first / plan->pixels, &pass, fault));
    film_add(&pass->film, &result->film);
    pass->count += record->count;
    pass->cpu_seconds += result->stats.cpu_seconds;
    if (pass->count == plan->pixels)
        passes_close(&plan->passes, pass, whole);
    return FAULT_NONE;
}

bool plan_passes_begun(const plan_t *plan)
{
    return plan->passes.lattice > 0 && plan->lengths[0].units_in == 0 && plan_passes_find(plan, 0) < PASSES_OPEN;
}

void plan_passes_settle(plan_t *plan, plan_pass_t *parts)
{
    *parts = (plan_pass_t){0};
    if (plan_passes_begun(plan))
        passes_close(&plan->passes, &plan->passes.open[plan_passes_find(plan, 0)], parts);
}

uint64_t plan_passes_waiting(const plan_t *plan)
{
    uint64_t count = 0;
    for (uint32_t i = 0; i < plan->passes.count; i++)
        count += plan->passes.open[i].count;
    return count;
}

/* ---- as bytes ---- */

void plan_passes_put(wire_writer_t *out, const plan_t *plan)
{
    const plan_passes_t *passes = &plan->passes;
    wire_put_u32(out, passes->count);
    for (uint32_t i = 0; i < passes->count; i++) {
        const plan_pass_t *pass = &passes->open[i];
        uint8_t *data = NULL;
        size_t size = 0;
        wire_put_u64(out, pass->number);
        wire_put_u64(out, pass->count);
        wire_put_f64(out, pass->cpu_seconds);
        if (film_encode(&pass->film, &data, &size, out->fault))
            wire_writer_fail(out, FAULT_MEMORY, "open pass", "%u x %u pixels are not encoded", pass->film.width,
                             pass->film.height);
        wire_put_bytes(out, "open pass", data, size, UINT32_MAX);
        free(data);
    }
}

fault_code_t plan_passes_get(wire_reader_t *in, plan_t *plan, fault_t *fault)
{
    const uint32_t count = wire_get_u32(in, "open passes");
    if (!in->code && count > PASSES_OPEN)
        return wire_reader_fail(in, FAULT_RANGE, "open passes", "%u, expected 0 to %d", count, PASSES_OPEN);
    for (uint32_t i = 0; i < count && !in->code; i++) {
        const uint64_t number = wire_get_u64(in, "open pass"), samples = wire_get_u64(in, "open pass");
        const double cpu_seconds = wire_get_f64(in, "open pass");
        size_t size = 0;
        const uint8_t *film = wire_get_bytes(in, "open pass", UINT32_MAX, &size);
        if (in->code)
            break;
        plan_pass_t *pass = NULL;
        TRY(passes_open(plan, number, &pass, fault));
        if (plan->passes.count != i + 1 || samples == 0 || samples >= plan->pixels ||
            !(cpu_seconds >= 0 && cpu_seconds < 1e15))
            return wire_reader_fail(in, FAULT_RANGE, "open pass", "%llu with %llu samples in %g s",
                                    (unsigned long long)number, (unsigned long long)samples, cpu_seconds);
        pass->count = samples;
        pass->cpu_seconds = cpu_seconds;
        TRY(film_decode(&pass->film, film, size, fault));
    }
    return in->code;
}
