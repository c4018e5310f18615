#include "client/import/pbrt_camera.h"

#include <string.h>

#define LARGEST_WINDOW 1e4
#define TO_RADIANS (MATH_PI / 180.0)

/* A list of exactly four numbers; null if absent. */
static fault_code_t four(pbrt_state_t *state, pbrt_params_t *params, const char *name, pbrt_type_t type,
                         const double **values)
{
    size_t count;
    PBRT_TRY(state, params, pbrt_params_numbers(params, name, PBRT_MASK(type), 1, values, &count, state->fault));
    if (*values && count != 4)
        return pbrt_fault(state, FAULT_FORMAT, "\"%s\" has %zu values, expected 4", name, count);
    return FAULT_NONE;
}

fault_code_t pbrt_camera(pbrt_state_t *state, const char *kind, pbrt_params_t *params)
{
    pbrt_view_t *view = &state->view;
    transform_t to_world;
    const double *window;
    if (strcmp(kind, "perspective") != 0)
        return pbrt_fault(state, FAULT_UNSUPPORTED, "Camera \"%s\" is not supported: expected \"perspective\"",
                          kind);
    PBRT_TRY(state, params, pbrt_params_float(params, "fov", 1e-3, 179.99, &view->fov, state->fault));
    PBRT_TRY(state, params, pbrt_params_float(params, "frameaspectratio", 1e-4, 1e4, &view->aspect, state->fault));
    PBRT_TRY(state, params, pbrt_params_float(params, "lensradius", 0, 1e15, &view->lens_radius, state->fault));
    PBRT_TRY(state, params,
             pbrt_params_float(params, "focaldistance", 1e-12, 1e15, &view->focal_distance, state->fault));
    TRY(four(state, params, "screenwindow", PBRT_FLOAT, &window));
    if (window) {
        memcpy(view->window, window, sizeof view->window);
        for (int i = 0; i < 4; i++)
            if (!(fabs(window[i]) <= LARGEST_WINDOW) || !(window[i | 1] > window[i & 2]))
                return pbrt_fault(state, FAULT_RANGE,
                                  "\"screenwindow\" (%g, %g, %g, %g): expected x0 < x1, y0 < y1", window[0],
                                  window[1], window[2], window[3]);
    }
    pbrt_params_ignore(params, "shutteropen");
    pbrt_params_ignore(params, "shutterclose");
    view->has_camera = true;
    view->camera_from_world = state->now.ctm;
    if (!transform_affine(&state->now.ctm) || !transform_invert(&state->now.ctm, &to_world))
        return pbrt_fault(state, FAULT_RANGE, "the camera's transformation cannot be inverted");
    return pbrt_set_space(state, "camera", &to_world);
}

static fault_code_t read_exposure(pbrt_state_t *state, pbrt_params_t *params)
{
    const char *sensor = "cie1931";
    double iso = 100, time = 1, white = 0;
    PBRT_TRY(state, params, pbrt_params_string(params, "sensor", &sensor, state->fault));
    PBRT_TRY(state, params, pbrt_params_float(params, "iso", 1e-6, 1e12, &iso, state->fault));
    PBRT_TRY(state, params, pbrt_params_float(params, "exposuretime", 1e-9, 1e9, &time, state->fault));
    PBRT_TRY(state, params, pbrt_params_float(params, "whitebalance", 0, 1e6, &white, state->fault));
    if (strcmp(sensor, "cie1931") != 0)
        pbrt_note(state, "Film sensor \"%s\" is not supported: \"cie1931\" is used", sensor);
    if (white != 0)
        pbrt_note(state, "Film \"whitebalance\" is not supported and is ignored");
    state->view.imaging_scale = time * iso / 100;
    return FAULT_NONE;
}

static fault_code_t read_crop(pbrt_state_t *state, pbrt_params_t *params)
{
    const double *crop, *bounds;
    pbrt_view_t *view = &state->view;
    TRY(four(state, params, "cropwindow", PBRT_FLOAT, &crop));
    TRY(four(state, params, "pixelbounds", PBRT_INTEGER, &bounds));
    for (int i = 0; crop && i < 4; i++) {
        if (!(crop[i] >= 0 && crop[i] <= 1 && crop[i | 1] > crop[i & 2]))
            return pbrt_fault(state, FAULT_RANGE,
                              "\"cropwindow\" (%g, %g, %g, %g): expected 0 <= x0 < x1 <= 1, same of y", crop[0],
                              crop[1], crop[2], crop[3]);
        view->crop[i] = crop[i];
    }
    view->has_bounds = bounds != NULL;
    for (int i = 0; bounds && i < 4; i++)
        view->bounds[i] = (int)bounds[i];
    return FAULT_NONE;
}

fault_code_t pbrt_film(pbrt_state_t *state, const char *kind, pbrt_params_t *params)
{
    static const char *const silent[] = {"filename", "diagonal", "savefp16", "maxcomponentvalue"};
    pbrt_view_t *view = &state->view;
    if (strcmp(kind, "gbuffer") == 0 || strcmp(kind, "spectral") == 0)
        pbrt_note(state, "Film \"%s\" is not supported: \"rgb\" is used", kind);
    else if (strcmp(kind, "rgb") != 0)
        return pbrt_fault(state, FAULT_UNKNOWN, "Film \"%s\": expected \"rgb\"", kind);
    PBRT_TRY(state, params,
             pbrt_params_int(params, "xresolution", 1, SCENE_MAX_FILM_SIZE, &view->width, state->fault));
    PBRT_TRY(state, params,
             pbrt_params_int(params, "yresolution", 1, SCENE_MAX_FILM_SIZE, &view->height, state->fault));
    for (size_t i = 0; i < sizeof silent / sizeof *silent; i++)
        pbrt_params_ignore(params, silent[i]);
    TRY(read_exposure(state, params));
    return read_crop(state, params);
}

