// $title on $robot, as a ROS 2 node. Exported by Understudy: teach it again instead of editing it.
// It decides every $tick_s s on the latest messages, and commands the robot once a person has armed it.

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <limits>
#include <memory>
#include <mutex>
#include <sstream>
#include <stdexcept>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include "diagnostic_msgs/msg/diagnostic_array.hpp"
#include "diagnostic_msgs/msg/diagnostic_status.hpp"
#include "diagnostic_msgs/msg/key_value.hpp"
#include "rcl_interfaces/msg/parameter_descriptor.hpp"
#include "rclcpp/rclcpp.hpp"
#include "std_srvs/srv/set_bool.hpp"
$includes

#include "derived_readings.hpp"
#include "message_values.hpp"
#include "motion_guard.hpp"
#include "$name.h"

namespace
{

using diagnostic_msgs::msg::DiagnosticStatus;
using understudy::ABSENT;
using understudy::Speeds;
using understudy::StopReason;

constexpr double TICK_S = $tick_s;
constexpr double CHECK_S = 0.02;      // the guard looks, and repeats the command
constexpr double OTHERS_S = 0.2;      // how often it looks for other publishers of commands
constexpr double DIAGNOSTICS_S = 1.0;
${key_constant}constexpr double INFINITE = std::numeric_limits<double>::infinity();
constexpr const char * ROBOT = $robot_text;

// The states of each automaton: the name, and the automaton that the state runs, or -1.
struct StateName
{
  const char * name;
  int automaton;
};
$states

// The latest values of a source in the robot's file.
struct Source
{
  const char * name;
  const char * topic;
  double stale_s;      // older values are absent
  double rate_hz;      // that is expected; 0 if the file does not say it
  bool required;       // the robot stops while it is absent
  bool always;         // every valid message has all values
  std::vector<double> values = {};
  double at = -INFINITE, first = ABSENT;  // the times of the last and the first message
  std::uint64_t count = 0;

  void receive(double now, std::vector<double> received)
  {
    values = std::move(received);
    at = now;
    first = count == 0 ? now : first;
    ++count;
  }
  bool is_fresh(double now) const {return now - at <= stale_s;}
  double read(double now, std::size_t index = 0) const
  {
    return is_fresh(now) && index < values.size() ? values[index] : ABSENT;
  }
  double compute_rate() const
  {
    return at > first ? static_cast<double>(count - 1) / (at - first) : ABSENT;
  }
};

enum SourceNumber {
$source_numbers
  SOURCES
};

std::string quote_json(const std::string & text)
{
  std::string quoted = "\"";
  for (const char each : text) {
    if (each == '"' || each == '\\') {
      quoted += '\\';
    }
    quoted += each;
  }
  return quoted + "\"";
}

class BehaviorNode : public rclcpp::Node
{
public:
  BehaviorNode()
  : Node("$node")
  {
    const bool resume = declare_parameter<bool>(
      "resume", false, describe("Move again by itself when what stopped the robot is over."));
    const bool armed = declare_parameter<bool>(
      "armed", false, describe("Command the robot from the start, without a call of ~/arm."));
    const understudy::MotionLimits limits = {
      read_number("limits.speed_m_s", $speed_m_s, $speed_m_s),
      read_number("limits.turn_rad_s", $turn_rad_s, $turn_rad_s),
      $acceleration, $turn_acceleration};
    drive_m_s_ = read_number("commands.drive_m_s", $drive_m_s, $speed_m_s);
    turn_rad_s_ = read_number("commands.turn_rad_s", $turn_full_rad_s, $turn_rad_s);
$parameters
$subscriptions
    commands_topic_ = get_node_topics_interface()->resolve_topic_name("$commands_topic");
    guard_ = std::make_unique<understudy::MotionGuard>(
      limits,
      understudy::GuardSettings{TICK_S, $deadline_s, $hold_to_run, resume, commands_topic_},
      [this](const Speeds & speeds) {send(speeds);},
      [this](double now) {return find_danger(now);},
      [this](const std::string & text) {RCLCPP_WARN(get_logger(), "%s", text.c_str());});
    path_publisher_ = create_publisher<std_msgs::msg::String>(
      "~/path", rclcpp::QoS(rclcpp::KeepLast(1)).reliable().transient_local());
    changes_publisher_ = create_publisher<std_msgs::msg::String>(
      "understudy/transitions", rclcpp::QoS(rclcpp::KeepLast(10)).reliable());
    diagnostics_publisher_ = create_publisher<diagnostic_msgs::msg::DiagnosticArray>(
      "/diagnostics", rclcpp::QoS(rclcpp::KeepLast(10)).reliable());
    arm_service_ = create_service<std_srvs::srv::SetBool>(
      "~/arm",
      [this](
        const std::shared_ptr<std_srvs::srv::SetBool::Request> request,
        std::shared_ptr<std_srvs::srv::SetBool::Response> response) {
        const std::lock_guard<std::mutex> lock(mutex_);
        response->message = request->data ? arm() : disarm("a person disarmed it");
        response->success = response->message.empty();
      });
$hold_subscription
    began_ = read_clock();
    ${name}_start(&machine_, 0.0);
    tick_timer_ = create_wall_timer(
      std::chrono::duration<double>(TICK_S), [this]() {
        const std::lock_guard<std::mutex> lock(mutex_);
        tick();
      });
    check_timer_ = create_wall_timer(
      std::chrono::duration<double>(CHECK_S), [this]() {
        const std::lock_guard<std::mutex> lock(mutex_);
        check();
      });
    diagnostics_timer_ = create_wall_timer(
      std::chrono::duration<double>(DIAGNOSTICS_S), [this]() {
        const std::lock_guard<std::mutex> lock(mutex_);
        publish_diagnostics();
      });
    wants_arming_ = armed;
  }

