/* Jobs: defaults, every field, what is refused and in which words, the canonical text. In the texts below ' stands
 * for ". */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#include "base/random.h"
#include "plan/plan_fixture.h"

/* ---- what is read ---- */

static void absent_fields_have_their_defaults(void **state)
{
    (void)state;
    static const char *const spellings[] = {
        "{'scene':'a/b.pbrt'}",
        "{'scene':'a/b.pbrt','film':{},'chains':{},'stop':{},'output':{}}",
        "{'scene':'a/b.pbrt','film':null,'seed':null,'algorithm':null,'stop':{'seconds':null}}",
        " {\n\t\"scene\" : \"a/b.pbrt\" , 'seed':'1', 'target':'luminance'} ",
    };
    for (size_t i = 0; i < sizeof spellings / sizeof *spellings; i++) {
        const job_t job = plan_fixture_job(spellings[i]);
        settings_t s;
        settings_default(&s);
        assert_string_equal(job.scene, "a/b.pbrt");
        assert_string_equal(job.image, "image.exr");
        assert_string_equal(job.preview, "");
        assert_string_equal(job.report, "");
        assert_true(job.preview_exposure == 0);
        assert_true(job.stop.seconds == 30 && job.stop.mutations_per_pixel == 0 && job.stop.error == 0);
        assert_int_equal(job.settings.algorithm, SETTINGS_RJMLT); /* what "auto" is */
        assert_true(job.settings.equalize == 1 && job.settings.split > 0 && job.settings.split_gain > 1);
        assert_int_equal(job.settings.width, 0);
        assert_int_equal(job.settings.height, 0);
        assert_int_equal(job.settings.filter, -1);
        assert_true(job.settings.filter_radius == 0);
        assert_int_equal(job.settings.max_path_length, 0);
        assert_int_equal(job.settings.seed, 1);
        assert_int_equal(job.settings.target, SETTINGS_TARGET_LUMINANCE);
        assert_int_equal(job.settings.kernel, SETTINGS_KERNEL_KELEMEN);
        assert_true(job.settings.large_step == s.large_step && job.settings.technique_step == s.technique_step);
        assert_true(job.settings.step_min == s.step_min && job.settings.step_max == s.step_max);
        assert_int_equal(job.settings.chain_length, 0);
        assert_int_equal(job.settings.pilot_samples, 0);
    }
}

static const char everything[] =
    "{'scene':'s.glb','film':{'width':640,'height':360,'filter':'gaussian','filter_radius':2.25},"
    "'algorithm':'bdpt','max_path_length':31,'seed':'18446744073709551615','target':'maximum',"
    "'chains':{'large_step':0.125,'technique_step':0.375,'kernel':'gaussian','step_min':0.002,'step_max':0.04,"
    "'length':4294967296,'pilot_samples':16777216},"
    "'effects':{'caustics':'off','aperture':'on','emission':'auto'},"
    "'stop':{'mutations_per_pixel':12.5,'seconds':3600.5,'error':0.03},"
    "'output':{'image':'o.exr','preview':'o.png','report':'o.json','preview_exposure':-1.5}}";

