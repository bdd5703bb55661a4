/*
 * The firmware around a loop: arms, samples, guards, answers and tells, on any board.
 */
#ifndef APP_H
#define APP_H

#ifdef __cplusplus
extern "C" {
#endif

void app_begin(void); /* once; all signals are off */
void app_turn(void);  /* for ever, as often as it can be */

#ifdef __cplusplus
}
#endif

#endif
