/* matrix.h: what `garland bench` compares, as a file (docs/bench.md): scenes, variants of algorithms, budgets and
 * seeds.
 *
 *     {"scenes": [{"name": "glass", "scene": "glass.pbrt", "film": {"width": 64}, "max_path_length": 6}],
 *      "variants": [{"name": "bdpt", "algorithm": "bdpt"}, {"name": "auto", "algorithm": "auto"}],
 *      "budgets": {"seconds": [1, 2, 4]}, "seeds": 4, "workers": 2,
 *      "reference": {"algorithm": "bdpt", "seconds": 60}}
 *
 * Unknown fields, wrong types, numbers out of range and jobs that the job reader refuses are refused with their
 * place and what was expected. */
#ifndef CLIENT_BENCH_MATRIX_H
#define CLIENT_BENCH_MATRIX_H

#include "plan/job.h"

enum {
    MATRIX_SCENES = 64,
    MATRIX_VARIANTS = 32,
    MATRIX_BUDGETS = 16,
    MATRIX_SEEDS = 1000,
    MATRIX_NAME = 48,
    MATRIX_TEXT = 1024,
    MATRIX_BYTES = 1 << 20 /* of a file */
};

typedef struct matrix_scene {
    char name[MATRIX_NAME];
    char scene[JOB_PATH_SIZE], references[2][JOB_PATH_SIZE]; /* relative to the working folder, or absolute */
    size_t reference_count;                                  /* 0, 1, or 2 independent halves */
    char film[MATRIX_TEXT];                                  /* JSON object */
    uint32_t max_path_length;                                /* 0: the scene's */
} matrix_scene_t;

typedef struct matrix_variant {
    char name[MATRIX_NAME], algorithm[MATRIX_NAME];
    char chains[MATRIX_TEXT]; /* JSON object */
} matrix_variant_t;

typedef struct matrix {
    matrix_scene_t scenes[MATRIX_SCENES];
    size_t scene_count;
    matrix_variant_t variants[MATRIX_VARIANTS]; /* the first is what others are compared with */
    size_t variant_count;
    double budgets[MATRIX_BUDGETS]; /* ascending: CPU seconds, or mutations a pixel */
    size_t budget_count;
    bool by_mutations;
    size_t seeds;
    int workers;                 /* runs at a time */
    double limit_seconds;        /* wall time of a run */
    char reference[MATRIX_NAME]; /* algorithm of references that are made; empty: none are */
    double reference_seconds;    /* CPU, of each half */
} matrix_t;

/* `name` is the file's, for messages and for the folder that paths in it are relative to. */
fault_code_t matrix_parse(matrix_t *matrix, const char *text, size_t length, const char *name, fault_t *fault);
fault_code_t matrix_read(matrix_t *matrix, const char *path, fault_t *fault);

/* The job of one run, stopped by a budget. Its scene is the name. */
fault_code_t matrix_job(job_t *job, const matrix_t *matrix, size_t scene, size_t variant, uint64_t seed,
                        size_t budget, fault_t *fault);
/* The job of a reference's half (0 or 1): a seed of its own that no run has. */
fault_code_t matrix_reference_job(job_t *job, const matrix_t *matrix, size_t scene, int half, fault_t *fault);

#endif
