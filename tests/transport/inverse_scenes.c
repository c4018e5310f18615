#include "inverse_scenes.h"

#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>
#include <setjmp.h>
#include <cmocka.h>

#include "client/import/pbrt.h"
#include "load.h"
#include "scene/builder.h"

#define QUAD(points) "Shape \"trianglemesh\" \"point3 P\" [ " points " ] \"integer indices\" [ 0 1 2 0 2 3 ]\n"
#define QUAD_UV(points)                                                                                            \
    "Shape \"trianglemesh\" \"point3 P\" [ " points                                                                \
    " ] \"integer indices\" [ 0 1 2 0 2 3 ] \"point2 uv\" [ 0 0 1 0 "                                              \
    "1 1 0 1 ]\n"
#define SPHERE(place, radius)                                                                                      \
    "AttributeBegin\nTranslate " place "\nShape \"sphere\" \"float radius\" [ " radius " ]\nAttributeEnd\n"
#define HEAD(camera)                                                                                               \
    camera "PixelFilter \"box\" \"float xradius\" [ 0.5 ] \"float yradius\" [ 0.5 ]\n"                             \
           "Film \"rgb\" \"string filename\" [ \"image.exr\" ] \"integer xresolution\" [ 8 ] \"integer "           \
           "yresolution\" [ 8 ]\n"

static const char furnace[] = HEAD(
    "LookAt 0.1 0.2 0.95  0 0 0  0 1 0\n") "Camera \"perspective\" \"float fov\" [ 70 ]\nWorldBegin\n"
                                           "AttributeBegin\n"
                                           "Material \"diffuse\" \"rgb reflectance\" [ 0.8 0.8 0.8 "
                                           "]\nAreaLightSource \"diffuse\" \"rgb L\" [ 1 1 1 ]\n" QUAD(
                                               "-1 -1 -1  -1 -1 1  1 -1 1  1 -1 -1") QUAD("-1 1 -1  1 1 -1  1 1 1  "
                                                                                          "-1 1 1") QUAD("-1 -1 -1 "
                                                                                                         " 1 -1 -1 "
                                                                                                         " 1 1 -1  "
                                                                                                         "-1 1 -1")
                                               QUAD("-1 -1 1  -1 1 1  1 1 1  1 -1 1") QUAD("-1 -1 -1  -1 1 -1  -1 "
                                                                                           "1 1  -1 -1 1") QUAD(
                                                   "1 -1 -1  1 -1 1  1 1 1  1 1 -1") "AttributeEnd\n"
                                                                                     "Material \"dielectric\" "
                                                                                     "\"float eta\" [ 1.5 "
                                                                                     "]\n" SPHERE("0.4 0.3 0.2", "0"
                                                                                                                 "."
                                                                                                                 "3"
                                                                                                                 "5") "Material \"conductor\" \"rgb reflectance\" [ 0.9 0.9 0.9 ]\n" SPHERE(
                                                                                         "-0.5 -0.4 0",
                                                                                         "0.3") "Material "
                                                                                                "\"coateddiffuse\" "
                                                                                                "\"rgb "
                                                                                                "reflectance\" [ "
                                                                                                "0.7 0.7 0.7 ] "
                                                                                                "\"float "
                                                                                                "roughness\" [ 0 "
                                                                                                "]\n" SPHERE("-0.4 "
                                                                                                             "0.5 "
                                                                                                             "-0.3",
                                                                                                             "0.3") "Material \"dielectric\" \"float eta\" [ 1.3 ] \"float roughness\" [ 0.4 ]\n" SPHERE("0.4 -0.5 -0.4",
                                                                                                                                                                                                         "0.3");

