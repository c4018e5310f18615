/* scene_list.h: the project's scenes on which algorithms and moves are compared, each a test of its own.
 *
 *     static void check(const char *name) { ... load_scene(name) ... }
 *     SCENE_LIST(SCENE_TEST)
 *     const struct CMUnitTest tests[] = {SCENE_LIST(SCENE_ENTRY)};
 */
#ifndef TESTS_TRANSPORT_SCENE_LIST_H
#define TESTS_TRANSPORT_SCENE_LIST_H

#define SCENE_LIST(X)                                                                                              \
    X(diffuse_room, "diffuse")                                                                                     \
    X(glossy_room, "glossy")                                                                                       \
    X(specular_room, "glass")                                                                                      \
    X(sky_and_sun, "environment")                                                                                  \
    X(point_and_spot, "delta-lights")                                                                              \
    X(lens_and_filter, "lens")                                                                                     \
    X(transmitting_screens, "transmission")                                                                        \
    X(interpolated_normals, "normals")

#define SCENE_ONE(function, name) +1
enum { SCENES = SCENE_LIST(SCENE_ONE) };

#define SCENE_NAME(function, name) name,

/* Defines a test that calls check(name). */
#define SCENE_TEST(function, name)                                                                                 \
    static void function(void **state)                                                                             \
    {                                                                                                              \
        (void)state;                                                                                               \
        check(name);                                                                                               \
    }
#define SCENE_ENTRY(function, name) cmocka_unit_test(function),

#endif
