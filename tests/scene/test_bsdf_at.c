/* Materials into lobes: what was resolved beforehand, what textures change, what is refused. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <cmocka.h>

#include <string.h>

#include "scene/bsdf_coat.h"

#include "bsdf_fixture.h"

static int32_t checkerboard(fixture_t *f, float a, float b)
{
    const scene_param_t none = {{0, 0, 0}, SCENE_NONE};
    scene_texture_t *t = &f->textures[f->texture_count];
    *t = (scene_texture_t){
        .kind = SCENE_TEXTURE_CHECKERBOARD, .image = SCENE_NONE, .scale_u = 1, .scale_v = 1, .m = none};
    t->a = (scene_param_t){{a, a, a}, SCENE_NONE};
    t->b = (scene_param_t){{b, b, b}, SCENE_NONE};
    return (int32_t)f->texture_count++;
}

static int32_t constant(fixture_t *f, float value)
{
    const scene_param_t none = {{1, 1, 1}, SCENE_NONE};
    scene_texture_t *t = &f->textures[f->texture_count];
    *t = (scene_texture_t){.kind = SCENE_TEXTURE_CONSTANT, .image = SCENE_NONE, .value = {value, value, value}};
    t->a = t->b = t->m = none;
    return (int32_t)f->texture_count++;
}

static void constant_materials_are_resolved_beforehand(void **state)
{
    (void)state;
    static fixture_t f;
    fixture_init(&f);
    for (uint32_t m = 0; m < f.count; m++) {
        bsdf_t scratch = {.count = 77}, copy;
        const bsdf_t *ready = bsdf_resolve(&f.scene, f.tables, m, 0.3, 0.4, &scratch);
        assert_ptr_equal(ready, fixture_bsdf(&f, m));
        assert_int_equal(scratch.count, 77);
        bsdf_at(&f.scene, f.tables, m, 0.3, 0.4, &copy);
        assert_int_equal(copy.count, ready->count);
        assert_int_equal(copy.flags, ready->flags);
        assert_memory_equal(copy.lobes, ready->lobes, ready->count * sizeof *copy.lobes);
        assert_int_equal(bsdf_material_flags(f.tables, m), ready->flags);
    }
    fixture_clear(&f);
}

static void textures_are_looked_up_and_clamped(void **state)
{
    (void)state;
    fixture_t f = {0};
    const uint32_t board = fixture_diffuse(&f, "board", 1, 0.5F, 1);
    f.materials[board].reflectance.texture = checkerboard(&f, 0.25F, 3);
    const uint32_t plain = fixture_diffuse(&f, "plain", 1, 0.5F, 1);
    f.materials[plain].reflectance.texture = constant(&f, 0.5F);
    fixture_make(&f);
    bsdf_t scratch;
    assert_ptr_equal(bsdf_resolve(&f.scene, f.tables, board, 0.5, 0.5, &scratch), &scratch);
    assert_true(scratch.count == 1 && (scratch.flags & BSDF_ONLY_DIFFUSE));
    const double one = scratch.lobes[0].color.r, one_green = scratch.lobes[0].color.g;
    bsdf_at(&f.scene, f.tables, board, 1.5, 0.5, &scratch);
    const double other = scratch.lobes[0].color.r;
    assert_true(fmin(one, other) == 0.25 && fmax(one, other) == 1);
    assert_true(one_green == (one == 0.25 ? 0.125 : 1));
    assert_non_null(f.tables->ready[plain]); /* a texture that is constant all the way down */
    assert_true(f.tables->ready[plain]->lobes[0].color.g == 0.25);
    fixture_clear(&f);
}

static void textured_roughness_turns_specular_where_it_is_zero(void **state)
{
    (void)state;
    fixture_t f = {0};
    const uint32_t metal = fixture_conductor(&f, "metal", 1, 1);
    f.materials[metal].alpha_u.texture = f.materials[metal].alpha_v.texture = checkerboard(&f, 0, 0.25F);
    f.materials[metal].remap_roughness = 1;
    const uint32_t coat = fixture_coated_diffuse(&f, "coat", 0.5F, 1.5F, 1, 1);
    f.materials[coat].coat_alpha_u.texture = f.materials[coat].coat_alpha_v.texture = 0;
    fixture_make(&f);
    assert_int_equal(bsdf_material_flags(f.tables, metal), BSDF_HAS_SMOOTH | BSDF_HAS_SPECULAR);
    int rough = 0;
    for (int i = 0; i < 2; i++) {
        bsdf_t b;
        bsdf_at(&f.scene, f.tables, metal, 0.5 + i, 0.5, &b);
        assert_int_equal(b.count, 1);
        if (b.lobes[0].kind == BSDF_CONDUCTOR) {
            assert_true(b.lobes[0].alpha_u == 0.5); /* sqrt(0.25) */
            rough++;
        } else {
            assert_int_equal(b.lobes[0].kind, BSDF_MIRROR_CONDUCTOR);
        }
        bsdf_at(&f.scene, f.tables, coat, 0.5 + i, 0.5, &b);
        assert_int_equal(b.count, 2);
        const bool smooth = b.lobes[0].kind == BSDF_MIRROR_COAT;
        assert_true(smooth || (b.lobes[0].kind == BSDF_COAT && b.lobes[0].alpha_u == 0.25));
        double through;
        const double e =
            bsdf_coat_albedo(&f.tables->coats[b.lobes[1].coat], vec3(0.8, 0, 0.6), b.lobes[1].coat_row, &through);
        const double expected =
            smooth ? fresnel_dielectric(0.6, 1.5) : bsdf_coat_quadrature(1.5, 0.25, 0.25, vec3(0.8, 0, 0.6), 3);
        assert_true(fabs(e - expected) < (smooth ? 1e-6 : 4e-3));
    }
    assert_int_equal(rough, 1);
    fixture_clear(&f);
}

