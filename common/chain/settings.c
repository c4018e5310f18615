#include "chain/settings.h"

void settings_default(settings_t *settings)
{
    *settings = (settings_t){
        .algorithm = SETTINGS_MMLT,
        .filter = -1,
        .seed = 1,
        .target = SETTINGS_TARGET_LUMINANCE,
        .kernel = SETTINGS_KERNEL_KELEMEN,
        .large_step = 0.1,
        .technique_step = 0.03,
        .jump_step = 0.05,
        .partial_step = 0,
        .split_gain = 1,
        .step_min = 1.0 / 1024,
        .step_max = 1.0 / 64,
    };
}

void settings_auto(settings_t *settings)
{
    settings->algorithm = SETTINGS_RJMLT;
    settings->partial_step = 0.5;
    settings->equalize = 1;
    settings->split = 20;
    settings->split_gain = 2.5;
    settings->shift = true;
}

const char *settings_algorithm_name(settings_algorithm_t algorithm)
{
    static const char *const names[SETTINGS_ALGORITHMS] = {"pt",       "bdpt",      "mmlt",       "rjmlt", "cmlt",
                                                           "cmlt-rex", "cmlt-ipsm", "pssmlt-mix", "pssmlt"};
    return (unsigned)algorithm < SETTINGS_ALGORITHMS ? names[algorithm] : "?";
}