static const char skies[] = HEAD(
    "LookAt 0 1.2 4.5  0 0.4 0  0 1 0\n") "Camera \"perspective\" \"float fov\" [ 38 ] \"float lensradius\" [ 0.05 "
                                          "] \"float focaldistance\" [ 4 ]\n"
                                          "WorldBegin\nLightSource \"infinite\" \"rgb L\" [ 0.5 0.6 0.8 ]\n"
                                          "AttributeBegin\nRotate 40 1 2 0\nLightSource \"infinite\" \"string "
                                          "filename\" [ \"sky.pfm\" ]\nAttributeEnd\n"
                                          "LightSource \"distant\" \"point3 from\" [ 2 5 3 ] \"point3 to\" [ 0 0 0 "
                                          "] \"rgb L\" [ 1.5 1.4 1.2 ]\n"
                                          "Texture \"tiles\" \"spectrum\" \"checkerboard\" \"float uscale\" [ 6 ] "
                                          "\"float vscale\" [ 6 ] \"rgb tex1\" [ 0.8 0.8 0.7 ] \"rgb tex2\" [ 0.2 "
                                          "0.3 0.2 ]\n"
                                          "Material \"diffuse\" \"texture reflectance\" [ \"tiles\" ]\n" QUAD_UV(
                                              "-3 0 -3  -3 0 3  3 0 3  3 0 -3") "Material \"coateddiffuse\" "
                                                                                "\"texture reflectance\" [ "
                                                                                "\"tiles\" ] \"float roughness\" [ "
                                                                                "0.2 ]\n" SPHERE("-0.7 0.5 0",
                                                                                                 "0.5") "Material "
                                                                                                        "\"dielectr"
                                                                                                        "ic\" "
                                                                                                        "\"float "
                                                                                                        "eta\" [ "
                                                                                                        "1.5 "
                                                                                                        "]"
                                                                                                        "\n" SPHERE("0.5 0.4 0.6",
                                                                                                                    "0.4");

