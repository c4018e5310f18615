#include "support.h"

#include <dirent.h>

#include "exr_samples.h"
#include "film/exr.h"
#include "film/image_file.h"

static const char *const NAMES[] = {
    "R",        "G",   "B", "stderr.R", "samples",
    "albedo.R", "N.X", "Z", "A",        "a.layer.whose.name.has.more.than.thirty-one.characters.R"};
enum { CHANNELS = sizeof NAMES / sizeof *NAMES };

/* Every kind of float, by its bits: NaN only as the quiet one, which any copy keeps. */
static void make_image(image_t *image, uint32_t width, uint32_t height)
{
    assert_ok(image_init(image, width, height, CHANNELS, NAMES, fault));
    for (size_t i = 0; i < (size_t)width * height * CHANNELS; i++) {
        const uint32_t bits = (uint32_t)random_u64(3, i);
        memcpy(&image->data[i], &bits, sizeof bits);
        if (isnan(image->data[i]))
            image->data[i] = NAN;
    }
}

static void assert_same_image(const image_t *a, const image_t *b)
{
    assert_int_equal(a->width, b->width);
    assert_int_equal(a->height, b->height);
    assert_int_equal(a->channel_count, b->channel_count);
    for (uint32_t c = 0; c < a->channel_count; c++) {
        const int other = image_find(b, a->names[c]);
        assert_true(other >= 0);
        assert_memory_equal(image_channel(a, c), image_channel(b, (uint32_t)other),
                            (size_t)a->width * a->height * sizeof(float));
    }
}

static void images_come_back_bit_for_bit(void **state)
{
    (void)state;
    static const uint32_t sizes[][2] = {{1, 1}, {16, 16}, {33, 17}, {3, 100}, {200, 5}};
    for (size_t i = 0; i < sizeof sizes / sizeof *sizes; i++) {
        image_t image, back;
        make_image(&image, sizes[i][0], sizes[i][1]);
        scratch_t scratch;
        scratch_open(&scratch, "a.exr");
        assert_ok(exr_write(&image, scratch.path, fault));
        assert_ok(exr_write(&image, scratch.path, fault)); /* over the one that is there */
        assert_ok(exr_read(&back, scratch.path, fault));
        assert_same_image(&image, &back);
        scratch_close(&scratch);
        image_clear(&image);
        image_clear(&back);
    }
}

static void attributes_come_back(void **state)
{
    (void)state;
    image_t image, back;
    make_image(&image, 5, 4);
    char *large = malloc(200001);
    memset(large, 'j', 200000);
    large[200000] = '\0';
    assert_ok(image_set_attribute(&image, "garland.job", "{\"seed\": \"3\"}", fault));
    assert_ok(image_set_attribute(&image, "an.attribute.with.a.name.of.more.than.31.bytes", "\xc3\xa4\n\"", fault));
    assert_ok(image_set_attribute(&image, "garland.report", large, fault));
    assert_ok(image_set_attribute(&image, "empty", "", fault));
    assert_ok(image_set_attribute(&image, "garland.job", "{\"seed\": \"4\"}", fault)); /* replaces */
    uint8_t *data;
    size_t size;
    assert_ok(exr_encode(&image, &data, &size, fault));
    assert_ok(exr_decode(&back, data, size, fault));
    assert_same_image(&image, &back);
    assert_int_equal(back.attribute_count, 4);
    assert_string_equal(image_attribute(&back, "garland.job"), "{\"seed\": \"4\"}");
    assert_string_equal(image_attribute(&back, "an.attribute.with.a.name.of.more.than.31.bytes"), "\xc3\xa4\n\"");
    assert_string_equal(image_attribute(&back, "garland.report"), large);
    assert_string_equal(image_attribute(&back, "empty"), "");
    assert_null(image_attribute(&back, "other"));
    free(data);
    free(large);
    image_clear(&back);
    assert_ok(image_set_attribute(&image, "channels", "R", fault));
    assert_fault(FAULT_RANGE, "\"channels\" is reserved", exr_encode(&image, &data, &size, fault));
    image_clear(&image);
}

