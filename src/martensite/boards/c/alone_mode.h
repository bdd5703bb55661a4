/*
 * Operation without a host: calibration kept in the EEPROM, and the reference of the scenario from flash.
 */
#ifndef ALONE_MODE_H
#define ALONE_MODE_H

#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

/* Calibration from the EEPROM, `count` numbers; 0 and no change if it is not of this firmware or damaged. */
uint8_t alone_load(float *settings, uint8_t count);

/* Write the next byte that differs; 1 if the EEPROM holds all of them. Never waits. */
uint8_t alone_store(const float *settings, uint8_t count);

/* A reference in a sample of its cycle of APP_SAMPLES. */
float alone_reference(uint8_t track, uint32_t sample);

#ifdef __cplusplus
}
#endif

#endif
