/* Vectors and what goes before main, for GCC; with stm32f405.ld. */
#include <stdint.h>

#include "app.h"

extern uint32_t _data_from[], _data_begin[], _data_end[], _bss_begin[], _bss_end[], _stack[];

int main(void);
void Reset_Handler(void);
void SysTick_Handler(void);
void USART1_IRQHandler(void);
void Fault_Handler(void) __attribute__((weak, alias("stop"))); /* of guard_stm32f405.c, if it is there */
void stop(void);

void stop(void) {
    for (;;) {
    }
}

void Reset_Handler(void) {
    const uintptr_t data = (uintptr_t)_data_end - (uintptr_t)_data_begin;
    const uintptr_t bss = (uintptr_t)_bss_end - (uintptr_t)_bss_begin;
    for (uintptr_t k = 0; k < data / sizeof(uint32_t); ++k) _data_begin[k] = _data_from[k];
    for (uintptr_t k = 0; k < bss / sizeof(uint32_t); ++k) _bss_begin[k] = 0;
    *(volatile uint32_t *)0xe000ed88u |= 0xfu << 20; /* floating point on */
    __asm volatile("dsb\n\tisb");
    (void)main();
    stop();
}

typedef void (*handler)(void);

__attribute__((section(".vectors"), used)) static const handler vectors[16 + 38] = {
    (handler)_stack,
    Reset_Handler,
    Fault_Handler, /* NMI */
    Fault_Handler, /* hard fault */
    Fault_Handler, /* memory management */
    Fault_Handler, /* bus fault */
    Fault_Handler, /* usage fault */
    [15] = SysTick_Handler,
    [16 + 37] = USART1_IRQHandler,
};

int main(void) {
    app_begin();
    for (;;) app_turn();
}
