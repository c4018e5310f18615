#include "film/image_file.h"

#include <stdlib.h>
#include <string.h>
#include <strings.h>

#include "base/file.h"
#include "film/exr.h"
#include "film/pfm.h"
#include "film/png.h"

fault_code_t image_file_read(image_t *image, const char *path, fault_t *fault)
{
    *image = (image_t){0};
    uint8_t *data;
    size_t size;
    TRY(file_read(path, IMAGE_MAX_FILE_BYTES, &data, &size, fault));
    fault_code_t code;
    if (size > 0 && data[0] == 0x76)
        code = exr_decode(image, data, size, fault);
    else if (size > 0 && data[0] == 'P')
        code = pfm_decode(image, data, size, fault);
    else
        code = fault_set(fault, FAULT_FORMAT, "neither an OpenEXR nor a PFM file");
    free(data);
    return fault_prefix(fault, code, "%s", path);
}

fault_code_t image_file_write(const image_t *image, double exposure, const char *path, fault_t *fault)
{
    const char *ending = strrchr(path, '.');
    if (ending && strcasecmp(ending, ".exr") == 0)
        return exr_write(image, path, fault);
    if (ending && strcasecmp(ending, ".pfm") == 0)
        return pfm_write(image, path, fault);
    if (ending && strcasecmp(ending, ".png") == 0)
        return png_write(image, exposure, path, fault);
    return fault_set(fault, FAULT_UNKNOWN, "%s: expected a name that ends in .exr, .pfm or .png", path);
}
