/* figures.h: what the tests of the hard cases measure, as the table of docs/hard-cases.md shows it.
 *
 * A test names its case; what it compares from then on is recorded under that name. With GARLAND_HARD_FIGURES=FILE
 * in the environment each figure becomes a line at the end of FILE, "case<tab>figure<tab>count<tab>worst", which
 * tests/hard/table makes rows of; without it nothing is written.
 */
#ifndef TESTS_HARD_FIGURES_H
#define TESTS_HARD_FIGURES_H

typedef enum hard_figure {
    HARD_REFUSED, /* evaluations; those refused before the film */
    HARD_ENERGY,  /* comparisons with a closed form; largest difference in standard errors */
    HARD_OFF,     /* the same; largest relative difference of the image's mean */
    HARD_TARGET,  /* paths against the definition; largest relative difference of those within their condition */
    HARD_EDGES,   /* the same; how many lie outside their condition */
    HARD_LOST,    /* round trips; those that failed */
    HARD_CHANGE,  /* the same; largest relative change of C */
    HARD_AGREE,   /* comparisons of an algorithm with bdpt; largest |t| */
    HARD_LEAKS,   /* segments; those that left a closed scene */
    HARD_DOUBLE,  /* cases in double against extended precision; largest error over the allowed one */
    HARD_FIGURES
} hard_figure_t;

/* A case of tests/hard/cases. */
void hard_case(const char *name);
void hard_record(hard_figure_t figure, double count, double worst);

#endif
