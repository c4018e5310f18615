/* camera_filter.h: a pixel filter along one axis, as the camera needs it. Internal to camera.c. */
#ifndef SCENE_CAMERA_FILTER_H
#define SCENE_CAMERA_FILTER_H

#include "scene/camera.h"

/* The filter (scene_filter_t) of radius r along one axis, its integral 1. */
double camera_filter_value(uint32_t filter, double radius, double sigma, double x);

/* Sum over all pixel centres c of value(x - c). */
double camera_filter_sum(uint32_t filter, double radius, double sigma, double x);

/* cdf[i], i = 0 .. CAMERA_FILTER_STEPS: probability that the offset is at most its i-th place, (2 i / steps - 1)
 * (radius - 1/2); radius > 1/2. */
void camera_filter_tabulate(uint32_t filter, double radius, double sigma, double *cdf);

/* The offset of u by inverse linear interpolation. */
double camera_filter_invert(const double *cdf, double radius, double u);

#endif