static void every_field_is_read(void **state)
{
    (void)state;
    const job_t job = plan_fixture_job(everything);
    const settings_t *s = &job.settings;
    static const uint8_t effects[SETTINGS_EFFECTS] = {
        [SETTINGS_CAUSTICS] = SETTINGS_SWITCH_OFF, [SETTINGS_APERTURE] = SETTINGS_SWITCH_ON};
    assert_memory_equal(s->effects, effects, sizeof effects);
    assert_string_equal(job.scene, "s.glb");
    assert_int_equal(s->width, 640);
    assert_int_equal(s->height, 360);
    assert_int_equal(s->filter, 2);
    assert_true(s->filter_radius == 2.25);
    assert_int_equal(s->algorithm, SETTINGS_BDPT);
    assert_int_equal(s->max_path_length, 31);
    assert_true(s->seed == UINT64_MAX);
    assert_int_equal(s->target, SETTINGS_TARGET_MAXIMUM);
    assert_true(s->large_step == 0.125 && s->technique_step == 0.375);
    assert_int_equal(s->kernel, SETTINGS_KERNEL_GAUSSIAN);
    assert_true(s->step_min == 0.002 && s->step_max == 0.04);
    assert_true(s->chain_length == UINT64_C(1) << 32 && s->pilot_samples == UINT64_C(1) << 24);
    assert_true(job.stop.mutations_per_pixel == 12.5 && job.stop.seconds == 3600.5 && job.stop.error == 0.03);
    assert_string_equal(job.image, "o.exr");
    assert_string_equal(job.preview, "o.png");
    assert_string_equal(job.report, "o.json");
    assert_true(job.preview_exposure == -1.5);
    assert_int_equal(plan_fixture_job("{'scene':'x','algorithm':'pt','film':{'filter':'box'}}").settings.algorithm,
                     SETTINGS_PT);
    assert_int_equal(plan_fixture_job("{'scene':'x','film':{'filter':'box'}}").settings.filter, 0);
    assert_int_equal(plan_fixture_job("{'scene':'x','film':{'filter':'triangle'}}").settings.filter, 1);
    assert_true(plan_fixture_job("{'scene':'x','stop':{'error':0.5}}").stop.seconds == 0); /* only what is asked */
    assert_string_equal(plan_fixture_job("{'scene':'x','output':{'image':''}}").image, "");
}

/* ---- what is refused ---- */

static void refuse(const char *text, fault_code_t code, const char *place, const char *expected)
{
    char *json = strdup(text);
    job_t job;
    fault_t fault = {0};
    for (char *c = json; *c; c++)
        *c = *c == '\'' ? '"' : *c;
    const fault_code_t got = job_parse(&job, json, strlen(json), "jobs/a.json", &fault);
    if (got != code || strncmp(fault.text, "jobs/a.json: ", 13) != 0 || !strstr(fault.text, place) ||
        !strstr(fault.text, expected))
        fail_msg("%.100s: fault %d \"%s\", expected %d naming %s and %s", text, (int)got, fault.text, (int)code,
                 place, expected);
    free(json);
}

static void unknown_fields_are_refused(void **state)
{
    (void)state;
    refuse("{'scene':'x','colour':1}", FAULT_UNKNOWN, "colour", "seed");
    refuse("{'scene':'x','Seed':'1'}", FAULT_UNKNOWN, "Seed", "seed");
    refuse("{'scene':'x','film':{'widht':640}}", FAULT_UNKNOWN, "film.widht", "width");
    refuse("{'scene':'x','chains':{'step':0.1}}", FAULT_UNKNOWN, "chains.step", "step_min");
    refuse("{'scene':'x','stop':{'spp':4}}", FAULT_UNKNOWN, "stop.spp", "mutations_per_pixel");
    refuse("{'scene':'x','effects':{'fog':'off'}}", FAULT_UNKNOWN, "effects.fog", "caustics");
    refuse("{'scene':'x','output':{'exr':'a'}}", FAULT_UNKNOWN, "output.exr", "image");
}

static void wrong_types_are_refused(void **state)
{
    (void)state;
    refuse("[]", FAULT_TYPE, "not an object", "{\"scene\": ...}");
    refuse("7", FAULT_TYPE, "not an object", "{\"scene\": ...}");
    refuse("{'scene':7}", FAULT_TYPE, "scene", "text");
    refuse("{'scene':'x','film':[640,360]}", FAULT_TYPE, "film", "object");
    refuse("{'scene':'x','film':{'width':'640'}}", FAULT_TYPE, "film.width", "a whole number from 1 to 32768");
    refuse("{'scene':'x','effects':['caustics']}", FAULT_TYPE, "effects", "object");
    refuse("{'scene':'x','effects':{'caustics':false}}", FAULT_TYPE, "effects.caustics", "text");
    refuse("{'scene':'x','film':{'filter':1}}", FAULT_TYPE, "film.filter", "text");
    refuse("{'scene':'x','film':{'filter':'box','filter_radius':true}}", FAULT_TYPE, "film.filter_radius",
           "a number from 0.5 to 16");
    refuse("{'scene':'x','algorithm':['pt']}", FAULT_TYPE, "algorithm", "text");
    refuse("{'scene':'x','max_path_length':'5'}", FAULT_TYPE, "max_path_length", "a whole number from 1 to 127");
    refuse("{'scene':'x','seed':true}", FAULT_TYPE, "seed", "2^64");
    refuse("{'scene':'x','target':1}", FAULT_TYPE, "target", "text");
    refuse("{'scene':'x','chains':'long'}", FAULT_TYPE, "chains", "object");
    refuse("{'scene':'x','chains':{'large_step':'0.3'}}", FAULT_TYPE, "chains.large_step", "a number from 0 to 1");
    refuse("{'scene':'x','stop':60}", FAULT_TYPE, "stop", "object");
    refuse("{'scene':'x','stop':{'seconds':'60'}}", FAULT_TYPE, "stop.seconds", "a number from 0.001");
    refuse("{'scene':'x','output':'image.exr'}", FAULT_TYPE, "output", "object");
    refuse("{'scene':'x','output':{'image':'a.b/o.PFM'}}", FAULT_UNSUPPORTED, "output.image", ".exr");
    refuse("{'scene':'x','output':{'preview':'o.jpg'}}", FAULT_UNSUPPORTED, "output.preview", ".png");
    refuse("{'scene':'x','output':{'preview':false}}", FAULT_TYPE, "output.preview", "text");
}

