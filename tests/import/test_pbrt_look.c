/* Materials, textures and spectra: what each parameter turns into. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <cmocka.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "client/import/spectra.h"
#include "film/pfm.h"
#include "import/read_text.h"
#include "math/vec.h"
#include "support/near.h"
#include "scene/texture.h"

/* Single precision of numbers of the order of one. */
#define CLOSE 3e-7

static void expect3(const float *found, double r, double g, double b, double tolerance)
{
    assert_near((double)found[0], r, tolerance * fmax(1, fabs(r)));
    assert_near((double)found[1], g, tolerance * fmax(1, fabs(g)));
    assert_near((double)found[2], b, tolerance * fmax(1, fabs(b)));
}

/* ---- materials ---- */

static reading_t read_material(const char *kind_and_params)
{
    char world[1024];
    snprintf(world, sizeof world, "Material %s Shape \"sphere\"", kind_and_params);
    return read_world(world);
}

static void materials_have_pbrts_defaults(void **state)
{
    (void)state;
    static const struct {
        const char *name;
        uint32_t kind;
    } kinds[] = {{"diffuse", SCENE_MATERIAL_DIFFUSE},
                 {"coateddiffuse", SCENE_MATERIAL_COATED_DIFFUSE},
                 {"conductor", SCENE_MATERIAL_CONDUCTOR},
                 {"coatedconductor", SCENE_MATERIAL_COATED_CONDUCTOR},
                 {"dielectric", SCENE_MATERIAL_DIELECTRIC},
                 {"thindielectric", SCENE_MATERIAL_THIN_DIELECTRIC},
                 {"diffusetransmission", SCENE_MATERIAL_DIFFUSE_TRANSMISSION},
                 {"interface", SCENE_MATERIAL_INTERFACE},
                 {"none", SCENE_MATERIAL_INTERFACE},
                 {"", SCENE_MATERIAL_INTERFACE}};
    for (size_t i = 0; i < sizeof kinds / sizeof *kinds; i++) {
        char text[64];
        snprintf(text, sizeof text, "\"%s\"", kinds[i].name);
        reading_t r = read_material(text);
        const scene_material_t *m = &r.scene.materials[r.scene.shapes[0].material];
        assert_int_equal(m->kind, kinds[i].kind);
        assert_int_equal(import_notes_count(r.notes), 0);
        assert_near((double)m->alpha_u.value[0], 0, 0);
        assert_near((double)m->coat_alpha_v.value[0], 0, 0);
        if (m->kind == SCENE_MATERIAL_DIFFUSE || m->kind == SCENE_MATERIAL_COATED_DIFFUSE)
            expect3(m->reflectance.value, 0.5, 0.5, 0.5, 0);
        if (m->kind == SCENE_MATERIAL_DIFFUSE_TRANSMISSION) {
            expect3(m->reflectance.value, 0.25, 0.25, 0.25, 0);
            expect3(m->transmittance.value, 0.25, 0.25, 0.25, 0);
        }
        if (m->kind == SCENE_MATERIAL_COATED_DIFFUSE || m->kind == SCENE_MATERIAL_COATED_CONDUCTOR)
            assert_near((double)m->coat_eta, 1.5, 0);
        if (m->kind == SCENE_MATERIAL_DIELECTRIC || m->kind == SCENE_MATERIAL_THIN_DIELECTRIC)
            assert_near((double)m->eta[0], 1.5, 0);
        if (m->kind == SCENE_MATERIAL_CONDUCTOR || m->kind == SCENE_MATERIAL_COATED_CONDUCTOR)
            assert_true(m->k[0] > m->k[2] && m->eta[0] < m->eta[2]); /* copper is red */
        reading_end(&r);
    }
}

