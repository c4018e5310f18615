/* A report as a page and as tables: what is in them, that they are well formed, that nothing of a report is markup.
 */
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#include "base/file.h"
#include "base/random.h"
#include "client/report/csv.h"
#include "client/report/page.h"

/* ---- a strict reader of tags ---- */

enum { MAX_DEPTH = 64, NAME_SIZE = 32 };

/* Where a document is wrong, or null: tags that do not match, attributes out of quotes, a bare < or &. */
static const char *markup_flaw(const char *html)
{
    static char names[MAX_DEPTH][NAME_SIZE];
    int depth = 0;
    const char *c = html;
    if (strncmp(c, "<!DOCTYPE html>", 15) != 0)
        return c;
    for (c += 15; *c;) {
        if (*c == '&') {
            const size_t n = strspn(c + 1, "abcdefghijklmnopqrstuvwxyz#0123456789");
            if (n == 0 || c[1 + n] != ';')
                return c;
            c += n + 2;
            continue;
        }
        if (*c != '<') {
            if (*c == '>' || (depth == 0 && *c != '\n'))
                return c;
            c++;
            continue;
        }
        const char *at = c + 1;
        const bool end = *at == '/';
        at += end;
        const size_t n = strspn(at, "abcdefghijklmnopqrstuvwxyz123456789");
        if (n == 0 || n >= NAME_SIZE)
            return c;
        if (end) {
            if (at[n] != '>' || depth == 0 || strlen(names[depth - 1]) != n ||
                strncmp(names[depth - 1], at, n) != 0)
                return c;
            depth--;
            c = at + n + 1;
            continue;
        }
        if (depth == MAX_DEPTH)
            return c;
        memcpy(names[depth], at, n);
        names[depth++][n] = '\0';
        for (at += n; *at == ' ';) { /* name="value" */
            at++;
            at += strcspn(at, "= />\"<");
            if (at[0] != '=' || at[1] != '"')
                return c;
            at += 2;
            at += strcspn(at, "\"<");
            if (*at != '"')
                return c;
            at++;
        }
        if (at[0] == '/' && at[1] == '>') {
            depth--;
            at++;
        }
        if (*at != '>')
            return c;
        c = at + 1;
    }
    return depth == 0 ? NULL : c;
}

static void assert_well_formed(const char *html)
{
    const char *flaw = markup_flaw(html);
    if (flaw)
        fail_msg("the page is not well formed at: %.80s", flaw);
}

static void reader_of_tags_finds_flaws(void **state)
{
    (void)state;
    assert_null(markup_flaw("<!DOCTYPE html><html a=\"b\"><p>x &lt; y</p><br/></html>\n"));
    assert_non_null(markup_flaw("<!DOCTYPE html><html><p></html>"));
    assert_non_null(markup_flaw("<!DOCTYPE html><html><p></html></p>"));
    assert_non_null(markup_flaw("<!DOCTYPE html><html>&</html>"));
    assert_non_null(markup_flaw("<!DOCTYPE html><html a=b></html>"));
    assert_non_null(markup_flaw("<!DOCTYPE html><html>a > b</html>"));
    assert_non_null(markup_flaw("<!DOCTYPE html><html><b"));
}

/* ---- fixtures ---- */

static char *fixture_text(const char *name)
{
    const char *tests = getenv("GARLAND_TESTS");
    char path[4096];
    uint8_t *data;
    size_t size;
    fault_t fault = {0};
    snprintf(path, sizeof path, "%s/client/reports/%s", tests ? tests : "tests", name);
    if (file_read(path, REPORT_MAX_BYTES, &data, &size, &fault) != FAULT_NONE)
        fail_msg("%s", fault.text);
    return (char *)data;
}

static report_t *report_of(const char *text)
{
    report_t *report;
    fault_t fault = {0};
    if (report_read(&report, text, strlen(text), "test", &fault) != FAULT_NONE)
        fail_msg("%s", fault.text);
    return report;
}

static report_t *fixture(const char *name)
{
    char *text = fixture_text(name);
    report_t *report = report_of(text);
    free(text);
    return report;
}

static char *page_of(const report_t *report)
{
    char *html;
    size_t size;
    fault_t fault = {0};
    if (page_write(&html, &size, report, NULL, &fault) != FAULT_NONE)
        fail_msg("%s", fault.text);
    assert_int_equal(strlen(html), size);
    assert_well_formed(html);
    return html;
}

static char *page_of_text(const char *text)
{
    report_t *report = report_of(text);
    char *html = page_of(report);
    report_destroy(&report);
    return html;
}

