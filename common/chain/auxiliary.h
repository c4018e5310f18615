/* auxiliary.h: a second chain beside each chain, whose target knows visibility alone (Pantaleoni 2017, section 3.3,
 * eq. 18, after Sik et al. 2016): A_s(u) = 1 where C_s(u) > 0, else 0. It wanders over all that carries light,
 * bright or dim, and trades states with the main chain with min(1, C(aux) A(main) / (C(main) A(aux))) = min(1,
 * C(aux) / C(main)).
 *
 * It starts in its own law: uniform states, drawn until one carries light. Where none of AUXILIARY_TRIES does, the
 * chain goes without; that depends on nothing the main chain does, so nothing is biased by it.
 */
#ifndef CHAIN_AUXILIARY_H
#define CHAIN_AUXILIARY_H

#include "chain/chain.h"

enum { AUXILIARY_TRIES = 4096 };

/* Draws the auxiliary chain's first state by numbers of `key`; false if none was found. */
bool auxiliary_start(chain_t *auxiliary, uint64_t key);

/* A step of the main chain: the auxiliary one makes a step of its own, then both propose to trade states. */
void auxiliary_step(chain_t *chain, chain_t *auxiliary, uint64_t key);

#endif