static void roughness_is_remapped_unless_told_otherwise(void **state)
{
    (void)state;
    reading_t r = read_material("\"dielectric\" \"float roughness\" .25 \"float vroughness\" .04");
    const scene_material_t *m = &r.scene.materials[0];
    assert_near((double)m->alpha_u.value[0], 0.5, CLOSE);
    assert_near((double)m->alpha_v.value[0], 0.2, CLOSE);
    assert_int_equal(m->remap_roughness, 1);
    reading_end(&r);
    r = read_material("\"coateddiffuse\" \"float roughness\" .25 \"bool remaproughness\" false");
    assert_near((double)r.scene.materials[0].coat_alpha_u.value[0], 0.25, 0);
    assert_near((double)r.scene.materials[0].alpha_u.value[0], 0, 0);
    assert_int_equal(r.scene.materials[0].remap_roughness, 0);
    reading_end(&r);
    r = read_material("\"coatedconductor\" \"float conductor.roughness\" .16 \"float interface.uroughness\" .09\n"
                      "\"float interface.eta\" 1.25 \"spectrum conductor.eta\" \"metal-Au-eta\"\n"
                      "\"spectrum conductor.k\" \"metal-Au-k\"");
    m = &r.scene.materials[0];
    assert_near((double)m->alpha_v.value[0], 0.4, CLOSE);
    assert_near((double)m->coat_alpha_u.value[0], 0.3, CLOSE);
    assert_near((double)m->coat_alpha_v.value[0], 0, 0);
    assert_near((double)m->coat_eta, 1.25, 0);
    assert_int_equal(import_notes_count(r.notes), 0);
    reading_end(&r);
    /* A texture keeps its values; the renderer maps them. */
    r = read_world("Texture \"t\" \"float\" \"checkerboard\" \"float tex1\" .3\n"
                   "Material \"conductor\" \"texture roughness\" \"t\" Shape \"sphere\"");
    assert_near((double)r.scene.materials[0].alpha_u.value[0], 1, 0);
    assert_int_equal(r.scene.materials[0].alpha_u.texture, 0);
    reading_end(&r);
    r = read_material("\"conductor\" \"float roughness\" 1.5");
    assert_near((double)r.scene.materials[0].alpha_u.value[0], 1, 0);
    assert_true(reading_notes(&r, "cut to 1"));
    reading_end(&r);
}

static void conductors_reflect_what_is_asked(void **state)
{
    (void)state;
    reading_t r = read_material("\"conductor\" \"rgb reflectance\" [.9 .5 .1]");
    const scene_material_t *m = &r.scene.materials[0];
    const double expected[3] = {0.9, 0.5, 0.1};
    for (int i = 0; i < 3; i++) { /* Fresnel at normal incidence: ((eta-1)^2 + k^2) / ((eta+1)^2 + k^2) */
        const double eta = (double)m->eta[i], k2 = (double)m->k[i] * (double)m->k[i];
        assert_near(((eta - 1) * (eta - 1) + k2) / ((eta + 1) * (eta + 1) + k2), expected[i], 1e-6);
    }
    reading_end(&r);
    r = read_material("\"conductor\" \"rgb eta\" [.2 .9 1.1] \"rgb k\" [9.2 6.3 4.8]");
    expect3(r.scene.materials[0].eta, 0.2, 0.9, 1.1, CLOSE);
    expect3(r.scene.materials[0].k, 9.2, 6.3, 4.8, CLOSE);
    reading_end(&r);
    read_world_fails("Material \"conductor\" \"rgb reflectance\" [1 1 1] \"rgb k\" [1 1 1]", FAULT_FORMAT,
                     WORDS("both"));
}

static void indices_of_refraction_come_in_many_ways(void **state)
{
    (void)state;
    static const char eta_file[] = "# nm eta\n400 1.6 500 1.5\n700 1.4\n";
    read_text_write("eta.spd", eta_file, sizeof eta_file - 1);
    static const struct {
        const char *text;
        double eta;
    } cases[] = {{"\"float eta\" 1.33", 1.33},
                 {"\"spectrum eta\" \"glass-BK7\"", 1.5168},
                 {"\"spectrum eta\" [500 1.5 700 1.7]", 1.5893}, /* at 589.3 nm */
                 {"\"spectrum eta\" \"eta.spd\"", 0}};
    for (size_t i = 0; i < 3; i++) {
        char text[128];
        snprintf(text, sizeof text, "\"dielectric\" %s", cases[i].text);
        reading_t r = read_material(text);
        assert_near((double)r.scene.materials[0].eta[0], cases[i].eta, CLOSE);
        reading_end(&r);
    }
    reading_t r = read_material("\"dielectric\" \"spectrum eta\" \"eta.spd\"");
    assert_true(r.scene.materials[0].eta[0] > 1.4f && r.scene.materials[0].eta[0] < 1.6f);
    reading_end(&r);
    read_world_fails("Material \"dielectric\" \"spectrum eta\" \"glass-of-water\"", FAULT_UNKNOWN,
                     WORDS("glass-of-water"));
    read_world_fails("Material \"dielectric\" \"spectrum eta\" [500 1.5 400 1.7]", FAULT_FORMAT,
                     WORDS("increasing"));
    read_world_fails("Material \"dielectric\" \"float eta\" -1", FAULT_RANGE, WORDS("refraction"));
}