static void assert_has(const char *html, const char *words)
{
    if (!strstr(html, words))
        fail_msg("the page lacks: %s", words);
}

/* ---- the page ---- */

static const char *const sections[] = {"error", "lengths",    "light",   "time",    "groups",  "regions", "bias",
                                       "moves", "techniques", "effects", "trouble", "service", "rest",    "job"};
enum { SECTIONS = sizeof sections / sizeof sections[0] };

static void full_report_has_every_section(void **state)
{
    (void)state;
    report_t *report = fixture("full.json");
    char *html = page_of(report);
    for (int i = 0; i < SECTIONS; i++) {
        char id[64];
        snprintf(id, sizeof id, "<section id=\"%s\"", sections[i]);
        assert_has(html, id);
    }
    assert_has(html, "<h1>rooms/ring &lt;1&gt; &amp; &quot;box&quot;.pbrt</h1>");
    assert_has(html, "is <strong>3\xc2\xa0%</strong> (95\xc2\xa0%: 2.83\xc2\xa0% to 3.32\xc2\xa0%)");
    assert_has(html, "<strong>30.2\xc2\xa0s</strong>");
    assert_has(html, "by the rule <strong>seconds</strong>");
    assert_has(html, "This image is biased: failures are left out");
    assert_has(html, "2 paths or splats were thrown away");
    assert_has(html, "length 5, technique 2: L S D S E");
    assert_has(html, "No chain of their path lengths brings more than 0.12\xc2\xa0% of it.");
    assert_has(html, "Mutations of a chain");
    assert_has(html, "glass, &quot;clear&quot;, and brass");
    assert_has(html, "1\xc2\xa0min\xc2\xa0"
                     "6\xc2\xa0s");
    assert_has(html, "<p>Estimates: variance between units of work, and of b.</p>");
    assert_has(html, "of which there were 1.85 a second");
    assert_has(html, "90\xc2\xa0"
                     "000 independent samples");
    assert_has(html, "samples: 70.6\xc2\xa0% of the processor time"); /* with the lengths' */
    assert_has(html, "length 3: all light, ");
    assert_has(html, ">2.25</td>");                      /* a cap */
    assert_has(html, ">34.5</td>");                      /* what a trial said */
    assert_has(html, "row 1, column 2: 2 (1.9 to 2.1)"); /* a region */
    assert_has(html, ">20\xc2\xa0%</td>");               /* the bias of a block */
    assert_has(html, ">5.5\xc2\xa0%</td>");              /* the deviation of a group */
    assert_has(html, "length 2: b at most 11.75");
    assert_has(html, ">11.75</td>");
    free(html);
    report_destroy(&report);
}

/* What is to be doubted stands in sentences where the figures are; members that are shown are not repeated. */
static void doubts_are_told(void **state)
{
    (void)state;
    report_t *report = fixture("full.json");
    char *html = page_of(report);
    assert_has(html, "This estimate is <strong>not reliable</strong>: one of 16 groups of units brings 31 % of the "
                     "&quot;squared&quot; error. ");
    assert_has(html, ">31.0\xc2\xa0\xc2\xb1\xc2\xa0"
                     "1.2\xc2\xa0%</td>");
    assert_has(html, ">none met</td>");
    assert_has(html, "leaves out</a> indirect and dispersion: the image lacks "
                     "25.60\xc2\xa0\xc2\xb1\xc2\xa0"
                     "0.41\xc2\xa0% of the light.");
    assert_has(html, "All that the job leaves out: 25.60\xc2\xa0\xc2\xb1\xc2\xa0"
                     "0.41\xc2\xa0% of the light");
    assert_has(html, "16\xc2\xa0"
                     "384 samples of their own");
    assert_has(html, "path lengths 5, 7 to 9. They may bring at most 1.35\xc2\xa0% of the light (95\xc2\xa0%).");
    assert_null(strstr(html, "<h3>missed</h3>"));
    assert_null(strstr(html, "<h3>left_out</h3>"));
    free(html);
    report_destroy(&report);
}

