/*
 * A board of martensite from C++, without ROS: open, arm, read, write. The interface for ros2_control is built on it, and
 * it is tested without ROS.
 */
#ifndef SMA_BOARD_HPP
#define SMA_BOARD_HPP

#include <cstdint>
#include <string>
#include <vector>

#include "link.h"

namespace sma {

class Board {
public:
    /* digest: of the firmware that must answer; columns: numbers of its telemetry; references: places of its settings. */
    Board(std::uint32_t digest, std::size_t columns, std::vector<std::uint8_t> references);
    ~Board();
    Board(const Board &) = delete;
    Board &operator=(const Board &) = delete;

    /* Open a serial line and greet the board; false, with `fault()`, if it is not there or holds another firmware. */
    bool open(const std::string &port, int baud);
    void close();

    /* Let the loop on the board run; disarm. The board disarms by itself when `read` or `write` are not called for 40 ms. */
    bool arm();
    bool disarm();

    /* Take what has come: false if the board disarmed or the line broke. */
    bool read();

    /* Tell references to the board, which is also told that the host is alive. */
    bool write(const std::vector<double> &references);

    const std::vector<double> &values() const { return values_; }
    std::uint8_t flags() const { return flags_; }
    std::uint8_t alarm() const { return alarm_; }
    double time() const { return time_; }
    std::uint32_t samples() const { return samples_; }
    const link_counts &counts() const { return line_.counts; }
    const std::string &fault() const { return fault_; }

private:
    bool send(std::uint8_t type, const std::uint8_t *payload, std::uint8_t size);
    bool command(std::uint8_t type, const std::uint8_t *payload, std::uint8_t size);
    bool take_bytes(int wait_ms);
    void take(const link_message &message);

    std::uint32_t digest_;
    std::vector<std::uint8_t> references_;
    std::vector<double> values_;
    link_receiver line_{};
    link_clock clock_{};
    std::uint16_t sent_ = 0;
    std::uint16_t answered_ = 0;
    std::uint8_t result_ = 0;
    bool answer_ = false, hello_ = false, disarmed_ = false;
    std::uint32_t found_digest_ = 0, samples_ = 0;
    std::uint8_t flags_ = 0, alarm_ = 0;
    double time_ = 0.0;
    int file_ = -1;
    std::string fault_;
};

}  // namespace sma

#endif
