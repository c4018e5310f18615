/* pixel_digest FILE.exr...: a line for each, the digest of the planes R, G and B: equal lines are equal bits. */
#include <stdio.h>
#include <stdlib.h>

#include "base/digest.h"
#include "film/exr.h"

int main(int argc, char **argv)
{
    for (int i = 1; i < argc; i++) {
        image_t image;
        const float *planes[3];
        fault_t fault = {0};
        digest_t parts[3], all;
        char text[DIGEST_TEXT_SIZE];
        if (exr_read(&image, argv[i], &fault) != FAULT_NONE ||
            image_find_rgb(&image, planes, &fault) != FAULT_NONE) {
            fprintf(stderr, "%s\n", fault.text);
            return EXIT_FAILURE;
        }
        for (int c = 0; c < 3; c++)
            digest_of(&parts[c], planes[c], (size_t)image.width * image.height * sizeof(float));
        digest_of(&all, parts, sizeof parts);
        digest_print(&all, text);
        puts(text);
        image_clear(&image);
    }
    return EXIT_SUCCESS;
}