/* Reports that do not tell all of it, and what the page then says, or (after a minus) does not. */
static void doubts_may_be_told_in_part(void **state)
{
    (void)state;
    static const char *const cases[][2] = {
        {"{\"stuck\": {\"chains\": 2, \"weight\": 0.1}}", "10\xc2\xa0% of the image's light.</p>"},
        {"{\"stuck\": {\"chains\": 2, \"bound\": null, \"shortened\": 3}}", "-Mutations of a chain"},
        {"{\"stuck\": {\"chains\": 0, \"bound\": 0, \"shortened\": [{\"length\": 0, \"to\": 300}, 5]}}",
         ">all</th>"},
        {"{\"error\": {\"error\": 0.1, \"reliable\": true}}", "Nothing that the render has seen speaks against"},
        {"{\"error\": {\"error\": 0.1, \"reliable\": false}}", "<strong>not reliable</strong>. The image"},
        {"{\"error\": {\"error\": 0.1, \"reliable\": null}}", "-class=\"trust"},
        {"{\"error\": {\"error\": 0.1, \"reliable\": \"no\"}}", "-class=\"trust"},
        {"{\"error\": {\"error\": 0.1}}", "-class=\"trust"},
        {"{\"error\": {\"error\": null, \"reliable\": false, \"reason\": \"only 3 units\"}}",
         "The error is <strong>not known</strong>: only 3 units"},
        {"{\"error\": {\"error\": null, \"reliable\": false, \"reason\": \"only 3 units\"}}", "-class=\"trust"},
        {"{\"left_out\": {\"energy\": 0, \"standard_error\": null}}", "some effects: no such light was met"},
        {"{\"left_out\": {}}", "how much light is not known"},
        {"{\"left_out\": {\"energy\": 0.5}}", "lacks 50\xc2\xa0% of the light"},
        {"{\"left_out\": {\"energy\": 1e300, \"standard_error\": 1e-9}}", "lacks 1e+302"},
        {"{\"lengths\": [{\"length\": 1}], \"missed\": {\"lengths\": [], \"most\": 0}}", "-Missing from the image"},
        {"{\"lengths\": [{\"length\": 1}], \"missed\": {\"lengths\": [2, 3, 1, 2.5, \"x\", 1e9, 5]}}",
         "path lengths 2, 3, 5.</p>"},
    };
    for (size_t i = 0; i < sizeof cases / sizeof cases[0]; i++) {
        char *html = page_of_text(cases[i][0]);
        if (cases[i][1][0] == '-')
            assert_null(strstr(html, cases[i][1] + 1));
        else
            assert_has(html, cases[i][1]);
        free(html);
    }
}

/* Every plot says in words what it shows, and ids are unique. */
static void plots_have_titles_and_descriptions(void **state)
{
    (void)state;
    report_t *report = fixture("full.json");
    char *html = page_of(report);
    int plots = 0, hidden = 0;
    for (const char *at = html; (at = strstr(at, "<svg ")); at++) {
        const char *end = strchr(at, '>');
        char tag[512];
        snprintf(tag, sizeof tag, "%.*s", (int)(end - at), at);
        if (strstr(tag, "aria-hidden")) {
            hidden++;
            continue;
        }
        plots++;
        assert_non_null(strstr(tag, "role=\"img\""));
        assert_int_equal(strncmp(end + 1, "\n<title id=", 11), 0);
    }
    assert_int_equal(plots, 9);  /* the error twice, for wide and for narrow screens */
    assert_int_equal(hidden, 5); /* squares beside the parts of the time */
    for (const char *at = html; (at = strstr(at, " id=\"")); at++) {
        char id[96];
        snprintf(id, sizeof id, "%.*s\"", (int)strcspn(at + 5, "\"") + 5, at);
        if (strstr(at + 1, id))
            fail_msg("twice:%s", id);
    }
    free(html);
    report_destroy(&report);
}

static void page_asks_for_nothing_from_elsewhere(void **state)
{
    (void)state;
    static const char *const words[] = {"<script", "<link", "http://", "https://", "@import", "url(", "<iframe"};
    report_t *report = fixture("full.json");
    char *html = page_of(report);
    for (size_t i = 0; i < sizeof words / sizeof words[0]; i++)
        for (const char *at = html; (at = strstr(at, words[i])); at++)
            if (strncmp(at, "http://www.w3.org/", 18) != 0) /* names of the markup's languages */
                fail_msg("found %.60s", at);
    free(html);
    report_destroy(&report);
}

static void picture_is_within(void **state)
{
    (void)state;
    static const uint8_t png[11] = {0x89, 'P', 'N', 'G', '\r', '\n', 0x1a, '\n', 1, 2, 3};
    report_t *report = fixture("full.json");
    char *html;
    size_t size;
    fault_t fault = {0};
    const page_picture_t picture = {png, sizeof png}, none = {(const uint8_t *)"GIF89a......", 12};
    assert_int_equal(page_write(&html, &size, report, &picture, &fault), FAULT_NONE);
    assert_well_formed(html);
    assert_has(html, "src=\"data:image/png;base64,iVBORw0KGgoBAgM=\"");
    free(html);
    assert_int_equal(page_write(&html, &size, report, &none, &fault), FAULT_FORMAT);
    assert_null(html);
    report_destroy(&report);
}

