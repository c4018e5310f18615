#include "scene/camera.h"

#include <string.h>

#include "math/warp.h"
#include "scene/camera_filter.h"

/* Largest filter radius, pixels: the sampled domain grows with it. */
#define CAMERA_MAX_FILTER_RADIUS 64.0

/* ---- set-up ---- */

/* The screen window (x0, x1, y0, y1 at distance 1) for a full film of another size. */
static void fit_screen(const scene_camera_t *data, double width, double height, double screen[4])
{
    memcpy(screen, data->screen, 4 * sizeof screen[0]);
    if (width * data->height == height * data->width)
        return;
    const double extent_x = screen[1] - screen[0], extent_y = screen[3] - screen[2];
    const double pixel_aspect = (extent_x / data->width) / (extent_y / data->height);
    /* the shorter extent, as a vertical one of square pixels */
    const double shorter = data->width < data->height ? extent_x / pixel_aspect : extent_y;
    const double unit = shorter / fmin(width, height); /* of a pixel's height */
    const double half_x = 0.5 * unit * width * pixel_aspect, half_y = 0.5 * unit * height;
    const double middle_x = 0.5 * (screen[0] + screen[1]), middle_y = 0.5 * (screen[2] + screen[3]);
    screen[0] = middle_x - half_x;
    screen[1] = middle_x + half_x;
    screen[2] = middle_y - half_y;
    screen[3] = middle_y + half_y;
}

/* A crop [x0, x1) of `from` pixels in proportion for `to` pixels; at least one pixel. */
static void scale_crop(uint32_t x0, uint32_t x1, uint32_t from, uint32_t to, uint32_t out[2])
{
    const double scale = (double)to / from;
    out[0] = (uint32_t)(x0 * scale + 0.5);
    out[1] = (uint32_t)(x1 * scale + 0.5);
    if (out[0] >= to)
        out[0] = to - 1;
    if (out[1] <= out[0])
        out[1] = out[0] + 1;
    if (out[1] > to)
        out[1] = to;
}

static vec3_t matrix_column(const scene_camera_t *data, int column)
{
    return vec3(data->to_world[column], data->to_world[4 + column], data->to_world[8 + column]);
}

/* a and b span a plane: *of_a, *of_b in it with a . of_a = b . of_b = 1, a . of_b = b . of_a = 0. */
static void dual_pair(vec3_t a, vec3_t b, vec3_t *of_a, vec3_t *of_b)
{
    const vec3_t n = vec3_cross(a, b);
    const double scale = 1 / vec3_dot(n, n);
    *of_a = vec3_scale(vec3_cross(b, n), scale);
    *of_b = vec3_scale(vec3_cross(n, a), scale);
}

static fault_code_t check_data(const scene_camera_t *data, uint32_t width, uint32_t height, fault_t *fault)
{
    if (data->width < 1 || data->height < 1 || data->width > SCENE_MAX_FILM_SIZE ||
        data->height > SCENE_MAX_FILM_SIZE)
        return fault_set(fault, FAULT_RANGE, "camera: the scene's film is %ux%u pixels, expected 1 to %d a side",
                         data->width, data->height, SCENE_MAX_FILM_SIZE);
    if (width > SCENE_MAX_FILM_SIZE || height > SCENE_MAX_FILM_SIZE)
        return fault_set(fault, FAULT_RANGE, "camera: a film of %ux%u pixels, expected at most %d a side", width,
                         height, SCENE_MAX_FILM_SIZE);
    if (data->crop[0] >= data->crop[1] || data->crop[1] > data->width || data->crop[2] >= data->crop[3] ||
        data->crop[3] > data->height)
        return fault_set(fault, FAULT_RANGE, "camera: crop %u..%u, %u..%u is empty or leaves the film of %ux%u",
                         data->crop[0], data->crop[1], data->crop[2], data->crop[3], data->width, data->height);
    if (!(data->screen[1] > data->screen[0] && data->screen[3] > data->screen[2] &&
          isfinite(data->screen[0] + data->screen[1] + data->screen[2] + data->screen[3])))
        return fault_set(fault, FAULT_RANGE, "camera: screen window %g..%g, %g..%g is empty", data->screen[0],
                         data->screen[1], data->screen[2], data->screen[3]);
    if (!(data->lens_radius >= 0 && isfinite(data->lens_radius)) ||
        (data->lens_radius > 0 && !(data->focal_distance > 0 && isfinite(data->focal_distance))))
        return fault_set(fault, FAULT_RANGE,
                         "camera: lens radius %g with focal distance %g, expected positive numbers",
                         data->lens_radius, data->focal_distance);
    if (!(data->imaging_scale > 0 && isfinite(data->imaging_scale)))
        return fault_set(fault, FAULT_RANGE, "camera: imaging scale %g, expected a positive number",
                         data->imaging_scale);
    return FAULT_NONE;
}

