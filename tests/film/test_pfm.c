#include "support.h"

#include <math.h>

#include "film/pfm.h"

static void fill(image_t *image, uint64_t stream)
{
    for (size_t i = 0; i < (size_t)image->width * image->height * image->channel_count; i++)
        image->data[i] = (float)(uniform(stream, i) * 1000 - 10);
}

static void colour_and_grey_round_trip(void **state)
{
    (void)state;
    static const char *const grey[] = {"Y"};
    for (int kind = 0; kind < 2; kind++) {
        image_t image, back;
        if (kind == 0)
            assert_ok(image_init_rgb(&image, 23, 17, fault));
        else
            assert_ok(image_init(&image, 23, 17, 1, grey, fault));
        fill(&image, 1);
        image.data[5] = INFINITY;
        image.data[6] = 1e-42f; /* a denormal */
        scratch_t scratch;
        scratch_open(&scratch, "a.pfm");
        assert_ok(pfm_write(&image, scratch.path, fault));
        assert_ok(pfm_read(&back, scratch.path, fault));
        assert_int_equal(back.channel_count, kind == 0 ? 3 : 1);
        assert_string_equal(back.names[0], kind == 0 ? "R" : "Y");
        assert_memory_equal(image.data, back.data, (size_t)23 * 17 * image.channel_count * sizeof(float));
        scratch_close(&scratch);
        image_clear(&image);
        image_clear(&back);
    }
}

/* 1 x 2 pixels by hand: 1.0f is 3f800000, 2.0f 40000000; the file starts with the bottom row. */
static void rows_run_from_the_bottom_in_either_byte_order(void **state)
{
    (void)state;
    static const uint8_t little[] = "Pf\n1 2\n-1\n\0\0\x80\x3f\0\0\0\x40",
                         big[] = "Pf 1\n2 2.5\n\x3f\x80\0\0\x40\0\0\0";
    image_t image;
    assert_ok(pfm_decode(&image, little, sizeof little - 1, fault));
    assert_true(image.data[0] == 2 && image.data[1] == 1);
    image_clear(&image);
    assert_ok(pfm_decode(&image, big, sizeof big - 1, fault)); /* in units of 2.5 */
    assert_true(image.data[0] == 5 && image.data[1] == 2.5f);
    uint8_t *data;
    size_t size;
    assert_ok(pfm_encode(&image, &data, &size, fault));
    assert_int_equal(size, sizeof little - 1);
    assert_memory_equal(data, "Pf\n1 2\n-1\n\0\0\x20\x40\0\0\xa0\x40", size);
    free(data);
    image_clear(&image);
}

static void channels_are_interleaved(void **state)
{
    (void)state;
    uint8_t file[64] = "PF\n2 1\n-1\n";
    const float values[6] = {1, 2, 3, 4, 5, 6};
    memcpy(file + 10, values, sizeof values);
    image_t image;
    assert_ok(pfm_decode(&image, file, 10 + sizeof values, fault));
    assert_true(image_channel(&image, 0)[1] == 4 && image_channel(&image, 1)[0] == 2 &&
                image_channel(&image, 2)[1] == 6);
    image_clear(&image);
}

static void malformed_files_are_refused_by_name(void **state)
{
    (void)state;
    const struct {
        const char *text, *piece;
        fault_code_t code;
    } cases[] = {
        {"", "byte 0", FAULT_FORMAT},
        {"P6\n1 1\n-1\n    ", "byte 0", FAULT_FORMAT},
        {"PFx\n1 1\n-1\n    ", "byte 0", FAULT_FORMAT},
        {"Pf", "byte 0", FAULT_FORMAT},
        {"Pf\n-1 1\n-1\n    ", "width \"-1\"", FAULT_FORMAT},
        {"Pf\n1.5 1\n-1\n    ", "width \"1.5\"", FAULT_FORMAT},
        {"Pf\n1 q\n-1\n    ", "height \"q\"", FAULT_FORMAT},
        {"Pf\n1 1\n0\n    ", "scale \"0\"", FAULT_FORMAT},
        {"Pf\n1 1\nnan\n    ", "scale \"nan\"", FAULT_FORMAT},
        {"Pf\n1 1\n1e999\n    ", "scale \"1e999\"", FAULT_FORMAT},
        {"Pf\n1 1\n-1", "scale", FAULT_FORMAT},
        {"Pf\n1 1\n-1\n   ", "13 bytes found, 14 expected", FAULT_FORMAT},
        {"Pf\n1 1\n-1\n     ", "15 bytes found, 14 expected", FAULT_FORMAT},
        {"Pf\n0 1\n-1\n", "0 x 1", FAULT_RANGE},
        {"Pf\n99999 99999\n-1\n", "99999 x 99999", FAULT_RANGE},
        {"Pf\n18446744073709551617 1\n-1\n    ", "4294967295 x 1", FAULT_RANGE},
        {"Pf\n32768 32768\n-1\n    ", "4294967314 expected", FAULT_FORMAT}, /* nothing is allocated for it */
    };
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        image_t image;
        const size_t size = strlen(cases[i].text);
        uint8_t *exact = malloc(size ? size : 1);
        memcpy(exact, cases[i].text, size);
        assert_fault(cases[i].code, cases[i].piece, pfm_decode(&image, exact, size, fault));
        assert_null(image.data);
        free(exact);
    }
}

static void file_faults_name_the_file(void **state)
{
    (void)state;
    image_t image, none;
    static const char *const depth[] = {"Z"};
    assert_ok(image_init(&image, 1, 1, 1, depth, fault));
    assert_fault(FAULT_NOT_FOUND, "/nowhere/a.pfm", pfm_read(&none, "/nowhere/a.pfm", fault));
    assert_fault(FAULT_NOT_FOUND, "found Z", pfm_write(&image, "b.pfm", fault));
    assert_fault(FAULT_NOT_FOUND, "b.pfm", pfm_write(&image, "b.pfm", fault));
    assert_int_equal(pfm_write(&image, "b.pfm", NULL), FAULT_NOT_FOUND); /* without a fault object too */
    image_clear(&image);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(colour_and_grey_round_trip),
        cmocka_unit_test(rows_run_from_the_bottom_in_either_byte_order),
        cmocka_unit_test(channels_are_interleaved),
        cmocka_unit_test(malformed_files_are_refused_by_name),
        cmocka_unit_test(file_faults_name_the_file),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