static void chains_of_all_lengths_have_their_moves(void **state)
{
    (void)state;
    report_t *report = fixture("all_lengths.json");
    char *html = page_of(report);
    assert_has(html, "small, length all: 70\xc2\xa0% of 90 accepted");
    assert_has(html, "The error is <strong>not known</strong>");
    assert_null(strstr(html, "<section id=\"effects\""));
    free(html);
    report_destroy(&report);
}

static void nothing_at_all_is_a_page(void **state)
{
    (void)state;
    free(page_of_text("{}"));
    free(page_of_text("{\"lengths\": [], \"history\": [], \"effects\": {}, \"rejected\": []}"));
}

/* Each member of the whole, one at a time: missing, null, of every wrong type, too large. */
static void any_member_may_be_anything(void **state)
{
    (void)state;
    static const char *const values[] = {"null",
                                         "true",
                                         "-1e308",
                                         "\"<b>\"",
                                         "[]",
                                         "{}",
                                         "[[1],{\"a\":null},\"x\",1e308]",
                                         "{\"a\":{\"moves\":[1]},\"b\":[]}"};
    char *text = fixture_text("full.json");
    json_t *root = NULL;
    assert_int_equal(json_parse(&root, text, strlen(text), NULL), FAULT_NONE);
    for (const json_t *changed = json_first(root); changed; changed = json_next(changed))
        for (size_t v = 0; v <= sizeof values / sizeof values[0]; v++) {
            json_t *copy = json_new_object(), *value = NULL;
            for (const json_t *at = json_first(root); at; at = json_next(at))
                if (at != changed)
                    json_add(copy, json_name(at), json_copy(at));
            if (v < sizeof values / sizeof values[0]) { /* else missing */
                assert_int_equal(json_parse(&value, values[v], strlen(values[v]), NULL), FAULT_NONE);
                json_add(copy, json_name(changed), value);
            }
            char *printed = json_print(copy, false);
            free(page_of_text(printed));
            free(printed);
            json_destroy(&copy);
        }
    json_destroy(&root);
    free(text);
}

/* Numbers of the fixture exchanged for others, texts for markup: a fixed list of 400. */
static void numbers_and_texts_may_be_hostile(void **state)
{
    (void)state;
    static const char *const values[] = {"1e308",
                                         "-1e308",
                                         "0",
                                         "-0.5",
                                         "1e-320",
                                         "null",
                                         "\"</style><script>\"",
                                         "[]",
                                         "18446744073709551616",
                                         "{\"x\":\"]]>\"}"};
    char *text = fixture_text("full.json");
    for (uint64_t i = 0; i < 400; i++) {
        char *out = NULL;
        size_t size;
        FILE *stream = open_memstream(&out, &size);
        const char *at = text;
        for (uint64_t n = 0; *at; n++) {
            const size_t skip = strcspn(at, ":");
            fwrite(at, 1, skip, stream);
            at += skip;
            if (!*at)
                break;
            fputs(": ", stream);
            at += 1 + strspn(at + 1, " ");
            const size_t number = strspn(at, "-+.0123456789e");
            if (number > 0 && random_u64(i, n) % 16 == 0) {
                fputs(values[random_u64(i + 1000, n) % (sizeof values / sizeof values[0])], stream);
                at += number;
            }
        }
        fclose(stream);
        char *html = page_of_text(out);
        assert_null(strstr(html, "<script"));
        free(html);
        free(out);
    }
    free(text);
}

static void more_than_fits_is_cut(void **state)
{
    (void)state;
    char *out = NULL;
    size_t size;
    FILE *stream = open_memstream(&out, &size);
    fputs("{\"history\": [", stream);
    for (int i = 0; i < 5000; i++)
        fprintf(stream, "%s{\"cpu_seconds\": %d, \"error\": %g}", i ? "," : "", i + 1, 1. / (i + 1));
    fputs("], \"lengths\": [", stream);
    for (int i = 0; i < 500; i++)
        fprintf(stream, "%s{\"length\": %d, \"b\": {\"value\": 1}}", i ? "," : "", i + 1);
    fputs("], \"biased\": \"", stream);
    for (int i = 0; i < 5000; i++)
        fputs("\xc3\xa4", stream);
    fputs("\"}", stream);
    fclose(stream);
    report_t *report = report_of(out);
    assert_in_range(report->history_count, REPORT_MAX_HISTORY / 2, REPORT_MAX_HISTORY);
    assert_true(report->history[report->history_count - 1].cpu_seconds == 5000);
    assert_int_equal(report->length_count, REPORT_MAX_LENGTHS);
    char *html = page_of(report);
    assert_has(html, "\xc3\xa4\xc3\xa4\xe2\x80\xa6"); /* cut between characters */
    free(html);
    report_destroy(&report);
    free(out);
}