static void impossible_places_are_named_and_left_clean(void **state)
{
    (void)state;
    image_t image, none;
    make_image(&image, 5, 4);
    scratch_t scratch;
    scratch_open(&scratch, "a.exr");
    char inside[160];
    snprintf(inside, sizeof inside, "%s/none/a.exr", scratch.folder);
    fault_t written = {0};
    assert_int_not_equal(exr_write(&image, inside, &written), FAULT_NONE);
    assert_non_null(strstr(written.text, inside));
    assert_int_not_equal(exr_write(&image, inside, NULL), FAULT_NONE);
    assert_int_not_equal(exr_write(&image, scratch.folder, &written), FAULT_NONE); /* a folder is in the way */
    assert_fault(FAULT_NOT_FOUND, inside, exr_read(&none, inside, fault));
    assert_int_equal(exr_read(&none, inside, NULL), FAULT_NOT_FOUND);
    assert_int_equal(image_file_read(&none, inside, NULL), FAULT_NOT_FOUND);
    assert_fault(FAULT_UNKNOWN, ".exr, .pfm or .png", image_file_write(&image, 1, "a.tiff", fault));
    scratch_close(&scratch);
    image_clear(&image);
}

static void truncated_files_are_refused(void **state)
{
    (void)state;
    image_t image, back;
    make_image(&image, 9, 40);
    uint8_t *data;
    size_t size;
    assert_ok(exr_encode(&image, &data, &size, fault));
    for (size_t cut = 0; cut < size; cut += cut < 1500 || cut + 98 > size ? 1 : 97) {
        uint8_t *exact = malloc(cut ? cut : 1);
        memcpy(exact, data, cut);
        fault_t fault = {0};
        assert_int_not_equal(exr_decode(&back, exact, cut, &fault), FAULT_NONE);
        assert_int_equal(exr_decode(&back, exact, cut, NULL), fault.code);
        assert_true(fault.text[0] != '\0');
        assert_null(back.data);
        free(exact);
    }
    free(data);
    image_clear(&image);
}

static void files_of_other_kinds_are_read(void **state)
{
    (void)state;
    for (int i = 0; i < EXR_SAMPLE_COUNT; i++) {
        const exr_sample_t *sample = &exr_samples[i];
        size_t size;
        uint8_t *data = exr_sample_make(sample, &size);
        image_t image;
        fault_t fault = {0};
        if (exr_decode(&image, data, size, &fault) != FAULT_NONE)
            fail_msg("%s: %s", sample->name, fault.text);
        assert_int_equal(image.width, sample->width);
        assert_int_equal(image.height, sample->height);
        assert_int_equal(image.channel_count, EXR_SAMPLE_CHANNELS);
        assert_string_equal(image_attribute(&image, "comments"), "a sample");
        assert_int_equal(image.attribute_count, 1);
        for (uint32_t c = 0; c < EXR_SAMPLE_CHANNELS; c++)
            for (int32_t y = 0; y < sample->height; y++)
                for (int32_t x = 0; x < sample->width; x++) {
                    const double found = (double)image_channel(&image, c)[y * sample->width + x],
                                 expected = exr_sample_value((int)c, x, y);
                    if (!(fabs(found - expected) <= sample->tolerance))
                        fail_msg("%s: channel %u at (%d,%d) is %g, not %g", sample->name, c, x, y, found, expected);
                }
        free(data);
        image_clear(&image);
    }
}

static void unsupported_kinds_are_refused_by_name(void **state)
{
    (void)state;
    image_t image;
    size_t size;
    uint8_t *data = exr_sample_make_header(1, &size);
    assert_fault(FAULT_UNSUPPORTED, "deep", exr_decode(&image, data, size, fault));
    free(data);
    data = exr_sample_make_header(0, &size);
    assert_fault(FAULT_UNSUPPORTED, "subsampled by 2 x 2", exr_decode(&image, data, size, fault));
    free(data);
    assert_fault(FAULT_FORMAT, "not an OpenEXR file", exr_decode(&image, (const uint8_t *)"PF\n1", 4, fault));
}

static void a_small_file_cannot_claim_a_large_image(void **state)
{
    (void)state;
    image_t image, back;
    assert_ok(image_init_rgb(&image, 2, 2, fault));
    uint8_t *data;
    size_t size;
    assert_ok(exr_encode(&image, &data, &size, fault));
    /* dataWindow's value: 0 0 1 1, behind its name, type and size */
    uint8_t *at = memmem(data, size, "dataWindow\0box2i\0\x10\0\0", 21);
    assert_non_null(at);
    at += 21;
    at[9] = 0x7f, at[13] = 0x7f; /* xMax = yMax = 0x7f01: 12 GB of pixels */
    assert_fault(FAULT_LIMIT, "claim to hold 32514 x 32514", exr_decode(&back, data, size, fault));
    at[10] = 1;
    assert_int_not_equal(exr_decode(&back, data, size, NULL), FAULT_NONE);
    free(data);
    image_clear(&image);
}

