/* The board as a ros2_control system: state interfaces of its telemetry, command interfaces of its references. */
#ifndef SMA_SYSTEM_HPP
#define SMA_SYSTEM_HPP

#include <hardware_interface/system_interface.hpp>
#include <memory>
#include <string>
#include <vector>

#include "sma_board.hpp"

namespace @PACKAGE@ {

using hardware_interface::CallbackReturn;
using hardware_interface::return_type;

class SmaSystem : public hardware_interface::SystemInterface {
public:
    CallbackReturn on_init(const hardware_interface::HardwareInfo &info) override;
    std::vector<hardware_interface::StateInterface> export_state_interfaces() override;
    std::vector<hardware_interface::CommandInterface> export_command_interfaces() override;
    CallbackReturn on_configure(const rclcpp_lifecycle::State &before) override;
    CallbackReturn on_activate(const rclcpp_lifecycle::State &before) override;
    CallbackReturn on_deactivate(const rclcpp_lifecycle::State &before) override;
    return_type read(const rclcpp::Time &time, const rclcpp::Duration &period) override;
    return_type write(const rclcpp::Time &time, const rclcpp::Duration &period) override;

private:
    std::unique_ptr<sma::Board> board_;
    std::vector<double> states_, commands_;
    std::string port_;
    bool armed_ = false;
};

}  // namespace @PACKAGE@

#endif
