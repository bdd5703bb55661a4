/*
 * Signals are off unless the host has armed the board, is heard, and no limit is passed. In every turn:
 *
 *     a message of the host -> command -> answer
 *     silence, time -> disarm
 *     the time of a sample has come -> channels -> supply, current -> disarm
 *                                               -> readings -> loop -> signals -> telemetry
 */
#include "app.h"

#include "alone_mode.h"
#include "board.h"
#include "link.h"
#include "loop.h"
#include "messages.h"
#define APP_TABLES
#include "settings.h"

enum {
    FREE = 16, /* levels of a waveform that are kept */
    BYTES = 64, /* bytes of the line in a turn, at most */
    COOLED = 10000 /* us between two updates of a bound that cools */
};
enum { BY_PIN = 1, BY_POWER };      /* APP_ALONE */
enum { ENDED, READY, RUNNING };     /* operation without a host: over, waits to be armed, is armed */

typedef struct {
    uint32_t micros;
    float value;
    uint8_t drive;
} app_level;

static loop_model model;
static link_receiver line;
static uint16_t sent;
static float settings[APP_SETTINGS - APP_FIXED]; /* set by the host; all others are constants in flash */
static float inputs[loop_INPUTS > 0 ? loop_INPUTS : 1];
static float channels[APP_CHANNELS];
static uint16_t in_pulse; /* bit i: channel i was read while its switch was closed */
static float outputs[loop_OUTPUTS > 0 ? loop_OUTPUTS : 1];
static float ages[APP_READINGS > 0 ? APP_READINGS : 1];
static float signals[APP_DRIVES], delivered[APP_DRIVES]; /* as wanted, and as the timer can */
static uint32_t next, level_at;                               /* us */
static uint32_t milliseconds, counted_at, heard, armed_at; /* ms since the start; counted up to here [us]; ms */
static uint32_t tracked_at; /* [us], time of the newest sample */
static float heat[APP_BOUNDS > 0 ? APP_BOUNDS : 1]; /* temperature bounds [K] */
#if APP_ALONE
static uint32_t played; /* samples of the cycle of the reference */
#endif
static uint16_t every, since;
static uint8_t mode, flags, started, alarm, alone;
static app_level levels[FREE];
static uint8_t first, filled;

static float setting(uint8_t place) { return place < APP_FIXED ? APP_DEFAULT(place) : settings[place - APP_FIXED]; }

/* ------------------------------------------------------------------------------- to the host */

static void send(uint8_t type, const uint8_t *payload, uint8_t size) {
    uint8_t frame[LINK_FRAME];
    const uint16_t length = link_encode(frame, type, sent, payload, size);
    ++sent; /* a frame that has no room is lost, and the host will see it by its number */
    if (length && board_room() >= length) {
        board_write(frame, length);
    }
}

static void answer(uint16_t to, uint8_t result) {
    uint8_t b[ANSWER_SIZE];
    link_put_u16(b + ANSWER_TO, to);
    b[ANSWER_RESULT] = result;
    b[ANSWER_ROOM] = (uint8_t)(FREE - filled);
    send(MESSAGE_ANSWER, b, ANSWER_SIZE);
}

static uint8_t append(uint8_t *bytes, uint8_t size, float value) {
    link_put_f32(bytes + size, value);
    return (uint8_t)(size + 4);
}

static void tell(uint32_t time) {
    uint8_t b[LINK_MOST], size = TELEMETRY_SIZE;
    link_put_u32(b + TELEMETRY_TIME, time);
    b[TELEMETRY_FLAGS] = flags;
    b[TELEMETRY_ALARM] = alarm;
    for (uint8_t i = 0; i < APP_READINGS; ++i) {
        size = append(b, size, inputs[APP_READING(i)]);
    }
    for (uint8_t i = 0; i < APP_DRIVES; ++i) {
        size = append(b, size, delivered[i]);
    }
    for (uint8_t i = 0; i < APP_CHANNELS; ++i) {
        if (APP_TELL_CHANNEL(i)) {
            size = append(b, size, channels[i]);
        }
    }
#if APP_TOLD
    for (uint8_t i = 0; i < APP_TOLD; ++i) {
        size = append(b, size, outputs[APP_TELL(i)]);
    }
#endif
    send(MESSAGE_TELEMETRY, b, size);
}

