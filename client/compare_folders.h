/* compare_folders.h: the images of a folder against those of another, paired by name without ending. */
#ifndef CLIENT_COMPARE_FOLDERS_H
#define CLIENT_COMPARE_FOLDERS_H

#include <stdbool.h>

#include "base/fault.h"

enum { COMPARE_FOLDERS_MOST = 4096 /* images in a folder */ };

typedef struct compare_folders_options {
    bool json;            /* print JSON in place of a table */
    const char *csv;      /* a file for the same as CSV; null: none */
    const char *heatmaps; /* a folder for a heat map of each pair, NAME.png (made if missing); null: none */
} compare_folders_options_t;

/* Compares every .exr and .pfm of `images` with that of the same stem in `references` and prints a table with means
 * and medians. Unpaired files are named. A pair that cannot be compared is a row with the reason, and the fault at
 * the end says how many there were; FAULT_NOT_FOUND if there is no pair. */
fault_code_t compare_folders(const char *images, const char *references, const compare_folders_options_t *options,
                             fault_t *fault);

#endif
