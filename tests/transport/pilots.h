/* pilots.h: results of pilots' units and of features, kept while renders of one scene are compared: those of one
 * seed have the same, to the bit, whatever moves their chains make.
 *
 *     pilots_t *pilots = pilots_new();        one a scene
 *     render_image_with(&render, scene, text, pilots);
 *     pilots_destroy(&pilots);
 */
#ifndef TESTS_TRANSPORT_PILOTS_H
#define TESTS_TRANSPORT_PILOTS_H

#include "chain/work.h"

typedef struct pilots pilots_t;

/* Never null: what fails ends the process. */
pilots_t *pilots_new(void);
void pilots_destroy(pilots_t **pilots);

/* The unit's result as bytes: one that is kept, or else run in the space and kept. Of other kinds of units, and
 * with null in place of pilots, it is run. The caller frees it. */
fault_code_t pilots_run(pilots_t *pilots, work_space_t *space, const settings_t *settings,
                        const work_record_t *record, uint8_t **data, size_t *size, fault_t *fault);

#endif
