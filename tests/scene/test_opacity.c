/* Opacity is a share of hits and a function of the ray; emitters are opaque, interfaces are not there. */
#include "accel_fixture.h"
#include "scene/surface.h"

enum { VEIL_QUAD = 0, VEIL_DISK, VEIL_SPHERE, VEILS };

/* A quad, a disk and a sphere side by side, 10 apart, each with this opacity. */
static void veils_make(small_scene_t *veils, float opacity, scene_material_kind_t kind, int32_t alpha_texture)
{
    const scene_material_t material = small_material(kind);
    static const float square[] = {-1, -1, 0, 1, -1, 0, 1, 1, 0, -1, 1, 0}, z[3] = {0, 0, 1};
    small_scene_begin(veils);
    const uint32_t index = small_add_material(veils, &material);
    if (alpha_texture >= 0) {
        /* opaque where floor(u) + floor(v) is even */
        const scene_texture_t texture = {.kind = SCENE_TEXTURE_CHECKERBOARD,
                                         .image = SCENE_NONE,
                                         .scale_u = 4,
                                         .scale_v = 2,
                                         .value = {1, 1, 1},
                                         .a = {{1, 1, 1}, SCENE_NONE},
                                         .b = {{0, 0, 0}, SCENE_NONE},
                                         .m = {{0, 0, 0}, SCENE_NONE}};
        fault_t fault = {0};
        assert_int_equal(scene_builder_add_texture(veils->builder, &texture, &(uint32_t){0}, &fault), FAULT_NONE);
    }
    small_add_quads(veils, index, SCENE_NONE, square, 1);
    small_add_disk(veils, index, (const float[]){10, 0, 0}, z, 1);
    small_add_sphere(veils, index, (const float[]){20, 0, 0}, 1);
    small_set_camera(veils, 0, 0, 5, 0.5);
    small_scene_finish(veils);
    /* the builder has no way to set the opacity of what is in it */
    scene_shape_t *shapes = (scene_shape_t *)(uintptr_t)veils->scene.shapes;
    for (int i = 0; i < VEILS; i++)
        shapes[i].alpha = (scene_param_t){{opacity, opacity, opacity}, alpha_texture};
}

/* Rays along -z through the middle of shape `which`; counts hits at the first and at a second surface (spheres). */
static void veil_count(const small_scene_t *veils, const accel_t *accel, int which, int rays, int *first,
                       int *second, int *blocked)
{
    stream_t stream = stream_of(10 + (uint64_t)which);
    *first = *second = *blocked = 0;
    for (int i = 0; i < rays; i++) {
        const vec3_t p = stream_point(&stream, 0.69);
        const vec3_t o = vec3(10 * which + p.x, p.y, 3), d = vec3(1e-3 * p.z, 0, -1);
        accel_hit_t hit;
        if (accel_intersect(accel, o, d, &hit) == ACCEL_HIT) {
            surface_t at;
            assert_int_equal(hit.shape, which);
            assert_true(surface_at_hit(&veils->scene, &hit, o, d, false, &at));
            *(at.position.z >= 0 ? first : second) += 1;
        }
        *blocked += accel_occluded(accel, o, vec3_mad(o, 6, d)) == ACCEL_HIT;
    }
}

/* |count - n p| <= 5.1 sqrt(n p (1 - p)): a false alarm in 3e-7. */
static void assert_share(const char *what, int count, int n, double p)
{
    assert_near((double)count / n, p, 5.1 * sqrt(p * (1 - p) / n));
    (void)what;
}

static void opacity_is_the_share_of_hits(void **state)
{
    (void)state;
    enum { RAYS = 20000 };
    static const float opacities[] = {0, 1, 0.5f, 0.125f};
    for (size_t i = 0; i < sizeof opacities / sizeof *opacities; i++) {
        small_scene_t veils;
        const double a = (double)opacities[i];
        veils_make(&veils, opacities[i], SCENE_MATERIAL_DIFFUSE, SCENE_NONE);
        accel_t *accel = accel_of(&veils.scene);
        for (int which = 0; which < VEILS; which++) {
            int first, second, blocked;
            veil_count(&veils, accel, which, RAYS, &first, &second, &blocked);
            const double back = which == VEIL_SPHERE ? (1 - a) * a : 0; /* a sphere has two sides */
            assert_share("first", first, RAYS, a);
            assert_share("second", second, RAYS, back);
            assert_share("blocked", blocked, RAYS, a + back);
        }
        accel_destroy(&accel);
        small_scene_clear(&veils);
    }
}

