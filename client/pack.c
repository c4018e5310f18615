/* garland pack: a scene file as a bundle. */
#include <inttypes.h>
#include <stdio.h>

#include "base/file.h"
#include "client/commands.h"
#include "client/options.h"
#include "client/remote.h"
#include "client/scene_source.h"

static const char usage[] =
    "usage: garland pack SCENE -o FILE\n"
    "\n"
    "Reads a scene (pbrt-v4 text with its meshes and images) and writes it as a bundle: one file, checked, named "
    "by the hash\n"
    "of its content. Prints the hash and what is in it. What could not be honoured is noted on standard error.\n"
    "\n"
    "  -o FILE, --output FILE   the bundle\n";

int command_pack(int argc, char **argv)
{
    const char *scene, *output = NULL;
    int status;
    const option_t list[] = {{"output", OPTION_TEXT, &output}, {0}};
    if (!options_parse("pack", usage, list, argc, argv, &scene, 1, 1, &status))
        return status;
    if (!output)
        return options_refuse("pack", "-o FILE is missing");
    fault_t fault = {0};
    digest_t digest;
    scene_counts_t counts;
    char text[DIGEST_TEXT_SIZE];
    if (scene_source_pack(scene, output, stderr, &digest, &counts, &fault) != FAULT_NONE)
        return remote_fail(&fault);
    digest_print(&digest, text);
    printf("%s\n", text);
    printf("%" PRIu64 " triangles, %" PRIu64 " vertices, %" PRIu32 " shapes, %" PRIu32 " materials, %" PRIu32
           " textures, %" PRIu32 " images (%.1f MB), %" PRIu32 " lights\n",
           counts.triangles, counts.vertices, counts.shapes, counts.materials, counts.textures, counts.images,
           1e-6 * (double)counts.texel_bytes, counts.lights);
    return STATUS_SUCCESS;
}
