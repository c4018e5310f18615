/* Any bytes as a polygon file: refused, or a mesh whose indices are in range. */
#include <math.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>

#include "client/import/ply.h"

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size);

static void demand(int condition, const char *what)
{
    if (!condition) {
        fprintf(stderr, "%s\n", what);
        abort();
    }
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    ply_mesh_t mesh;
    fault_t fault = {0};
    const fault_code_t code = ply_parse(data, size, &mesh, &fault);
    if (code) {
        demand(code == fault.code && fault.text[0], "a fault without a text");
        demand(!mesh.positions && !mesh.normals && !mesh.uvs && !mesh.indices,
               "a fault that leaves something behind");
        return 0;
    }
    for (uint64_t i = 0; i < 3 * mesh.vertices; i++)
        demand(isfinite(mesh.positions[i]) && (!mesh.normals || isfinite(mesh.normals[i])),
               "a number is not finite");
    for (uint64_t i = 0; i < 3 * mesh.triangles; i++)
        demand(mesh.indices[i] < mesh.vertices, "an index is out of range");
    ply_mesh_clear(&mesh);
    return 0;
}