/* ------------------------------------------------------------------------------- signals */

static void drive_all(void) {
    const uint8_t pass = (flags & FLAG_ARMED) && !(flags & FLAG_EMULATED);
    for (uint8_t i = 0; i < APP_DRIVES; ++i) {
        const float most = setting(APP_MOST_DUTY);
        const float u = signals[i] < 0.0f ? 0.0f : signals[i] > most ? most : signals[i];
        delivered[i] = board_drive(i, pass ? u : 0.0f);
        if (flags & FLAG_EMULATED) {
            delivered[i] = signals[i];
        }
    }
}

/* ------------------------------------------------------------------------------- temperature bounds */

#if APP_BOUNDS
/* A bound after a time under a duty cycle, from above: e^-x < 1 - x + x^2/2. */
static float warm_up(uint8_t bound, float seconds, float duty) {
    const float ambient = FLASH_FLOAT(app_bounds[bound].ambient), x = seconds * FLASH_FLOAT(app_bounds[bound].cooling);
    const float decay = 1.0f - x + 0.5f * x * x;
    return ambient + (heat[bound] - ambient) * decay + seconds * FLASH_FLOAT(app_bounds[bound].rate) * duty;
}
#endif

static uint8_t is_off(void) {
    for (uint8_t i = 0; i < APP_DRIVES; ++i) {
        if (delivered[i] > 0.0f && !(flags & FLAG_EMULATED)) {
            return 0;
        }
    }
    return 1;
}

/* Advance the bounds to now: in the loop by what a late sample has heated, else by their own equation. */
static void track_heat(uint32_t now) {
    const uint32_t held = now - tracked_at;
    const uint8_t loop = started && mode == MODE_LOOP, off = is_off();
    if (!loop && off && held < COOLED) {
        return;
    }
    tracked_at = now;
#if APP_BOUNDS
    for (uint8_t i = 0; i < APP_BOUNDS; ++i) {
        const float duty = off ? 0.0f : delivered[FLASH_U16(app_bounds[i].drive)];
        if (!loop) {
            heat[i] = warm_up(i, 1e-6f * (float)held, duty);
            continue;
        }
        heat[i] = model.x[FLASH_U16(app_bounds[i].state)];
        if (held > APP_PERIOD) {
            heat[i] += 1e-6f * (float)(held - APP_PERIOD) * FLASH_FLOAT(app_bounds[i].rate) * duty;
        }
    }
#endif
}

static void pass_heat(void) {
#if APP_BOUNDS
    for (uint8_t i = 0; i < APP_BOUNDS; ++i) {
        model.x[FLASH_U16(app_bounds[i].state)] = heat[i];
    }
#endif
}

static uint8_t is_warm(void) {
    uint8_t warm = 0;
#if APP_BOUNDS
    for (uint8_t i = 0; i < APP_BOUNDS; ++i) {
        warm |= heat[i] > FLASH_FLOAT(app_bounds[i].ambient) + APP_WARM;
    }
#endif
    return warm;
}

static void switch_off(void) {
    for (uint8_t i = 0; i < APP_DRIVES; ++i) {
        signals[i] = 0.0f;
    }
}

static void disarm(uint8_t reason) {
    const uint8_t was = flags & FLAG_ARMED;
    track_heat(board_micros());
    switch_off();
    flags = (uint8_t)(flags & ~(unsigned)FLAG_ARMED);
    started = 0;
    filled = 0;
    drive_all();
    if (was) {
        uint8_t b[DISARMED_SIZE];
        link_put_u32(b + DISARMED_TIME, board_micros());
        b[DISARMED_REASON] = reason;
        send(MESSAGE_DISARMED, b, DISARMED_SIZE);
    }
}

/* ------------------------------------------------------------------------------- a sample */

