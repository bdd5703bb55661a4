/*
 * An AVR under simavr whose serial line, clock and circuit are in the hands of another program:
 *
 *     simavr_line ELF MCU HZ BAUD PIN_A PIN_B LAG
 *
 * PIN_A and PIN_B are the bits of PORTB of timer 1; LAG is the time constant of the amplifiers in cycles.
 *
 * On standard input, again and again: cycles to run (u32; 2^32 - 1 to switch off and on); voltages at A0 to A7 while all
 * switches are open (eight u16, in mV); voltages that a closed switch adds (eight u16, in mV); the switch of each
 * channel, 0 or 1 (eight u8); number of bytes to send to the board (u16); the bytes. On standard output, each time:
 * cycles so far (u64), duty cycles of both pins (two u16, in 1/65535), frequency of timer 1 (f32, in Hz), whether the
 * processor has crashed (u8), number of bytes that the board has sent (u16); the bytes; then 16 cycle counts (u32): the
 * largest between GPIOR0 = k and GPIOR0 = 0.
 *
 * The converter holds its input two of its clocks after the start of a conversion, as in the data sheet. The input is
 * the voltage at this instant, within the pulse or between pulses.
 */
#include <simavr/avr_adc.h>
#include <simavr/avr_ioport.h>
#include <simavr/avr_uart.h>
#include <simavr/sim_avr.h>
#include <simavr/sim_cycle_timers.h>
#include <simavr/sim_elf.h>
#include <math.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { ROOM = 1 << 16, MARKS = 16, GPIOR0 = 0x3e, ADCSRA = 0x7a, PORTB = 0x25, HELD = 2 };
enum { TCCR1A = 0x80, TCCR1B = 0x81, TCNT1L = 0x84, ICR1L = 0x86, OCR1L = 0x88 };

static avr_t *avr;
static avr_irq_t *to_board;
static uint8_t in[ROOM], out[ROOM];
static uint32_t in_from, in_to, out_size, marks[MARKS];
static avr_cycle_count_t per_byte, marked;
static uint8_t mark;
static int open_line = 1, converted;
static int pins[2];
static double lag = 1.0;
static uint16_t steady[8], pulsed[8];
static uint8_t by[8];

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

static uint32_t word(uint16_t low) { return avr->data[low] | (uint32_t)avr->data[low + 1] << 8; }

/* Cycles of a count of timer 1; 0 while it stands still. */
static uint32_t divider(void) {
    static const uint32_t by[8] = {0, 1, 8, 64, 256, 1024, 0, 0};
    return by[avr->data[TCCR1B] & 7];
}

/* Counts of a pulse of a drive, and of a period. */
static uint32_t period(void) { return word(ICR1L) + 1u; }

static uint32_t pulse(int drive) {
    if (avr->data[TCCR1A] & (drive ? 0x20 : 0x80)) return word((uint16_t)(OCR1L + 2 * drive)) + 1u;
    return avr->data[PORTB] >> pins[drive] & 1 ? period() : 0;
}

static float frequency(void) {
    return divider() ? (float)avr->frequency / (float)(divider() * period()) : 0.0f;
}

/* Voltage at a channel now [mV]: an amplifier follows its switch with a lag. */
static uint32_t look(int channel) {
    const uint32_t on = pulse(by[channel]);
    double share = on ? 1.0 : 0.0;
    if (on && on < period()) {
        const avr_io_addr_t place = AVR_DATA_TO_IO(TCNT1L);
        const uint32_t low = avr->io[place].r.c(avr, TCNT1L, avr->io[place].r.param);
        const double now = low | (uint32_t)avr->data[TCNT1L + 1] << 8;
        share = exp(-(now < on ? now : now - on) * divider() / lag);
        if (now < on) share = 1.0 - share;
    }
    return (uint32_t)(steady[channel] + share * pulsed[channel] + 0.5);
}

static avr_cycle_count_t hold(avr_t *of, avr_cycle_count_t when, void *param) {
    (void)of, (void)when, (void)param;
    avr_raise_irq(avr_io_getirq(avr, AVR_IOCTL_ADC_GETIRQ, ADC_IRQ_ADC0 + converted), look(converted));
    return 0;
}

static void convert(struct avr_irq_t *irq, uint32_t value, void *param) {
    union {
        avr_adc_mux_t mux;
        uint32_t number;
    } found = {.number = value};
    const uint8_t shift = avr->data[ADCSRA] & 7;
    (void)irq, (void)param;
    converted = (int)found.mux.src & 7;
    avr_cycle_timer_register(avr, (avr_cycle_count_t)HELD << (shift ? shift : 1), hold, NULL);
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
    if (count != 8) return 2;
    pins[0] = atoi(words[5]);
    pins[1] = atoi(words[6]);
    lag = fmax(atof(words[7]), 1.0);
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
    avr_irq_register_notify(avr_io_getirq(avr, AVR_IOCTL_ADC_GETIRQ, ADC_IRQ_OUT_TRIGGER), convert, NULL);
    avr_cycle_timer_register(avr, per_byte, feed, NULL);
    reset_of_chip = avr->reset;
    avr->reset = begin_anew;
    for (;;) {
        uint32_t cycles;
        uint16_t more, duties[2];
        uint64_t now;
        float hertz;
        uint8_t bytes[ROOM], crashed;
        int state = cpu_Running;
        get(&cycles, sizeof cycles);
        get(steady, sizeof steady);
        get(pulsed, sizeof pulsed);
        get(by, sizeof by);
        get(&more, sizeof more);
        get(bytes, more);
        for (uint16_t i = 0; i < more; ++i) in[in_to++ % ROOM] = bytes[i];
        if (cycles == UINT32_MAX) {
            cycle_power();
            cycles = 0;
        }
        const avr_cycle_count_t until = avr->cycle + cycles;
        while (avr->cycle < until && state != cpu_Done && state != cpu_Crashed) state = avr_run(avr);
        now = avr->cycle;
        crashed = state == cpu_Crashed || state == cpu_Done;
        for (int i = 0; i < 2; ++i) duties[i] = (uint16_t)(65535.0 * pulse(i) / period() + 0.5);
        hertz = frequency();
        more = (uint16_t)(out_size < 65535u ? out_size : 65535u);
        put(&now, sizeof now);
        put(duties, sizeof duties);
        put(&hertz, sizeof hertz);
        put(&crashed, 1);
        put(&more, sizeof more);
        put(out, more);
        put(marks, sizeof marks);
        fflush(stdout);
        out_size = 0;
    }
}