static void mixtures_are_flattened_and_weighted(void **state)
{
    (void)state;
    fixture_t f = {0};
    const uint32_t red = fixture_diffuse(&f, "red", 0.8F, 0, 0), blue = fixture_diffuse(&f, "blue", 0, 0, 0.4F);
    const uint32_t paint = fixture_mix(&f, "paint", red, blue, 0.25F);
    const uint32_t metal = fixture_conductor(&f, "metal", 0.2F, 0.2F);
    const uint32_t worn = fixture_mix(&f, "worn", paint, metal, 0.5F);
    const uint32_t none = fixture_mix(&f, "none of it", red, metal, 0);
    const uint32_t hole = fixture_add(&f, "hole", SCENE_MATERIAL_INTERFACE);
    const uint32_t lace = fixture_mix(&f, "lace", red, hole, 0.5F);
    const uint32_t black = fixture_diffuse(&f, "black", 0, 0, 0);
    fixture_make(&f);
    const bsdf_t *b = fixture_bsdf(&f, paint);
    assert_true(b->count == 1 && (b->flags & BSDF_ONLY_DIFFUSE));
    assert_true(fabs(b->lobes[0].color.r - 0.6) < 1e-7 && fabs(b->lobes[0].color.b - 0.1) < 1e-7);
    b = fixture_bsdf(&f, worn);
    assert_int_equal(b->count, 2);
    assert_true(fabs(b->lobes[0].color.r - 0.3) < 1e-7 && b->lobes[1].color.g == 0.5);
    assert_true(fixture_bsdf(&f, none)->flags & BSDF_ONLY_DIFFUSE);
    b = fixture_bsdf(&f, lace);
    assert_int_equal(b->flags, BSDF_HAS_SMOOTH | BSDF_HAS_SPECULAR | BSDF_HAS_TRANSMISSION);
    assert_int_equal(b->lobes[1].kind, BSDF_PASS);
    /* half of the light goes straight on */
    double through = 0;
    for (int i = 0; i < 1000; i++) {
        const double u[3] = {(i + 0.5) / 1000, 0.4, 0.7};
        bsdf_sample_t s;
        assert_true(bsdf_sample(b, f.tables, vec3(0.6, 0, 0.8), u, BSDF_RADIANCE, &s));
        if (!s.specular)
            continue;
        assert_true(s.transmitted && s.wi.x == -0.6 && s.wi.z == -0.8 && s.eta == 1);
        through += s.weight.r / 1000;
    }
    assert_true(fabs(through - 0.5) < 1.0 / 500);
    bsdf_sample_t s;
    const double u[3] = {0.1, 0.1, 0.1};
    assert_int_equal(fixture_bsdf(&f, black)->count, 0);
    assert_false(bsdf_sample(fixture_bsdf(&f, black), f.tables, vec3(0, 0, 1), u, BSDF_RADIANCE, &s));
    fixture_clear(&f);
}

static void too_many_lobes_are_refused(void **state)
{
    (void)state;
    fixture_t f = {0};
    fault_t fault = {0};
    uint32_t mix = fixture_conductor(&f, "0", 0.1F, 0.1F);
    for (int i = 0; i < 6; i++) {
        const uint32_t next = fixture_conductor(&f, "next", 0.1F, 0.1F);
        mix = fixture_mix(&f, "mix", mix, next, 0.5F);
    }
    f.scene.materials = f.materials;
    f.scene.material_count = f.count - 2; /* six lobes */
    assert_int_equal(bsdf_tables_new(&f.tables, &f.scene, &fault), FAULT_NONE);
    assert_int_equal(fixture_bsdf(&f, f.count - 3)->count, BSDF_MAX_LOBES);
    fixture_clear(&f);
    assert_null(f.tables);
    f.scene.material_count = f.count;
    assert_int_equal(bsdf_tables_new(&f.tables, &f.scene, &fault), FAULT_LIMIT);
    assert_null(f.tables);
    assert_non_null(strstr(fault.text, "material 12"));
    assert_non_null(strstr(fault.text, "7 lobes"));
}

