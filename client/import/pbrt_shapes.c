#include "client/import/pbrt_shapes.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "client/import/pbrt_textures.h"
#include "client/import/ply.h"
#include "client/import/surfaces.h"

#define LARGEST_SIZE 1e15
#define TO_RADIANS (MATH_PI / 180.0)

/* ---- meshes ---- */

static void copy_floats(float *to, const double *from, uint64_t count)
{
    for (uint64_t i = 0; i < count; i++)
        to[i] = (float)from[i];
}

/* N and uv must be as many as P. */
static fault_code_t mesh_vectors(pbrt_state_t *state, pbrt_params_t *params, size_t points, const double **normals,
                                 const double **uvs)
{
    size_t count;
    const char *name = pbrt_params_find(params, "uv") ? "uv" : "st";
    PBRT_TRY(state, params,
             pbrt_params_numbers(params, "N", PBRT_MASK(PBRT_NORMAL) | PBRT_MASK(PBRT_VECTOR3), 3, normals, &count,
                                 state->fault));
    if (*normals && count != points)
        return pbrt_fault(state, FAULT_FORMAT, "%s has %zu normals for %zu points", params->what, count, points);
    PBRT_TRY(state, params,
             pbrt_params_numbers(params, name,
                                 PBRT_MASK(PBRT_POINT2) | PBRT_MASK(PBRT_VECTOR2) | PBRT_MASK(PBRT_FLOAT), 2, uvs,
                                 &count, state->fault));
    if (*uvs && count != points)
        return pbrt_fault(state, FAULT_FORMAT, "%s has %zu texture coordinates for %zu points", params->what, count,
                          points);
    return FAULT_NONE;
}

/* Indices below the number of points, in tuples; without any: 0, 1, ... if the points are one tuple. *indices is
 * the caller's to free(). */
static fault_code_t mesh_indices(pbrt_state_t *state, pbrt_params_t *params, size_t points, size_t tuple,
                                 uint32_t **indices, size_t *tuples)
{
    const double *numbers;
    *indices = NULL;
    PBRT_TRY(
        state, params,
        pbrt_params_numbers(params, "indices", PBRT_MASK(PBRT_INTEGER), tuple, &numbers, tuples, state->fault));
    if (!numbers && points != tuple)
        return pbrt_fault(state, FAULT_FORMAT, "%s has %zu points and no \"indices\"", params->what, points);
    if (!numbers)
        *tuples = 1;
    uint32_t *out = malloc(*tuples * tuple * sizeof *out);
    if (!out)
        return pbrt_fault(state, FAULT_MEMORY, "no memory for %zu indices", *tuples * tuple);
    for (size_t i = 0; i < *tuples * tuple; i++) {
        const double index = numbers ? numbers[i] : (double)i;
        if (!(index >= 0 && index < (double)points)) {
            free(out);
            return pbrt_fault(state, FAULT_RANGE, "%s: index %.0f at place %zu, expected 0 to %zu", params->what,
                              index, i, points - 1);
        }
        out[i] = (uint32_t)index;
    }
    *indices = out;
    return FAULT_NONE;
}

static fault_code_t mesh_points(pbrt_state_t *state, pbrt_params_t *params, const double **points, size_t *count)
{
    PBRT_TRY(state, params,
             pbrt_params_numbers(params, "P", PBRT_MASK(PBRT_POINT3), 3, points, count, state->fault));
    if (!*points)
        return pbrt_fault(state, FAULT_FORMAT, "%s has no \"point3 P\"", params->what);
    for (size_t i = 0; i < 3 * *count; i++)
        if (!(fabs((*points)[i]) <= 3e38))
            return pbrt_fault(state, FAULT_RANGE, "%s: %g is no coordinate of a point", params->what, (*points)[i]);
    return FAULT_NONE;
}