static fault_code_t set_filter(camera_t *camera, const scene_camera_t *data, fault_t *fault)
{
    if (data->filter >= SCENE_FILTER_KINDS)
        return fault_set(fault, FAULT_RANGE, "camera: filter kind %u is unknown", data->filter);
    camera->filter = data->filter;
    camera->filter_sigma = data->filter_sigma;
    for (int axis = 0; axis < 2; axis++) {
        const double radius = data->filter_radius[axis];
        if (!(radius > 0 && radius <= CAMERA_MAX_FILTER_RADIUS))
            return fault_set(fault, FAULT_RANGE, "camera: filter radius %g, expected a number above 0 and up to %g",
                             radius, CAMERA_MAX_FILTER_RADIUS);
        /* beyond, the Gaussian is a point or its difference from its rim drowns in rounding */
        if (data->filter == SCENE_FILTER_GAUSSIAN &&
            !(data->filter_sigma >= 1e-3 * radius && data->filter_sigma <= 1e3 * radius))
            return fault_set(fault, FAULT_RANGE,
                             "camera: filter sigma %g, expected 0.001 to 1000 times the radius %g",
                             data->filter_sigma, radius);
        camera->filter_radius[axis] = radius;
        if (radius > 0.5)
            camera_filter_tabulate(data->filter, radius, data->filter_sigma, camera->filter_offset[axis]);
    }
    camera->filter_is_box =
        data->filter == SCENE_FILTER_BOX && data->filter_radius[0] == 0.5 && data->filter_radius[1] == 0.5;
    return FAULT_NONE;
}

/* The image plane at distance 1 in world space. */
static fault_code_t set_plane(camera_t *camera, const scene_camera_t *data, const double screen[4], double width,
                              double height, const uint32_t crop[4], double *distance, fault_t *fault)
{
    const vec3_t mx = matrix_column(data, 0), my = matrix_column(data, 1), mz = matrix_column(data, 2);
    const vec3_t normal = vec3_cross(mx, my);
    const double area = vec3_length(normal), volume = fabs(vec3_dot(normal, mz));
    const double size = vec3_length(mx) * vec3_length(my) * vec3_length(mz);
    camera->origin = matrix_column(data, 3);
    if (!(volume > 1e-9 * size && isfinite(size) && vec3_finite(camera->origin)))
        return fault_set(fault, FAULT_RANGE,
                         "camera: its matrix has the volume %g and columns of lengths %g, %g, %g: "
                         "expected an invertible one",
                         volume, vec3_length(mx), vec3_length(my), vec3_length(mz));
    camera->forward = vec3_scale(normal, (vec3_dot(normal, mz) < 0 ? -1 : 1) / area);
    camera->right = vec3_unit(mx);
    camera->down = vec3_scale(my, -1 / vec3_length(my));
    *distance = volume / area; /* of camera space's plane z = 1, in world units */
    const double per_pixel_x = (screen[1] - screen[0]) / width, per_pixel_y = (screen[3] - screen[2]) / height;
    const double x0 = screen[0] + crop[0] * per_pixel_x, y0 = screen[3] - crop[2] * per_pixel_y;
    camera->corner = vec3_scale(vec3_mad(vec3_mad(mz, x0, mx), y0, my), 1 / *distance);
    camera->dx = vec3_scale(mx, per_pixel_x / *distance);
    camera->dy = vec3_scale(my, -per_pixel_y / *distance);
    camera->plane_pixel_area = vec3_length(vec3_cross(camera->dx, camera->dy));
    dual_pair(camera->dx, camera->dy, &camera->raster_x, &camera->raster_y);
    return FAULT_NONE;
}

