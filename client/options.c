#include "client/options.h"

#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { NEAREST_LENGTH = 32, NEAREST_DISTANCE = 2, MOST_OPTIONS = 32, MOST_COUNT = 65536 };

int options_refuse(const char *command, const char *format, ...)
{
    char text[1024];
    va_list args;
    va_start(args, format);
    vsnprintf(text, sizeof text, format, args);
    va_end(args);
    fprintf(stderr, "garland: %s\nTry: garland %s%s--help\n", text, command, command[0] ? " " : "");
    return STATUS_USAGE;
}

/* Edit distance (Wagner and Fischer 1974), one row at a time. */
static size_t distance(const char *a, const char *b)
{
    size_t row[NEAREST_LENGTH + 1];
    const size_t m = strlen(a), n = strlen(b);
    if (m > NEAREST_LENGTH || n > NEAREST_LENGTH)
        return NEAREST_LENGTH;
    for (size_t j = 0; j <= n; j++)
        row[j] = j;
    for (size_t i = 1; i <= m; i++) {
        size_t diagonal = row[0];
        row[0] = i;
        for (size_t j = 1; j <= n; j++) {
            const size_t replace = diagonal + (a[i - 1] != b[j - 1]);
            const size_t insert = (row[j] < row[j - 1] ? row[j] : row[j - 1]) + 1;
            diagonal = row[j];
            row[j] = replace < insert ? replace : insert;
        }
    }
    return row[n];
}

const char *options_nearest(const char *typed, const char *const *names)
{
    const char *best = NULL;
    size_t least = NEAREST_DISTANCE + 1;
    for (; *names; names++) {
        const size_t d = distance(typed, *names);
        if (d < least) {
            least = d;
            best = *names;
        }
    }
    return best;
}

static int refuse_unknown(const char *command, const option_t *list, const char *name)
{
    const char *names[MOST_OPTIONS + 2] = {"help"};
    for (int i = 0; i < MOST_OPTIONS && list[i].name; i++)
        names[i + 1] = list[i].name;
    const char *near = options_nearest(name, names);
    if (near)
        return options_refuse(command, "unknown option --%s; did you mean --%s?", name, near);
    return options_refuse(command, "unknown option --%s", name);
}

/* Takes one option; true if it used the next word of the command line too. */
static bool take_option(const char *command, const option_t *list, char *word, const char *next, int *status)
{
    char *value = strchr(word, '=');
    if (value)
        *value++ = '\0';
    while (list->name && strcmp(list->name, word) != 0)
        list++;
    if (list->kind == OPTION_FLAG) {
        if (value)
            *status = options_refuse(command, "--%s takes no value", word);
        else
            *(bool *)list->target = true;
        return false;
    }
    const char *text = value ? value : next;
    if (!text) {
        *status = options_refuse(command, "--%s: a value is missing", word);
        return false;
    }
    if (list->kind == OPTION_TEXT) {
        *(const char **)list->target = text;
    } else {
        char *end;
        const long count = strtol(text, &end, 10);
        if (end == text || *end != '\0' || count < 1 || count > MOST_COUNT)
            *status = options_refuse(command, "--%s: found \"%s\", expected a number from 1 to %d", word, text,
                                     MOST_COUNT);
        else
            *(int *)list->target = (int)count;
    }
    return !value;
}

static bool is_known(const option_t *list, const char *word)
{
    const size_t length = strcspn(word, "=");
    for (; list->name; list++)
        if (strlen(list->name) == length && strncmp(list->name, word, length) == 0)
            return true;
    return false;
}

bool options_parse(const char *command, const char *usage, const option_t *list, int argc, char **argv,
                   const char **arguments, int least, int most, int *status)
{
    int count = 0;
    bool only_arguments = false;
    *status = -1;
    for (int i = 0; i < most; i++)
        arguments[i] = NULL;
    for (int i = 0; i < argc && *status < 0; i++) {
        char *word = argv[i];
        if (only_arguments || word[0] != '-' || word[1] == '\0') {
            if (count == most)
                *status = options_refuse(command, "unexpected argument \"%s\"", word);
            else
                arguments[count++] = word;
        } else if (strcmp(word, "--") == 0) {
            only_arguments = true;
        } else if (strcmp(word, "--help") == 0 || strcmp(word, "-h") == 0) {
            fputs(usage, stdout);
            *status = STATUS_SUCCESS;
        } else if (strcmp(word, "-o") == 0 && is_known(list, "output")) {
            static char output[] = "output";
            i += take_option(command, list, output, i + 1 < argc ? argv[i + 1] : NULL, status);
        } else if (word[1] != '-') {
            *status = options_refuse(command, "unknown option %s", word);
        } else if (!is_known(list, word + 2)) {
            *status = refuse_unknown(command, list, word + 2);
        } else if (take_option(command, list, word + 2, i + 1 < argc ? argv[i + 1] : NULL, status)) {
            i++;
        }
    }
    if (*status < 0 && count < least)
        *status = options_refuse(command, "an argument is missing");
    return *status < 0;
}