/* A channel in SI. Those that a switch interrupts are read while it is closed; then the bit of the channel is set. */
static void read_channel(uint8_t i) {
    const uint8_t drive = APP_PULSED(i);
    const uint16_t bit = (uint16_t)(1u << i);
    uint8_t found = BOARD_OPEN;
    float steps = 0.0f;
    if (drive == APP_STEADY) {
        steps = board_channel(i);
    } else {
        found = board_pulse_channel(i, drive, &steps);
    }
    in_pulse = (uint16_t)(found == BOARD_PULSE ? in_pulse | bit : in_pulse & ~(unsigned)bit);
    if (found != BOARD_SHORT) {
        channels[i] = setting(APP_GAIN(i)) * (steps - setting(APP_OFFSET(i)));
    }
}

/* Channels in SI, and readings by them; a reading that cannot be made grows old. */
static void read_all(void) {
    for (uint8_t i = 0; i < APP_CHANNELS; ++i) {
        read_channel(i);
    }
    if (flags & FLAG_EMULATED) {
        return; /* the host sends the readings */
    }
    for (uint8_t i = 0; i < APP_READINGS; ++i) {
        const app_reading one = APP_SOURCE(i);
        float x = channels[one.channel];
        uint8_t fresh = 1;
        if (one.kind == APP_RATIO) {
            const float current = channels[one.other];
            const uint8_t both = (uint8_t)(in_pulse >> one.channel & in_pulse >> one.other & 1u);
            fresh = both && current >= setting(APP_LEAST_CURRENT);
            x = fresh ? x / current : inputs[APP_READING(i)];
        }
        ages[i] = fresh ? 0.0f : ages[i] + 1e-6f * (float)APP_PERIOD;
        inputs[APP_READING(i)] = x;
    }
}

/* One step of the loop on the readings and references in `inputs`. */
static void run_loop(void) {
    for (uint8_t i = 0; i < APP_READINGS; ++i) {
        inputs[APP_AGE(i)] = ages[i];
    }
    int status = started ? loop_step(&model, inputs, model.p[loop_p_period]) : loop_start(&model, inputs);
    if (status <= loop_LONG_STEP) {
        status = loop_observe(&model, inputs, outputs);
    }
    if (status > loop_LONG_STEP) {
        flags |= FLAG_STOPPED;
        disarm(REASON_LOOP);
        return;
    }
    started = 1;
#if APP_ALARM >= 0
    alarm = (uint8_t)(outputs[APP_ALARM] + 0.5f);
    flags = (uint8_t)(alarm ? flags | FLAG_GUARDED : flags & ~(unsigned)FLAG_GUARDED);
#endif
    for (uint8_t i = 0; i < APP_DRIVES; ++i) {
        signals[i] = outputs[APP_SIGNAL(i)];
    }
}

static float find_reference(uint8_t i) {
#if APP_ALONE
    if (alone == RUNNING) {
        return alone_reference(i, played);
    }
#endif
    return setting(APP_WANTED(i));
}

/* A sample of the loop. It goes on from the temperature bounds of the firmware, and begins with a period off if warm. */
static void follow(void) {
    for (uint8_t i = 0; i < APP_REFERENCES; ++i) {
        inputs[APP_REFERENCE(i)] = find_reference(i);
    }
    const uint8_t first_step = !started, warm = first_step && is_warm();
    if (warm && APP_CUTS) {
        flags |= FLAG_GUARDED; /* a guard that cuts would cut at once: wait until the element is cold */
        switch_off();
        return;
    }
    if (!first_step) {
        pass_heat();
    }
    run_loop();
    if (warm && started) {
        pass_heat();
        switch_off();
    }
#if APP_ALONE
    played = played + 1u < APP_SAMPLES ? played + 1u : 0u;
#endif
}

static void run_waveform(uint32_t now) {
    while (filled && now - level_at >= levels[first].micros) {
        level_at += levels[first].micros;
        first = (uint8_t)((first + 1u) % FREE);
        --filled;
    }
    for (uint8_t i = 0; i < APP_DRIVES; ++i) {
        if (!filled || levels[first].drive == i) {
            signals[i] = filled ? levels[first].value : 0.0f;
        }
    }
    if (!filled) {
        level_at = now; /* the next level begins then */
    }
}