static fault_code_t make_trianglemesh(pbrt_state_t *state, pbrt_params_t *params, geometry_t *out)
{
    const double *points, *normals, *uvs;
    size_t count, triangles;
    uint32_t *indices;
    TRY(mesh_points(state, params, &points, &count));
    TRY(mesh_vectors(state, params, count, &normals, &uvs));
    TRY(mesh_indices(state, params, count, 3, &indices, &triangles));
    pbrt_params_ignore(params, "S");
    pbrt_params_ignore(params, "faceIndices");
    const fault_code_t code = geometry_new_mesh(out, count, triangles, normals != NULL, uvs != NULL, state->fault);
    if (code == FAULT_NONE) {
        copy_floats(out->positions, points, 3 * count);
        if (normals)
            copy_floats(out->normals, normals, 3 * count);
        if (uvs)
            copy_floats(out->uvs, uvs, 2 * count);
        memcpy(out->indices, indices, 3 * triangles * sizeof *indices);
    }
    free(indices);
    return code;
}

static fault_code_t make_loopsubdiv(pbrt_state_t *state, pbrt_params_t *params, geometry_t *out)
{
    pbrt_note(state, "loopsubdiv shapes are not subdivided: the control mesh is used");
    pbrt_params_ignore(params, "levels");
    pbrt_params_ignore(params, "scheme");
    return make_trianglemesh(state, params, out);
}

static fault_code_t make_plymesh(pbrt_state_t *state, pbrt_params_t *params, geometry_t *out)
{
    const char *filename = NULL;
    char path[PBRT_PATH_MAX];
    ply_mesh_t mesh;
    PBRT_TRY(state, params, pbrt_params_string(params, "filename", &filename, state->fault));
    if (!filename)
        return pbrt_fault(state, FAULT_FORMAT, "%s has no \"filename\"", params->what);
    if (pbrt_params_find(params, "displacement"))
        pbrt_note(state, "\"displacement\" of plymesh shapes is not supported and is ignored");
    pbrt_params_ignore(params, "displacement.edgelength");
    TRY(pbrt_resolve(state, filename, path));
    TRY(ply_read(path, &mesh, state->fault));
    if (mesh.small_faces > 0)
        pbrt_note(state, "%s: %llu faces of fewer than three corners are left out", filename,
                  (unsigned long long)mesh.small_faces);
    *out = (geometry_t){.kind = SCENE_SHAPE_MESH,
                        .positions = mesh.positions,
                        .normals = mesh.normals,
                        .uvs = mesh.uvs,
                        .indices = mesh.indices,
                        .vertices = mesh.vertices,
                        .triangles = mesh.triangles};
    return FAULT_NONE;
}

static fault_code_t make_bilinearmesh(pbrt_state_t *state, pbrt_params_t *params, geometry_t *out)
{
    const double *points, *normals, *uvs;
    size_t count, patches;
    uint32_t *indices;
    uint64_t curved;
    TRY(mesh_points(state, params, &points, &count));
    TRY(mesh_vectors(state, params, count, &normals, &uvs));
    if (pbrt_params_find(params, "emissionfilename"))
        pbrt_note(state, "\"emissionfilename\" of bilinearmesh shapes is not supported: emission is even");
    pbrt_params_ignore(params, "faceIndices");
    TRY(mesh_indices(state, params, count, 4, &indices, &patches));
    const fault_code_t code = surfaces_patches(out, points, normals, uvs, indices, patches, &curved, state->fault);
    free(indices);
    if (code == FAULT_NONE && curved > 0)
        pbrt_note(state, "bilinear patches that are no parallelograms are divided into %d x %d cells",
                  SURFACES_PATCH, SURFACES_PATCH);
    return code;
}

/* ---- quadrics ---- */

static fault_code_t read_size(pbrt_state_t *state, pbrt_params_t *params, const char *name, double lo,
                              double *value)
{
    PBRT_TRY(state, params, pbrt_params_float(params, name, lo, LARGEST_SIZE, value, state->fault));
    return FAULT_NONE;
}

