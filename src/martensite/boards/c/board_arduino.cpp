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

#if defined(__AVR__)
/* Timer 1 in fast PWM: a period has TOP + 1 counts, and a pulse begins at 0. Pins 9, 10 (Uno) and 11, 12 (Mega). */
#define COUNTS(divider) (F_CPU / (divider) / APP_PWM_HZ)
#if COUNTS(1UL) <= 65536UL
enum { DIVIDER = 1, CLOCK_BITS = 1 };
#elif COUNTS(8UL) <= 65536UL
enum { DIVIDER = 8, CLOCK_BITS = 2 };
#elif COUNTS(64UL) <= 65536UL
enum { DIVIDER = 64, CLOCK_BITS = 3 };
#else
enum { DIVIDER = 256, CLOCK_BITS = 4 };
#endif
constexpr uint32_t PERIOD = F_CPU / DIVIDER / APP_PWM_HZ; /* counts */
uint32_t pulses[APP_DRIVES];                              /* counts for which the switches are closed */

constexpr uint32_t count(uint32_t micros) { return (F_CPU / 1000000UL * micros + DIVIDER - 1) / DIVIDER; }

void begin_pwm(void) {
    TCCR1A = _BV(WGM11);
    TCCR1B = _BV(WGM13) | _BV(WGM12) | CLOCK_BITS;
    ICR1 = PERIOD - 1;
}

float set_pulse(uint8_t drive, float duty) {
    const uint32_t level = static_cast<uint32_t>(duty * static_cast<float>(PERIOD) + 0.5f);
    pulses[drive] = level;
    if (level == 0) {
        digitalWrite(drive_pins[drive], LOW);
    } else if (drive == 0) {
        OCR1A = static_cast<uint16_t>(level - 1);
        TCCR1A |= _BV(COM1A1);
    } else {
        OCR1B = static_cast<uint16_t>(level - 1);
        TCCR1A |= _BV(COM1B1);
    }
    return static_cast<float>(level) / static_cast<float>(PERIOD);
}

/* Start a conversion whose input is held within a pulse; 0 if the pulse is too short. */
uint8_t convert_in_pulse(uint32_t pulse) {
    if (pulse < count(APP_SETTLE_US) + count(APP_HOLD_US)) return 0;
    for (uint32_t left = 2 * 1000000UL / APP_PWM_HZ + 200; left; --left) { /* a turn takes more than 1 us */
        noInterrupts();
        const uint16_t now = TCNT1;
        const uint8_t inside = now >= count(APP_SETTLE_US) && now + count(APP_HOLD_US) <= pulse;
        if (inside) ADCSRA |= _BV(ADSC);
        interrupts();
        if (inside) return 1;
    }
    return 0;
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
#if defined(__AVR__)
    begin_pwm();
#elif defined(ESP32) && ESP_ARDUINO_VERSION_MAJOR >= 3
    for (uint8_t i = 0; i < APP_DRIVES; ++i) analogWriteFrequency(drive_pins[i], APP_PWM_HZ);
#else
    analogWriteFrequency(APP_PWM_HZ);
#endif
    Serial.begin(APP_BAUD);
}

uint32_t board_micros(void) { return micros(); }

int board_read(void) { return Serial.read(); }

/* Its queue may be shorter than a frame: writing then waits, a millisecond or two. */
uint16_t board_room(void) { return 255; }

void board_write(const uint8_t *bytes, uint16_t size) { Serial.write(bytes, size); }

float board_drive(uint8_t drive, float duty) {
#if defined(__AVR__)
    return set_pulse(drive, duty);
#else
    const int level = static_cast<int>(duty * 255.0f + 0.5f);
    if (level <= 0) {
        digitalWrite(drive_pins[drive], LOW);
    } else {
        analogWrite(drive_pins[drive], level);
    }
    return static_cast<float>(level < 0 ? 0 : level) / 255.0f;
#endif
}

float board_channel(uint8_t channel) {
    if (channel_pins[channel] >= 0) return static_cast<float>(analogRead(static_cast<uint8_t>(channel_pins[channel])));
    noInterrupts();
    const int32_t found = counts[channel];
    interrupts();
    return static_cast<float>(found);
}

/* Resistance is measured on AVR only; see boards.toml. */
uint8_t board_pulse_channel(uint8_t channel, uint8_t drive, float *steps) {
#if defined(__AVR__)
    if (pulses[drive] != 0) {
        const uint8_t input = static_cast<uint8_t>(channel_pins[channel] - A0);
        ADMUX = static_cast<uint8_t>(DEFAULT << 6 | (input & 7u));
#if defined(MUX5)
        ADCSRB &= static_cast<uint8_t>(~_BV(MUX5)); /* A0 to A7 */
#endif
        if (!convert_in_pulse(pulses[drive])) return BOARD_SHORT;
        while (ADCSRA & _BV(ADSC)) {
        }
        *steps = static_cast<float>(ADC);
        return BOARD_PULSE;
    }
#endif
    (void)drive;
    *steps = board_channel(channel);
    return BOARD_OPEN;
}