/* Supply and current, as they are in this sample. */
static void watch_channels(void) {
#if APP_SUPPLY_CHANNEL >= 0
    const uint8_t low = channels[APP_SUPPLY_CHANNEL] < setting(APP_LEAST_SUPPLY);
    flags = (uint8_t)(low ? flags | FLAG_BROWN_OUT : flags & ~(unsigned)FLAG_BROWN_OUT);
#endif
    if (flags & FLAG_EMULATED) {
        return;
    }
    if (flags & FLAG_BROWN_OUT) {
        disarm(REASON_BROWN_OUT);
    }
    for (uint8_t i = 0; i < APP_READINGS; ++i) {
        const app_reading one = APP_SOURCE(i);
        if (one.kind == APP_RATIO && channels[one.other] > setting(APP_MOST_CURRENT)) {
            disarm(REASON_CURRENT);
        }
    }
}

static void sample(uint32_t now) {
    track_heat(now);
    read_all();
    watch_channels();
    if (flags & FLAG_ARMED) {
        if (mode == MODE_LOOP) {
            follow();
        }
        if (mode == MODE_WAVEFORM) {
            run_waveform(now);
        }
    }
    drive_all();
    if (every && ++since >= every) {
        since = 0;
        tell(now);
    }
}

/* ------------------------------------------------------------------------------- commands */

/* Set a gain of the loop; 0 if the loop cannot take it. */
static uint8_t tune(uint8_t gain, float value) {
#if APP_TUNES
    const uint16_t place = APP_PARAMETER(gain);
    const float before = model.p[place];
    model.p[place] = value;
    if (loop_prepare(&model) == loop_OK) {
        return 1;
    }
    model.p[place] = before;
    settings[APP_TUNED(gain) - APP_FIXED] = before;
    (void)loop_prepare(&model);
#else
    (void)gain;
    (void)value;
#endif
    return 0;
}

/* The loop as it is in flash, with the gains that the host has set. */
static void restore_loop(void) {
    loop_defaults(&model);
#if APP_TUNES
    for (uint8_t i = 0; i < APP_TUNES; ++i) {
        (void)tune(i, setting(APP_TUNED(i)));
    }
#endif
}

static uint8_t arm(uint32_t word, uint32_t now) {
    if (word != LINK_ARM_WORD || mode == MODE_IDLE) {
        return RESULT_REFUSED;
    }
    if (mode != MODE_EMULATED && ((flags & FLAG_BROWN_OUT) || setting(APP_CALIBRATED) < 0.5f)) {
        return RESULT_REFUSED;
    }
    if (flags & FLAG_ARMED) {
        return RESULT_DONE;
    }
    restore_loop();
    flags = (uint8_t)((flags | FLAG_ARMED) & ~(unsigned)(FLAG_STOPPED | FLAG_OVERRUN));
    started = 0;
    armed_at = milliseconds;
#if APP_ALONE
    played = 0;
#endif
    level_at = now;
    return RESULT_DONE;
}

static uint8_t choose(uint8_t wanted) {
    if (wanted > MODE_EMULATED) {
        return RESULT_OUT_OF_RANGE;
    }
    if (wanted != mode) {
        disarm(REASON_ASKED);
    }
    mode = wanted;
    flags = (uint8_t)(mode == MODE_EMULATED ? flags | FLAG_EMULATED : flags & ~(unsigned)FLAG_EMULATED);
    return RESULT_DONE;
}

/* A reference or a gain at any time; a calibration only while disarmed; a constant never. */
static uint8_t set(uint8_t place, float value) {
    if (place < APP_FIXED || (place >= APP_SETTINGS && place < APP_SETTINGS + loop_PARAMETERS)) {
        return RESULT_FIXED;
    }
    if (place >= APP_SETTINGS || !(value >= APP_LOW(place) && value <= APP_HIGH(place))) {
        return RESULT_OUT_OF_RANGE;
    }
    if (place < APP_WANTED(0) && (flags & FLAG_ARMED)) {
        return RESULT_REFUSED;
    }
    settings[place - APP_FIXED] = value;
    return place < APP_TUNED(0) || tune((uint8_t)(place - APP_TUNED(0)), value) ? RESULT_DONE : RESULT_OUT_OF_RANGE;
}

