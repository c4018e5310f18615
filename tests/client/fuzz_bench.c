/* Files of `garland bench` of any bytes: refused with words, or read within bounds. */
#include <assert.h>
#include <stdint.h>

#include "client/bench/matrix.h"

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size);

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    static matrix_t matrix;
    fault_t fault = {0};
    if (matrix_parse(&matrix, (const char *)data, size, "folder/input", &fault) != FAULT_NONE) {
        assert(fault.text[0]);
        return 0;
    }
    assert(matrix.scene_count >= 1 && matrix.scene_count <= MATRIX_SCENES);
    assert(matrix.variant_count >= 1 && matrix.variant_count <= MATRIX_VARIANTS);
    assert(matrix.budget_count >= 1 && matrix.budget_count <= MATRIX_BUDGETS);
    assert(matrix.seeds >= 1 && matrix.seeds <= MATRIX_SEEDS && matrix.workers >= 1);
    return 0;
}