  // Stop the robot if this node commands it; the context must still be valid.
  void stop()
  {
    {
      const std::lock_guard<std::mutex> lock(mutex_);
      wants_arming_ = false;
      if (!guard_->is_armed()) {
        return;
      }
      guard_->disarm("the node was shut down", read_clock());
    }
    for (int repeated = 0; repeated < 3; ++repeated) {
      std::this_thread::sleep_for(std::chrono::duration<double>(CHECK_S));
      const std::lock_guard<std::mutex> lock(mutex_);
      send(Speeds());
    }
  }

private:
  // Parameters

  static rcl_interfaces::msg::ParameterDescriptor describe(const std::string & text)
  {
    rcl_interfaces::msg::ParameterDescriptor descriptor;
    descriptor.description = text;
    descriptor.read_only = true;
    return descriptor;
  }

  // A number above 0 and at most `most`.
  double read_number(const std::string & name, double usual, double most)
  {
    std::ostringstream range;
    range << "a number above 0, up to " << most;
    const double value = declare_parameter<double>(name, usual, describe(range.str()));
    if (!(value > 0.0 && value <= most)) {
      throw std::invalid_argument(
              "parameter " + name + " is " + std::to_string(value) + "; give " + range.str());
    }
    return value;
  }

  double read_place(const std::string & name, double usual)
  {
    const double value = declare_parameter<double>(name, usual, describe("m"));
    if (!std::isfinite(value)) {
      throw std::invalid_argument("parameter " + name + " is not finite; give a place in m");
    }
    return value;
  }

  // Readings

  double read_clock() {return static_cast<double>(steady_clock_.now().nanoseconds()) * 1e-9;}

  template<class Message, class Receive>
  void subscribe(const std::string & topic, Receive receive)
  {
    subscriptions_.push_back(
      create_subscription<Message>(
        topic, rclcpp::QoS(rclcpp::KeepLast(4)).best_effort(),
        [this, receive](const std::shared_ptr<const Message> message) {
          const std::lock_guard<std::mutex> lock(mutex_);
          receive(*message, read_clock());
        }));
  }

  // The readings of this tick, at a time of the clock; times within are from the start of the node.
  void read_all(double now, ${name}_readings * r)
  {
    ${name}_clear_readings(r);
$readings
    (void)now;
  }

