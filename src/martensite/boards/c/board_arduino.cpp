/*
 * Any board with an Arduino core: Uno, Mega, Due, ESP32, Teensy. Pins stand in settings.h.
 */
#include <Arduino.h>

#include "board.h"
#include "settings.h"

namespace {

const uint8_t drive_pins[APP_DRIVES] = APP_DRIVE_PINS;
const int16_t channel_pins[APP_CHANNELS] = APP_CHANNEL_PINS; /* below 0: an encoder on pins -1 - pin and the next one */
volatile int32_t counts[APP_CHANNELS];

#if APP_ENCODERS
uint8_t encoder_pins[APP_ENCODERS], encoder_channels[APP_ENCODERS];
uint8_t encoders;

/* Both edges of the first line: up if the second differs from it. */
template <uint8_t k>
void turned() {
    const uint8_t a = encoder_pins[k];
    counts[encoder_channels[k]] += digitalRead(a) != digitalRead(a + 1) ? 1 : -1;
}

void begin_encoder(uint8_t channel, uint8_t pin) {
    if (encoders >= APP_ENCODERS) return;
    encoder_pins[encoders] = pin;
    encoder_channels[encoders] = channel;
    pinMode(pin, INPUT_PULLUP);
    pinMode(pin + 1, INPUT_PULLUP);
    attachInterrupt(digitalPinToInterrupt(pin), encoders == 0 ? turned<0> : turned<APP_ENCODERS - 1>, CHANGE);
    ++encoders;
}
#endif

}  // namespace

void board_begin(void) {
    for (uint8_t i = 0; i < APP_DRIVES; ++i) {
        pinMode(drive_pins[i], OUTPUT);
        digitalWrite(drive_pins[i], LOW);
    }
#if APP_ENCODERS
    for (uint8_t i = 0; i < APP_CHANNELS; ++i)
        if (channel_pins[i] < 0) begin_encoder(i, static_cast<uint8_t>(-1 - channel_pins[i]));
#endif
    Serial.begin(APP_BAUD);
}

uint32_t board_micros(void) { return micros(); }

int board_read(void) { return Serial.read(); }

/* Its queue may be shorter than a frame: writing then waits, a millisecond or two. */
uint16_t board_room(void) { return 255; }

void board_write(const uint8_t *bytes, uint16_t size) { Serial.write(bytes, size); }

float board_drive(uint8_t drive, float duty) {
    const int level = static_cast<int>(duty * 255.0f + 0.5f);
    if (level <= 0) {
        digitalWrite(drive_pins[drive], LOW);
    } else {
        analogWrite(drive_pins[drive], level);
    }
    return static_cast<float>(level < 0 ? 0 : level) / 255.0f;
}

float board_channel(uint8_t channel) {
    if (channel_pins[channel] >= 0) return static_cast<float>(analogRead(static_cast<uint8_t>(channel_pins[channel])));
    noInterrupts();
    const int32_t found = counts[channel];
    interrupts();
    return static_cast<float>(found);
}