static fault_code_t read_radius(pbrt_state_t *state, pbrt_params_t *params, double *radius)
{
    TRY(read_size(state, params, "radius", 0, radius));
    if (!(*radius > 0))
        return pbrt_fault(state, FAULT_RANGE, "%s has the radius %g", params->what, *radius);
    return FAULT_NONE;
}

static fault_code_t read_phi_max(pbrt_state_t *state, pbrt_params_t *params, double *radians)
{
    double degrees = 360;
    PBRT_TRY(state, params, pbrt_params_float(params, "phimax", 0, 1e6, &degrees, state->fault));
    if (!(degrees > 0))
        return pbrt_fault(state, FAULT_RANGE, "%s has the phimax %g", params->what, degrees);
    *radians = degrees >= 360 ? 2 * MATH_PI : degrees * TO_RADIANS;
    return FAULT_NONE;
}

static fault_code_t make_sphere(pbrt_state_t *state, pbrt_params_t *params, geometry_t *out)
{
    double radius = 1, phi_max = 360;
    TRY(read_radius(state, params, &radius));
    double z_min = -radius, z_max = radius;
    TRY(read_size(state, params, "zmin", -LARGEST_SIZE, &z_min));
    TRY(read_size(state, params, "zmax", -LARGEST_SIZE, &z_max));
    TRY(read_phi_max(state, params, &phi_max));
    const double low = fmax(fmin(z_min, z_max), -radius), high = fmin(fmax(z_min, z_max), radius);
    *out = (geometry_t){.kind = SCENE_SHAPE_SPHERE, .radius = radius};
    if (low <= -radius && high >= radius && phi_max >= 2 * MATH_PI)
        return FAULT_NONE;
    if (!(low < high))
        return pbrt_fault(state, FAULT_RANGE, "%s: nothing is between zmin %g and zmax %g", params->what, z_min,
                          z_max);
    pbrt_note(state, "parts of spheres are tessellated (%d facets around)", SURFACES_AROUND);
    return surfaces_sphere(out, radius, low, high, phi_max, state->fault);
}

static fault_code_t make_disk(pbrt_state_t *state, pbrt_params_t *params, geometry_t *out)
{
    double radius = 1, height = 0, inner = 0, phi_max = 360;
    TRY(read_radius(state, params, &radius));
    TRY(read_size(state, params, "height", -LARGEST_SIZE, &height));
    TRY(read_size(state, params, "innerradius", 0, &inner));
    TRY(read_phi_max(state, params, &phi_max));
    *out = (geometry_t){.kind = SCENE_SHAPE_DISK, .radius = radius, .height = height};
    if (inner == 0 && phi_max >= 2 * MATH_PI)
        return FAULT_NONE;
    if (!(inner < radius))
        return pbrt_fault(state, FAULT_RANGE, "%s: innerradius %g, expected less than the radius %g", params->what,
                          inner, radius);
    pbrt_note(state, "rings and sectors of disks are tessellated (%d facets around)", SURFACES_AROUND);
    return surfaces_disk(out, height, radius, inner, phi_max, state->fault);
}

static fault_code_t make_cylinder(pbrt_state_t *state, pbrt_params_t *params, geometry_t *out)
{
    double radius = 1, z_min = -1, z_max = 1, phi_max = 360;
    TRY(read_radius(state, params, &radius));
    TRY(read_size(state, params, "zmin", -LARGEST_SIZE, &z_min));
    TRY(read_size(state, params, "zmax", -LARGEST_SIZE, &z_max));
    TRY(read_phi_max(state, params, &phi_max));
    if (z_min == z_max)
        return pbrt_fault(state, FAULT_RANGE, "%s has no height", params->what);
    pbrt_note(state, "cylinders are tessellated (%d facets around)", SURFACES_AROUND);
    return surfaces_cylinder(out, radius, fmin(z_min, z_max), fmax(z_min, z_max), phi_max, state->fault);
}