static const char lamps
    [] = HEAD("LookAt 0 1 4.2  0 1 0  0 1 0\n") "Camera \"perspective\" \"float fov\" [ 38 ]\nWorldBegin\n"
                                                "Material \"diffuse\" \"rgb reflectance\" [ 0.7 0.7 0.68 ]\n" QUAD(
                                                    "-1 0 -1  -1 0 1  1 0 1  1 0 -1") QUAD("-1 2 -1  1 2 -1  1 2 1 "
                                                                                           " -1 2 1") QUAD("-1 0 "
                                                                                                           "-1  1 "
                                                                                                           "0 -1  "
                                                                                                           "1 2 -1 "
                                                                                                           " -1 2 "
                                                                                                           "-1")
                                                    QUAD("-1 0 -1  -1 2 -1  -1 2 1  -1 0 1") QUAD("1 0 -1  1 0 1  "
                                                                                                  "1 2 1  1 2 -1") "AttributeBegin\nAreaLightSource \"diffuse\" \"rgb L\" [ 8 7 6 ]\n" SPHERE(
                                                        "-0.5 1.6 0",
                                                        "0.15") "AttributeEnd\n"
                                                                "AttributeBegin\nAreaLightSource \"diffuse\" \"rgb "
                                                                "L\" [ 6 7 8 ]\nTranslate 0.5 1.5 0\nRotate 160 1 "
                                                                "0.2 0\n"
                                                                "Shape \"disk\" \"float radius\" [ 0.2 "
                                                                "]\nAttributeEnd\n"
                                                                "AttributeBegin\nAreaLightSource \"diffuse\" \"rgb "
                                                                "L\" [ 3 3 3 ] \"bool twosided\" [ true ]\n" QUAD(
                                                                    "-0.1 1 0.3  0.2 1 0.3  0.2 1.3 0.4  -0.1 1.3 "
                                                                    "0.4") "AttributeEnd\n"
                                                                           "Material \"conductor\" \"rgb "
                                                                           "reflectance\" [ 0.8 0.7 0.6 ] \"float "
                                                                           "uroughness\" [ 0.1 ] \"float "
                                                                           "vroughness\" [ 0.5 ] \"bool "
                                                                           "remaproughness\" [ false ]\n" SPHERE(
                                                                               "-0.4 0.4 0.1",
                                                                               "0.35") "Material "
                                                                                       "\"coatedconductor\" \"rgb "
                                                                                       "reflectance\" [ 0.8 0.7 "
                                                                                       "0.6 ] \"float "
                                                                                       "conductor.roughness\" [ "
                                                                                       "0.3 ] \"float "
                                                                                       "interface.roughness\" [ "
                                                                                       "0.2 ]\n" SPHERE("0.5 0.4 "
                                                                                                        "-0.2",
                                                                                                        "0.35") "Ma"
                                                                                                                "ke"
                                                                                                                "Na"
                                                                                                                "me"
                                                                                                                "dM"
                                                                                                                "at"
                                                                                                                "er"
                                                                                                                "ia"
                                                                                                                "l "
                                                                                                                "\""
                                                                                                                "a"
                                                                                                                "\""
                                                                                                                " "
                                                                                                                "\""
                                                                                                                "st"
                                                                                                                "ri"
                                                                                                                "ng"
                                                                                                                " t"
                                                                                                                "yp"
                                                                                                                "e"
                                                                                                                "\""
                                                                                                                " ["
                                                                                                                " "
                                                                                                                "\""
                                                                                                                "di"
                                                                                                                "ff"
                                                                                                                "us"
                                                                                                                "e"
                                                                                                                "\""
                                                                                                                " ]"
                                                                                                                " "
                                                                                                                "\""
                                                                                                                "rg"
                                                                                                                "b "
                                                                                                                "re"
                                                                                                                "fl"
                                                                                                                "ec"
                                                                                                                "ta"
                                                                                                                "nc"
                                                                                                                "e"
                                                                                                                "\""
                                                                                                                " ["
                                                                                                                " 0"
                                                                                                                ".9"
                                                                                                                " 0"
                                                                                                                ".9"
                                                                                                                " 0"
                                                                                                                ".9"
                                                                                                                " ]"
                                                                                                                "\n"
                                                                                                                "Ma"
                                                                                                                "ke"
                                                                                                                "Na"
                                                                                                                "me"
                                                                                                                "dM"
                                                                                                                "at"
                                                                                                                "er"
                                                                                                                "ia"
                                                                                                                "l "
                                                                                                                "\""
                                                                                                                "b"
                                                                                                                "\""
                                                                                                                " "
                                                                                                                "\""
                                                                                                                "st"
                                                                                                                "ri"
                                                                                                                "ng"
                                                                                                                " t"
                                                                                                                "yp"
                                                                                                                "e"
                                                                                                                "\""
                                                                                                                " ["
                                                                                                                " "
                                                                                                                "\""
                                                                                                                "co"
                                                                                                                "nd"
                                                                                                                "uc"
                                                                                                                "to"
                                                                                                                "r"
                                                                                                                "\""
                                                                                                                " ]"
                                                                                                                " "
                                                                                                                "\""
                                                                                                                "rg"
                                                                                                                "b "
                                                                                                                "re"
                                                                                                                "fl"
                                                                                                                "ec"
                                                                                                                "ta"
                                                                                                                "nc"
                                                                                                                "e"
                                                                                                                "\""
                                                                                                                " ["
                                                                                                                " 0"
                                                                                                                ".9"
                                                                                                                " 0"
                                                                                                                ".9"
                                                                                                                " 0"
                                                                                                                ".9"
                                                                                                                " ]"
                                                                                                                "\n"
                                                                                                                "Ma"
                                                                                                                "ke"
                                                                                                                "Na"
                                                                                                                "me"
                                                                                                                "dM"
                                                                                                                "at"
                                                                                                                "er"
                                                                                                                "ia"
                                                                                                                "l "
                                                                                                                "\""
                                                                                                                "c"
                                                                                                                "\""
                                                                                                                " "
                                                                                                                "\""
                                                                                                                "st"
                                                                                                                "ri"
                                                                                                                "ng"
                                                                                                                " t"
                                                                                                                "yp"
                                                                                                                "e"
                                                                                                                "\""
                                                                                                                " ["
                                                                                                                " "
                                                                                                                "\""
                                                                                                                "th"
                                                                                                                "in"
                                                                                                                "di"
                                                                                                                "el"
                                                                                                                "ec"
                                                                                                                "tr"
                                                                                                                "ic"
                                                                                                                "\""
                                                                                                                " ]"
                                                                                                                " "
                                                                                                                "\""
                                                                                                                "fl"
                                                                                                                "oa"
                                                                                                                "t "
                                                                                                                "et"
                                                                                                                "a"
                                                                                                                "\""
                                                                                                                " ["
                                                                                                                " 1"
                                                                                                                ".5"
                                                                                                                " ]"
                                                                                                                "\n"
                                                                                                                "Ma"
                                                                                                                "ke"
                                                                                                                "Na"
                                                                                                                "me"
                                                                                                                "dM"
                                                                                                                "at"
                                                                                                                "er"
                                                                                                                "ia"
                                                                                                                "l "
                                                                                                                "\""
                                                                                                                "d"
                                                                                                                "\""
                                                                                                                " "
                                                                                                                "\""
                                                                                                                "st"
                                                                                                                "ri"
                                                                                                                "ng"
                                                                                                                " t"
                                                                                                                "yp"
                                                                                                                "e"
                                                                                                                "\""
                                                                                                                " ["
                                                                                                                " "
                                                                                                                "\""
                                                                                                                "mi"
                                                                                                                "x"
                                                                                                                "\""
                                                                                                                " ]"
                                                                                                                " "
                                                                                                                "\""
                                                                                                                "st"
                                                                                                                "ri"
                                                                                                                "ng"
                                                                                                                " m"
                                                                                                                "at"
                                                                                                                "er"
                                                                                                                "ia"
                                                                                                                "ls"
                                                                                                                "\""
                                                                                                                " ["
                                                                                                                " "
                                                                                                                "\""
                                                                                                                "a"
                                                                                                                "\""
                                                                                                                " "
                                                                                                                "\""
                                                                                                                "b"
                                                                                                                "\""
                                                                                                                " ]"
                                                                                                                " "
                                                                                                                "\""
                                                                                                                "fl"
                                                                                                                "oa"
                                                                                                                "t "
                                                                                                                "am"
                                                                                                                "ou"
                                                                                                                "nt"
                                                                                                                "\""
                                                                                                                " ["
                                                                                                                " 0"
                                                                                                                ".4"
                                                                                                                " ]"
                                                                                                                "\n"
                                                                                                                "Ma"
                                                                                                                "te"
                                                                                                                "ri"
                                                                                                                "al"
                                                                                                                " "
                                                                                                                "\""
                                                                                                                "mi"
                                                                                                                "x"
                                                                                                                "\""
                                                                                                                " "
                                                                                                                "\""
                                                                                                                "st"
                                                                                                                "ri"
                                                                                                                "ng"
                                                                                                                " m"
                                                                                                                "at"
                                                                                                                "er"
                                                                                                                "ia"
                                                                                                                "ls"
                                                                                                                "\""
                                                                                                                " ["
                                                                                                                " "
                                                                                                                "\""
                                                                                                                "d"
                                                                                                                "\""
                                                                                                                " "
                                                                                                                "\""
                                                                                                                "c"
                                                                                                                "\""
                                                                                                                " ]"
                                                                                                                " "
                                                                                                                "\""
                                                                                                                "fl"
                                                                                                                "oa"
                                                                                                                "t "
                                                                                                                "am"
                                                                                                                "ou"
                                                                                                                "nt"
                                                                                                                "\""
                                                                                                                " ["
                                                                                                                " 0"
                                                                                                                ".4"
                                                                                                                " ]"
                                                                                                                "\n" QUAD(
                                                                                                                    "0 0.1 0.5  0.8 0.1 0.5  0.8 0.9 0.6  0 0.9 0.6");

