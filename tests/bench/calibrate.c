#include "calibrate.h"

#include <embree3/rtcore.h>
#include <math.h>
#include <stdint.h>
#include <stdlib.h>

#include "base/clock.h"
#include "base/random.h"

enum {
    BANDS = 100,
    SECTORS = 100,
    VERTICES = (BANDS + 1) * SECTORS,
    TRIANGLES = 2 * BANDS * SECTORS,
    RAYS = 1000000
};

static void sphere_vertices(float *out)
{
    for (int band = 0; band <= BANDS; band++)
        for (int sector = 0; sector < SECTORS; sector++) {
            const double theta = M_PI * band / BANDS, phi = 2 * M_PI * sector / SECTORS;
            *out++ = (float)(sin(theta) * cos(phi));
            *out++ = (float)(sin(theta) * sin(phi));
            *out++ = (float)cos(theta);
        }
}

static void sphere_triangles(unsigned *out)
{
    for (unsigned band = 0; band < BANDS; band++)
        for (unsigned sector = 0; sector < SECTORS; sector++) {
            const unsigned a = band * SECTORS + sector, b = band * SECTORS + (sector + 1) % SECTORS;
            const unsigned quad[6] = {a, b, a + SECTORS, b, b + SECTORS, a + SECTORS};
            for (int i = 0; i < 6; i++)
                *out++ = quad[i];
        }
}

static RTCScene sphere_scene(RTCDevice device)
{
    RTCScene scene = rtcNewScene(device);
    RTCGeometry mesh = rtcNewGeometry(device, RTC_GEOMETRY_TYPE_TRIANGLE);
    float *vertices =
        rtcSetNewGeometryBuffer(mesh, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3, 3 * sizeof(float), VERTICES);
    unsigned *triangles =
        rtcSetNewGeometryBuffer(mesh, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3, 3 * sizeof(unsigned), TRIANGLES);
    if (vertices && triangles) {
        sphere_vertices(vertices);
        sphere_triangles(triangles);
    }
    rtcCommitGeometry(mesh);
    rtcAttachGeometry(scene, mesh);
    rtcReleaseGeometry(mesh);
    rtcSetSceneFlags(scene, RTC_SCENE_FLAG_ROBUST);
    rtcCommitScene(scene);
    return scene;
}

/* A point of the unit sphere, uniform (Archimedes), from 2 x 24 random bits. */
static void sphere_point(float point[3], uint64_t bits)
{
    const float u = (float)(bits >> 40) * 0x1p-24f, v = (float)(bits & 0xffffff) * 0x1p-24f;
    const float z = 1 - 2 * u, r = sqrtf(fmaxf(0, 1 - z * z)), phi = 2 * (float)M_PI * v;
    point[0] = r * cosf(phi);
    point[1] = r * sinf(phi);
    point[2] = z;
}

/* Between two points of the sphere, from a little inside it. */
static void sphere_chord(struct RTCRayHit *chord, uint64_t key, uint64_t index)
{
    float a[3], b[3];
    sphere_point(a, random_u64(key, 2 * index));
    sphere_point(b, random_u64(key, 2 * index + 1));
    *chord = (struct RTCRayHit){.ray = {.org_x = 0.9f * a[0],
                                        .org_y = 0.9f * a[1],
                                        .org_z = 0.9f * a[2],
                                        .dir_x = b[0] - a[0],
                                        .dir_y = b[1] - a[1],
                                        .dir_z = b[2] - a[2],
                                        .tfar = INFINITY,
                                        .mask = UINT32_MAX},
                                .hit = {.geomID = RTC_INVALID_GEOMETRY_ID}};
}

double calibrate_run(void)
{
    RTCDevice device = rtcNewDevice(NULL);
    if (!device)
        return NAN;
    RTCScene scene = sphere_scene(device);
    const uint64_t key = random_key(1, RANDOM_PURPOSE_TEST, 0, 0);
    unsigned hits = 0;
    const double start = clock_thread_cpu();
    for (uint64_t i = 0; i < RAYS; i++) {
        struct RTCIntersectContext context;
        struct RTCRayHit chord;
        sphere_chord(&chord, key, i);
        rtcInitIntersectContext(&context);
        rtcIntersect1(scene, &context, &chord);
        hits += chord.hit.geomID != RTC_INVALID_GEOMETRY_ID;
    }
    const double seconds = clock_thread_cpu() - start;
    rtcReleaseScene(scene);
    rtcReleaseDevice(device);
    return hits > RAYS / 2 ? RAYS * 1e-6 / seconds : NAN;
}
