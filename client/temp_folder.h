/* temp_folder.h: a private folder that is gone afterwards. */
#ifndef CLIENT_TEMP_FOLDER_H
#define CLIENT_TEMP_FOLDER_H

#include <stddef.h>

#include "base/fault.h"

enum { TEMP_FOLDER_SIZE = 96 /* so that a socket's name fits in behind it: 108 bytes on Linux */ };

/* Makes one below $TMPDIR, or /tmp where that is unset or too long; nobody else may enter (mode 700). */
fault_code_t temp_folder_make(char path[TEMP_FOLDER_SIZE], fault_t *fault);
/* Removes a folder with all that is in it; does not follow links. */
void temp_folder_remove(const char *path);

#endif
