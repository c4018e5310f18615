/* techniques.h: refuses, before any work is done, what an algorithm cannot do with the techniques
 * (docs/transport.md) that a scene's paths can have.
 *
 * A path with s vertices from the light and t from the camera is joined between two vertices that are not specular,
 * or (s = 0) the camera's walk hits a light. So where every surface is specular, paths of two and more segments
 * have one technique at most, s = 0, and none if no light can be hit; a light that is seen itself (one segment) has
 * two.
 */
#ifndef PLAN_TECHNIQUES_H
#define PLAN_TECHNIQUES_H

#include "base/fault.h"
#include "chain/settings.h"
#include "scene/scene.h"

/* FAULT_NO_LIGHT: no path length has a technique. FAULT_UNSUPPORTED: the algorithm moves between techniques
 * (`automatic`: nobody has asked for it to), and paths of two and more segments have only one. The text says why,
 * and what to do. The scene has passed scene_check; the settings are complete. */
fault_code_t techniques_check(const scene_t *scene, const settings_t *settings, bool automatic, fault_t *fault);

#endif
