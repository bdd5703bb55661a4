/*
 * STM32F405 without a library: USART1 on PA9 and PA10, PWM of TIM3 on PA6, PA7, PB0, PB1, converter ADC1 on PA0 to PA5.
 * 168 MHz from the inner oscillator, so that any board with this chip will do.
 *
 * Registers: STMicroelectronics, RM0090, STM32F405/415 reference manual.
 */
#include "board.h"
#include "settings.h"

#ifndef AT /* a test of this file has its own registers */
#define AT(address) (*(volatile uint32_t *)(address))
#define MASK_INTERRUPTS() __asm volatile("cpsid i")
#define ALLOW_INTERRUPTS() __asm volatile("cpsie i")
#endif
#define RCC_AHB1ENR AT(0x40023830u)
#define RCC_APB1ENR AT(0x40023840u)
#define RCC_APB2ENR AT(0x40023844u)
#define GPIOA_MODER AT(0x40020000u)
#define GPIOA_AFRL AT(0x40020020u)
#define GPIOA_AFRH AT(0x40020024u)
#define GPIOB_MODER AT(0x40020400u)
#define GPIOB_AFRL AT(0x40020420u)
#define USART_SR AT(0x40011000u)
#define USART_DR AT(0x40011004u)
#define USART_BRR AT(0x40011008u)
#define USART_CR1 AT(0x4001100cu)
#define TIM3_CR1 AT(0x40000400u)
#define TIM3_EGR AT(0x40000414u)
#define TIM3_CCMR1 AT(0x40000418u)
#define TIM3_CCMR2 AT(0x4000041cu)
#define TIM3_CCER AT(0x40000420u)
#define TIM3_CNT AT(0x40000424u)
#define TIM3_PSC AT(0x40000428u)
#define TIM3_ARR AT(0x4000042cu)
#define TIM3_CCR(k) AT(0x40000434u + 4u * (k))
#define ADC_SR AT(0x40012000u)
#define ADC_CR2 AT(0x40012008u)
#define ADC_SMPR2 AT(0x40012010u)
#define ADC_SQR3 AT(0x40012034u)
#define ADC_DR AT(0x4001204cu)
#define ADC_CCR AT(0x40012304u)
#define SYST_CSR AT(0xe000e010u)
#define SYST_RVR AT(0xe000e014u)
#define SYST_CVR AT(0xe000e018u)
#define RCC_CR AT(0x40023800u)
#define RCC_PLLCFGR AT(0x40023804u)
#define RCC_CFGR AT(0x40023808u)
#define FLASH_ACR AT(0x40023c00u)

enum {
    CLOCK = 168000000, /* of the core */
    SLOW = CLOCK / 2,  /* of USART1 and of the timers */
    PER_MS = CLOCK / 1000,
    PWM_DIVIDER = SLOW / APP_PWM_HZ / 65536u + 1u,
    PWM_STEPS = SLOW / PWM_DIVIDER / APP_PWM_HZ, /* counts of a period; a pulse begins at 0 */
    PWM_SETTLE = (SLOW / 1000000 * APP_SETTLE_US + PWM_DIVIDER - 1) / PWM_DIVIDER,
    PWM_HOLD = (SLOW / 1000000 * APP_HOLD_US + PWM_DIVIDER - 1) / PWM_DIVIDER,
    KEPT = 256 /* bytes that wait to be sent; a power of 2 */
};

static volatile uint32_t milliseconds;
static uint32_t pulses[4]; /* counts for which the switches are closed */
static uint8_t waiting[KEPT];
static uint16_t put, taken;
static uint8_t received[KEPT];
static volatile uint16_t got, given;

void SysTick_Handler(void);
void USART1_IRQHandler(void);
void board_tick(void); /* of guard_stm32f405.c */

void SysTick_Handler(void) {
    ++milliseconds;
    board_tick();
}

/* A byte, or an overrun (ORE) without one: reading the status and then the data clears both. */
void USART1_IRQHandler(void) {
    const uint32_t status = USART_SR;
    if (!(status & 0x28u)) return; /* a byte that comes now has its own interrupt */
    const uint8_t byte = (uint8_t)USART_DR;
    if (status & 0x20u) {
        const uint16_t next = (uint16_t)((got + 1u) % KEPT);
        if (next != given) {
            received[got] = byte;
            got = next;
        }
    }
}

/* Sends what waits, a byte whenever the line is free; asked for in every turn of the firmware. */
static void pump(void) {
    while (taken != put && (USART_SR & 0x80u)) {
        USART_DR = waiting[taken];
        taken = (uint16_t)((taken + 1u) % KEPT);
    }
}

/* 16 MHz / 16 * 336 / 2. An emulator without this clock runs at its own. */
static void set_clock(void) {
    FLASH_ACR = 0x705u; /* 5 wait states, caches */
    RCC_PLLCFGR = 16u | 336u << 6 | 7u << 24;
    RCC_CFGR = 0x5u << 10 | 0x4u << 13;
    RCC_CR |= 1u << 24;
    for (uint32_t k = 0; k < 100000u && !(RCC_CR & 1u << 25); ++k) {
    }
    RCC_CFGR |= 2u;
    for (uint32_t k = 0; k < 100000u && (RCC_CFGR & 0xcu) != 0x8u; ++k) {
    }
}