static const struct {
    const char *name;
    fault_code_t (*make)(pbrt_state_t *, pbrt_params_t *, geometry_t *);
} kinds[] = {{"trianglemesh", make_trianglemesh},
             {"plymesh", make_plymesh},
             {"sphere", make_sphere},
             {"disk", make_disk},
             {"bilinearmesh", make_bilinearmesh},
             {"cylinder", make_cylinder},
             {"loopsubdiv", make_loopsubdiv}};

/* ---- placing ---- */

/* The light of this shape: shared, or with a radiance of its own where the power is given. */
static fault_code_t area_light(pbrt_state_t *state, pbrt_area_t *area, double surface, int32_t *index)
{
    scene_light_t light = {.kind = SCENE_LIGHT_AREA, .image = SCENE_NONE, .two_sided = area->two_sided};
    double scale = 1;
    uint32_t added;
    if (area->power < 0 && area->light != SCENE_NONE) {
        *index = area->light;
        return FAULT_NONE;
    }
    if (area->power >= 0) { /* power = luminance * pi * area * sides */
        const double emitted = rgb_luminance(area->radiance) * MATH_PI * surface * (area->two_sided ? 2 : 1);
        scale = emitted > 0 ? area->power / emitted : 0;
    }
    const rgb_t radiance = rgb_scale(area->radiance, scale);
    if (!(rgb_max(radiance) <= 1e30))
        return pbrt_fault(state, FAULT_RANGE, "a radiance of %g, expected at most 1e30", rgb_max(radiance));
    light.radiance[0] = (float)radiance.r;
    light.radiance[1] = (float)radiance.g;
    light.radiance[2] = (float)radiance.b;
    TRY(scene_builder_add_light(state->builder, &light, &added, state->fault));
    *index = (int32_t)added;
    if (area->power < 0)
        area->light = *index;
    return FAULT_NONE;
}

/* What is left out is counted: one note at the end says how much. */
static void note_placed(pbrt_state_t *state, const placed_t *placed)
{
    if (placed->degenerate + placed->no_normal > 0 && state->degenerate_line == 0) {
        snprintf(state->degenerate_file, sizeof state->degenerate_file, "%s", state->file);
        state->degenerate_line = state->line;
    }
    state->degenerate += placed->degenerate;
    state->no_normal += placed->no_normal;
    if (placed->tessellated)
        pbrt_note(state, "spheres and disks that are stretched are tessellated (%d facets around)",
                  SURFACES_AROUND);
}

static bool is_interface(const pbrt_state_t *state, int32_t material)
{
    return scene_builder_view(state->builder).materials[material].kind == SCENE_MATERIAL_INTERFACE;
}

static fault_code_t place(pbrt_state_t *state, const geometry_t *geometry, const transform_t *ctm, bool reverse,
                          int32_t material, scene_param_t alpha, int32_t area)
{
    placed_t placed;
    TRY(geometry_place(geometry, ctm, reverse, &placed, state->fault));
    note_placed(state, &placed);
    placed.shape.material = material;
    placed.shape.alpha = alpha;
    fault_code_t code = FAULT_NONE;
    if (area != SCENE_NONE && is_interface(state, material))
        pbrt_note(state, "area lights on shapes of the interface material emit nothing");
    else if (area != SCENE_NONE && placed.area > 0)
        code = area_light(state, &state->areas[area], placed.area, &placed.shape.area_light);
    if (code == FAULT_NONE && (placed.shape.kind != SCENE_SHAPE_MESH || placed.triangles > 0))
        code = geometry_add(&placed, state->builder, state->fault);
    placed_clear(&placed);
    return code;
}

