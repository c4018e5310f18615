/* service_fixture.h: what the service's tests share: a folder of their own, a small scene as a bundle, the job on
 * it, and the job done in this process without any service. */
#ifndef TESTS_SERVICE_FIXTURE_H
#define TESTS_SERVICE_FIXTURE_H

#include <stddef.h>

#include "base/digest.h"
#include "plan/plan.h"
#include "scene/bundle.h"

enum { FIXTURE_PATH = 512 };

extern char fixture_folder[FIXTURE_PATH]; /* fixture_setup makes it, fixture_teardown removes it */
extern char fixture_bundle[FIXTURE_PATH]; /* the bundle's file */
extern digest_t fixture_digest;

int fixture_setup(void **state); /* for cmocka_run_group_tests */
int fixture_teardown(void **state);

/* A path in the folder; the text is good for four more calls. */
const char *fixture_path(const char *name);
/* Empties or removes what a test left. */
void fixture_remove(const char *name);

/* A job on the scene: mmlt, 24 x 24, so many mutations per pixel, this seed. */
const char *fixture_job(double mutations_per_pixel, int seed);

/* A renderer of fixture_job(any number, 1), and the bundle that it borrows from. */
void fixture_renderer(bundle_t **bundle, renderer_t **renderer);
/* Runs a unit as a worker would; the caller frees *data. */
void fixture_run_unit(renderer_t *renderer, const work_record_t *record, uint8_t **data, size_t *size);
/* Digest of the job's pixels R, G, B, done with a plan alone. */
void fixture_direct(const char *job, digest_t *pixels);
/* Digest of the R, G, B planes of an OpenEXR file. */
void fixture_pixels(const char *path, digest_t *pixels);

#endif
