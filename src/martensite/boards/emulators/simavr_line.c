/*
 * An AVR under simavr whose serial line and clock are in the hands of another program: simavr_line ELF MCU HZ BAUD
 *
 * On standard input, again and again: cycles to run (u32; 2^32 - 1 to switch off and on), voltages at A0 to A7 (eight u16, in mV), how many bytes to
 * send to the board (u16), the bytes. On
 * standard output, each time: cycles so far (u64), the duty of pins 9 and 10 (two u16, in 1/255), whether the processor
 * has crashed (u8), how many bytes the board has sent (u16), the bytes; then 16 cycle counts (u32): those between
 * GPIOR0 = k and GPIOR0 = 0, the largest so far.
 */
#include <simavr/avr_adc.h>
#include <simavr/avr_ioport.h>
#include <simavr/avr_uart.h>
#include <simavr/sim_avr.h>
#include <simavr/sim_cycle_timers.h>
#include <simavr/sim_elf.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { ROOM = 1 << 16, MARKS = 16, GPIOR0 = 0x3e, TCCR1A = 0x80, OCR1AL = 0x88, OCR1BL = 0x8a, PORTB = 0x25 };

static avr_t *avr;
static avr_irq_t *to_board;
static uint8_t in[ROOM], out[ROOM];
static uint32_t in_from, in_to, out_size, marks[MARKS];
static avr_cycle_count_t per_byte, marked;
static uint8_t mark;
static int open_line = 1;

static void receive(struct avr_irq_t *irq, uint32_t value, void *param) {
    (void)irq, (void)param;
    if (out_size < ROOM) out[out_size++] = (uint8_t)value;
}

static void begin(struct avr_irq_t *irq, uint32_t value, void *param) {
    (void)irq, (void)value, (void)param;
    open_line = 1;
}

static void stop(struct avr_irq_t *irq, uint32_t value, void *param) {
    (void)irq, (void)value, (void)param;
    open_line = 0;
}

/* A byte takes its time on the line; one that finds the board's register full waits, as simavr wants it. */
static avr_cycle_count_t feed(avr_t *of, avr_cycle_count_t when, void *param) {
    (void)of, (void)param;
    if (in_from != in_to && open_line) avr_raise_irq(to_board, in[in_from++ % ROOM]);
    return when + per_byte;
}

static void note(avr_t *of, avr_io_addr_t address, uint8_t value, void *param) {
    (void)param;
    of->data[address] = value;
    if (value == 0 && mark && mark < MARKS) {
        const uint32_t passed = (uint32_t)(of->cycle - marked);
        if (passed > marks[mark]) marks[mark] = passed;
    }
    mark = value;
    marked = of->cycle;
}

static uint16_t duty(uint8_t connected, uint8_t bit, uint16_t compare) {
    if (avr->data[TCCR1A] & connected) return avr->data[compare];
    return avr->data[PORTB] >> bit & 1 ? 255 : 0;
}

static void (*reset_of_chip)(avr_t *of);

/* A reset, as by the watchdog, forgets the timers of simavr. */
static void begin_anew(avr_t *of) {
    if (reset_of_chip) reset_of_chip(of);
    open_line = 1;
    in_from = in_to;
    avr_cycle_timer_register(of, per_byte, feed, NULL);
}

/* Off and on again: the RAM has lost what it held. */
static void cycle_power(void) {
    memset(avr->data + avr->ioend + 1, 0xa5, (size_t)(avr->ramend - avr->ioend));
    avr_reset(avr);
    avr_regbit_set(avr, avr->reset_flags.porf);
}

static void get(void *to, size_t size) {
    if (fread(to, 1, size, stdin) != size) exit(0);
}

static void put(const void *from, size_t size) { fwrite(from, 1, size, stdout); }

static void quiet(avr_t *of, const int level, const char *format, va_list rest) {
    (void)of;
    if (level <= LOG_ERROR) vfprintf(stderr, format, rest);
}

int main(int count, char **words) {
    elf_firmware_t firmware = {0};
    uint32_t flags = 0;
    if (count != 5) return 2;
    avr_global_logger_set(quiet);
    if (elf_read_firmware(words[1], &firmware)) return 2;
    avr = avr_make_mcu_by_name(words[2]);
    if (!avr) return 2;
    avr_init(avr);
    avr->log = LOG_ERROR;
    firmware.frequency = (uint32_t)strtoul(words[3], NULL, 10);
    avr_load_firmware(avr, &firmware);
    avr->frequency = firmware.frequency;
    avr->vcc = avr->avcc = avr->aref = 5000;
    per_byte = (avr_cycle_count_t)firmware.frequency * 10u / strtoul(words[4], NULL, 10);
    avr_ioctl(avr, AVR_IOCTL_UART_GET_FLAGS('0'), &flags);
    flags &= ~(uint32_t)(AVR_UART_FLAG_STDIO | AVR_UART_FLAG_POLL_SLEEP);
    avr_ioctl(avr, AVR_IOCTL_UART_SET_FLAGS('0'), &flags);
    to_board = avr_io_getirq(avr, AVR_IOCTL_UART_GETIRQ('0'), UART_IRQ_INPUT);
    avr_irq_register_notify(avr_io_getirq(avr, AVR_IOCTL_UART_GETIRQ('0'), UART_IRQ_OUTPUT), receive, NULL);
    avr_irq_register_notify(avr_io_getirq(avr, AVR_IOCTL_UART_GETIRQ('0'), UART_IRQ_OUT_XON), begin, NULL);
    avr_irq_register_notify(avr_io_getirq(avr, AVR_IOCTL_UART_GETIRQ('0'), UART_IRQ_OUT_XOFF), stop, NULL);
    avr_register_io_write(avr, GPIOR0, note, NULL);
    avr_cycle_timer_register(avr, per_byte, feed, NULL);
    reset_of_chip = avr->reset;
    avr->reset = begin_anew;
    for (;;) {
        uint32_t cycles;
        uint16_t more, duties[2], volts[8];
        uint64_t now;
        uint8_t bytes[ROOM], crashed;
        int state = cpu_Running;
        get(&cycles, sizeof cycles);
        get(volts, sizeof volts);
        get(&more, sizeof more);
        get(bytes, more);
        for (int i = 0; i < 8; ++i) avr_raise_irq(avr_io_getirq(avr, AVR_IOCTL_ADC_GETIRQ, ADC_IRQ_ADC0 + i), volts[i]);
        for (uint16_t i = 0; i < more; ++i) in[in_to++ % ROOM] = bytes[i];
        if (cycles == UINT32_MAX) {
            cycle_power();
            cycles = 0;
        }
        const avr_cycle_count_t until = avr->cycle + cycles;
        while (avr->cycle < until && state != cpu_Done && state != cpu_Crashed) state = avr_run(avr);
        now = avr->cycle;
        crashed = state == cpu_Crashed || state == cpu_Done;
        duties[0] = duty(0x80, 1, OCR1AL);
        duties[1] = duty(0x20, 2, OCR1BL);
        more = (uint16_t)(out_size < 65535u ? out_size : 65535u);
        put(&now, sizeof now);
        put(duties, sizeof duties);
        put(&crashed, 1);
        put(&more, sizeof more);
        put(out, more);
        put(marks, sizeof marks);
        fflush(stdout);
        out_size = 0;
    }
}
