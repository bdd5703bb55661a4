#include "sma_system.hpp"

#include <algorithm>
#include <pluginlib/class_list_macros.hpp>
#include <rclcpp/logging.hpp>

#include "firmware.hpp"

namespace @PACKAGE@ {

namespace {
const auto logger = rclcpp::get_logger("@PACKAGE@");
}

CallbackReturn SmaSystem::on_init(const hardware_interface::HardwareInfo &info) {
    if (hardware_interface::SystemInterface::on_init(info) != CallbackReturn::SUCCESS) return CallbackReturn::ERROR;
    const auto given = info_.hardware_parameters.find("port");
    if (given == info_.hardware_parameters.end()) {
        RCLCPP_ERROR(logger, "The hardware needs a parameter `port`, such as /dev/ttyACM0.");
        return CallbackReturn::ERROR;
    }
    port_ = given->second;
    const auto arm = info_.hardware_parameters.find("arm");
    armed_ = arm != info_.hardware_parameters.end() && arm->second == "ARM";
    states_.assign(std::size(firmware::states), 0.0);
    commands_.assign(std::begin(firmware::first), std::end(firmware::first));
    board_ = std::make_unique<sma::Board>(
        firmware::digest, std::size(firmware::states),
        std::vector<std::uint8_t>(std::begin(firmware::places), std::end(firmware::places)));
    return CallbackReturn::SUCCESS;
}

std::vector<hardware_interface::StateInterface> SmaSystem::export_state_interfaces() {
    std::vector<hardware_interface::StateInterface> found;
    for (std::size_t i = 0; i < states_.size(); ++i) found.emplace_back(info_.name, firmware::states[i], &states_[i]);
    return found;
}

std::vector<hardware_interface::CommandInterface> SmaSystem::export_command_interfaces() {
    std::vector<hardware_interface::CommandInterface> found;
    for (std::size_t i = 0; i < commands_.size(); ++i) found.emplace_back(info_.name, firmware::commands[i], &commands_[i]);
    return found;
}

CallbackReturn SmaSystem::on_configure(const rclcpp_lifecycle::State &) {
    if (board_->open(port_, firmware::baud)) return CallbackReturn::SUCCESS;
    RCLCPP_ERROR(logger, "%s", board_->fault().c_str());
    return CallbackReturn::ERROR;
}

CallbackReturn SmaSystem::on_activate(const rclcpp_lifecycle::State &) {
    if (!armed_) {
        RCLCPP_WARN(logger, "Nothing is armed: the hardware parameter `arm` is not `ARM`.");
        return CallbackReturn::SUCCESS;
    }
    if (board_->arm()) return CallbackReturn::SUCCESS;
    RCLCPP_ERROR(logger, "%s", board_->fault().c_str());
    return CallbackReturn::ERROR;
}

CallbackReturn SmaSystem::on_deactivate(const rclcpp_lifecycle::State &) {
    return board_->disarm() ? CallbackReturn::SUCCESS : CallbackReturn::ERROR;
}

return_type SmaSystem::read(const rclcpp::Time &, const rclcpp::Duration &) {
    const bool fine = board_->read();
    std::copy(board_->values().begin(), board_->values().end(), states_.begin());
    if (fine) return return_type::OK;
    RCLCPP_ERROR(logger, "%s", board_->fault().c_str());
    return return_type::ERROR;
}

return_type SmaSystem::write(const rclcpp::Time &, const rclcpp::Duration &) {
    return board_->write(commands_) ? return_type::OK : return_type::ERROR;
}

}  // namespace @PACKAGE@

PLUGINLIB_EXPORT_CLASS(@PACKAGE@::SmaSystem, hardware_interface::SystemInterface)