static void mixtures_name_their_parts(void **state)
{
    (void)state;
    reading_t r = read_world("MakeNamedMaterial \"a\" \"string type\" \"diffuse\"\n"
                             "MakeNamedMaterial \"b\" \"string type\" \"dielectric\"\n"
                             "MakeNamedMaterial \"m\" \"string type\" \"mix\" \"string materials\" [\"b\" \"a\"]\n"
                             "\"float amount\" .3 NamedMaterial \"m\" Shape \"sphere\"");
    const scene_material_t *m = &r.scene.materials[r.scene.shapes[0].material];
    assert_int_equal(m->kind, SCENE_MATERIAL_MIX);
    assert_int_equal(m->first, 1);
    assert_int_equal(m->second, 0);
    assert_near((double)m->mix.value[0], 0.3, CLOSE);
    reading_end(&r);
    read_world_fails("Material \"mix\" \"string materials\" [\"x\" \"y\"]", FAULT_UNKNOWN, WORDS(":2:16", "\"x\""));
    read_world_fails("Material \"mix\" \"string materials\" [\"x\"]", FAULT_FORMAT, WORDS("two names"));
    read_world_fails("MakeNamedMaterial \"a\"", FAULT_FORMAT, WORDS("string type"));
}

static void other_materials_are_named(void **state)
{
    (void)state;
    reading_t r =
        read_world("Material \"subsurface\" \"rgb reflectance\" [.1 .2 .3] \"float x\" 3 Shape \"sphere\"\n"
                   "Material \"hair\" \"float eumelanin\" .3 Shape \"sphere\"\n"
                   "Material \"diffuse\" \"string normalmap\" \"bumps.png\" Shape \"sphere\"\n"
                   "Material \"coateddiffuse\" \"rgb albedo\" [.1 .1 .1] \"float thickness\" .1 Shape \"sphere\"");
    expect3(r.scene.materials[0].reflectance.value, 0.1, 0.2, 0.3, CLOSE);
    assert_true(reading_notes(&r, "\"subsurface\""));
    assert_true(reading_notes(&r, "\"hair\""));
    assert_true(reading_notes(&r, "\"normalmap\""));
    assert_true(reading_notes(&r, "albedo"));
    assert_int_equal(import_notes_count(r.notes), 4);
    reading_end(&r);
}

/* ---- textures ---- */

/* A picture of 2 x 2 as PFM: top row (1,0,0) (0,1,0), bottom row (0,0,1) (4,4,4). */
static void write_picture(const char *name)
{
    image_t image;
    fault_t fault = {0};
    uint8_t *data;
    size_t size;
    static const float texels[4][3] = {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}, {4, 4, 4}};
    assert_int_equal(image_init_rgb(&image, 2, 2, &fault), FAULT_NONE);
    for (uint32_t c = 0; c < 3; c++)
        for (int i = 0; i < 4; i++)
            image_channel(&image, c)[i] = texels[i][c];
    assert_int_equal(pfm_encode(&image, &data, &size, &fault), FAULT_NONE);
    read_text_write(name, data, size);
    free(data);
    image_clear(&image);
}

static void expect_color(const reading_t *r, int32_t texture, double u, double v, double red, double green,
                         double blue)
{
    const rgb_t c = texture_color(&r->scene, texture, u, v);
    assert_near(c.r, red, CLOSE);
    assert_near(c.g, green, CLOSE);
    assert_near(c.b, blue, CLOSE);
}