  StopReason find_danger(double now) const
  {
    for (const Source & source : sources_) {
      if (source.required) {
        const bool fresh = source.is_fresh(now);
        const bool absent = source.always &&
          std::any_of(source.values.begin(), source.values.end(), understudy::is_absent);
        if (!fresh || absent) {
          return {std::string(source.name) + " is absent", !fresh};
        }
      }
    }
$fence
    return {};
  }

  // Decisions

  std::string arm()
  {
    const double now = read_clock();
    const bool was_armed = guard_->is_armed();
    const std::string problem = guard_->arm(now, has_others());
    if (problem.empty() && !was_armed) {
      if (!commands_publisher_) {  // who only reads must not be a publisher of commands
        commands_publisher_ = create_publisher<$command_type>(
          "$commands_topic", rclcpp::QoS(rclcpp::KeepLast(1)).reliable());
      }
      ${name}_start(&machine_, now - began_);
      RCLCPP_INFO(get_logger(), "%s is armed", ROBOT);
    }
    return problem;
  }

  std::string disarm(const std::string & cause)
  {
    wants_arming_ = false;
    guard_->disarm(cause, read_clock());
    return "";
  }

  void tick()
  {
    if (wants_arming_ && arm().empty()) {
      wants_arming_ = false;
    }
    const double now = read_clock();
    ${name}_readings readings;
    ${name}_commands commands;
    read_all(now, &readings);
    ${name}_step(&machine_, &readings, now - began_, &commands);
    guard_->command({commands.$drive * drive_m_s_, commands.$turn * turn_rad_s_}, now);
    publish_path(now);
  }

  void check()
  {
    const double now = read_clock();
    bool others = false;
    if (guard_->is_armed() && now - looked_ > OTHERS_S) {
      looked_ = now;
      others = has_others();
    }
    guard_->check(now, others);
  }

  bool has_others()
  {
    return count_publishers(commands_topic_) > (commands_publisher_ ? 1u : 0u);
  }

  void send(const Speeds & speeds)
  {
    $command_type message;
$fill_command
    commands_publisher_->publish(message);
  }

  // Reports

  void publish_path(double now)
  {
    std::uint8_t states[${NAME}_LEVELS], flags[${NAME}_LEVELS];
    const std::uint8_t levels = ${name}_path(&machine_, states, flags);
    std::vector<std::string> path;
    int automaton = $root;
    for (std::uint8_t level = 0; level < levels && automaton >= 0; ++level) {
      const StateName & state = AUTOMATA[automaton][states[level]];
      path.push_back(state.name);
      automaton = state.automaton;
    }
    if (path == path_) {
      return;
    }
    std::size_t level = 0;
    while (level < path.size() && level < path_.size() && path[level] == path_[level]) {
      ++level;
    }
    std_msgs::msg::String message;
    for (const std::string & state : path) {
      message.data += (message.data.empty() ? "" : "/") + state;
    }
    path_publisher_->publish(message);
    std::ostringstream change;
    change.precision(15);
    change << "{\"time_s\":" << now - began_ << ",\"robot\":" << quote_json(ROBOT) <<
      ",\"level\":" << level <<
      ",\"before\":" << quote_json(level < path_.size() ? path_[level] : "") <<
      ",\"after\":" << quote_json(level < path.size() ? path[level] : "") << ",\"path\":[";
    for (std::size_t each = 0; each < path.size(); ++each) {
      change << (each == 0 ? "" : ",") << quote_json(path[each]);
    }
    change << "]}";
    std_msgs::msg::String changed;
    changed.data = change.str();
    changes_publisher_->publish(changed);
    path_ = path;
  }

  static void add(DiagnosticStatus & status, const std::string & key, double value)
  {
    char text[32];
    std::snprintf(text, sizeof text, "%.4g", value);
    diagnostic_msgs::msg::KeyValue pair;
    pair.key = key;
    pair.value = std::isnan(value) ? "absent" : text;
    status.values.push_back(pair);
  }

