/* interrupt.h: SIGINT and SIGTERM as a question that loops ask, so that whatever was started is put away first. */
#ifndef CLIENT_INTERRUPT_H
#define CLIENT_INTERRUPT_H

#include <stdbool.h>

/* From now on the signals only set the flag. */
void interrupt_catch(void);
bool interrupt_happened(void);

#endif
