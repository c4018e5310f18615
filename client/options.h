/* options.h: the command line of a subcommand: long options in any place, the rest are arguments. -o is --output
 * where there is such an option; there are no other short ones.
 *
 *     const char *out = NULL;
 *     const option_t list[] = {{"out", OPTION_TEXT, &out}, {0}};
 *     const char *arguments[1];
 *     int status;
 *     if (!options_parse("render", usage, list, argc, argv, arguments, 1, 1, &status))
 *         return status;
 */
#ifndef CLIENT_OPTIONS_H
#define CLIENT_OPTIONS_H

#include <stdbool.h>

/* Exit statuses of every subcommand. */
enum { STATUS_SUCCESS = 0, STATUS_FAILURE = 1, STATUS_USAGE = 2 };

typedef enum option_kind {
    OPTION_FLAG = 0, /* bool */
    OPTION_TEXT = 1, /* const char *; borrowed from argv */
    OPTION_COUNT = 2 /* int, at least 1 */
} option_kind_t;

typedef struct option {
    const char *name; /* without dashes; null ends a list */
    option_kind_t kind;
    void *target;
} option_t;

/* False: the program ends with *status (--help was printed, or the usage is wrong and that was said). argv begins
 * after the subcommand's name. `least` to `most` arguments are expected; missing ones are null. */
bool options_parse(const char *command, const char *usage, const option_t *list, int argc, char **argv,
                   const char **arguments, int least, int most, int *status);

/* Says what is wrong with the usage and where to look; returns STATUS_USAGE. */
int options_refuse(const char *command, const char *format, ...) __attribute__((format(printf, 2, 3)));

/* The name in a null-terminated list that is nearest to what was typed, or null if none is near. */
const char *options_nearest(const char *typed, const char *const *names);

#endif