static void set_lens(camera_t *camera, const scene_camera_t *data, double distance)
{
    camera->pinhole = data->lens_radius == 0;
    camera->lens_area = 1;
    if (camera->pinhole)
        return;
    camera->focal_distance = data->focal_distance * distance;
    camera->lens_x = vec3_scale(matrix_column(data, 0), data->lens_radius);
    camera->lens_y = vec3_scale(matrix_column(data, 1), -data->lens_radius);
    camera->lens_area = MATH_PI * vec3_length(vec3_cross(camera->lens_x, camera->lens_y));
    camera->lens_radius = sqrt(camera->lens_area * MATH_INV_PI);
    dual_pair(camera->lens_x, camera->lens_y, &camera->unlens_x, &camera->unlens_y);
}

fault_code_t camera_init(camera_t *camera, const scene_camera_t *data, uint32_t width, uint32_t height,
                         fault_t *fault)
{
    memset(camera, 0, sizeof *camera);
    TRY(check_data(data, width, height, fault));
    TRY(set_filter(camera, data, fault));
    const uint32_t full_width = width ? width : data->width, full_height = height ? height : data->height;
    double screen[4], distance = 1;
    fit_screen(data, full_width, full_height, screen);
    uint32_t crop[4];
    scale_crop(data->crop[0], data->crop[1], data->width, full_width, crop);
    scale_crop(data->crop[2], data->crop[3], data->height, full_height, crop + 2);
    TRY(set_plane(camera, data, screen, full_width, full_height, crop, &distance, fault));
    set_lens(camera, data, distance);
    camera->width = crop[1] - crop[0];
    camera->height = crop[3] - crop[2];
    const double margin_x = fmax(camera->filter_radius[0] - 0.5, 0),
                 margin_y = fmax(camera->filter_radius[1] - 0.5, 0);
    camera->raster_x0 = -margin_x;
    camera->raster_y0 = -margin_y;
    camera->raster_w = camera->width + 2 * margin_x;
    camera->raster_h = camera->height + 2 * margin_y;
    camera->raster_x1 = nextafter(camera->raster_x0 + camera->raster_w, camera->raster_x0);
    camera->raster_y1 = nextafter(camera->raster_y0 + camera->raster_h, camera->raster_y0);
    camera->imaging_scale = data->imaging_scale;
    if (!(camera->plane_pixel_area > 0 && camera->lens_area > 0 && isfinite(camera->plane_pixel_area) &&
          isfinite(camera->lens_area)))
        return fault_set(fault, FAULT_RANGE, "camera: a pixel of area %g or a lens of area %g is out of range",
                         camera->plane_pixel_area, camera->lens_area);
    return FAULT_NONE;
}

/* ---- sampling ---- */

/* Place on the lens relative to its centre. */
static vec3_t lens_offset(const camera_t *camera, const double lens[2])
{
    const vec2_t p = warp_disk(lens[0], lens[1]);
    return vec3_mad(vec3_scale(camera->lens_x, p.x), p.y, camera->lens_y);
}

/* The point on the image plane at distance 1 that a ray from the lens's place `offset` along w belongs to: what it
 * hits at the focal distance, divided by it. cosine = w . forward > 0. */
static vec3_t plane_point(const camera_t *camera, vec3_t offset, vec3_t w, double cosine)
{
    const vec3_t p = vec3_scale(w, 1 / cosine);
    return camera->pinhole ? p : vec3_mad(p, 1 / camera->focal_distance, offset);
}

static vec2_t raster_of_plane(const camera_t *camera, vec3_t p)
{
    const vec3_t d = vec3_sub(p, camera->corner);
    return (vec2_t){vec3_dot(d, camera->raster_x), vec3_dot(d, camera->raster_y)};
}

/* On the plane at distance 1, dA = d omega / cos^3; a lens's point only moves the plane (thin lens: the plane of
 * focus is the image plane scaled by the focal distance). d raster / d omega: */
static double raster_per_solid(const camera_t *camera, double cosine)
{
    return 1 / (camera->plane_pixel_area * cosine * cosine * cosine);
}

