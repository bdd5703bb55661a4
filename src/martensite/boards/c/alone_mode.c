#include "settings.h"

#if APP_ALONE
#include "alone_mode.h"
#include "board.h"
#include "link.h"
#define ALONE_TABLES
#include "reference.h"

enum { DIGEST = 4, NUMBER = 4, CHECK = 4, MOST_IMAGE = DIGEST + NUMBER * APP_STORED + CHECK };

/* Digest of the firmware, numbers, check. */
static uint8_t write_image(uint8_t *image, const float *settings, uint8_t count) {
    uint8_t size = DIGEST;
    link_put_u32(image, APP_DIGEST);
    for (uint8_t i = 0; i < count; ++i) {
        link_put_f32(image + size, settings[i]);
        size = (uint8_t)(size + NUMBER);
    }
    link_put_u32(image + size, link_check(image, size));
    return (uint8_t)(size + CHECK);
}

uint8_t alone_load(float *settings, uint8_t count) {
    uint8_t image[MOST_IMAGE];
    const uint8_t size = (uint8_t)(DIGEST + NUMBER * count);
    for (uint8_t k = 0; k < size + CHECK; ++k) {
        image[k] = board_load(k);
    }
    if (link_u32(image) != APP_DIGEST || link_u32(image + size) != link_check(image, size)) {
        return 0;
    }
    for (uint8_t i = 0; i < count; ++i) {
        settings[i] = link_f32(image + DIGEST + NUMBER * i);
    }
    return 1;
}

uint8_t alone_store(const float *settings, uint8_t count) {
    uint8_t image[MOST_IMAGE];
    const uint8_t size = write_image(image, settings, count);
    for (uint8_t k = 0; k < size; ++k) {
        if (!board_can_store()) {
            return 0;
        }
        if (board_load(k) != image[k]) {
            board_store(k, image[k]);
            return 0;
        }
    }
    return 1;
}

float alone_reference(uint8_t track, uint32_t sample) {
    uint16_t k = FLASH_U16(alone_first[track]);
    while (FLASH_U32(alone_points[k + 1u].sample) < sample) {
        ++k;
    }
    const uint32_t from = FLASH_U32(alone_points[k].sample), to = FLASH_U32(alone_points[k + 1u].sample);
    const float low = FLASH_FLOAT(alone_points[k].value), high = FLASH_FLOAT(alone_points[k + 1u].value);
    return low + (high - low) * (float)(sample - from) / (float)(to - from);
}
#endif
