/* garland compare: how far an image, or a folder of them, is from references. */
#include <inttypes.h>
#include <stdio.h>
#include <stdlib.h>
#include <sys/stat.h>

#include "base/json.h"
#include "client/commands.h"
#include "client/compare_folders.h"
#include "client/options.h"
#include "client/remote.h"
#include "film/compare.h"
#include "film/image_file.h"
#include "film/png.h"

static const char usage[] =
    "usage: garland compare IMAGE REFERENCE [--json] [--reference2 FILE] [--heatmap FILE.png]\n"
    "       garland compare IMAGES REFERENCES [--json] [--csv FILE] [--heatmaps DIR]\n"
    "\n"
    "Compares OpenEXR or PFM images, two or all of two folders by their names without ending: MSE, relMSE (mean of "
    "(I-R)^2 / (R^2 + 0.01), scaled so that R's mean "
    "luminance is 1),\n"
    "error (its square root), relMSE without the worst 0.1 % of the pixels, bias (ratio of the means).\n"
    "\n"
    "  --json              as JSON\n"
    "  --reference2 FILE   a second, independent reference: the references' own noise then cancels\n"
    "  --heatmap FILE.png  the relative error of each pixel as a picture\n"
    "\n"
    "With folders:\n"
    "  --csv FILE          a row for each pair\n"
    "  --heatmaps DIR      a heat map of each pair, NAME.png, into DIR (made if missing)\n";

typedef struct comparison {
    image_t image, reference, second;
    bool two;
    compare_result_t result;
} comparison_t;

static void print_text(const compare_result_t *r)
{
    printf("size            %" PRIu32 " x %" PRIu32 "\n", r->width, r->height);
    printf("error           %.6g (%.3f %%)\n", r->error, 100 * r->error);
    printf("relMSE          %.6g\n", r->relmse);
    printf("relMSE trimmed  %.6g (without the worst %" PRIu64 " pixels)\n", r->relmse_trimmed, r->trimmed);
    printf("MSE             %.6g (reference scaled to a mean luminance of 1)\n", r->mse);
    printf("bias            %.6g (R %.6g, G %.6g, B %.6g)\n", r->bias, r->bias_rgb[0], r->bias_rgb[1],
           r->bias_rgb[2]);
    printf("worst pixel     (%" PRIu32 ", %" PRIu32 ") with %.6g\n", r->worst_x, r->worst_y, r->worst);
    if (r->nonfinite > 0)
        printf("not finite      %" PRIu64 " pixels, left out; the first is (%" PRIu32 ", %" PRIu32 ") of %s\n",
               r->nonfinite, r->nonfinite_x, r->nonfinite_y, r->nonfinite_name);
}

static json_t *blocks_json(const compare_result_t *r)
{
    json_t *blocks = json_new_array();
    for (uint32_t y = 0; y < r->grid; y++) {
        json_t *row = json_new_array();
        for (uint32_t x = 0; x < r->grid; x++)
            json_append(row, json_new_number(r->blocks[y * r->grid + x].ratio));
        json_append(blocks, row);
    }
    return blocks;
}

static void print_json(const compare_result_t *r)
{
    json_t *json = json_new_object(), *bias = json_new_array(), *worst = json_new_object();
    json_add_number(json, "width", r->width);
    json_add_number(json, "height", r->height);
    json_add_number(json, "error", r->error);
    json_add_number(json, "relmse", r->relmse);
    json_add_number(json, "error_trimmed", r->error_trimmed);
    json_add_number(json, "relmse_trimmed", r->relmse_trimmed);
    json_add_number(json, "trimmed_pixels", (double)r->trimmed);
    json_add_number(json, "mse", r->mse);
    json_add_number(json, "scale", r->scale);
    json_add_number(json, "bias", r->bias);
    for (int c = 0; c < 3; c++)
        json_append(bias, json_new_number(r->bias_rgb[c]));
    json_add(json, "bias_rgb", bias);
    json_add_number(worst, "x", r->worst_x);
    json_add_number(worst, "y", r->worst_y);
    json_add_number(worst, "value", r->worst);
    json_add(json, "worst_pixel", worst);
    json_add_number(json, "nonfinite_pixels", (double)r->nonfinite);
    json_add(json, "block_ratios", blocks_json(r));
    char *text = json_print(json, true);
    puts(text);
    free(text);
    json_destroy(&json);
}

static fault_code_t write_heat_map(const comparison_t *c, const char *path, fault_t *fault)
{
    image_t map;
    TRY(compare_heat_map(&map, &c->result, &c->image, &c->reference, c->two ? &c->second : NULL, fault));
    const fault_code_t code = png_write(&map, 1, path, fault);
    image_clear(&map);
    return code;
}

static fault_code_t compare(comparison_t *c, const char *const paths[3], const char *heat_map, fault_t *fault)
{
    const compare_options_t options = {.names = {paths[0], paths[1], paths[2]}};
    c->two = paths[2] != NULL;
    TRY(image_file_read(&c->image, paths[0], fault));
    TRY(image_file_read(&c->reference, paths[1], fault));
    if (c->two)
        TRY(image_file_read(&c->second, paths[2], fault));
    TRY(compare_images(&c->result, &c->image, &c->reference, c->two ? &c->second : NULL, &options, fault));
    return heat_map ? write_heat_map(c, heat_map, fault) : FAULT_NONE;
}

static int run_images(const char *const paths[3], const char *heat_map, bool as_json)
{
    comparison_t *comparison = calloc(1, sizeof *comparison);
    fault_t fault = {0};
    int status = STATUS_SUCCESS;
    if (!comparison)
        fault_set(&fault, FAULT_MEMORY, "out of memory");
    else
        compare(comparison, paths, heat_map, &fault);
    if (fault.code != FAULT_NONE)
        status = remote_fail(&fault);
    else if (as_json)
        print_json(&comparison->result);
    else
        print_text(&comparison->result);
    if (comparison) {
        image_clear(&comparison->image);
        image_clear(&comparison->reference);
        image_clear(&comparison->second);
    }
    free(comparison);
    return status;
}

static bool is_folder(const char *path)
{
    struct stat info;
    return stat(path, &info) == 0 && S_ISDIR(info.st_mode);
}

int command_compare(int argc, char **argv)
{
    const char *paths[3] = {NULL, NULL, NULL}, *heat_map = NULL;
    compare_folders_options_t folders = {0};
    int status;
    fault_t fault = {0};
    const option_t list[] = {{"json", OPTION_FLAG, &folders.json},         {"reference2", OPTION_TEXT, &paths[2]},
                             {"heatmap", OPTION_TEXT, &heat_map},          {"csv", OPTION_TEXT, &folders.csv},
                             {"heatmaps", OPTION_TEXT, &folders.heatmaps}, {0}};
    if (!options_parse("compare", usage, list, argc, argv, paths, 2, 2, &status))
        return status;
    if (is_folder(paths[0]) != is_folder(paths[1]))
        return options_refuse("compare", "%s is a folder and %s is not: two images or two folders are compared",
                              paths[!is_folder(paths[0])], paths[is_folder(paths[0])]);
    if (!is_folder(paths[0])) {
        if (folders.csv || folders.heatmaps)
            return options_refuse("compare", "--csv and --heatmaps go with folders");
        return run_images(paths, heat_map, folders.json);
    }
    if (paths[2] || heat_map)
        return options_refuse("compare", "--reference2 and --heatmap go with two images");
    return compare_folders(paths[0], paths[1], &folders, &fault) == FAULT_NONE ? STATUS_SUCCESS
                                                                               : remote_fail(&fault);
}
