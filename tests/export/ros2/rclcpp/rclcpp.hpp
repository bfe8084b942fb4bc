// Stands in for rclcpp in tests: the calls that exported nodes make, with the signatures of Humble to Rolling, on a
// clock and messages that a test gives on standard input. What the node does is printed, a line each.
#ifndef RCLCPP__RCLCPP_HPP_
#define RCLCPP__RCLCPP_HPP_

#include <chrono>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <functional>
#include <iostream>
#include <map>
#include <memory>
#include <sstream>
#include <stdexcept>
#include <string>
#include <type_traits>
#include <vector>

#include "builtin_interfaces/msg/time.hpp"
#include "rcl_interfaces/msg/parameter_descriptor.hpp"
#include "stand_in_text.hpp"

enum rcl_clock_type_t {RCL_STEADY_TIME = 3};

namespace rclcpp
{

struct State
{
  std::int64_t now_ns = 0;
  std::string ns = "";
  std::map<std::string, std::string> parameters;
  std::map<std::string, std::size_t> others;      // other publishers by topic
  std::map<std::string, std::size_t> publishers;  // of the node itself
  std::multimap<std::string, std::function<void(std::istream &)>> subscriptions;
  std::map<std::string, std::function<void(std::istream &)>> services;
  bool is_shut_down = false;
};

inline State & state()
{
  static State only;
  return only;
}

class Time
{
public:
  explicit Time(std::int64_t ns)
  : ns_(ns) {}
  std::int64_t nanoseconds() const {return ns_;}
  operator builtin_interfaces::msg::Time() const
  {
    builtin_interfaces::msg::Time time;
    time.sec = static_cast<std::int32_t>(ns_ / 1000000000);
    time.nanosec = static_cast<std::uint32_t>(ns_ % 1000000000);
    return time;
  }

private:
  std::int64_t ns_;
};

class Clock
{
public:
  explicit Clock(rcl_clock_type_t) {}
  Time now() {return Time(state().now_ns);}
};

struct KeepLast
{
  explicit KeepLast(std::size_t depth)
  : depth(depth) {}
  std::size_t depth;
};

class QoS
{
public:
  QoS(const KeepLast & history)  // NOLINT: as in rclcpp
  : depth(history.depth) {}
  QoS & best_effort() {reliability = "best_effort"; return *this;}
  QoS & reliable() {reliability = "reliable"; return *this;}
  QoS & transient_local() {durability = "transient_local"; return *this;}
  std::string describe() const
  {
    return reliability + " " + durability + " " + std::to_string(depth);
  }
  std::size_t depth;
  std::string reliability = "reliable", durability = "volatile";
};

class Context
{
public:
  void add_pre_shutdown_callback(std::function<void()> callback) {callbacks_.push_back(callback);}
  void shut_down()
  {
    for (const auto & each : callbacks_) {
      each();
    }
    state().is_shut_down = true;
  }

private:
  std::vector<std::function<void()>> callbacks_;
};

inline std::shared_ptr<Context> context()
{
  static const auto only = std::make_shared<Context>();
  return only;
}

template<class Message>
class Publisher
{
public:
  using SharedPtr = std::shared_ptr<Publisher<Message>>;
  explicit Publisher(const std::string & topic)
  : topic_(topic) {}
  void publish(const Message & message)
  {
    if (state().is_shut_down) {
      throw std::runtime_error("published after the context was shut down");
    }
    std::cout << "published " << state().now_ns << " " << topic_;
    stand_in::write(std::cout, message);
    std::cout << "\n";
  }

private:
  std::string topic_;
};

class SubscriptionBase
{
public:
  using SharedPtr = std::shared_ptr<SubscriptionBase>;
  virtual ~SubscriptionBase() = default;
};

template<class Message>
class Subscription : public SubscriptionBase {};

template<class Type>
class Service
{
public:
  using SharedPtr = std::shared_ptr<Service<Type>>;
};

class TimerBase
{
public:
  using SharedPtr = std::shared_ptr<TimerBase>;
  TimerBase(std::int64_t period_ns, std::function<void()> callback)
  : period_ns(period_ns), due_ns(state().now_ns + period_ns), callback(callback) {}
  std::int64_t period_ns, due_ns;
  std::function<void()> callback;
};

inline std::vector<TimerBase::SharedPtr> & timers()
{
  static std::vector<TimerBase::SharedPtr> all;
  return all;
}

class Logger
{
public:
  explicit Logger(const std::string & name)
  : name(name) {}
  std::string name;
};

inline Logger get_logger(const std::string & name) {return Logger(name);}

template<class ... Values>
void log(const char * level, const Logger & logger, const char * format, Values ... values)
{
  char text[512];
  std::snprintf(text, sizeof text, format, values ...);
  std::cout << "log " << level << " " << logger.name << " " << text << "\n";
}

#define RCLCPP_INFO(logger, ...) rclcpp::log("info", logger, __VA_ARGS__)
#define RCLCPP_WARN(logger, ...) rclcpp::log("warn", logger, __VA_ARGS__)
#define RCLCPP_FATAL(logger, ...) rclcpp::log("fatal", logger, __VA_ARGS__)

class NodeBase
{
public:
  std::shared_ptr<Context> get_context() {return context();}
};

inline std::string resolve(const std::string & name, const std::string & node)
{
  if (name[0] == '/') {
    return name;
  }
  return state().ns + "/" + (name[0] == '~' ? node + name.substr(1) : name);
}

class NodeTopics
{
public:
  explicit NodeTopics(const std::string & node)
  : node_(node) {}
  std::string resolve_topic_name(const std::string & name) const
  {
    return resolve(name, node_);
  }

private:
  std::string node_;
};

class Node
{
public:
  explicit Node(const std::string & name)
  : name_(name) {}
  virtual ~Node() = default;

