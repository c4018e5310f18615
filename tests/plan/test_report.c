/* Reports: every field is in docs/reports.md, and what can be worked out in a second way agrees. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#include "plan/plan_fixture.h"

static char document[1 << 16];

static int read_document(void **state)
{
    (void)state;
    FILE *file = fopen(REPORTS_DOCUMENT, "rb");
    assert_non_null(file);
    const size_t size = fread(document, 1, sizeof document - 1, file);
    fclose(file);
    assert_true(size > 1000);
    return 0;
}

static json_t *report_of(const char *algorithm, bool diffuse)
{
    char text[256];
    snprintf(text, sizeof text,
             "{'scene':'x','algorithm':'%s','max_path_length':5,'chains':{'shift':true,'length':64},"
             "'stop':{'mutations_per_pixel':40}}",
             algorithm);
    const job_t job = plan_fixture_job(text);
    small_scene_t small;
    plan_worker_t worker;
    if (diffuse)
        small_scene_diffuse(&small);
    else
        small_scene_box(&small, SMALL_LIGHT_AREA);
    plan_worker_make(&worker, &job, &small.scene);
    plan_t *plan = plan_fixture_new(&job, &small.scene);
    plan_fixture_run(plan, &worker, 0.25);
    json_t *report = plan_report(plan);
    plan_destroy(&plan);
    plan_worker_clear(&worker);
    small_scene_clear(&small);
    return report;
}

static void assert_documented(const json_t *value)
{
    for (const json_t *member = json_first(value); member; member = json_next(member)) {
        char name[128];
        if (json_name(member)) {
            snprintf(name, sizeof name, "`%s`", json_name(member));
            if (!strstr(document, name))
                fail_msg("%s is not in docs/reports.md", name);
            if (strcmp(json_name(member), "job") == 0)
                continue; /* docs/jobs.md */
        }
        assert_documented(member);
    }
}

static void every_field_is_documented(void **state)
{
    (void)state;
    static const char *const algorithms[] = {"mmlt", "bdpt", "pt", "pssmlt"};
    for (int a = 0; a < 4; a++) {
        json_t *report = report_of(algorithms[a], false);
        assert_documented(report);
        assert_string_equal(json_string(json_get(report, "algorithm")), algorithms[a]);
        json_destroy(&report);
    }
}

static double number(const json_t *object, const char *name)
{
    const json_t *value = json_get(object, name);
    if (!value || !json_is_number(value))
        fail_msg("no number \"%s\"", name);
    return json_number(value);
}

static void numbers_agree_with_each_other(void **state)
{
    (void)state;
    json_t *report = report_of("mmlt", true);
    const json_t *rates = json_get(report, "rates"), *lengths = json_get(report, "lengths");
    assert_true(number(rates, "mutations") == 40 * 24 * 24 && number(rates, "mutations_per_pixel") == 40);
    assert_true(number(rates, "shadow_rays") < number(rates, "rays"));
    assert_string_equal(json_string(json_get(report, "stopped_by")), "mutations_per_pixel");
    const json_t *error = json_get(report, "error");
    assert_true(fabs(number(error, "error") * number(error, "error") / number(error, "relmse") - 1) < 1e-12);
    assert_int_equal(json_size(lengths), 5);
    double mutations = 0, share = 0;
    for (const json_t *length = json_first(lengths); length; length = json_next(length)) {
        const json_t *b = json_get(length, "b"), *moves = json_get(length, "moves");
        double proposed = 0, parts = 0;
        for (const json_t *move = json_first(moves); move; move = json_next(move)) {
            proposed += number(move, "proposed");
            assert_true(number(move, "acceptance") > 0 && number(move, "acceptance") <= 1);
        }
        assert_true(proposed == number(length, "mutations"));
        assert_true(number(length, "zero_contribution") < proposed);
        for (const json_t *t = json_first(json_get(length, "techniques")); t; t = json_next(t))
            parts += number(t, "value");
        /* Means of the same samples with the same weights: equal but for rounding. */
        if (!(fabs(parts - number(b, "value")) <= 1e-9 * number(b, "value")))
            fail_msg("length %g: techniques add up to %.17g, b is %.17g", number(length, "length"), parts,
                     number(b, "value"));
        mutations += number(length, "mutations");
        share += number(length, "share");
    }
    assert_true(mutations == 40 * 24 * 24);
    assert_true(fabs(share - 1) < 1e-12);
    const json_t *rejected = json_get(report, "rejected");
    for (const json_t *count = json_first(rejected); count; count = json_next(count))
        assert_true(json_number(count) == 0);
    json_destroy(&report);
}

/* Chains of all lengths are told of once. */
static void chains_of_all_lengths_have_their_own_place(void **state)
{
    (void)state;
    json_t *report = report_of("pssmlt", true);
    const json_t *chains = json_get(report, "chains"), *lengths = json_get(report, "lengths");
    double proposed = 0, b = 0;
    for (const json_t *move = json_first(json_get(chains, "moves")); move; move = json_next(move)) {
        proposed += number(move, "proposed");
        assert_true(number(move, "acceptance") > 0 && number(move, "acceptance") <= 1);
    }
    assert_true(proposed == 40 * 24 * 24 && number(chains, "mutations") == proposed);
    assert_true(number(chains, "zero_contribution") < proposed && number(chains, "chains") >= 16);
    assert_int_equal(json_size(lengths), 5);
    for (const json_t *length = json_first(lengths); length; length = json_next(length)) {
        assert_true(!json_get(length, "moves") && !json_get(length, "share") && !json_get(length, "chains"));
        b += number(json_get(length, "b"), "value");
    }
    assert_true(b > 0);
    json_destroy(&report);
    report = report_of("mmlt", true);
    assert_null(json_get(report, "chains"));
    json_destroy(&report);
}

/* Several algorithms, one b_k: within 6 standard errors, a false alarm in 2e-8 for the ten of them. */
static void check_b(const char *one, const char *other)
{
    json_t *chains = report_of(one, true), *samples = report_of(other, true);
    const json_t *a = json_first(json_get(chains, "lengths")), *c = json_first(json_get(samples, "lengths"));
    for (; a && c; a = json_next(a), c = json_next(c)) {
        const json_t *x = json_get(a, "b"), *y = json_get(c, "b");
        const double off = number(x, "value") - number(y, "value"),
                     error = hypot(number(x, "standard_error"), number(y, "standard_error"));
        if (!(fabs(off) <= 6 * error))
            fail_msg("%s and %s, length %g: b is %g and %g, %g standard errors apart", one, other,
                     number(a, "length"), number(x, "value"), number(y, "value"), off / error);
    }
    json_destroy(&chains);
    json_destroy(&samples);
}

static void algorithms_agree_about_b(void **state)
{
    (void)state;
    check_b("mmlt", "bdpt");
    check_b("pssmlt", "bdpt");
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(every_field_is_documented),
        cmocka_unit_test(numbers_agree_with_each_other),
        cmocka_unit_test(chains_of_all_lengths_have_their_own_place),
        cmocka_unit_test(algorithms_agree_about_b),
    };
    return cmocka_run_group_tests(tests, read_document, NULL);
}
