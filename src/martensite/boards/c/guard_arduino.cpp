/*
 * Watchdog, stack check and cause of the reset on AVR. Any reset makes inputs of all pins, so the gates are off.
 * On other processors with an Arduino core this file does nothing.
 *
 * Registers: Microchip DS40002061B, ATmega328P data sheet, sections 11 and 13.
 */
#include <Arduino.h>

#include "board.h"
#include "messages.h"
#include "settings.h"

#if defined(__AVR__)
#include <avr/wdt.h>

extern "C" {
extern uint8_t __heap_start; /* end of the variables; the stack grows towards it */
void keep_reset_flags(void) __attribute__((naked, used, section(".init3")));
}

namespace {

enum { CANARY = 0xc5, CANARIES = 8 };
const uint16_t FAILED = 0x5aa5;
uint8_t reset_flags __attribute__((section(".noinit")));
uint8_t loader_flags __attribute__((section(".noinit"))); /* the boot loader Optiboot clears MCUSR and leaves it in r2 */
uint16_t failed __attribute__((section(".noinit")));
uint8_t cause;

void fail(void) {
    const uint8_t pins[] = APP_DRIVE_PINS;
    noInterrupts();
    for (uint8_t pin : pins) {
        digitalWrite(pin, LOW);
    }
    failed = FAILED;
    for (;;) { /* until the watchdog resets */
        __asm__ volatile("nop");
    }
}

uint8_t find_cause(void) {
    const uint8_t flags = reset_flags ? reset_flags : loader_flags;
    if (flags & _BV(PORF)) {
        return RESET_POWER_ON;
    }
    if (flags & _BV(BORF)) {
        return RESET_BROWN_OUT;
    }
    if (flags & _BV(WDRF)) {
        return failed == FAILED ? RESET_FAULT : RESET_WATCHDOG;
    }
    return flags & _BV(EXTRF) ? RESET_PIN : RESET_UNKNOWN;
}

}  // namespace

/* Before main: a watchdog stays on after its reset. */
void keep_reset_flags(void) {
    __asm__ volatile("sts %0, r2" : "=m"(loader_flags));
    reset_flags = MCUSR;
    if (reset_flags == 0 && (WDTCSR & _BV(WDE))) { /* a stray jump and no reset: registers hold anything */
        for (;;) {                                 /* until the watchdog resets */
            __asm__ volatile("nop");
        }
    }
    MCUSR = 0;
    wdt_disable();
}

ISR(BADISR_vect) { fail(); }

void board_guard(void) {
    cause = find_cause();
    failed = 0;
    for (uint8_t i = 0; i < CANARIES; ++i) {
        (&__heap_start)[i] = CANARY;
    }
#if APP_ALONE
    pinMode(APP_ARM_PIN, INPUT_PULLUP);
#endif
    wdt_enable(APP_WATCHDOG_CODE);
}

void board_feed(void) {
    for (uint8_t i = 0; i < CANARIES; ++i) {
        if ((&__heap_start)[i] != CANARY) {
            fail();
        }
    }
    wdt_reset();
}

uint8_t board_reset_cause(void) { return cause; }

#if APP_ALONE
#include <avr/eeprom.h>

static uint8_t *find_place(uint8_t address) { return reinterpret_cast<uint8_t *>(static_cast<uintptr_t>(address)); }

uint8_t board_load(uint8_t address) { return eeprom_read_byte(find_place(address)); }

uint8_t board_can_store(void) { return eeprom_is_ready() ? 1 : 0; }

void board_store(uint8_t address, uint8_t byte) { eeprom_write_byte(find_place(address), byte); }

uint8_t board_switch(void) { return digitalRead(APP_ARM_PIN) == LOW; }
#endif

#else

void board_guard(void) {}

void board_feed(void) {}

uint8_t board_reset_cause(void) { return RESET_UNKNOWN; }

#endif