static void values_out_of_range_are_refused(void **state)
{
    (void)state;
    refuse("{}", FAULT_FORMAT, "scene", "missing");
    refuse("{'scene':''}", FAULT_FORMAT, "scene", "missing");
    refuse("{'scene':'x','effects':{'indirect':'no'}}", FAULT_UNKNOWN, "effects.indirect: \"no\"",
           "\"auto\", \"on\" or \"off\"");
    refuse("{'scene':'x','film':{'width':0}}", FAULT_RANGE, "film.width", "1 to 32768, found 0");
    refuse("{'scene':'x','film':{'height':32769}}", FAULT_RANGE, "film.height", "1 to 32768, found 32769");
    refuse("{'scene':'x','film':{'width':1.5}}", FAULT_RANGE, "film.width", "whole number");
    refuse("{'scene':'x','film':{'filter':'mitchell'}}", FAULT_UNKNOWN, "film.filter: \"mitchell\"",
           "\"box\", \"triangle\" or \"gaussian\"");
    refuse("{'scene':'x','film':{'filter':'box','filter_radius':0.25}}", FAULT_RANGE, "film.filter_radius",
           "0.5 to 16");
    refuse("{'scene':'x','film':{'filter_radius':2}}", FAULT_FORMAT, "film.filter_radius",
           "film.filter, which is missing");
    refuse("{'scene':'x','algorithm':'MMLT'}", FAULT_UNKNOWN, "algorithm: \"MMLT\"",
           "\"pt\", \"bdpt\", \"mmlt\", \"rjmlt\", \"cmlt\", \"cmlt-rex\", \"cmlt-ipsm\", \"pssmlt-mix\", "
           "\"pssmlt\" or \"auto\"");
    refuse("{'scene':'x','algorithm':'pssmlt-mix','chains':{'failures':'published'}}", FAULT_UNSUPPORTED,
           "chains.failures", "mmlt, rjmlt and cmlt");
    refuse("{'scene':'x','algorithm':'pssmlt','chains':{'failures':'published'}}", FAULT_UNSUPPORTED,
           "chains.failures", "pssmlt");
    refuse("{'scene':'x','algorithm':'pssmlt','chains':{'failures':'delayed'}}", FAULT_UNSUPPORTED,
           "chains.failures", "pssmlt");
    refuse("{'scene':'x','algorithm':'pssmlt','chains':{'partial_step':0.1}}", FAULT_UNSUPPORTED,
           "chains.partial_step", "pssmlt");
    refuse("{'scene':'x','algorithm':'pssmlt','chains':{'auxiliary_step':0.1}}", FAULT_UNSUPPORTED,
           "chains.auxiliary_step", "pssmlt");
    refuse("{'scene':'x','algorithm':'cmlt-ipsm','chains':{'failures':'delayed'}}", FAULT_UNSUPPORTED,
           "chains.failures", "cmlt-ipsm");
    refuse("{'scene':'x','algorithm':'cmlt-rex','chains':{'auxiliary_step':0.1}}", FAULT_UNSUPPORTED,
           "chains.auxiliary_step", "mmlt, rjmlt and cmlt");
    refuse("{'scene':'x','algorithm':'mmlt','chains':{'auxiliary_step':0.1,'failures':'published'}}",
           FAULT_UNSUPPORTED, "chains.auxiliary_step", "published");
    refuse("{'scene':'x','chains':{'auxiliary_step':0.7,'large_step':0.4}}", FAULT_RANGE, "auxiliary_step",
           "more than 1");
    refuse("{'scene':'x','algorithm':'mmlt','chains':{'equalize':1,'failures':'published'}}", FAULT_UNSUPPORTED,
           "chains.equalize", "published");
    refuse("{'scene':'x','algorithm':'mmlt','chains':{'split':5,'failures':'published'}}", FAULT_UNSUPPORTED,
           "chains.split", "published");
    refuse("{'scene':'x','algorithm':'pssmlt','chains':{'split':5}}", FAULT_UNSUPPORTED, "chains.split", "pssmlt");
    refuse("{'scene':'x','algorithm':'mmlt','chains':{'adapt':true,'failures':'published'}}", FAULT_UNSUPPORTED,
           "chains.adapt", "published");
    refuse("{'scene':'x','algorithm':'pssmlt','chains':{'adapt':true}}", FAULT_UNSUPPORTED, "chains.adapt",
           "pssmlt");
    refuse("{'scene':'x','algorithm':'mmlt','chains':{'adapt':1}}", FAULT_TYPE, "chains.adapt", "true or false");
    refuse("{'scene':'x','algorithm':'mmlt','chains':{'shift':'on'}}", FAULT_TYPE, "chains.shift", "true or false");
    refuse("{'scene':'x','chains':{'split':-1}}", FAULT_RANGE, "chains.split", "1000000");
    refuse("{'scene':'x','chains':{'split_gain':0.5}}", FAULT_RANGE, "chains.split_gain", "1");
    refuse("{'scene':'x','chains':{'equalize':1.5}}", FAULT_RANGE, "chains.equalize", "1");
    refuse("{'scene':'x','chains':{'failures':'rectified'}}", FAULT_UNKNOWN, "chains.failures", "\"published\"");
    refuse("{'scene':'x','chains':{'partial_step':1.5}}", FAULT_RANGE, "chains.partial_step", "1");
    refuse("{'scene':'x','max_path_length':0}", FAULT_RANGE, "max_path_length", "1 to 127");
    refuse("{'scene':'x','max_path_length':128}", FAULT_RANGE, "max_path_length", "1 to 127");
    refuse("{'scene':'x','seed':'18446744073709551616'}", FAULT_RANGE, "seed", "2^64");
    refuse("{'scene':'x','seed':-1}", FAULT_RANGE, "seed", "2^64");
    refuse("{'scene':'x','seed':9007199254740993}", FAULT_RANGE, "seed", "2^53");
    refuse("{'scene':'x','target':'red'}", FAULT_UNKNOWN, "target", "\"luminance\" or \"maximum\"");
    refuse("{'scene':'x','chains':{'large_step':1.01}}", FAULT_RANGE, "chains.large_step", "0 to 1");
    refuse("{'scene':'x','chains':{'technique_step':-0.1}}", FAULT_RANGE, "chains.technique_step", "0 to 1");
    refuse("{'scene':'x','chains':{'kernel':'levy'}}", FAULT_UNKNOWN, "chains.kernel",
           "\"kelemen\" or \"gaussian\"");
    refuse("{'scene':'x','chains':{'step_min':0}}", FAULT_RANGE, "chains.step_min", "0.5");
    refuse("{'scene':'x','chains':{'step_max':0.6}}", FAULT_RANGE, "chains.step_max", "0.5");
    refuse("{'scene':'x','chains':{'step_min':0.1,'step_max':0.05}}", FAULT_RANGE, "chains.step_min: 0.1",
           "chains.step_max, which is 0.05");
    refuse("{'scene':'x','chains':{'length':0}}", FAULT_RANGE, "chains.length", "1 to 4294967296");
    refuse("{'scene':'x','chains':{'pilot_samples':1e12}}", FAULT_RANGE, "chains.pilot_samples", "1 to 16777216");
    refuse("{'scene':'x','stop':{'mutations_per_pixel':0}}", FAULT_RANGE, "stop.mutations_per_pixel", "0.001");
    refuse("{'scene':'x','stop':{'seconds':1e10}}", FAULT_RANGE, "stop.seconds", "1000000000");
    refuse("{'scene':'x','stop':{'error':11}}", FAULT_RANGE, "stop.error", "10");
    refuse("{'scene':'x','output':{'preview_exposure':31}}", FAULT_RANGE, "output.preview_exposure", "-30 to 30");
    refuse("{'scene':'x','seed':'1','seed':'2'}", FAULT_SYNTAX, "seed", "twice");
    refuse("{'scene':'x'", FAULT_SYNTAX, "line 1", "expected");
    refuse("", FAULT_SYNTAX, "line 1", "expected");
}