static void what_is_no_report_is_refused(void **state)
{
    (void)state;
    report_t *report;
    fault_t fault = {0};
    assert_int_equal(report_read(&report, "[]", 2, "a.json", &fault), FAULT_TYPE);
    assert_string_equal(fault.text, "a.json: not a report: expected an object");
    assert_int_equal(report_read(&report, "{", 1, "a.json", &fault), FAULT_SYNTAX);
    assert_int_equal(report_read(&report, "", (size_t)REPORT_MAX_BYTES + 1, "a.json", &fault), FAULT_LIMIT);
    assert_null(report);
}

/* ---- tables ---- */

/* The next field of RFC 4180 text into out; returns what comes after its separator, null at the end. */
static const char *csv_field(const char *at, char *out, size_t size, bool *line_ends)
{
    size_t n = 0;
    const bool quoted = *at == '"';
    at += quoted;
    while (*at && n + 1 < size) {
        if (quoted && *at == '"') {
            if (at[1] != '"') {
                at++;
                break;
            }
            at++;
        } else if (!quoted && (*at == ',' || *at == '\r')) {
            break;
        }
        out[n++] = *at++;
    }
    out[n] = '\0';
    *line_ends = *at == '\r';
    assert_true(*at == ',' || (at[0] == '\r' && at[1] == '\n'));
    at += *line_ends ? 2 : 1;
    return *line_ends && !*at ? NULL : at;
}

/* Fields come back as they went in; every line has as many as the first. */
static void tables_come_back(void **state)
{
    (void)state;
    static const size_t rows[CSV_TABLES] = {4, 4, 8, 2 + 3 + 4 + 5, 4, 4};
    report_t *report = fixture("full.json");
    for (int table = 0; table < CSV_TABLES; table++) {
        char *text = csv_print(report, (csv_table_t)table);
        size_t columns = 0, count = 0, lines = 0;
        for (const char *at = text; at;) {
            char field[256];
            bool end;
            at = csv_field(at, field, sizeof field, &end);
            if (table == CSV_EFFECTS && lines == 1 && count == 2)
                assert_string_equal(field, report->effects[0].reason);
            if (table == CSV_EFFECTS && lines == 2 && count == 4)
                assert_string_equal(field, report->effects[1].consequence);
            if (table == CSV_EFFECTS && lines == 2 && count == 3)
                assert_string_equal(field, "");
            if (table == CSV_HISTORY && lines == 4 && count == 4)
                assert_true(strtod(field, NULL) == report->history[3].error);
            if (table == CSV_LENGTHS && lines == 3 && count == 1)
                assert_true(strtod(field, NULL) == report->lengths[2].b);
            if (table == CSV_LENGTHS && lines == 3 && count == 11)
                assert_true(strtod(field, NULL) == report->lengths[2].cap);
            if (table == CSV_REGIONS && lines == 3 && count == 2)
                assert_string_equal(field, ""); /* not known */
            if (table == CSV_REGIONS && lines == 4 && count == 4)
                assert_true(strtod(field, NULL) == report->regions[3].high);
            count++;
            if (!end)
                continue;
            columns = lines == 0 ? count : columns;
            assert_int_equal(count, columns);
            count = 0;
            lines++;
        }
        assert_int_equal(lines, 1 + rows[table]);
        free(text);
    }
    report_destroy(&report);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(reader_of_tags_finds_flaws),
        cmocka_unit_test(full_report_has_every_section),
        cmocka_unit_test(doubts_are_told),
        cmocka_unit_test(doubts_may_be_told_in_part),
        cmocka_unit_test(plots_have_titles_and_descriptions),
        cmocka_unit_test(page_asks_for_nothing_from_elsewhere),
        cmocka_unit_test(picture_is_within),
        cmocka_unit_test(chains_of_all_lengths_have_their_moves),
        cmocka_unit_test(nothing_at_all_is_a_page),
        cmocka_unit_test(any_member_may_be_anything),
        cmocka_unit_test(numbers_and_texts_may_be_hostile),
        cmocka_unit_test(more_than_fits_is_cut),
        cmocka_unit_test(what_is_no_report_is_refused),
        cmocka_unit_test(tables_come_back),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