static void pictures_lie_as_in_pbrt(void **state)
{
    (void)state;
    write_picture("p.pfm");
    reading_t r = read_world(
        "Texture \"p\" \"spectrum\" \"imagemap\" \"string filename\" \"p.pfm\" \"string filter\" \"point\"\n"
        "Texture \"q\" \"spectrum\" \"imagemap\" \"string filename\" \"p.pfm\" \"float uscale\" 2\n"
        "\"float vdelta\" .5 \"float scale\" .5 \"bool invert\" true \"string wrap\" \"clamp\"\n"
        "Texture \"f\" \"float\" \"imagemap\" \"string filename\" \"p.pfm\"\n"
        "Material \"diffuse\" \"texture reflectance\" \"p\" Shape \"sphere\"");
    /* (u,v) = (0,0) is the lower left corner; texel centres at quarters. */
    expect_color(&r, 0, 0.25, 0.75, 1, 0, 0);
    expect_color(&r, 0, 0.75, 0.75, 0, 1, 0);
    expect_color(&r, 0, 0.25, 0.25, 0, 0, 1);
    expect_color(&r, 0, 1.75, -0.75, 4, 4, 4);   /* repeated */
    expect_color(&r, 1, 0.125, 0.25, 0.5, 1, 1); /* 1 - half of (1,0,0) */
    expect_color(&r, 1, 7, -7, 0, 0, 0);         /* 1 - half of (4,4,4), not below zero */
    assert_near(texture_scalar(&r.scene, 2, 0.25, 0.75), 1.0 / 3, CLOSE);
    assert_int_equal(r.scene.image_count, 1); /* one file, one image */
    assert_int_equal(r.scene.materials[r.scene.shapes[0].material].reflectance.texture, 0);
    assert_int_equal(import_notes_count(r.notes), 0);
    reading_end(&r);
    read_world_fails("Texture \"p\" \"spectrum\" \"imagemap\"", FAULT_FORMAT, WORDS("filename"));
    read_world_fails("Texture \"p\" \"spectrum\" \"imagemap\" \"string filename\" \"no.png\"", FAULT_NOT_FOUND,
                     WORDS(":2:1", "no.png"));
    read_text_write("text.png", "no picture", 10);
    read_world_fails("Texture \"p\" \"spectrum\" \"imagemap\" \"string filename\" \"text.png\"", FAULT_FORMAT,
                     WORDS("text.png", "not an image"));
    read_world_fails(
        "Texture \"p\" \"spectrum\" \"imagemap\" \"string filename\" \"p.pfm\" \"string encoding\" \"x\"",
        FAULT_UNKNOWN, WORDS("encoding"));
    read_world_fails("Texture \"p\" \"color\" \"constant\"", FAULT_TYPE, WORDS("\"color\""));
}

static void operations_on_constants_are_folded(void **state)
{
    (void)state;
    reading_t r = read_world(
        "Texture \"a\" \"spectrum\" \"constant\" \"rgb value\" [.1 .2 .4]\n"
        "Texture \"b\" \"spectrum\" \"scale\" \"texture tex\" \"a\" \"float scale\" 2\n"
        "Texture \"c\" \"spectrum\" \"mix\" \"texture tex1\" \"a\" \"texture tex2\" \"b\" \"float amount\" .25\n"
        "Texture \"k\" \"spectrum\" \"checkerboard\" \"texture tex1\" \"c\" \"rgb tex2\" [0 1 0]\n"
        "Texture \"d\" \"spectrum\" \"scale\" \"texture tex\" \"k\" \"float scale\" .5\n"
        "Texture \"w\" \"spectrum\" \"wrinkled\" \"integer octaves\" 3\n"
        "Material \"diffuse\" \"texture reflectance\" \"c\" Shape \"sphere\"\n"
        "Material \"diffuse\" \"texture reflectance\" \"d\" Shape \"sphere\"\n"
        "Material \"diffuse\" \"texture reflectance\" \"w\" Shape \"sphere\"");
    expect3(r.scene.materials[0].reflectance.value, 0.125, 0.25, 0.5, CLOSE);
    assert_int_equal(r.scene.materials[0].reflectance.texture, SCENE_NONE);
    const int32_t d = r.scene.materials[1].reflectance.texture;
    expect_color(&r, d, 0.5, 0.5, 0.0625, 0.125, 0.25);
    expect_color(&r, d, 1.5, 0.5, 0, 0.5, 0);
    expect_color(&r, d, -0.5, -0.5, 0.0625, 0.125, 0.25);
    expect3(r.scene.materials[2].reflectance.value, 0.5, 0.5, 0.5, 0);
    assert_int_equal(import_notes_count(r.notes), 1);
    assert_true(reading_notes(&r, "\"wrinkled\""));
    reading_end(&r);
}

/* ---- spectra ---- */