static void long_paths_are_refused(void **state)
{
    (void)state;
    static const char *const frames[] = {"{'scene':'%s'}", "{'scene':'x','output':{'image':'%s'}}",
                                         "{'scene':'x','output':{'preview':'%s'}}",
                                         "{'scene':'x','output':{'report':'%s'}}"};
    static const char *const places[] = {"scene", "output.image", "output.preview", "output.report"};
    char path[JOB_PATH_SIZE + 1], text[JOB_PATH_SIZE + 100];
    for (size_t i = 0; i < sizeof frames / sizeof *frames; i++) {
        memset(path, 'a', JOB_PATH_SIZE);
        path[JOB_PATH_SIZE] = '\0';
#pragma GCC diagnostic push
#pragma GCC diagnostic ignored "-Wformat-nonliteral"
        snprintf(text, sizeof text, frames[i], path);
        refuse(text, FAULT_LIMIT, places[i], "fewer than 4096");
        path[JOB_PATH_SIZE - 1] = '\0';
        snprintf(text, sizeof text, frames[i], path);
#pragma GCC diagnostic pop
        plan_fixture_job(text);
    }
}

/* ---- the canonical text ---- */

static void assert_round_trip(const job_t *job)
{
    char *text = job_print(job), *again;
    job_t back;
    fault_t fault = {0};
    if (job_parse(&back, text, strlen(text), "job", &fault))
        fail_msg("%s is refused: %s", text, fault.text);
    again = job_print(&back);
    assert_string_equal(again, text);
    const settings_t *a = &job->settings, *b = &back.settings;
    assert_true(
        a->algorithm == b->algorithm && a->width == b->width && a->height == b->height && a->filter == b->filter &&
        a->filter_radius == b->filter_radius && a->max_path_length == b->max_path_length && a->seed == b->seed &&
        a->target == b->target && a->kernel == b->kernel && a->large_step == b->large_step &&
        a->technique_step == b->technique_step && a->jump_step == b->jump_step &&
        a->partial_step == b->partial_step && a->adapt == b->adapt && a->shift == b->shift &&
        a->equalize == b->equalize && a->split == b->split && a->split_gain == b->split_gain &&
        a->auxiliary_step == b->auxiliary_step && a->failures == b->failures && a->step_min == b->step_min &&
        a->step_max == b->step_max && a->chain_length == b->chain_length && a->pilot_samples == b->pilot_samples);
    assert_memory_equal(a->effects, b->effects, sizeof a->effects);
    assert_true(job->stop.mutations_per_pixel == back.stop.mutations_per_pixel &&
                job->stop.seconds == back.stop.seconds && job->stop.error == back.stop.error &&
                job->preview_exposure == back.preview_exposure);
    assert_int_equal(job->automatic, back.automatic);
    assert_string_equal(job->scene, back.scene);
    assert_string_equal(job->image, back.image);
    assert_string_equal(job->preview, back.preview);
    assert_string_equal(job->report, back.report);
    free(text);
    free(again);
}

