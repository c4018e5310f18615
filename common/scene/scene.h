/* scene.h: a scene as data. Flat arrays of plain records, indices instead of pointers: what a bundle holds is what
 * the renderer reads, mapped into memory as it is.
 *
 * A scene_t is a view: it owns nothing. Its arrays belong to a scene_builder_t (made by a reader) or to a bundle_t
 * (opened from a file). Immutable while anyone renders it; any number of threads may read it.
 *
 * Conventions: world space, right- or left-handed as the reader left it; metres or any unit; angles in radians;
 * linear RGB (Rec. 709); positions are single precision (what Embree sees is what the double-precision hit uses).
 * Every index is checked by scene_check before anything else reads the scene.
 */
#ifndef SCENE_SCENE_H
#define SCENE_SCENE_H

#include <stddef.h>
#include <stdint.h>

#include "base/fault.h"

enum { SCENE_NONE = -1 }; /* an index that refers to nothing */

/* ---- images and textures ---- */

typedef enum scene_texel {
    SCENE_TEXEL_SRGB8 = 0, /* unsigned char, sRGB transfer function: decoded by a table */
    SCENE_TEXEL_LINEAR8 = 1,
    SCENE_TEXEL_FLOAT32 = 2
} scene_texel_t;

typedef struct scene_image {
    uint64_t offset; /* of the first texel in scene_t.texels, in bytes; a multiple of 16 */
    uint32_t width, height;
    uint32_t channels; /* 1, 3 or 4; the fourth is alpha (never sRGB-encoded) */
    uint32_t texel;    /* scene_texel_t; rows from the top, channels interleaved */
} scene_image_t;

typedef enum scene_texture_kind {
    SCENE_TEXTURE_CONSTANT = 0,     /* value */
    SCENE_TEXTURE_IMAGE = 1,        /* value * image(uv), bilinear; invert: 1 - it */
    SCENE_TEXTURE_SCALE = 2,        /* a * b * value */
    SCENE_TEXTURE_CHECKERBOARD = 3, /* a or b by the parity of floor(u) + floor(v) */
    SCENE_TEXTURE_MIX = 4           /* a (1 - m) + b m */
} scene_texture_kind_t;

typedef enum scene_wrap { SCENE_WRAP_REPEAT = 0, SCENE_WRAP_BLACK = 1, SCENE_WRAP_CLAMP = 2 } scene_wrap_t;

/* A parameter: a constant, times a texture where there is one. */
typedef struct scene_param {
    float value[3];  /* scalar parameters use value[0] */
    int32_t texture; /* index into textures, or SCENE_NONE */
} scene_param_t;

typedef struct scene_texture {
    uint32_t kind;                              /* scene_texture_kind_t */
    uint32_t wrap;                              /* scene_wrap_t, images */
    int32_t image;                              /* index into images, or SCENE_NONE */
    int32_t alpha_channel;                      /* 1: the scalar value is the image's fourth channel */
    float scale_u, scale_v, offset_u, offset_v; /* texture (u,v) = (scale_u u + offset_u, scale_v v + offset_v) */
    float value[3];
    uint32_t invert;
    scene_param_t a, b, m; /* operands; their texture index is less than this texture's own: no cycles */
} scene_texture_t;

/* ---- materials ---- */

typedef enum scene_material_kind {
    SCENE_MATERIAL_DIFFUSE = 0,
    SCENE_MATERIAL_COATED_DIFFUSE = 1,
    SCENE_MATERIAL_CONDUCTOR = 2,
    SCENE_MATERIAL_COATED_CONDUCTOR = 3,
    SCENE_MATERIAL_DIELECTRIC = 4,
    SCENE_MATERIAL_THIN_DIELECTRIC = 5,
    SCENE_MATERIAL_DIFFUSE_TRANSMISSION = 6,
    SCENE_MATERIAL_MIX = 7,       /* of the two materials `first`, `second`: share `mix` of the second */
    SCENE_MATERIAL_INTERFACE = 8, /* not there for light */
    SCENE_MATERIAL_KINDS
} scene_material_kind_t;

typedef struct scene_material {
    uint32_t kind;               /* scene_material_kind_t */
    uint32_t remap_roughness;    /* 1: textured roughness values go through alpha = sqrt(roughness); constants are
                                    remapped by the reader, whose roughness here is alpha */
    scene_param_t reflectance;   /* diffuse parts; in [0,1] */
    scene_param_t transmittance; /* diffuse transmission */
    scene_param_t alpha_u, alpha_v; /* GGX alpha along and across the tangent; below SCENE_ALPHA_SMOOTH: specular */
    float eta[3], k[3]; /* conductor: complex index per channel; dielectric: eta[0], interior over exterior */
    float coat_eta;     /* coated materials: index of the coat */
    scene_param_t coat_alpha_u, coat_alpha_v;
    scene_param_t mix;
    int32_t first, second; /* materials of a mix, less than this one's own index; else SCENE_NONE */
} scene_material_t;

/* GGX alpha below which a lobe is a perfect mirror: pbrt's threshold for "effectively smooth". */
#define SCENE_ALPHA_SMOOTH 1e-4f

/* ---- shapes ---- */

typedef enum scene_shape_kind {
    SCENE_SHAPE_MESH = 0,
    SCENE_SHAPE_SPHERE = 1, /* exact: centre and radius */
    SCENE_SHAPE_DISK = 2    /* exact: centre, unit normal, radius */
} scene_shape_kind_t;

