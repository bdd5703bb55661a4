#include "sma_board.hpp"

#include <fcntl.h>
#include <poll.h>
#include <termios.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <utility>

#include "messages.h"

namespace sma {

namespace {

constexpr int TRIES = 5, WAIT_MS = 200;

speed_t find_speed(int baud) {
    switch (baud) {
        case 115200: return B115200;
        case 500000: return B500000;
        case 921600: return B921600;
        default: return B1000000;
    }
}

}  // namespace

Board::Board(std::uint32_t digest, std::size_t columns, std::vector<std::uint8_t> references)
    : digest_(digest), references_(std::move(references)), values_(columns, 0.0) {
    link_begin(&line_);
}

Board::~Board() { close(); }

bool Board::open(const std::string &port, int baud) {
    close();
    file_ = ::open(port.c_str(), O_RDWR | O_NOCTTY | O_NONBLOCK);
    if (file_ < 0) {
        fault_ = port + ": " + std::strerror(errno);
        return false;
    }
    termios line{};
    if (tcgetattr(file_, &line) == 0) {
        cfmakeraw(&line);
        cfsetspeed(&line, find_speed(baud));
        tcsetattr(file_, TCSANOW, &line);
    }
    link_begin(&line_);
    std::uint8_t token[PING_SIZE];
    link_put_u32(token, digest_);
    for (int k = 0; k < TRIES && !hello_; ++k) {
        if (!send(MESSAGE_PING, token, PING_SIZE) || !take_bytes(WAIT_MS)) return false;
    }
    if (!hello_) {
        fault_ = "the board does not answer";
        return false;
    }
    if (found_digest_ != digest_) {
        fault_ = "the board holds another firmware";
        return false;
    }
    std::uint8_t every[RATE_SIZE];
    link_put_u16(every, 1);
    return command(MESSAGE_RATE, every, RATE_SIZE);
}

void Board::close() {
    if (file_ >= 0) {
        (void)disarm();
        ::close(file_);
    }
    file_ = -1;
    hello_ = false;
}

bool Board::arm() {
    disarmed_ = false;
    const std::uint8_t mode = MODE_LOOP;
    std::uint8_t word[ARM_SIZE];
    link_put_u32(word, LINK_ARM_WORD);
    return command(MESSAGE_MODE, &mode, MODE_SIZE) && command(MESSAGE_ARM, word, ARM_SIZE);
}

bool Board::disarm() { return file_ >= 0 && send(MESSAGE_DISARM, nullptr, 0); }

bool Board::read() {
    if (!take_bytes(0)) return false;
    if (disarmed_) fault_ = "the board disarmed";
    return !disarmed_;
}

bool Board::write(const std::vector<double> &references) {
    for (std::size_t i = 0; i < references_.size() && i < references.size(); ++i) {
        std::uint8_t b[SET_SIZE];
        b[SET_PLACE] = references_[i];
        link_put_f32(b + SET_VALUE, static_cast<float>(references[i]));
        if (!send(MESSAGE_SET, b, SET_SIZE)) return false;
    }
    return true;
}

bool Board::send(std::uint8_t type, const std::uint8_t *payload, std::uint8_t size) {
    std::uint8_t frame[LINK_FRAME];
    const std::uint16_t length = link_encode(frame, type, sent_++, payload, size);
    for (std::uint16_t done = 0; done < length;) {
        const ssize_t put = ::write(file_, frame + done, static_cast<std::size_t>(length - done));
        if (put > 0) {
            done = static_cast<std::uint16_t>(done + put);
            continue;
        }
        pollfd one{file_, POLLOUT, 0};
        if ((put < 0 && errno != EAGAIN) || poll(&one, 1, WAIT_MS) <= 0) {
            fault_ = "the line is broken";
            return false;
        }
    }
    return true;
}

bool Board::command(std::uint8_t type, const std::uint8_t *payload, std::uint8_t size) {
    for (int k = 0; k < TRIES; ++k) {
        answer_ = false;
        const std::uint16_t number = sent_;
        if (!send(type, payload, size)) return false;
        for (int left = WAIT_MS; left > 0; left -= 10) {
            if (!take_bytes(10)) return false;
            if (answer_ && answered_ == number) {
                if (result_ != RESULT_DONE) fault_ = "the board refuses";
                return result_ == RESULT_DONE;
            }
        }
    }
    fault_ = "the board does not answer";
    return false;
}

bool Board::take_bytes(int wait_ms) {
    pollfd one{file_, POLLIN, 0};
    if (poll(&one, 1, wait_ms) < 0 || (one.revents & (POLLERR | POLLNVAL))) {
        fault_ = "the line is broken";
        return false;
    }
    std::uint8_t bytes[512];
    ssize_t count;
    while ((count = ::read(file_, bytes, sizeof bytes)) > 0) {
        for (ssize_t i = 0; i < count; ++i) {
            link_message message;
            if (link_receive(&line_, bytes[i], &message)) take(message);
        }
    }
    return true;
}

void Board::take(const link_message &message) {
    const std::uint8_t *b = message.payload;
    if (message.type == MESSAGE_HELLO && message.size == HELLO_SIZE && b[HELLO_VERSION] == LINK_VERSION) {
        hello_ = true;
        found_digest_ = link_u32(b + HELLO_DIGEST);
    } else if (message.type == MESSAGE_ANSWER && message.size == ANSWER_SIZE) {
        answer_ = true;
        answered_ = link_u16(b + ANSWER_TO);
        result_ = b[ANSWER_RESULT];
    } else if (message.type == MESSAGE_DISARMED) {
        disarmed_ = true;
    } else if (message.type == MESSAGE_TELEMETRY && message.size == TELEMETRY_SIZE + 4 * values_.size()) {
        time_ = 1e-6 * static_cast<double>(link_unwrap(&clock_, link_u32(b + TELEMETRY_TIME)));
        flags_ = b[TELEMETRY_FLAGS];
        alarm_ = b[TELEMETRY_ALARM];
        for (std::size_t i = 0; i < values_.size(); ++i)
            values_[i] = static_cast<double>(link_f32(b + TELEMETRY_SIZE + 4 * i));
        ++samples_;
    }
}

}  // namespace sma