fault_code_t pbrt_filter(pbrt_state_t *state, const char *kind, pbrt_params_t *params)
{
    pbrt_view_t *view = &state->view;
    view->filter = SCENE_FILTER_GAUSSIAN;
    double radius = 1.5;
    if (strcmp(kind, "box") == 0) {
        view->filter = SCENE_FILTER_BOX;
        radius = 0.5;
    } else if (strcmp(kind, "triangle") == 0) {
        view->filter = SCENE_FILTER_TRIANGLE;
        radius = 2;
    } else if (strcmp(kind, "gaussian") != 0) {
        if (strcmp(kind, "mitchell") != 0 && strcmp(kind, "sinc") != 0)
            return pbrt_fault(state, FAULT_UNKNOWN, "PixelFilter \"%s\": expected box, triangle or gaussian", kind);
        pbrt_note(state, "PixelFilter \"%s\" is not supported (it is negative in places): pbrt's gaussian is used",
                  kind);
        for (size_t i = 0; i < params->count; i++)
            params->items[i].used = true;
        view->filter_radius[0] = view->filter_radius[1] = radius;
        view->filter_sigma = 0.5;
        return FAULT_NONE;
    }
    view->filter_radius[0] = view->filter_radius[1] = radius;
    view->filter_sigma = 0.5;
    PBRT_TRY(state, params, pbrt_params_float(params, "xradius", 1e-3, 16, &view->filter_radius[0], state->fault));
    PBRT_TRY(state, params, pbrt_params_float(params, "yradius", 1e-3, 16, &view->filter_radius[1], state->fault));
    if (view->filter == SCENE_FILTER_GAUSSIAN)
        PBRT_TRY(state, params, pbrt_params_float(params, "sigma", 1e-3, 1e3, &view->filter_sigma, state->fault));
    return FAULT_NONE;
}

fault_code_t pbrt_integrator(pbrt_state_t *state, const char *kind, pbrt_params_t *params)
{
    (void)kind;
    PBRT_TRY(state, params, pbrt_params_int(params, "maxdepth", 0, 1 << 20, &state->view.max_depth, state->fault));
    for (size_t i = 0; i < params->count; i++) /* how to render is the job's affair */
        params->items[i].used = true;
    return FAULT_NONE;
}

/* The screen at distance 1: the shorter side is 2 tan(fov/2) long. */
static void set_screen(const pbrt_view_t *view, double screen[4])
{
    const double aspect = view->aspect > 0 ? view->aspect : (double)view->width / view->height;
    const double x = aspect > 1 ? aspect : 1, y = aspect > 1 ? 1 : 1 / aspect;
    const double window[4] = {-x, x, -y, y}, scale = tan(view->fov * TO_RADIANS / 2);
    for (int i = 0; i < 4; i++)
        screen[i] = scale * (view->window[1] > view->window[0] ? view->window[i] : window[i]);
}

/* pbrt rounds the crop window's edges up; pixel bounds count as they are, within the film. */
static fault_code_t set_crop(pbrt_state_t *state, scene_camera_t *camera)
{
    const pbrt_view_t *view = &state->view;
    for (int i = 0; i < 4; i++) {
        const int size = i < 2 ? view->width : view->height;
        const int edge = view->has_bounds ? view->bounds[i] : (int)ceil(size * view->crop[i]);
        camera->crop[i] = (uint32_t)(edge < 0 ? 0 : edge > size ? size : edge);
    }
    if (camera->crop[0] >= camera->crop[1] || camera->crop[2] >= camera->crop[3])
        return pbrt_fault(state, FAULT_RANGE, "the film's crop window x %u to %u, y %u to %u holds no pixel",
                          camera->crop[0], camera->crop[1], camera->crop[2], camera->crop[3]);
    return FAULT_NONE;
}

fault_code_t pbrt_set_camera(pbrt_state_t *state)
{
    const pbrt_view_t *view = &state->view;
    scene_camera_t camera = {.lens_radius = view->lens_radius,
                             .focal_distance = view->focal_distance,
                             .width = (uint32_t)view->width,
                             .height = (uint32_t)view->height,
                             .filter = view->filter,
                             .max_path_length = view->max_depth < 0 ? 0 : (uint32_t)view->max_depth + 1,
                             .filter_radius = {view->filter_radius[0], view->filter_radius[1]},
                             .filter_sigma = view->filter_sigma,
                             .imaging_scale = view->imaging_scale};
    transform_t to_world;
    if (!view->has_camera)
        pbrt_note(state, "no Camera before WorldBegin: pbrt's default is used, at the origin, looking along +z");
    if (!transform_invert(&view->camera_from_world, &to_world))
        return pbrt_fault(state, FAULT_RANGE, "the camera's transformation cannot be inverted");
    for (int i = 0; i < 3; i++)
        for (int j = 0; j < 4; j++)
            camera.to_world[4 * i + j] = to_world.m[i][j];
    set_screen(view, camera.screen);
    TRY(set_crop(state, &camera));
    scene_builder_set_camera(state->builder, &camera);
    return FAULT_NONE;
}