static uint64_t counter;

static double number(double lo, double hi)
{
    return lo + (hi - lo) * random_double(random_key(2385, RANDOM_PURPOSE_TEST, 1, 0), counter++);
}

static bool coin(void)
{
    return number(0, 1) < 0.5;
}

static void printed_jobs_come_back_to_the_last_bit(void **state)
{
    (void)state;
    const job_t least = plan_fixture_job("{'scene':'x'}"), most = plan_fixture_job(everything);
    assert_round_trip(&least);
    assert_round_trip(&most);
    for (int i = 0; i < 3000; i++) {
        job_t job = least;
        settings_t *s = &job.settings;
        snprintf(job.scene, sizeof job.scene, "a \"%d\"\\\n\t\xc3\xa9.pbrt", i);
        snprintf(job.image, sizeof job.image, "%s%d", coin() ? "i\\\\" : "", i);
        snprintf(job.preview, sizeof job.preview, "%.*s", coin() ? 5 : 0, "p.png");
        s->algorithm = (settings_algorithm_t)number(0, SETTINGS_ALGORITHMS);
        job.automatic = s->algorithm == least.settings.algorithm && coin();
        s->width = coin() ? (uint32_t)number(1, 32768) : 0;
        s->height = coin() ? (uint32_t)number(1, 32768) : 0;
        s->filter = (int32_t)number(0, 4) - 1;
        s->filter_radius = s->filter >= 0 && coin() ? number(0.5, 16) : 0;
        s->max_path_length = coin() ? (uint32_t)number(1, 128) : 0;
        s->seed = random_u64(2385, counter++);
        s->target = coin() ? SETTINGS_TARGET_MAXIMUM : SETTINGS_TARGET_LUMINANCE;
        s->kernel = coin() ? SETTINGS_KERNEL_GAUSSIAN : SETTINGS_KERNEL_KELEMEN;
        s->large_step = number(0, 1);
        s->technique_step = number(0, 1);
        s->jump_step = number(0, 1 - s->large_step);
        s->partial_step = s->algorithm == SETTINGS_PSSMLT ? 0 : number(0, 1);
        s->equalize = s->algorithm == SETTINGS_MMLT ? 0 : number(0, 1);
        s->split = coin() && s->algorithm > SETTINGS_MMLT && s->algorithm != SETTINGS_PSSMLT ? number(0, 100) : 0;
        s->split_gain = coin() ? number(1, 100) : 1;
        s->adapt = s->algorithm > SETTINGS_MMLT && s->algorithm != SETTINGS_PSSMLT && coin();
        s->shift = coin();
        s->failures = s->algorithm == SETTINGS_MMLT ? SETTINGS_FAILURES_PUBLISHED : SETTINGS_FAILURES_PLAIN;
        s->auxiliary_step = s->algorithm == SETTINGS_CMLT ? 1 - s->large_step - s->jump_step : 0;
        s->step_max = number(1e-9, 0.5);
        s->step_min = coin() ? s->step_max : 1e-9;
        s->chain_length = coin() ? (uint64_t)number(1, 4e9) : 0;
        s->pilot_samples = coin() ? (uint64_t)number(1, 1e7) : 0;
        job.stop = (job_stop_t){coin() ? number(1e-3, 1e9) : 0, coin() ? number(1e-3, 1e9) : 0, number(1e-6, 10)};
        job.preview_exposure = number(-30, 30);
        assert_round_trip(&job);
    }
}

static void two_spellings_have_one_text(void **state)
{
    (void)state;
    const job_t
        a = plan_fixture_job("{'seed':7,'scene':'x','stop':{'error':1e-1,'seconds':10}}"),
        b = plan_fixture_job(
            "{'stop':{'seconds':1.0e1,'error':0.1},'film':{},'scene':'\\u0078','algorithm':'auto','seed':'7'}");
    char *text = job_print(&a), *other = job_print(&b);
    assert_string_equal(text, other);
    free(text);
    free(other);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(absent_fields_have_their_defaults),
        cmocka_unit_test(every_field_is_read),
        cmocka_unit_test(unknown_fields_are_refused),
        cmocka_unit_test(wrong_types_are_refused),
        cmocka_unit_test(values_out_of_range_are_refused),
        cmocka_unit_test(long_paths_are_refused),
        cmocka_unit_test(printed_jobs_come_back_to_the_last_bit),
        cmocka_unit_test(two_spellings_have_one_text),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
