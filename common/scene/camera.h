/* camera.h: the perspective camera as a source of importance.
 *
 * Raster coordinates are continuous, (0,0) the top left corner of the *rendered* (cropped) image, (width, height)
 * its bottom right. The sampled domain is larger by the filter's radius minus half a pixel on each side, so that
 * pixels at the edge see their whole filter; a splat lands on the pixel of its position after filter_offset, or
 * nowhere.
 *
 * Film override. A film of another shape than the scene's keeps the shorter axis's extent (pbrt's fov is along the
 * shorter axis) and adapts the longer one about the same centre; the ratio of a pixel's sides stays as it was. The
 * crop is kept in proportion, rounded to whole pixels.
 *
 * Any invertible camera matrix will do: a mirror, a scale and a shear only change the image plane's vectors. Under
 * a non-uniform scale the lens is an ellipse.
 *
 * Accuracy: camera_eval and camera_invert give back what camera_sample made to about 1e-15 of the film, plus, with
 * a lens, the rounding of its point in world space, 1e-16 |origin| (over the focal distance in directions, over the
 * lens's radius in lens numbers).
 *
 * Importance W is such that pixel j = integral h_j(raster) L(ray) d raster, with the pixel's area as unit and the
 * integral of the filter h_j equal to 1: with W cos dA_lens domega = d raster * dA_lens/A_lens. Values: W(w) =
 * jacobian (raster area per solid angle) / (cos * A_lens) for a lens, without A_lens for a pinhole (a delta
 * position). The film's imaging scale is included.
 *
 * Filter. With f the scene's filter, normalised, h_j(x) = f(x - c_j) / H(x), c_j the pixel's centre, H(x) = sum
 * over all pixels of f(x - c_j) (H = 1 for boxes of a whole number of pixels and triangles of a whole radius; 1 +-
 * 0.02 for pbrt's default Gaussian): the weights of the pixels add up to one everywhere, so a splat goes to one
 * pixel, chosen by one offset that doesn't depend on the place. A caller who wants f itself multiplies its splat by
 * camera_filter_weight.
 *
 * Dimensions: film x, film y, lens 1, lens 2 (lens ones unused by a pinhole). Pure; any thread.
 */
#ifndef SCENE_CAMERA_H
#define SCENE_CAMERA_H

#include <stdbool.h>

#include "base/fault.h"
#include "math/vec.h"
#include "scene/scene.h"

enum { CAMERA_FILTER_STEPS = 256 };

typedef struct camera {
    vec3_t origin;               /* world: the pinhole or the lens's centre */
    vec3_t right, down, forward; /* unit, world; forward: the image plane's normal */
    vec3_t corner, dx, dy;     /* world: raster (x,y) looks along corner + x dx + y dy, which has 1 along forward */
    vec3_t raster_x, raster_y; /* of a point p on the plane at distance 1: raster x = (p - corner) . raster_x */
    vec3_t lens_x, lens_y;     /* world: the lens's half axes; zero for a pinhole */
    vec3_t unlens_x, unlens_y; /* of a point q on the lens: disk x = (q - origin) . unlens_x */
    double raster_x0, raster_y0, raster_w, raster_h; /* the sampled domain */
    double raster_x1, raster_y1;                     /* its largest coordinates: just below its ends */
    double plane_pixel_area;                         /* of one pixel on the plane at distance 1 */
    double lens_radius, focal_distance, lens_area;   /* world units; area 1 for a pinhole */
    double imaging_scale;
    uint32_t width, height; /* of the rendered image, pixels */
    uint32_t filter;
    double filter_radius[2], filter_sigma;
    bool pinhole, filter_is_box; /* a box of one pixel needs no offset and has the weight 1 */
    double filter_offset[2]
                        [CAMERA_FILTER_STEPS + 1]; /* x, y: the offset's distribution function at equal steps over
                                                      +-(radius - 1/2) */
} camera_t;

/* From the scene's camera with an optional film override (0: the scene's): the crop is kept in proportion. */
fault_code_t camera_init(camera_t *camera, const scene_camera_t *data, uint32_t width, uint32_t height,
                         fault_t *fault);

typedef struct camera_sample {
    vec3_t origin;        /* on the lens */
    vec3_t direction;     /* unit, world */
    vec2_t raster;        /* in the sampled domain */
    double pdf_position;  /* per lens area; 1 (discrete) for a pinhole */
    double pdf_direction; /* per solid angle */
    double weight; /* W cos / (pdf_position pdf_direction): the number of pixels in the sampled domain * scale */
} camera_sample_t;

/* film[2], lens[2] in [0,1). */
void camera_sample(const camera_t *camera, const double film[2], const double lens[2], camera_sample_t *out);

/* A point on the lens for a connection, uniform over it; returns its density per area (1 for a pinhole). */
double camera_sample_lens(const camera_t *camera, const double lens[2], vec3_t *point);

typedef struct camera_value {
    vec2_t raster;
    double importance;    /* W for (lens point, direction) */
    double pdf_direction; /* per solid angle, of camera_sample taking this direction from this point */
} camera_value_t;

/* Importance from the lens point `origin` towards the unit world direction; false if it misses the sampled domain.
 */
bool camera_eval(const camera_t *camera, vec3_t origin, vec3_t direction, camera_value_t *out);

/* Inverse: numbers that camera_sample maps to this origin and direction; lens numbers of a pinhole are taken from
 * free_numbers[2]. */
bool camera_invert(const camera_t *camera, vec3_t origin, vec3_t direction, const double free_numbers[2],
                   double film[2], double lens[2]);

/* A sample of the filter as an offset in raster space, u in [0,1)^2: pixel = floor(raster + offset). Zero for a box
 * of one pixel and for a filter inside one. By inversion of the tabulated distribution: chances of pixels are right
 * to 1e-4 (a general box's steps are smeared over 1/256 of the support). */
vec2_t camera_filter_offset(const camera_t *camera, double u1, double u2);

/* H(raster) of above: the factor that makes the pixel's filter exactly the scene's. */
double camera_filter_weight(const camera_t *camera, vec2_t raster);

#endif
