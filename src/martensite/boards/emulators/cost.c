/*
 * What steps of a core cost on an emulated processor: COST_ROWS rows of inputs are played, and every call is counted.
 * AVR under simavr: cycles, told by GPIOR0. Cortex-M4 under QEMU with -icount shift=0: an instruction is a nanosecond,
 * and SysTick counts nanoseconds of a clock of 168 MHz; told by semihosting.
 */
#include <stdint.h>

#include "cost.h"

static CORE_MODEL model;
static CORE_REAL inputs[CORE_INPUTS];

#if defined(__AVR__)
#include <avr/pgmspace.h>
#define IN_FLASH PROGMEM
static void begin(void) {}
static void mark(uint8_t what) { *(volatile uint8_t *)0x3e = what; }
static float take(const float *place) { return pgm_read_float(place); }
static void end(void) {
    *(volatile uint8_t *)0x3e = 15;
    for (;;) {
    }
}
#else
#define IN_FLASH
#define SYST_CSR (*(volatile uint32_t *)0xe000e010u)
#define SYST_RVR (*(volatile uint32_t *)0xe000e014u)
#define SYST_CVR (*(volatile uint32_t *)0xe000e018u)
static uint32_t most[16], sum[16], calls[16], from;
static uint8_t what_now;
static void begin(void) {
    SYST_RVR = 0xffffffu;
    SYST_CVR = 0;
    SYST_CSR = 5u;
}
static void mark(uint8_t what) {
    const uint32_t now = SYST_CVR;
    if (what == 0 && what_now) {
        const uint32_t passed = (from - now) & 0xffffffu;
        if (passed > most[what_now]) most[what_now] = passed;
        sum[what_now] += passed;
        ++calls[what_now];
    }
    what_now = what;
    from = SYST_CVR;
}
static float take(const float *place) { return *place; }
static void semihost(uint32_t operation, const void *block) {
    register uint32_t r0 __asm("r0") = operation;
    register const void *r1 __asm("r1") = block;
    __asm volatile("bkpt 0xab" : "+r"(r0) : "r"(r1) : "memory");
}
static void tell(uint32_t number) {
    char digits[12];
    uint8_t place = 11;
    digits[place] = 0;
    digits[--place] = '\n';
    do digits[--place] = (char)('0' + number % 10u);
    while ((number /= 10u) != 0 && place);
    semihost(4, digits + place);
}
static void end(void) {
    for (uint8_t k = 1; k < 4; ++k) {
        tell(most[k]);
        tell(calls[k] ? sum[k] / calls[k] : 0);
    }
    const uint32_t stop[2] = {0x20026u, 0};
    semihost(0x20, stop);
}
void app_begin(void);
void app_turn(void);
void SysTick_Handler(void);
void USART1_IRQHandler(void);
void SysTick_Handler(void) {}
void USART1_IRQHandler(void) {}
#endif

static const float rows[COST_ROWS][CORE_INPUTS] IN_FLASH = COST_TABLE;
static volatile int status;

static void play(void) {
    begin();
    mark(1); /* nothing: what counting costs */
    mark(0);
    CORE(defaults)(&model);
    for (uint16_t k = 0; k < COST_ROWS; ++k) {
        for (uint8_t i = 0; i < CORE_INPUTS; ++i) inputs[i] = take(&rows[k][i]);
        if (k == 0) {
            status = CORE(start)(&model, inputs);
            continue;
        }
        mark(2);
        status = CORE(step)(&model, inputs, COST_PERIOD);
        mark(0);
        if (status > 1) mark(3), mark(0);
    }
    end();
}

#if defined(__AVR__)
int main(void) {
    play();
}
#else
void app_begin(void) { play(); }
void app_turn(void) {}
#endif