  void publish_diagnostics()
  {
    const double now_s = read_clock();
    diagnostic_msgs::msg::DiagnosticArray report;
    report.header.stamp = now();
    DiagnosticStatus own;
    own.name = std::string(get_name()) + ": behavior";
    own.hardware_id = ROBOT;
    own.level = guard_->get_cause().empty() ? DiagnosticStatus::OK :
      guard_->is_armed() ? DiagnosticStatus::ERROR : DiagnosticStatus::WARN;
    own.message = guard_->is_armed() ?
      (guard_->get_cause().empty() ? "moving" : "stopped: " + guard_->get_cause()) :
      "disarmed: " + guard_->get_cause();
    diagnostic_msgs::msg::KeyValue path;
    path.key = "path";
    for (const std::string & state : path_) {
      path.value += (path.value.empty() ? "" : "/") + state;
    }
    own.values.push_back(path);
    add(own, "drive_m_s", guard_->get_speeds().drive);
    add(own, "turn_rad_s", guard_->get_speeds().turn);
    report.status.push_back(own);
    for (const Source & source : sources_) {
      DiagnosticStatus status;
      status.name = std::string(get_name()) + ": " + source.name;
      status.hardware_id = ROBOT;
      const double rate = source.compute_rate();
      if (source.count == 0 || !source.is_fresh(now_s)) {
        status.level = source.required ? DiagnosticStatus::ERROR : DiagnosticStatus::STALE;
        status.message = source.count == 0 ? "nothing came" : "it fell silent";
      } else if (source.rate_hz > 0 && rate < 0.8 * source.rate_hz) {
        status.level = DiagnosticStatus::WARN;
        status.message = "it is slower than the robot's file says";
      } else {
        status.level = DiagnosticStatus::OK;
        status.message = "fresh";
      }
      diagnostic_msgs::msg::KeyValue topic;
      topic.key = "topic";
      topic.value = source.topic;
      status.values.push_back(topic);
      add(status, "messages", static_cast<double>(source.count));
      add(status, "rate_hz", rate);
      add(status, "age_s", source.count == 0 ? ABSENT : now_s - source.at);
      for (std::size_t index = 0; index < source.values.size(); ++index) {
        add(status, index == 0 ? "value" : "second value", source.read(now_s, index));
      }
      report.status.push_back(status);
    }
    diagnostics_publisher_->publish(report);
  }

  std::mutex mutex_;
  rclcpp::Clock steady_clock_{RCL_STEADY_TIME};
  double began_ = 0.0, looked_ = -INFINITE;
  bool wants_arming_ = false;
  std::string commands_topic_;  // with its namespace
  double drive_m_s_ = 0.0, turn_rad_s_ = 0.0;
  std::vector<Source> sources_;
$members
  ${name}_machine machine_;
  std::vector<std::string> path_;
  std::unique_ptr<understudy::MotionGuard> guard_;
  std::vector<rclcpp::SubscriptionBase::SharedPtr> subscriptions_;
  rclcpp::Publisher<$command_type>::SharedPtr commands_publisher_;
  rclcpp::Publisher<std_msgs::msg::String>::SharedPtr path_publisher_, changes_publisher_;
  rclcpp::Publisher<diagnostic_msgs::msg::DiagnosticArray>::SharedPtr diagnostics_publisher_;
  rclcpp::Service<std_srvs::srv::SetBool>::SharedPtr arm_service_;
  rclcpp::TimerBase::SharedPtr tick_timer_, check_timer_, diagnostics_timer_;
};

}  // namespace

int main(int argc, char ** argv)
{
  rclcpp::init(argc, argv);
  try {
    const auto node = std::make_shared<BehaviorNode>();
    const std::weak_ptr<BehaviorNode> weak = node;
    // Before, not after: a context that was shut down publishes nothing.
    node->get_node_base_interface()->get_context()->add_pre_shutdown_callback(
      [weak]() {
        if (const auto found = weak.lock()) {
          found->stop();
        }
      });
    rclcpp::spin(node);
  } catch (const std::exception & error) {
    RCLCPP_FATAL(rclcpp::get_logger("$node"), "%s", error.what());
    rclcpp::shutdown();
    return 1;
  }
  rclcpp::shutdown();
  return 0;
}