static void channel_names_are_checked(void **state)
{
    (void)state;
    image_t image;
    char text[300];
    memset(text, 'n', sizeof text);
    text[299] = '\0';
    const char *const twice[] = {"R", "G", "R"}, *const empty[] = {""}, *const large[] = {text};
    assert_fault(FAULT_RANGE, "\"R\" occurs twice", image_init(&image, 2, 2, 3, twice, fault));
    assert_fault(FAULT_RANGE, "name of 0 bytes", image_init(&image, 2, 2, 1, empty, fault));
    assert_fault(FAULT_RANGE, "name of 299 bytes", image_init(&image, 2, 2, 1, large, fault));
    assert_fault(FAULT_RANGE, "0 channels", image_init(&image, 2, 2, 0, large, fault));
    assert_fault(FAULT_RANGE, "40000 x 2", image_init_rgb(&image, 40000, 2, fault));
    assert_null(image.data);
    text[255] = '\0'; /* OpenEXR's longest */
    assert_ok(image_init(&image, 2, 2, 1, large, fault));
    uint8_t *data;
    size_t size;
    image_t back;
    assert_ok(exr_encode(&image, &data, &size, fault));
    assert_ok(exr_decode(&back, data, size, fault));
    assert_string_equal(back.names[0], text);
    free(data);
    image_clear(&image);
    image_clear(&back);
}

/* Reads the images of a folder; where one exists as EXR and as PFM, they must agree. Returns how many were read. */
static int read_folder(const char *path)
{
    DIR *folder = opendir(path);
    int count = 0;
    for (struct dirent *entry; folder && (entry = readdir(folder));) {
        const char *ending = strrchr(entry->d_name, '.');
        if (!ending || (strcmp(ending, ".exr") != 0 && strcmp(ending, ".pfm") != 0))
            continue;
        char file[1024], other[1024];
        snprintf(file, sizeof file, "%s/%s", path, entry->d_name);
        snprintf(other, sizeof other, "%.*s.pfm", (int)(strlen(file) - 4), file);
        image_t image, twin;
        const float *planes[3], *twins[3];
        assert_ok(image_file_read(&image, file, fault));
        assert_ok(image_find_rgb(&image, planes, fault));
        if (strcmp(ending, ".exr") == 0 && access(other, R_OK) == 0) {
            assert_ok(image_file_read(&twin, other, fault));
            assert_ok(image_find_rgb(&twin, twins, fault));
            assert_int_equal((int)twin.width, image.width);
            for (int c = 0; c < 3; c++)
                for (size_t i = 0; i < (size_t)image.width * image.height; i++) /* the EXR may hold halves */
                    assert_near((double)planes[c][i], (double)twins[c][i],
                                0x1p-11 * fabs((double)twins[c][i]) + 0x1p-25);
            image_clear(&twin);
        }
        image_clear(&image);
        count++;
    }
    if (folder)
        closedir(folder);
    return count;
}

static void images_of_other_renderers_are_read(void **state)
{
    (void)state;
    const char *shared = getenv("GARLAND_SHARED");
    if (!shared || access(shared, R_OK) != 0) {
        print_message("GARLAND_SHARED is not set: no images of other renderers to read\n");
        skip();
    }
    static const char *const folders[] = {"peers/pbrt/refs",    "peers/tungsten/refs", "scenes/coffee",
                                          "scenes/cornell-box", "scenes/staircase2",   "scenes/veach-ajar",
                                          "scenes/veach-bidir", "scenes/veach-mis",    "scenes/water-caustic"};
    for (size_t i = 0; i < sizeof folders / sizeof *folders; i++) {
        char path[512];
        snprintf(path, sizeof path, "%s/%s", shared, folders[i]);
        assert_true(read_folder(path) > 0);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(images_come_back_bit_for_bit),
        cmocka_unit_test(attributes_come_back),
        cmocka_unit_test(impossible_places_are_named_and_left_clean),
        cmocka_unit_test(truncated_files_are_refused),
        cmocka_unit_test(files_of_other_kinds_are_read),
        cmocka_unit_test(unsupported_kinds_are_refused_by_name),
        cmocka_unit_test(a_small_file_cannot_claim_a_large_image),
        cmocka_unit_test(channel_names_are_checked),
        cmocka_unit_test(images_of_other_renderers_are_read),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