static uint8_t keep_level(const uint8_t *b) {
    const app_level one = {link_u32(b + LEVEL_MICROS), link_f32(b + LEVEL_VALUE), b[LEVEL_DRIVE]};
    if (mode != MODE_WAVEFORM || !(flags & FLAG_ARMED)) {
        return RESULT_REFUSED;
    }
    if (one.drive >= APP_DRIVES || one.micros == 0 || !(one.value >= 0.0f && one.value <= 1.0f)) {
        return RESULT_OUT_OF_RANGE;
    }
    if (filled == FREE) {
        return RESULT_FULL;
    }
    levels[(uint8_t)((first + filled) % FREE)] = one;
    ++filled;
    return RESULT_DONE;
}

/* A sample with readings and references of the host, while the outputs are off. */
static uint8_t emulate(const link_message *m) {
    if (mode != MODE_EMULATED || !(flags & FLAG_ARMED)) {
        return RESULT_REFUSED;
    }
    if (m->size != SAMPLE_SIZE + 8 * APP_READINGS + 4 * APP_REFERENCES) {
        return RESULT_UNKNOWN;
    }
    const uint8_t *b = m->payload + SAMPLE_SIZE;
    for (uint8_t i = 0; i < APP_READINGS; ++i, b += 8) {
        inputs[APP_READING(i)] = link_f32(b);
        ages[i] = link_f32(b + 4);
    }
    for (uint8_t i = 0; i < APP_REFERENCES; ++i, b += 4) {
        inputs[APP_REFERENCE(i)] = link_f32(b);
    }
    run_loop();
    drive_all();
    tell(link_u32(m->payload + SAMPLE_TIME));
    return RESULT_DONE;
}

static void greet(uint32_t token) {
    uint8_t b[HELLO_SIZE];
    link_put_u32(b + HELLO_TOKEN, token);
    b[HELLO_VERSION] = LINK_VERSION;
    link_put_u32(b + HELLO_DIGEST, APP_DIGEST);
    link_put_u32(b + HELLO_TIME, board_micros());
    b[HELLO_RESET] = board_reset_cause();
    send(MESSAGE_HELLO, b, HELLO_SIZE);
}

static void show(uint8_t place) {
    uint8_t b[SETTING_SIZE];
    b[SETTING_PLACE] = place;
    link_put_f32(b + SETTING_VALUE, place < APP_SETTINGS ? setting(place) : model.p[place - APP_SETTINGS]);
    send(MESSAGE_SETTING, b, SETTING_SIZE);
}

static uint8_t obey(const link_message *m, uint32_t now) {
    const uint8_t *b = m->payload;
    if (m->type == MESSAGE_ARM && m->size == ARM_SIZE) {
        return arm(link_u32(b + ARM_WORD), now);
    }
    if (m->type == MESSAGE_MODE && m->size == MODE_SIZE) {
        return choose(b[MODE_MODE]);
    }
    if (m->type == MESSAGE_SET && m->size == SET_SIZE) {
        return set(b[SET_PLACE], link_f32(b + SET_VALUE));
    }
    if (m->type == MESSAGE_LEVEL && m->size == LEVEL_SIZE) {
        return keep_level(b);
    }
    if (m->type == MESSAGE_SAMPLE) {
        return emulate(m);
    }
    if (m->type == MESSAGE_RATE && m->size == RATE_SIZE) {
        every = link_u16(b + RATE_EVERY);
        return RESULT_DONE;
    }
#if APP_ALONE
    if (m->type == MESSAGE_STORE && m->size == STORE_SIZE) {
        if (flags & FLAG_ARMED) {
            return RESULT_REFUSED;
        }
        return alone_store(settings, APP_STORED) ? RESULT_DONE : RESULT_BUSY;
    }
#endif
    if (m->type == MESSAGE_DISARM && m->size == DISARM_SIZE) {
        disarm(REASON_ASKED);
        return RESULT_DONE;
    }
    return RESULT_UNKNOWN;
}

static void serve(const link_message *m, uint32_t now) {
    heard = milliseconds;
    if (m->type == MESSAGE_PING && m->size == PING_SIZE) {
        greet(link_u32(m->payload + PING_TOKEN));
        return;
    }
    if (m->type == MESSAGE_READ && m->size == READ_SIZE && m->payload[READ_PLACE] < APP_SETTINGS + loop_PARAMETERS) {
        show(m->payload[READ_PLACE]);
        return;
    }
    const uint16_t number = m->number;
    const uint8_t type = m->type, result = obey(m, now);
    if (type != MESSAGE_SAMPLE || result != RESULT_DONE) {
        answer(number, result);
    }
}

