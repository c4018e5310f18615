/* options.h: command lines of the benches: "--name value" pairs, lists with commas. */
#ifndef TESTS_BENCH_OPTIONS_H
#define TESTS_BENCH_OPTIONS_H

#include "base/json.h"
#include "chain/settings.h"
#include "peer_scene.h"

enum { OPTIONS_LIST = 64 };

typedef struct options_scenes {
    const peer_scene_t *entries[OPTIONS_LIST];
    size_t count;
} options_scenes_t;

typedef struct options_algorithms {
    settings_algorithm_t kinds[SETTINGS_ALGORITHMS];
    size_t count;
} options_algorithms_t;

typedef struct options_numbers {
    double values[OPTIONS_LIST];
    size_t count;
} options_numbers_t;

/* The value behind "--name"; null if it is not given. */
const char *options_value(int argc, char **argv, const char *name);
/* Every argument must be one of `names` (null-terminated) with a value: otherwise the program says so and ends with
 * status 2. So do the functions below about a value they cannot use. */
void options_expect(int argc, char **argv, const char *const *names);

double options_number(int argc, char **argv, const char *name, double usual, double least, double most);
/* "--name 1,2": at least one number. */
void options_numbers(options_numbers_t *list, int argc, char **argv, const char *name, const char *usual);
/* "--scenes a,b"; "usual" without the option. Names in the list must be there; of the usual ones those that are. */
void options_scenes(options_scenes_t *list, int argc, char **argv, const char *usual);
/* Writes the figures where "--json FILE" says, if it is there. */
void options_write_json(const json_t *figures, int argc, char **argv);
/* "--algorithms pt,bdpt,mmlt". */
void options_algorithms(options_algorithms_t *list, int argc, char **argv, const char *usual);

#endif
