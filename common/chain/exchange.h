/* exchange.h: replica exchange between chains that keep their techniques (Pantaleoni 2017, section 4, eq. 22 to 24;
 * cmlt-rex).
 *
 * Chains i and j hold the paths x and y by the techniques s_i and s_j. They trade techniques: x goes to R_{s_j}(x),
 * y to R_{s_i}(y), accepted together with
 *
 *     p_i(y) p_j(x) / (p_i(x) p_j(y)) = [w_i(y) / w_j(y)] [w_j(x) / w_i(x)].
 *
 * In the paper chains keep their techniques and trade paths; which of the two is called a chain makes no difference
 * to what is splatted. There the ensemble has one chain for each technique; here it has as many as its seeds put
 * there, which is in proportion to energy (b_{k,s}), so that all have the same weight and none is spent where there
 * is no light.
 */
#ifndef CHAIN_EXCHANGE_H
#define CHAIN_EXCHANGE_H

#include "chain/chain.h"

/* A step of `chain`: it proposes an exchange with one of the others of its ensemble. */
void exchange_step(chain_t *chain, chain_t *ensemble, uint32_t count, uint64_t key);

#endif