/* At most one message or BYTES bytes, so that no line delays a sample by more than an answer. */
static void listen(uint32_t now) {
    link_message m;
    for (uint8_t k = 0; k < BYTES; ++k) {
        const int byte = board_read();
        if (byte < 0) {
            return;
        }
        if (link_receive(&line, (uint8_t)byte, &m)) {
            serve(&m, now);
            return;
        }
    }
}

/* ------------------------------------------------------------------------------- for ever */

/* Milliseconds do not wrap within any duration of settings.h; microseconds wrap after 71.6 minutes. */
static void count_time(uint32_t now) {
    if (now - counted_at >= 1000u) {
        const uint32_t passed = (now - counted_at) / 1000u;
        milliseconds += passed;
        counted_at += 1000u * passed;
    }
}

static void watch(void) {
    if (!(flags & FLAG_ARMED)) {
        if (milliseconds - heard > APP_SILENCE) {
            link_restart(&line); /* the next host may count from any number */
        }
        return;
    }
    if (milliseconds - heard > APP_SILENCE && alone != RUNNING) {
        disarm(REASON_SILENCE);
    } else if (milliseconds - armed_at > APP_LONGEST) {
        disarm(REASON_TIME);
    }
}

#if APP_ALONE
/* After a power-on with a calibration the board waits to be armed; after a watchdog or a fault it stays off. */
static uint8_t begin_alone(void) {
    const uint8_t cause = board_reset_cause(), loaded = alone_load(settings, APP_STORED);
    for (uint8_t i = 0; i < APP_STORED; ++i) {
        const uint8_t place = (uint8_t)(APP_FIXED + i);
        if (!loaded || !(settings[i] >= APP_LOW(place) && settings[i] <= APP_HIGH(place))) {
            settings[i] = APP_DEFAULT(place);
        }
    }
    if (APP_ALONE == BY_PIN) {
        return ENDED; /* until the switch is seen open */
    }
    return loaded && (cause == RESET_POWER_ON || cause == RESET_BROWN_OUT || cause == RESET_PIN) ? READY : ENDED;
}

static void run_alone(uint32_t now) {
    const uint8_t closed = APP_ALONE == BY_PIN ? board_switch() : 1u;
    if (alone == RUNNING && !closed) {
        disarm(REASON_PIN);
    }
    if (alone == RUNNING && !(flags & FLAG_ARMED)) {
        alone = ENDED;
    }
    if (alone == ENDED && !closed) {
        alone = READY;
    }
    if (alone == READY && closed && !(flags & FLAG_ARMED) && milliseconds - heard > APP_SILENCE) {
        (void)choose(MODE_LOOP);
        if (arm(LINK_ARM_WORD, now) == RESULT_DONE) {
            alone = RUNNING;
        }
    }
}
#endif

void app_begin(void) {
    board_begin();
    link_begin(&line);
    for (uint8_t i = APP_FIXED; i < APP_SETTINGS; ++i) {
        settings[i - APP_FIXED] = APP_DEFAULT(i);
    }
    restore_loop();
    mode = MODE_IDLE;
    flags = 0;
    disarm(REASON_ASKED);
    board_guard();
    next = counted_at = tracked_at = board_micros();
    milliseconds = heard = 0;
#if APP_BOUNDS
    for (uint8_t i = 0; i < APP_BOUNDS; ++i) {
        heat[i] = FLASH_FLOAT(app_bounds[i].limit); /* unknown after a reset */
    }
#endif
#if APP_ALONE
    alone = begin_alone();
#endif
}

void app_turn(void) {
    const uint32_t begun = board_micros();
    count_time(begun);
    listen(begun);
    watch();
    const uint32_t now = board_micros();
    if ((int32_t)(now - next) < 0) {
        return;
    }
    if (now - next >= APP_PERIOD) {
        flags |= FLAG_OVERRUN;
        next = now;
        if (!(flags & FLAG_EMULATED)) {
            disarm(REASON_OVERRUN);
        }
    }
    next += APP_PERIOD;
    sample(now);
#if APP_ALONE
    run_alone(now);
#endif
    board_feed();
}