static scene_builder_t *builder;
static scene_t made;
static char folder[64];

void inverse_scene_clear(void)
{
    scene_builder_destroy(&builder);
    load_clear();
    if (folder[0]) {
        char path[80];
        snprintf(path, sizeof path, "%s/sky.pfm", folder);
        unlink(path);
        rmdir(folder);
        folder[0] = 0;
    }
}

/* A square of 8 x 8 texels of quite different brightness, some of them black. */
static void write_sky(void)
{
    char path[80];
    strcpy(folder, "/tmp/garland-inverse-XXXXXX");
    assert_non_null(mkdtemp(folder));
    snprintf(path, sizeof path, "%s/sky.pfm", folder);
    FILE *file = fopen(path, "wb");
    assert_non_null(file);
    fprintf(file, "PF\n8 8\n-1.0\n");
    for (int i = 0; i < 64; i++) {
        const float value = i % 7 == 3 ? 0 : (float)(i * 37 % 64) / 32 + (i == 21 ? 20 : 0);
        const float texel[3] = {value, 0.9f * value, 0.8f * value};
        assert_int_equal(fwrite(texel, sizeof texel, 1, file), 1);
    }
    assert_int_equal(fclose(file), 0);
}

static const scene_t *make(const char *name, const char *text, size_t size)
{
    fault_t fault = {0};
    builder = scene_builder_new();
    import_notes_t *notes = import_notes_new();
    if (pbrt_read_text(name, folder[0] ? folder : ".", text, size, builder, notes, &fault))
        fail_msg("%s", fault.text);
    import_notes_destroy(&notes);
    made = scene_builder_view(builder);
    if (scene_check(&made, &fault))
        fail_msg("%s: %s", name, fault.text);
    return &made;
}

const scene_t *inverse_scene(const char *name)
{
    inverse_scene_clear();
    if (strcmp(name, "glass-furnace") == 0)
        return make(name, furnace, sizeof furnace - 1);
    if (strcmp(name, "lamps") == 0)
        return make(name, lamps, sizeof lamps - 1);
    if (strcmp(name, "skies") != 0)
        return load_scene(name);
    write_sky();
    return make(name, skies, sizeof skies - 1);
}