enum {
    SCENE_SHAPE_NORMALS = 1, /* mesh: has vertex normals (else the geometric one shades) */
    SCENE_SHAPE_UVS = 2,     /* mesh: has texture coordinates (else (0,0), (1,0), (1,1) at the corners) */
    SCENE_SHAPE_FLIP = 4     /* the geometric normal is reversed (ReverseOrientation xor a mirroring transform) */
};

typedef struct scene_shape {
    uint32_t kind; /* scene_shape_kind_t */
    uint32_t flags;
    int32_t material;    /* index into materials */
    int32_t area_light;  /* index into lights of kind area, or SCENE_NONE */
    scene_param_t alpha; /* opacity: a hit counts with this probability (decided by a hash of the hit) */
    /* mesh: triangles [first_triangle, +triangles) of `indices`, vertices [first_vertex, +vertices) of positions,
     * normals, uvs; indices are relative to first_vertex. Geometric normal: (p1-p0) x (p2-p0), then the flip. */
    uint32_t first_vertex, vertices, first_triangle, triangles;
    /* sphere and disk */
    float centre[3], radius;
    float normal[3], pad0;  /* disk: unit normal; sphere: unit axis of its (u,v), pbrt's z axis */
    float tangent[3], pad1; /* unit, where u = 0 */
} scene_shape_t;

/* ---- lights ---- */

typedef enum scene_light_kind {
    SCENE_LIGHT_AREA = 0,     /* radiance from the side of the normal, or both; shapes point to it */
    SCENE_LIGHT_INFINITE = 1, /* radiance from direction w: radiance * image(to_light w) */
    SCENE_LIGHT_DISTANT = 2,  /* irradiance `radiance` at normal incidence, light travels along `direction` */
    SCENE_LIGHT_POINT = 3,    /* intensity */
    SCENE_LIGHT_SPOT = 4,     /* intensity, smooth falloff from cos_start down to cos_end */
    SCENE_LIGHT_KINDS
} scene_light_kind_t;

typedef struct scene_light {
    uint32_t kind; /* scene_light_kind_t */
    uint32_t two_sided;
    float radiance[3]; /* or intensity (W/sr), or irradiance for distant */
    int32_t image;     /* infinite: equal-area octahedral map (Clarberg 2008, as pbrt-v4), square, or SCENE_NONE */
    float position[3], cos_start;
    float direction[3], cos_end; /* unit; of travel, in world space */
    float to_light[9];           /* infinite: rows of the rotation world -> light */
    uint32_t pad[3];
} scene_light_t;

/* ---- camera and film ---- */

typedef enum scene_filter {
    SCENE_FILTER_BOX = 0,
    SCENE_FILTER_TRIANGLE = 1,
    SCENE_FILTER_GAUSSIAN = 2, /* pbrt's, sigma, minus its value at the radius */
    SCENE_FILTER_KINDS
} scene_filter_t;

/* Perspective camera: raster (x,y) in [0,width) x [0,height), y downwards, looks along +z in camera space through
 * the point ((x/width) (x1-x0) + x0, y1 - (y/height) (y1-y0), 1) * with the screen window in units of tan(angle).
 */
typedef struct scene_camera {
    double to_world[12];                /* rows of the 3x4 matrix camera -> world; may scale or mirror */
    double screen[4];                   /* x0, x1, y0, y1 at distance 1: tan(fov/2) included */
    double lens_radius, focal_distance; /* camera units; radius 0: pinhole */
    uint32_t width, height;             /* of the full film, pixels */
    uint32_t crop[4];                   /* x0, x1, y0, y1: pixels that are rendered, half open */
    uint32_t filter;                    /* scene_filter_t */
    uint32_t max_path_length;           /* what the scene file asks for, in segments; 0: nothing */
    double filter_radius[2], filter_sigma;
    double imaging_scale; /* pixel value per radiance: the film's exposure and ISO */
} scene_camera_t;

typedef struct scene {
    const float *positions;  /* 3 floats a vertex */
    const float *normals;    /* 3 floats a vertex where the shape has normals; others zero. Null if no shape has. */
    const float *uvs;        /* 2 floats a vertex, likewise */
    const uint32_t *indices; /* 3 a triangle */
    const scene_shape_t *shapes;
    const scene_material_t *materials;
    const scene_texture_t *textures;
    const scene_image_t *images;
    const uint8_t *texels;
    const scene_light_t *lights;
    const scene_camera_t *camera; /* exactly one */
    uint64_t vertex_count, triangle_count, texel_bytes;
    uint32_t shape_count, material_count, texture_count, image_count, light_count;
} scene_t;

/* Limits a scene must respect; a reader refuses what is larger. */
enum {
    SCENE_MAX_SHAPES = 1 << 22,
    SCENE_MAX_MATERIALS = 1 << 16,
    SCENE_MAX_TEXTURES = 1 << 16,
    SCENE_MAX_IMAGES = 1 << 14,
    SCENE_MAX_LIGHTS = 1 << 20,
    SCENE_MAX_IMAGE_SIZE = 1 << 15,
    SCENE_MAX_FILM_SIZE = 1 << 15
};
#define SCENE_MAX_VERTICES UINT64_C(2000000000)
#define SCENE_MAX_TRIANGLES UINT64_C(2000000000)
#define SCENE_MAX_TEXEL_BYTES (UINT64_C(1) << 36)
/* Largest magnitude of a coordinate; beyond about 1e18 Embree aborts. */
#define SCENE_MAX_COORDINATE 1e15f

/* Checks every index, count, kind and number (finite, in range; normals and directions of unit length; reflectances
 * in [0,1]; ...). The fault names the record: "shape 3: index 17 of triangle 5 is beyond its 12 vertices". */
fault_code_t scene_check(const scene_t *scene, fault_t *fault);

#endif