/* Mixtures of one kind merge into one lobe however many they are; their work is limited all the same. */
static void deep_mixtures_are_refused(void **state)
{
    (void)state;
    fixture_t f = {0};
    fault_t fault = {0};
    uint32_t mix = fixture_diffuse(&f, "0", 0.5F, 0.5F, 0.5F);
    for (int i = 0; i < 40; i++)
        mix = fixture_mix(&f, "mix", mix, mix, 0.5F);
    f.scene.materials = f.materials;
    f.scene.material_count = f.count;
    assert_int_equal(bsdf_tables_new(&f.tables, &f.scene, &fault), FAULT_LIMIT);
    assert_non_null(strstr(fault.text, "material 9:")); /* 2^9 = 512 */
    f.scene.material_count = 9;
    assert_int_equal(bsdf_tables_new(&f.tables, &f.scene, &fault), FAULT_NONE);
    assert_true(fabs(fixture_bsdf(&f, 8)->lobes[0].color.r - 0.5) < 1e-7);
    fixture_clear(&f);
}

static void coats_are_shared_and_too_many_are_refused(void **state)
{
    (void)state;
    fixture_t f = {0};
    const uint32_t a = fixture_coated_diffuse(&f, "a", 0.1F, 1.5F, 0.2F, 0.2F);
    const uint32_t b = fixture_coated_diffuse(&f, "b", 0.7F, 1.5F, 0.2F, 0.2F);
    const uint32_t c = fixture_coated_diffuse(&f, "c", 0.7F, 1, 0.2F, 0.2F);
    fixture_make(&f);
    assert_int_equal(f.tables->coat_count, 1);
    assert_int_equal(f.tables->coat_of[a], f.tables->coat_of[b]);
    assert_true(fixture_bsdf(&f, c)->flags & BSDF_ONLY_DIFFUSE); /* a coat of index 1 is none */
    fixture_clear(&f);
    /* 63 textured coats of 33 rows are more than 2048 rows */
    fault_t fault = {0};
    const int32_t texture = checkerboard(&f, 0.1F, 0.9F);
    while (f.count < 3 + 63) {
        const uint32_t m = fixture_coated_diffuse(&f, "coat", 0.5F, 1.1F + 0.01F * (float)f.count, 1, 1);
        f.materials[m].coat_alpha_u.texture = f.materials[m].coat_alpha_v.texture = texture;
    }
    f.scene.textures = f.textures;
    f.scene.texture_count = f.texture_count;
    f.scene.material_count = f.count;
    assert_int_equal(bsdf_tables_new(&f.tables, &f.scene, &fault), FAULT_LIMIT);
    assert_non_null(strstr(fault.text, "material 65:"));
    assert_null(f.tables);
}

static void matched_indices_pass_light_on(void **state)
{
    (void)state;
    fixture_t f = {0};
    const uint32_t same = fixture_dielectric(&f, "same", 1, 0.3F, 0.3F);
    const uint32_t nearly = fixture_dielectric(&f, "nearly", 1.0000002F, 0.3F, 0.3F);
    fixture_make(&f);
    assert_int_equal(fixture_bsdf(&f, same)->lobes[0].kind, BSDF_PASS);
    assert_int_equal(fixture_bsdf(&f, nearly)->lobes[0].kind, BSDF_MIRROR_DIELECTRIC);
    fixture_clear(&f);
}

/* The feature layer's albedo: within a few per cent of the true one for what has no grazing rise. */
static void albedo_estimate_is_in_range(void **state)
{
    (void)state;
    static fixture_t f;
    fixture_init(&f);
    for (uint32_t m = 0; m < f.count; m++)
        for (int d = 0; d < FIXTURE_DIRECTIONS; d++) {
            const rgb_t a = bsdf_albedo(fixture_bsdf(&f, m), f.tables, fixture_direction(d));
            assert_true(a.r >= 0 && a.r <= 1 && a.g >= 0 && a.g <= 1 && a.b >= 0 && a.b <= 1);
            if (f.furnace[m])
                assert_true(a.r > 1 - 1e-4);
        }
    fixture_clear(&f);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(constant_materials_are_resolved_beforehand),
        cmocka_unit_test(textures_are_looked_up_and_clamped),
        cmocka_unit_test(textured_roughness_turns_specular_where_it_is_zero),
        cmocka_unit_test(mixtures_are_flattened_and_weighted),
        cmocka_unit_test(too_many_lobes_are_refused),
        cmocka_unit_test(deep_mixtures_are_refused),
        cmocka_unit_test(coats_are_shared_and_too_many_are_refused),
        cmocka_unit_test(matched_indices_pass_light_on),
        cmocka_unit_test(albedo_estimate_is_in_range),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
