// The guard of a robot: every command passes through it. It knows nothing of ROS.
#ifndef MOTION_GUARD_HPP_
#define MOTION_GUARD_HPP_

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <functional>
#include <limits>
#include <string>
#include <utility>

namespace understudy
{

struct Speeds
{
  double drive = 0.0;  // m/s
  double turn = 0.0;   // rad/s, counter-clockwise
};

// Limits of every command; accelerations are not limited if they are infinite.
struct MotionLimits
{
  double speed, turn, acceleration, turn_acceleration;
};

struct GuardSettings
{
  double tick_s;
  double deadline_s;   // a tick that is later than this stops the robot
  bool hold_to_run;    // it moves only while a key is held
  bool resume;         // it moves again by itself when what stopped it is over
  std::string topic;   // of commands
};

// Why a robot must not move; no cause if it may. If it is lost, the robot is disarmed.
struct StopReason
{
  std::string cause;
  bool lost = true;
};

// An armed robot either moves or is stopped, which ends with the next command that nothing forbids.
// A disarmed robot is sent stops for a while, then nothing, until it is armed again.
// Times are seconds of one clock that never jumps.
class MotionGuard
{
public:
  static constexpr double LOST_S = 1.0;      // what lasts longer than this disarms
  static constexpr double FIRST_S = 10.0;    // longest time from arming to the first command
  static constexpr double STOPPING_S = 5.0;  // how long stops are repeated after disarming

  MotionGuard(
    const MotionLimits & limits, GuardSettings settings, std::function<void(const Speeds &)> send,
    std::function<StopReason(double)> find_danger, std::function<void(const std::string &)> report)
  : limits_(limits), settings_(std::move(settings)), send_(std::move(send)),
    find_danger_(std::move(find_danger)), report_(std::move(report))
  {
  }

  bool is_armed() const {return armed_;}
  // Why the last command was a stop; empty while the robot may move.
  const std::string & get_cause() const {return stopped_;}
  // What was sent last.
  const Speeds & get_speeds() const {return speeds_;}

  // Send commands from now on; return why not, or nothing.
  std::string arm(double now, bool others)
  {
    if (armed_) {
      return "";
    }
    const StopReason danger = find_danger_(now);
    if (!danger.cause.empty()) {
      return danger.cause;
    }
    if (others) {
      return describe_others();
    }
    armed_ = true;
    stopped_ = settings_.hold_to_run ? NO_KEY : "";
    speeds_ = Speeds();
    told_ = now;
    due_ = now + FIRST_S;
    held_ = -INFINITE;
    return "";
  }

  void disarm(const std::string & cause, double now)
  {
    if (!armed_) {
      return;
    }
    armed_ = false;
    stopped_ = cause;
    until_ = now + STOPPING_S;
    issue(Speeds());
    report_("disarmed: " + cause);
  }

  // Count the key as held until a time.
  void hold(double until) {held_ = until;}

  // Send a command within the limits, or a stop if the robot must not move.
  void command(const Speeds & asked, double now)
  {
    if (!armed_) {
      repeat(now);
      return;
    }
    const StopReason danger = find_reason(now, false);
    const double elapsed = std::min(now - told_, 2 * settings_.tick_s);
    told_ = now;
    due_ = now + settings_.tick_s + settings_.deadline_s;
    if (!danger.cause.empty()) {
      respond(danger, now);
      return;
    }
    stopped_.clear();
    issue(
      {approach(asked.drive, speeds_.drive, limits_.speed, limits_.acceleration * elapsed),
        approach(asked.turn, speeds_.turn, limits_.turn, limits_.turn_acceleration * elapsed)});
  }

  // Repeat the last command, or send a stop if the robot must not move; call this often.
  void check(double now, bool others)
  {
    if (!armed_) {
      repeat(now);
      return;
    }
    StopReason danger = find_reason(now, others);
    if (danger.cause.empty() && now > due_) {
      danger = {describe_silence(now), false};
    }
    if (danger.cause.empty()) {
      issue(speeds_);
    } else {
      respond(danger, now);
    }
  }

  std::string describe_others() const {return "somebody else publishes on " + settings_.topic;}

private:
  static constexpr double INFINITE = std::numeric_limits<double>::infinity();
  static constexpr const char * NO_KEY = "nobody holds the key";

  StopReason find_reason(double now, bool others) const
  {
    if (others) {
      return {describe_others(), true};
    }
    if (now - due_ > LOST_S) {
      return {describe_silence(now), true};
    }
    const StopReason danger = find_danger_(now);
    if (!danger.cause.empty()) {
      const bool lasts = danger.cause == stopped_ && now - stopped_at_ > LOST_S;
      return {danger.cause, danger.lost || lasts};
    }
    if (settings_.hold_to_run && now > held_) {
      return {NO_KEY, false};
    }
    return {};
  }

  void respond(const StopReason & danger, double now)
  {
    if (danger.lost && !settings_.resume) {
      disarm(danger.cause, now);
      return;
    }
    const std::string before = stopped_;
    stopped_ = danger.cause;
    issue(Speeds());
    if (danger.cause != before) {
      stopped_at_ = now;
    }
    if (before.empty()) {
      report_("stopped: " + danger.cause);
    }
  }

  void repeat(double now)
  {
    if (now < until_) {
      issue(Speeds());
    }
  }

  void issue(const Speeds & speeds)
  {
    speeds_ = speeds;
    send_(speeds);
  }

  std::string describe_silence(double now) const
  {
    char text[64];
    std::snprintf(text, sizeof text, "no command came for %.2f s", now - told_);
    return text;
  }

  static double approach(double asked, double last, double most, double step)
  {
    const double want = std::isnan(asked) ? 0.0 : std::max(-most, std::min(most, asked));
    return std::isfinite(step) ? std::max(last - step, std::min(last + step, want)) : want;
  }

  MotionLimits limits_;
  GuardSettings settings_;
  std::function<void(const Speeds &)> send_;
  std::function<StopReason(double)> find_danger_;
  std::function<void(const std::string &)> report_;
  bool armed_ = false;
  std::string stopped_ = "not armed";
  Speeds speeds_;
  double told_ = -INFINITE, due_ = -INFINITE, held_ = -INFINITE;
  double stopped_at_ = -INFINITE, until_ = -INFINITE;
};

}  // namespace understudy

#endif  // MOTION_GUARD_HPP_