void camera_sample(const camera_t *camera, const double film[2], const double lens[2], camera_sample_t *out)
{
    out->raster.x = camera->raster_x0 + film[0] * camera->raster_w;
    out->raster.y = camera->raster_y0 + film[1] * camera->raster_h;
    vec3_t d = vec3_mad(vec3_mad(camera->corner, out->raster.x, camera->dx), out->raster.y, camera->dy);
    out->origin = camera->origin;
    out->pdf_position = 1;
    if (!camera->pinhole) {
        const vec3_t offset = lens_offset(camera, lens);
        d = vec3_mad(d, -1 / camera->focal_distance, offset);
        out->origin = vec3_add(camera->origin, offset);
        out->pdf_position = 1 / camera->lens_area;
    }
    out->direction = vec3_unit(d);
    const double cosine = vec3_dot(out->direction, camera->forward);
    const double raster_area = camera->raster_w * camera->raster_h;
    out->pdf_direction = raster_per_solid(camera, cosine) / raster_area;
    out->weight = raster_area * camera->imaging_scale;
}

double camera_sample_lens(const camera_t *camera, const double lens[2], vec3_t *point)
{
    *point = camera->pinhole ? camera->origin : vec3_add(camera->origin, lens_offset(camera, lens));
    return camera->pinhole ? 1 : 1 / camera->lens_area;
}

/* Fraction of the sampled domain by which a ray may miss it by rounding: then it counts as on the edge, so that
 * what camera_sample makes of u = 0 is found again. */
#define CAMERA_EDGE 1e-12

/* x in [low, high], just outside moved to the edge; false if it is further away. */
static bool clamp_to_domain(double *x, double low, double high)
{
    const double slack = CAMERA_EDGE * (high - low);
    if (!(*x >= low - slack && *x <= high + slack))
        return false;
    *x = math_min(math_max(*x, low), high);
    return true;
}

bool camera_eval(const camera_t *camera, vec3_t origin, vec3_t direction, camera_value_t *out)
{
    const double cosine = vec3_dot(direction, camera->forward);
    if (!(cosine > 0))
        return false;
    const vec3_t offset = vec3_sub(origin, camera->origin);
    out->raster = raster_of_plane(camera, plane_point(camera, offset, direction, cosine));
    if (!clamp_to_domain(&out->raster.x, camera->raster_x0, camera->raster_x1) ||
        !clamp_to_domain(&out->raster.y, camera->raster_y0, camera->raster_y1))
        return false;
    const double density = raster_per_solid(camera, cosine);
    out->pdf_direction = density / (camera->raster_w * camera->raster_h);
    out->importance = camera->imaging_scale * density / (cosine * camera->lens_area);
    return true;
}

bool camera_invert(const camera_t *camera, vec3_t origin, vec3_t direction, const double free_numbers[2],
                   double film[2], double lens[2])
{
    camera_value_t value;
    if (!camera_eval(camera, origin, direction, &value))
        return false;
    film[0] = warp_clamp_unit((value.raster.x - camera->raster_x0) / camera->raster_w);
    film[1] = warp_clamp_unit((value.raster.y - camera->raster_y0) / camera->raster_h);
    if (camera->pinhole) {
        lens[0] = free_numbers[0];
        lens[1] = free_numbers[1];
        return true;
    }
    const vec3_t offset = vec3_sub(origin, camera->origin);
    const vec2_t p = {vec3_dot(offset, camera->unlens_x), vec3_dot(offset, camera->unlens_y)};
    warp_disk_invert(p, &lens[0], &lens[1]);
    return true;
}

/* ---- filter ---- */

static double filter_offset_axis(const camera_t *camera, int axis, double u)
{
    const double radius = camera->filter_radius[axis];
    return radius > 0.5 ? camera_filter_invert(camera->filter_offset[axis], radius, u) : 0;
}

vec2_t camera_filter_offset(const camera_t *camera, double u1, double u2)
{
    if (camera->filter_is_box)
        return (vec2_t){0, 0};
    return (vec2_t){filter_offset_axis(camera, 0, u1), filter_offset_axis(camera, 1, u2)};
}

double camera_filter_weight(const camera_t *camera, vec2_t raster)
{
    if (camera->filter_is_box)
        return 1;
    return camera_filter_sum(camera->filter, camera->filter_radius[0], camera->filter_sigma, raster.x) *
           camera_filter_sum(camera->filter, camera->filter_radius[1], camera->filter_sigma, raster.y);
}