static void black_bodies_have_their_colours(void **state)
{
    (void)state;
    double last = 1e9;
    for (double kelvin = 1000; kelvin < 20000; kelvin *= 1.3) { /* ever bluer, at the luminance 1 */
        const rgb_t c = spectra_blackbody(kelvin, SPECTRA_LIGHT);
        assert_near(rgb_luminance(c), 1, 1e-12);
        assert_true(c.r / (c.b + 1e-3) < last);
        last = c.r / (c.b + 1e-3);
    }
    /* 6504 K is nearly D65: the Planckian locus passes it at a distance of 0.0055 in (x, y), a few percent in RGB.
     */
    const rgb_t white = spectra_blackbody(6504, SPECTRA_LIGHT);
    assert_near(white.r, 1, 0.06);
    assert_near(white.g, 1, 0.06);
    assert_near(white.b, 1, 0.06);
    /* CIE: illuminant A is the black body of 2856 K. The fit of the matching functions is good to a few percent. */
    rgb_t a;
    assert_true(spectra_named("stdillum-A", SPECTRA_LIGHT, &a));
    const rgb_t b = spectra_blackbody(2856, SPECTRA_LIGHT);
    assert_near(b.r, a.r, 0.05);
    assert_near(b.g, a.g, 0.05);
    assert_near(b.b, a.b, 0.05);
    assert_true(spectra_named("stdillum-D65", SPECTRA_LIGHT, &a));
    assert_near(a.r, 1, 2e-3);
    assert_near(a.b, 1, 2e-3);
}

static void tables_keep_constants_and_order(void **state)
{
    (void)state;
    static const double flat[] = {400, 0.37, 700, 0.37}, red[] = {400, 0, 580, 0, 600, 1, 700, 1};
    rgb_t c = spectra_of_pairs(flat, 2, SPECTRA_REFLECTANCE);
    assert_near(c.r, 0.37, 1e-12);
    assert_near(c.g, 0.37, 1e-12);
    assert_near(c.b, 0.37, 1e-12);
    c = spectra_of_pairs(red, 4, SPECTRA_REFLECTANCE);
    assert_true(c.r > 0.8 && c.r <= 1 && c.g < 0.2 && c.b < 0.05);
    c = spectra_of_pairs(red, 4, SPECTRA_LIGHT);
    assert_near(rgb_luminance(c), 1, 1e-12);
    assert_near(spectra_pairs_at(red, 4, 590), 0.5, 1e-12);
    assert_near(spectra_pairs_at(red, 4, 0), 0, 0);
    assert_near(spectra_pairs_at(red, 4, 1e4), 1, 0);
    /* Metals: bright, gold and copper reddish. Fresnel at normal incidence. */
    static const char *const names[] = {"Ag", "Al", "Au", "Cu", "CuZn"};
    for (size_t i = 0; i < 5; i++) {
        char name[32];
        rgb_t eta, k;
        snprintf(name, sizeof name, "metal-%s-eta", names[i]);
        assert_true(spectra_named(name, SPECTRA_UNBOUNDED, &eta));
        snprintf(name, sizeof name, "metal-%s-k", names[i]);
        assert_true(spectra_named(name, SPECTRA_UNBOUNDED, &k));
        const double red_part = ((eta.r - 1) * (eta.r - 1) + k.r * k.r) / ((eta.r + 1) * (eta.r + 1) + k.r * k.r);
        const double blue = ((eta.b - 1) * (eta.b - 1) + k.b * k.b) / ((eta.b + 1) * (eta.b + 1) + k.b * k.b);
        assert_true(red_part > 0.88 && red_part < 1);
        assert_true(i < 2 ? blue > 0.9 : blue < 0.75);
    }
    assert_false(spectra_named("metal-Xx-eta", SPECTRA_UNBOUNDED, &c));
    assert_false(spectra_named("metal-Ag-q", SPECTRA_UNBOUNDED, &c));
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(materials_have_pbrts_defaults),
        cmocka_unit_test(roughness_is_remapped_unless_told_otherwise),
        cmocka_unit_test(conductors_reflect_what_is_asked),
        cmocka_unit_test(indices_of_refraction_come_in_many_ways),
        cmocka_unit_test(mixtures_name_their_parts),
        cmocka_unit_test(other_materials_are_named),
        cmocka_unit_test(pictures_lie_as_in_pbrt),
        cmocka_unit_test(operations_on_constants_are_folded),
        cmocka_unit_test(black_bodies_have_their_colours),
        cmocka_unit_test(tables_keep_constants_and_order),
    };
    return cmocka_run_group_tests(tests, NULL, read_text_clean);
}
