/*
 * Watchdogs, faults and the cause of the reset on the STM32F405.
 *
 * SysTick switches off and resets APP_WATCHDOG ms after the newest sample. The independent watchdog does so if even
 * SysTick stands still, after 1.4 to 3.8 times this time: its clock has 17 to 47 kHz. A fault switches off at once.
 * The stack is at the bottom of the RAM, so that its overflow is a fault.
 *
 * Registers: STMicroelectronics, RM0090, STM32F405/415 reference manual; PM0214, Cortex-M4 programming manual.
 */
#include "board.h"
#include "messages.h"
#include "settings.h"

#define AT(address) (*(volatile uint32_t *)(address))
#define RCC_CSR AT(0x40023874u)
#define IWDG_KR AT(0x40003000u)
#define IWDG_PR AT(0x40003004u)
#define IWDG_RLR AT(0x40003008u)
#define GPIOA_MODER AT(0x40020000u)
#define GPIOA_BSRR AT(0x40020018u)
#define GPIOB_MODER AT(0x40020400u)
#define GPIOB_BSRR AT(0x40020418u)
#define TIM3_CCER AT(0x40000420u)
#define TIM3_CCR(k) AT(0x40000434u + 4u * (k))
#define NVIC_IPR9 AT(0xe000e424u)
#define SCB_AIRCR AT(0xe000ed0cu)

enum {
    CSR_CLEAR = 24, /* bits of RCC_CSR */
    CSR_BROWN_OUT = 25,
    CSR_PIN = 26,
    CSR_POWER_ON = 27,
    CSR_WATCHDOG = 29,
    LSI = 32000, /* nominal clock of the independent watchdog [Hz] */
    MOST_RELOAD = 4095
};
static const uint32_t KEPT = 0x6b657074u;

static uint32_t kept[2] __attribute__((section(".noinit"))); /* mark, cause of a reset by this file */
static uint8_t cause, watching;
static volatile uint32_t since; /* ms since the newest sample */

void Fault_Handler(void);
void handle_fault(void);
void board_tick(void);

/* PA6, PA7, PB0 and PB1 become outputs at 0, and the timer stops driving them. */
static void stop_outputs(void) {
    GPIOA_BSRR = (1u << 22) | (1u << 23);
    GPIOB_BSRR = (1u << 16) | (1u << 17);
    GPIOA_MODER = (GPIOA_MODER & 0xffff0fffu) | 0x5000u;
    GPIOB_MODER = (GPIOB_MODER & 0xfffffff0u) | 0x5u;
    TIM3_CCER = 0;
    for (uint32_t k = 0; k < 4; ++k) {
        TIM3_CCR(k) = 0;
    }
}

static void restart(uint32_t why) {
    stop_outputs();
    kept[0] = KEPT;
    kept[1] = why;
    SCB_AIRCR = (0x05fau << 16) | (1u << 2);
    for (;;) {
    }
}

/* All faults; the stack may be unusable. */
__attribute__((naked)) void Fault_Handler(void) {
    __asm volatile("ldr r0, =_stack\n\tmsr msp, r0\n\tb handle_fault\n\t.ltorg");
}

__attribute__((used)) void handle_fault(void) { restart(RESET_FAULT); }

/* Every millisecond, above all other interrupts. */
void board_tick(void) {
    if (watching && ++since > APP_WATCHDOG) {
        restart(RESET_WATCHDOG);
    }
}

static uint8_t find_cause(void) {
    const uint32_t flags = RCC_CSR;
    if (kept[0] == KEPT && !(flags & (1u << CSR_POWER_ON))) {
        return (uint8_t)kept[1];
    }
    if (flags & (1u << CSR_POWER_ON)) {
        return RESET_POWER_ON;
    }
    if (flags & (1u << CSR_BROWN_OUT)) {
        return RESET_BROWN_OUT;
    }
    if (flags & (1u << CSR_WATCHDOG)) {
        return RESET_WATCHDOG;
    }
    return (flags & (1u << CSR_PIN)) ? RESET_PIN : RESET_UNKNOWN;
}

void board_guard(void) {
    uint32_t divider = 4, code = 0;
    cause = find_cause();
    kept[0] = 0;
    RCC_CSR |= 1u << CSR_CLEAR;
    NVIC_IPR9 = 0x10u << 8; /* USART1 below SysTick */
    while (2u * APP_WATCHDOG * (LSI / 1000) / divider > MOST_RELOAD && code < 6u) {
        divider *= 2u;
        ++code;
    }
    IWDG_KR = 0x5555u; /* allow changes */
    IWDG_PR = code;
    IWDG_RLR = 2u * APP_WATCHDOG * (LSI / 1000) / divider;
    IWDG_KR = 0xccccu; /* start */
    since = 0;
    watching = 1;
}

void board_feed(void) {
    since = 0;
    IWDG_KR = 0xaaaau;
}

uint8_t board_reset_cause(void) { return cause; }
