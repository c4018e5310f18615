/* gain_table.h: bench_gain's figures as text. */
#ifndef TESTS_BENCH_GAIN_TABLE_H
#define TESTS_BENCH_GAIN_TABLE_H

#include <stdio.h>

#include "gain_data.h"

/* Gains over mmlt at equal time, variants by scenes. */
void gain_print_summary(FILE *out, const gain_scene_t *scenes, size_t count);
/* A table a scene: errors, stability, brightness, costs, acceptance. */
void gain_print_scenes(FILE *out, const gain_scene_t *scenes, size_t count);
/* Acceptance of each move, zero proposals and costs, by path length. */
void gain_print_moves(FILE *out, const gain_scene_t *scenes, size_t count);

#endif