  template<class Value>
  Value declare_parameter(
    const std::string & name, const Value & usual,
    const rcl_interfaces::msg::ParameterDescriptor & = rcl_interfaces::msg::ParameterDescriptor())
  {
    const auto found = state().parameters.find(name);
    if (found == state().parameters.end()) {
      return usual;
    }
    if constexpr (std::is_same_v<Value, bool>) {
      return found->second == "true";
    } else {
      return static_cast<Value>(std::strtod(found->second.c_str(), nullptr));
    }
  }

  template<class Message>
  typename Publisher<Message>::SharedPtr create_publisher(const std::string & topic, const QoS & qos)
  {
    const std::string name = resolve(topic, name_);
    ++state().publishers[name];
    std::cout << "publisher " << name << " " << qos.describe() << "\n";
    return std::make_shared<Publisher<Message>>(name);
  }

  template<class Message, class Callback>
  std::shared_ptr<Subscription<Message>> create_subscription(
    const std::string & topic, const QoS & qos, Callback callback)
  {
    const std::string name = resolve(topic, name_);
    std::cout << "subscription " << name << " " << qos.describe() << "\n";
    state().subscriptions.emplace(
      name, [callback](std::istream & in) {
        const auto message = std::make_shared<Message>();
        stand_in::read(in, *message);
        callback(message);
      });
    return std::make_shared<Subscription<Message>>();
  }

  template<class Type, class Callback>
  typename Service<Type>::SharedPtr create_service(const std::string & service, Callback callback)
  {
    state().services[resolve(service, name_)] = [callback](std::istream & in) {
        const auto request = std::make_shared<typename Type::Request>();
        const auto response = std::make_shared<typename Type::Response>();
        stand_in::read(in, *request);
        callback(request, response);
        std::cout << "answered " << state().now_ns;
        stand_in::write(std::cout, *response);
        std::cout << "\n";
      };
    return std::make_shared<Service<Type>>();
  }

  template<class Duration>
  TimerBase::SharedPtr create_wall_timer(Duration period, std::function<void()> callback)
  {
    const auto ns = std::chrono::duration_cast<std::chrono::nanoseconds>(period).count();
    timers().push_back(std::make_shared<TimerBase>(ns, callback));
    return timers().back();
  }

  std::size_t count_publishers(const std::string & topic) const
  {
    const std::string name = resolve(topic, name_);
    return state().others[name] + state().publishers[name];
  }

  Time now() const {return Time(state().now_ns);}
  const char * get_name() const {return name_.c_str();}
  Logger get_logger() const {return Logger(name_);}
  std::shared_ptr<NodeBase> get_node_base_interface() {return std::make_shared<NodeBase>();}
  std::shared_ptr<NodeTopics> get_node_topics_interface() {return std::make_shared<NodeTopics>(name_);}

private:
  std::string name_;
};

// Understands `-r __ns:=/NAMESPACE` and `-p NAME:=VALUE`.
inline void init(int count, char ** arguments)
{
  for (int each = 1; each < count; ++each) {
    const std::string text = arguments[each];
    const std::size_t at = text.find(":=");
    if (at == std::string::npos) {
      continue;
    }
    if (text.compare(0, at, "__ns") == 0) {
      state().ns = text.substr(at + 2);
    } else {
      state().parameters[text.substr(0, at)] = text.substr(at + 2);
    }
  }
}

inline void shutdown() {}

// Lets time pass until it is `until_ns`, and calls the timers that are due, the older one first.
inline void advance(std::int64_t until_ns)
{
  while (true) {
    TimerBase::SharedPtr next;
    for (const auto & each : timers()) {
      if (each->due_ns <= until_ns && (!next || each->due_ns < next->due_ns)) {
        next = each;
      }
    }
    if (!next) {
      break;
    }
    state().now_ns = std::max(state().now_ns, next->due_ns);
    next->due_ns += next->period_ns;
    next->callback();
  }
  state().now_ns = until_ns;
}

// Lines: `advance NS`, `freeze NS` (time passes and no timer is called), `message TOPIC VALUES`,
// `call SERVICE VALUES`, `others TOPIC COUNT`, `shutdown`.
template<class NodeType>
void spin(const std::shared_ptr<NodeType> &)
{
  std::string line;
  while (std::getline(std::cin, line)) {
    std::istringstream in(line);
    std::string word, name;
    in >> word;
    if (word == "advance" || word == "freeze") {
      std::int64_t ns = 0;
      in >> ns;
      if (word == "advance") {
        advance(ns);
      } else {
        state().now_ns = ns;
        for (const auto & each : timers()) {
          while (each->due_ns + each->period_ns <= ns) {
            each->due_ns += each->period_ns;
          }
        }
      }
    } else if (word == "message") {
      in >> name;
      const auto found = state().subscriptions.equal_range(name);
      const auto begin = in.tellg();
      for (auto each = found.first; each != found.second; ++each) {
        in.seekg(begin);
        each->second(in);
      }
    } else if (word == "call") {
      in >> name;
      state().services.at(name)(in);
    } else if (word == "others") {
      in >> name;
      in >> state().others[name];
    } else if (word == "shutdown") {
      context()->shut_down();
      return;
    }
  }
}

}  // namespace rclcpp

#endif  // RCLCPP__RCLCPP_HPP_
