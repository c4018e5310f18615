#include "plan/plan_pending.h"

#include <stdlib.h>
#include <string.h>

void plan_pending_clear(plan_pending_t *pending)
{
    for (size_t i = 0; i < pending->count; i++)
        free(pending->results[i].data);
    free(pending->results);
    *pending = (plan_pending_t){0};
}

fault_code_t plan_pending_add(plan_pending_t *pending, uint64_t unit, const uint8_t *data, size_t size,
                              fault_t *fault)
{
    if (pending->count >= PLAN_PENDING_MOST)
        return fault_set(fault, FAULT_LIMIT, "%zu results wait already", pending->count);
    if (pending->count == pending->room) {
        const size_t room = pending->room ? 2 * pending->room : 16;
        plan_pending_result_t *results = realloc(pending->results, sizeof *results * room);
        if (!results)
            return fault_set(fault, FAULT_MEMORY, "no memory for %zu results", room);
        pending->results = results;
        pending->room = room;
    }
    uint8_t *copy = malloc(size ? size : 1);
    if (!copy)
        return fault_set(fault, FAULT_MEMORY, "no memory to keep a result of %zu octets", size);
    memcpy(copy, data, size);
    pending->results[pending->count++] = (plan_pending_result_t){unit, copy, size};
    return FAULT_NONE;
}

bool plan_pending_has(const plan_pending_t *pending, uint64_t unit)
{
    for (size_t i = 0; i < pending->count; i++)
        if (pending->results[i].unit == unit)
            return true;
    return false;
}

plan_pending_result_t plan_pending_take(plan_pending_t *pending, size_t i)
{
    const plan_pending_result_t result = pending->results[i];
    pending->results[i] = pending->results[--pending->count];
    return result;
}

void plan_pending_put(wire_writer_t *out, const plan_pending_t *pending)
{
    wire_put_u64(out, pending->count);
    for (size_t i = 0; i < pending->count; i++) {
        wire_put_u64(out, pending->results[i].unit);
        wire_put_bytes(out, "result", pending->results[i].data, pending->results[i].size, UINT32_MAX);
    }
}

fault_code_t plan_pending_get(wire_reader_t *in, plan_pending_t *pending, uint64_t units)
{
    const uint64_t count = wire_get_u64(in, "pending results");
    if (!in->code && count > PLAN_PENDING_MOST)
        return wire_reader_fail(in, FAULT_LIMIT, "pending results", "%llu, expected at most %d",
                                (unsigned long long)count, PLAN_PENDING_MOST);
    for (uint64_t i = 0; i < count && !in->code; i++) {
        const uint64_t unit = wire_get_u64(in, "pending results");
        size_t size = 0;
        const uint8_t *data = wire_get_bytes(in, "result", UINT32_MAX, &size);
        if (in->code)
            break;
        if (unit >= units || plan_pending_has(pending, unit))
            return wire_reader_fail(in, FAULT_FORMAT, "pending results", "unit %llu of %llu, or twice",
                                    (unsigned long long)unit, (unsigned long long)units);
        if (plan_pending_add(pending, unit, data, size, in->fault))
            return wire_reader_fail(in, FAULT_MEMORY, "pending results", "no memory");
    }
    return in->code;
}
