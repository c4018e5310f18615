#include "client/temp_folder.h"

#include <errno.h>
#include <ftw.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>

enum { OPEN_FOLDERS = 16 };

fault_code_t temp_folder_make(char path[TEMP_FOLDER_SIZE], fault_t *fault)
{
    static const char name[] = "/garland-XXXXXX";
    const char *parent = getenv("TMPDIR");
    if (!parent || parent[0] != '/' || strlen(parent) + sizeof name > TEMP_FOLDER_SIZE)
        parent = "/tmp";
    snprintf(path, TEMP_FOLDER_SIZE, "%.*s%s", (int)(TEMP_FOLDER_SIZE - sizeof name), parent, name);
    if (!mkdtemp(path))
        return fault_set(fault, FAULT_IO, "cannot make a temporary folder in %s: %s", parent, strerror(errno));
    return FAULT_NONE;
}

static int remove_one(const char *path, const struct stat *info, int type, struct FTW *where)
{
    (void)info;
    (void)type;
    (void)where;
    remove(path); /* what cannot be removed stays; its folder then says so */
    return 0;
}

void temp_folder_remove(const char *path)
{
    nftw(path, remove_one, OPEN_FOLDERS, FTW_DEPTH | FTW_PHYS);
}