static void opacity_is_a_function_of_the_ray(void **state)
{
    (void)state;
    small_scene_t veils;
    veils_make(&veils, 0.5f, SCENE_MATERIAL_DIFFUSE, SCENE_NONE);
    accel_t *accel = accel_of(&veils.scene), *other = accel_of(&veils.scene);
    stream_t stream = stream_of(20);
    for (int i = 0; i < 3000; i++) {
        const vec3_t p = stream_point(&stream, 0.69), o = vec3(10 * (i % VEILS) + p.x, p.y, 3), d = vec3(0, 0, -1);
        const vec3_t to = vec3(o.x, o.y, -3);
        accel_hit_t hit;
        const accel_answer_t answer = accel_intersect(accel, o, d, &hit);
        assert_int_equal(accel_intersect(other, o, d, &hit), answer);
        assert_int_equal(accel_occluded(accel, o, to), accel_occluded(other, o, to));
        assert_int_equal(accel_occluded(accel, o, to), accel_occluded(accel, to, o));
    }
    accel_destroy(&accel);
    accel_destroy(&other);
    small_scene_clear(&veils);
}

/* A texture of squares says which hits count; the second way is the texture coordinates that surface_at_hit gives.
 */
static void opacity_textures_are_looked_up_at_the_hit(void **state)
{
    (void)state;
    small_scene_t veils, plain;
    veils_make(&veils, 1, SCENE_MATERIAL_DIFFUSE, 0);
    veils_make(&plain, 1, SCENE_MATERIAL_DIFFUSE, SCENE_NONE);
    accel_t *accel = accel_of(&veils.scene), *solid = accel_of(&plain.scene);
    stream_t stream = stream_of(21);
    int seen[VEILS][2] = {{0}};
    for (int i = 0; i < 6000; i++) {
        const int which = i % VEILS;
        const vec3_t p = stream_point(&stream, 0.69), o = vec3(10 * which + p.x, p.y, 3), d = vec3(0, 0, -1);
        accel_hit_t hit, through;
        surface_t at;
        assert_int_equal(accel_intersect(solid, o, d, &hit), ACCEL_HIT);
        assert_true(surface_at_hit(&plain.scene, &hit, o, d, true, &at));
        const double u = 4 * at.u, v = 2 * at.v;
        if (fabs(u - rint(u)) < 1e-4 || fabs(v - rint(v)) < 1e-4)
            continue; /* on a line, where single precision may decide otherwise */
        const int opaque = ((int)floor(u) + (int)floor(v)) % 2 == 0;
        const bool front = accel_intersect(accel, o, d, &through) == ACCEL_HIT && fabs(through.t - hit.t) < 1e-5;
        if (front != (opaque != 0))
            fail_msg("shape %d at (u, v) = (%g, %g): %s, expected %s", which, at.u, at.v, front ? "hit" : "passed",
                     opaque ? "hit" : "passed");
        seen[which][opaque]++;
    }
    for (int which = 0; which < VEILS; which++)
        assert_true(seen[which][0] > 300 && seen[which][1] > 300);
    accel_destroy(&accel);
    accel_destroy(&solid);
    small_scene_clear(&veils);
    small_scene_clear(&plain);
}

static void emitters_are_opaque(void **state)
{
    (void)state;
    small_scene_t furnace;
    small_scene_furnace(&furnace, 0.5, 1);
    scene_shape_t *shape = (scene_shape_t *)(uintptr_t)furnace.scene.shapes;
    shape->alpha.value[0] = 0;
    accel_t *accel = accel_of(&furnace.scene);
    stream_t stream = stream_of(22);
    accel_hit_t hit;
    for (int i = 0; i < 1000; i++)
        assert_int_equal(accel_intersect(accel, stream_point(&stream, 0.9), stream_direction(&stream), &hit),
                         ACCEL_HIT);
    accel_destroy(&accel);
    small_scene_clear(&furnace);
}

static void interfaces_are_not_hit(void **state)
{
    (void)state;
    small_scene_t veils;
    veils_make(&veils, 1, SCENE_MATERIAL_INTERFACE, SCENE_NONE);
    accel_t *accel = accel_of(&veils.scene);
    for (int which = 0; which < VEILS; which++) {
        int first, second, blocked;
        veil_count(&veils, accel, which, 1000, &first, &second, &blocked);
        assert_int_equal(first + second + blocked, 0);
    }
    accel_destroy(&accel);
    small_scene_clear(&veils);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(opacity_is_the_share_of_hits),
        cmocka_unit_test(opacity_is_a_function_of_the_ray),
        cmocka_unit_test(opacity_textures_are_looked_up_at_the_hit),
        cmocka_unit_test(emitters_are_opaque),
        cmocka_unit_test(interfaces_are_not_hit),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
