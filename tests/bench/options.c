#include "options.h"

#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "base/file.h"
#include "fail.h"

enum { TEXT_SIZE = 1024 };

__attribute__((noreturn, format(printf, 2, 3))) static void options_fail(const char *program, const char *format,
                                                                         ...)
{
    va_list args;
    fprintf(stderr, "%s: ", program);
    va_start(args, format);
    vfprintf(stderr, format, args);
    va_end(args);
    fputc('\n', stderr);
    exit(2);
}

const char *options_value(int argc, char **argv, const char *name)
{
    for (int i = 1; i + 1 < argc; i += 2)
        if (strcmp(argv[i], name) == 0)
            return argv[i + 1];
    return NULL;
}

void options_expect(int argc, char **argv, const char *const *names)
{
    for (int i = 1; i < argc; i += 2) {
        int known = 0;
        for (const char *const *name = names; *name; name++)
            known |= strcmp(argv[i], *name) == 0;
        if (known && i + 1 < argc)
            continue;
        char list[TEXT_SIZE] = "";
        for (const char *const *name = names; *name; name++)
            snprintf(list + strlen(list), sizeof list - strlen(list), " %s", *name);
        options_fail(argv[0], "%s%s, expected pairs of%s and a value", argv[i], known ? " has no value" : "", list);
    }
}

static double options_parse(const char *program, const char *name, const char *text, double least, double most)
{
    char *end;
    const double value = strtod(text, &end);
    if (end == text || *end || !(value >= least && value <= most))
        options_fail(program, "%s: %s, expected a number from %g to %g", name, text, least, most);
    return value;
}

double options_number(int argc, char **argv, const char *name, double usual, double least, double most)
{
    const char *text = options_value(argc, argv, name);
    return text ? options_parse(argv[0], name, text, least, most) : usual;
}

/* Calls take with each word of the list. */
static void options_words(const char *program, const char *name, const char *text,
                          void (*take)(void *user, const char *program, const char *word), void *user)
{
    char copy[TEXT_SIZE], *rest;
    if (strlen(text) >= sizeof copy)
        options_fail(program, "%s: the list is longer than %d bytes", name, TEXT_SIZE - 1);
    strcpy(copy, text);
    for (char *word = strtok_r(copy, ",", &rest); word; word = strtok_r(NULL, ",", &rest))
        take(user, program, word);
}

static void take_number(void *user, const char *program, const char *word)
{
    options_numbers_t *list = user;
    if (list->count == OPTIONS_LIST)
        options_fail(program, "more than %d numbers", OPTIONS_LIST);
    list->values[list->count++] = options_parse(program, "list", word, 1e-6, 1e9);
}

void options_numbers(options_numbers_t *list, int argc, char **argv, const char *name, const char *usual)
{
    const char *text = options_value(argc, argv, name);
    *list = (options_numbers_t){0};
    options_words(argv[0], name, text ? text : usual, take_number, list);
}

static void take_scene(void *user, const char *program, const char *word)
{
    options_scenes_t *list = user;
    const peer_scene_t *entry = peer_scene_find(word);
    if (!entry)
        options_fail(program, "--scenes: there is no scene %s", word);
    if (list->count == OPTIONS_LIST)
        options_fail(program, "--scenes: more than %d scenes", OPTIONS_LIST);
    list->entries[list->count++] = entry;
}

void options_scenes(options_scenes_t *list, int argc, char **argv, const char *usual)
{
    const char *text = options_value(argc, argv, "--scenes");
    *list = (options_scenes_t){0};
    options_words(argv[0], "--scenes", text ? text : usual, take_scene, list);
    size_t kept = 0;
    for (size_t i = 0; i < list->count; i++) {
        if (peer_scene_present(list->entries[i]))
            list->entries[kept++] = list->entries[i];
        else if (text)
            options_fail(argv[0], "%s is not there: GARLAND_SHARED or GARLAND_TESTS does not name its folder",
                         list->entries[i]->name);
    }
    list->count = kept;
}

static void take_algorithm(void *user, const char *program, const char *word)
{
    options_algorithms_t *list = user;
    for (int kind = 0; kind < SETTINGS_ALGORITHMS; kind++)
        if (strcmp(word, settings_algorithm_name((settings_algorithm_t)kind)) == 0 &&
            list->count < SETTINGS_ALGORITHMS) {
            list->kinds[list->count++] = (settings_algorithm_t)kind;
            return;
        }
    options_fail(program, "--algorithms: %s, expected some of pt, bdpt, mmlt", word);
}

void options_algorithms(options_algorithms_t *list, int argc, char **argv, const char *usual)
{
    const char *text = options_value(argc, argv, "--algorithms");
    *list = (options_algorithms_t){0};
    options_words(argv[0], "--algorithms", text ? text : usual, take_algorithm, list);
}

void options_write_json(const json_t *figures, int argc, char **argv)
{
    const char *path = options_value(argc, argv, "--json");
    fault_t fault = {0};
    if (!path)
        return;
    char *text = json_print(figures, true);
    if (file_write(path, text, strlen(text), &fault))
        bench_fail(&fault);
    free(text);
}
