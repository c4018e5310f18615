/* render.h: the engine that renders: bundles from the cache, units by common/chain/work.h. */
#ifndef WORKER_RENDER_H
#define WORKER_RENDER_H

#include "worker/cache.h"
#include "worker/engine.h"

/* The cache is borrowed for the engine's life. */
engine_t render_engine(cache_t *cache);

#endif