void board_begin(void) {
    set_clock();
    RCC_AHB1ENR |= 0x3u;          /* GPIOA, GPIOB */
    RCC_APB1ENR |= 0x2u;          /* TIM3 */
    RCC_APB2ENR |= 0x10u | 0x100u; /* USART1, ADC1 */
    GPIOA_MODER = (GPIOA_MODER & 0xffc30000u) | 0x0028afffu; /* PA0-5 analogue, PA6-7 and PA9-10 alternate */
    GPIOA_AFRL = (GPIOA_AFRL & 0x00ffffffu) | 0x22000000u;
    GPIOA_AFRH = (GPIOA_AFRH & 0xfffff00fu) | 0x00000770u;
    GPIOB_MODER = (GPIOB_MODER & 0xfffffff0u) | 0xau;
    GPIOB_AFRL = (GPIOB_AFRL & 0xffffff00u) | 0x22u;
    TIM3_PSC = PWM_DIVIDER - 1u;
    TIM3_ARR = PWM_STEPS - 1u;
    TIM3_CCMR1 = TIM3_CCMR2 = 0x6868u; /* PWM mode 1, buffered */
    for (uint32_t k = 0; k < 4; ++k) TIM3_CCR(k) = 0;
    TIM3_CCER = 0x1111u;
    TIM3_EGR = 1u;
    TIM3_CR1 = 0x81u;
    ADC_CCR = 1u << 16;   /* 84 MHz / 4; at most 36 MHz are allowed */
    ADC_SMPR2 = 0x24924u; /* 84 clocks of sampling for channels 0 to 5 */
    ADC_CR2 = 1u;
    USART_BRR = (SLOW + APP_BAUD / 2u) / APP_BAUD;
    USART_CR1 = 0x202cu; /* on, both ways, an interrupt for what comes */
    AT(0xe000e104u) = 1u << (37 - 32);
    SYST_RVR = PER_MS - 1u;
    SYST_CVR = 0;
    SYST_CSR = 7u;
}

/* Never less than before: a counter that began anew may be read before its interrupt has counted the millisecond. */
uint32_t board_micros(void) {
    static uint32_t last;
    uint32_t ms, left;
    do {
        ms = milliseconds;
        left = SYST_CVR;
    } while (ms != milliseconds);
    const uint32_t gone = left < PER_MS ? PER_MS - 1u - left : 0u; /* an emulator may say a count more than there is */
    const uint32_t found = ms * 1000u + gone / (CLOCK / 1000000u);
    if ((int32_t)(found - last) > 0) last = found;
    return last;
}

int board_read(void) {
    pump();
    if (given == got) return -1;
    const uint8_t byte = received[given];
    given = (uint16_t)((given + 1u) % KEPT);
    return byte;
}

uint16_t board_room(void) { return (uint16_t)(KEPT - 1u - (uint16_t)((put - taken) % KEPT)); }

void board_write(const uint8_t *bytes, uint16_t size) {
    for (uint16_t i = 0; i < size; ++i) {
        waiting[put] = bytes[i];
        put = (uint16_t)((put + 1u) % KEPT);
    }
    pump();
}

float board_drive(uint8_t drive, float duty) {
    const uint32_t level = (uint32_t)(duty * (float)PWM_STEPS + 0.5f);
    if (drive < 4) {
        pulses[drive] = level;
        TIM3_CCR(drive) = level;
    }
    return (float)level / (float)PWM_STEPS;
}

static void select_input(uint8_t channel) {
    static const uint8_t pins[APP_CHANNELS] = APP_CHANNEL_PINS;
    ADC_SQR3 = pins[channel];
}

static float finish_conversion(void) {
    for (uint32_t k = 0; k < 1000u && !(ADC_SR & 2u); ++k) {
    }
    return (float)ADC_DR;
}

float board_channel(uint8_t channel) {
    select_input(channel);
    ADC_CR2 |= 1u << 30;
    return finish_conversion();
}

/* Start a conversion whose input is held within a pulse; 0 if the pulse is too short. */
static uint8_t convert_in_pulse(uint32_t pulse) {
    if (pulse < PWM_SETTLE + PWM_HOLD) return 0;
    const uint32_t begin = board_micros();
    uint8_t inside = 0;
    while (!inside && board_micros() - begin < 2000000u / APP_PWM_HZ + 10u) {
        MASK_INTERRUPTS();
        const uint32_t now = TIM3_CNT;
        inside = now >= PWM_SETTLE && now + PWM_HOLD <= pulse;
        if (inside) ADC_CR2 |= 1u << 30;
        ALLOW_INTERRUPTS();
    }
    return inside;
}

uint8_t board_pulse_channel(uint8_t channel, uint8_t drive, float *steps) {
    if (pulses[drive] == 0) {
        *steps = board_channel(channel);
        return BOARD_OPEN;
    }
    select_input(channel);
    if (!convert_in_pulse(pulses[drive])) return BOARD_SHORT;
    *steps = finish_conversion();
    return BOARD_PULSE;
}