/* Takes the geometry over. */
static fault_code_t keep(pbrt_state_t *state, geometry_t *geometry, int32_t material, scene_param_t alpha)
{
    pbrt_instanced_t *list = state->instanced_count < PBRT_MAX_INSTANCED
                                 ? pbrt_grown(state->instanced, state->instanced_count, sizeof *list)
                                 : NULL;
    if (!list) {
        geometry_clear(geometry);
        return pbrt_fault(state, FAULT_LIMIT, "more than %d shapes in objects, or no memory for them",
                          PBRT_MAX_INSTANCED);
    }
    state->instanced = list;
    list[state->instanced_count++] =
        (pbrt_instanced_t){*geometry, state->now.ctm, state->now.reverse, material, alpha};
    state->object_list[state->object_count - 1].count++;
    return FAULT_NONE;
}

fault_code_t pbrt_shape(pbrt_state_t *state, const char *kind, pbrt_params_t *params)
{
    geometry_t geometry = {0};
    scene_param_t alpha;
    bool given;
    int32_t material;
    size_t i = 0;
    while (i < sizeof kinds / sizeof *kinds && strcmp(kind, kinds[i].name) != 0)
        i++;
    if (i == sizeof kinds / sizeof *kinds) {
        pbrt_note(state, "shapes of the kind \"%s\" are not supported and are left out", kind);
        for (size_t j = 0; j < params->count; j++)
            params->items[j].used = true;
        return FAULT_NONE;
    }
    TRY(pbrt_scalar_param(state, params, "alpha", 1, &alpha, &given));
    TRY(pbrt_current_material(state, &material));
    TRY(kinds[i].make(state, params, &geometry));
    if (state->in_object) {
        if (state->now.area != SCENE_NONE)
            pbrt_note(state, "area lights in objects are ignored, as pbrt does");
        return keep(state, &geometry, material, alpha);
    }
    const fault_code_t code =
        place(state, &geometry, &state->now.ctm, state->now.reverse, material, alpha, state->now.area);
    geometry_clear(&geometry);
    return code;
}

/* ---- objects ---- */

fault_code_t pbrt_object_begin(pbrt_state_t *state, const char *name)
{
    if (state->in_object)
        return pbrt_fault(state, FAULT_SYNTAX, "ObjectBegin \"%s\" inside another object", name);
    if (name_table_get(&state->objects, name, -1) >= 0)
        return pbrt_fault(state, FAULT_SYNTAX, "the object \"%s\" is defined twice", name);
    if (state->object_count == PBRT_MAX_OBJECTS)
        return pbrt_fault(state, FAULT_LIMIT, "more than %d objects", PBRT_MAX_OBJECTS);
    pbrt_object_t *list = pbrt_grown(state->object_list, state->object_count, sizeof *list);
    if (!list)
        return pbrt_fault(state, FAULT_MEMORY, "no memory for an object");
    state->object_list = list;
    TRY(pbrt_push(state, 'O'));
    TRY(name_table_set(&state->objects, name, (int32_t)state->object_count, state->fault));
    list[state->object_count++] = (pbrt_object_t){state->instanced_count, 0};
    state->in_object = true;
    return FAULT_NONE;
}

fault_code_t pbrt_object_end(pbrt_state_t *state)
{
    TRY(pbrt_pop(state, 'O', "ObjectEnd"));
    state->in_object = false;
    return FAULT_NONE;
}

fault_code_t pbrt_object_instance(pbrt_state_t *state, const char *name)
{
    const int32_t index = name_table_get(&state->objects, name, -1);
    if (index < 0)
        return pbrt_fault(state, FAULT_UNKNOWN, "there is no object \"%s\" before this line", name);
    if (state->in_object)
        return pbrt_fault(state, FAULT_SYNTAX, "ObjectInstance \"%s\" inside the definition of an object", name);
    const pbrt_object_t *object = &state->object_list[index];
    for (size_t i = 0; i < object->count; i++) {
        const pbrt_instanced_t *shape = &state->instanced[object->first + i];
        const transform_t ctm = transform_mul(&state->now.ctm, &shape->ctm);
        TRY(place(state, &shape->geometry, &ctm, shape->reverse, shape->material, shape->alpha, SCENE_NONE));
    }
    return FAULT_NONE;
}
