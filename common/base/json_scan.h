/* json_scan.h: is this text JSON? A strict check (RFC 8259) ahead of a lenient parser, with the place of what is
 * wrong.
 *
 * Accepts one value with white space around it, within the limits of json.h. Refuses what json.h lists, except
 * duplicate keys. Pure; any thread.
 */
#ifndef BASE_JSON_SCAN_H
#define BASE_JSON_SCAN_H

#include <stddef.h>

#include "base/fault.h"

/* Faults: FAULT_SYNTAX, FAULT_LIMIT, both with line and column (in characters, from 1). */
fault_code_t json_scan(const char *text, size_t length, fault_t *fault);

/* Bytes of the UTF-8 character at text[0..length), length > 0; 0 if it is none (RFC 3629: no overlong forms, no
 * surrogates, nothing beyond U+10FFFF). */
size_t json_utf8_length(const char *text, size_t length);

#endif
