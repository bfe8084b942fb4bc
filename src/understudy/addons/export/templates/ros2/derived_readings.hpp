// Readings that are in no message: the sensors "since", "random" and "stuck" of a robot's type.
#ifndef DERIVED_READINGS_HPP_
#define DERIVED_READINGS_HPP_

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <deque>
#include <random>

#include "message_values.hpp"

namespace understudy
{

// The time, s, since a reading was last present; for one of yes or no, since it was last yes.
class ElapsedTime
{
public:
  double compute(double now, double value, bool is_yes_or_no)
  {
    if (!is_absent(value) && (!is_yes_or_no || value > 0)) {
      last_ = now;
    }
    return now - last_;
  }

private:
  double last_ = ABSENT;
};

// A random number in [0, 1), drawn anew every `every` s, or in every tick if that is 0.
class RandomNumber
{
public:
  RandomNumber(std::uint64_t seed, double every)
  : random_(seed), every_(every)
  {
  }

  double compute(double now)
  {
    const double period = every_ > 0 ? std::floor(now / every_) : -1;
    if (is_absent(period_) || period < 0 || period != period_) {
      period_ = period;
      drawn_ = std::uniform_real_distribution<double>(0.0, 1.0)(random_);
    }
    return drawn_;
  }

private:
  std::mt19937_64 random_;
  double every_;
  double period_ = ABSENT;
  double drawn_ = 0.0;
};

// Whether the robot was commanded to drive for some time, s, and hardly moved.
class StallDetector
{
public:
  explicit StallDetector(double after)
  : after_(after)
  {
  }

  double compute(double now, double x, double y, double asked_m_s)
  {
    if (is_absent(x) || is_absent(y)) {
      track_.clear();
      return ABSENT;
    }
    if (asked_m_s == 0.0) {
      track_.clear();
    }
    track_.push_back({now, x, y, std::fabs(asked_m_s)});
    while (track_.size() > 1 && now - track_[1].time >= after_) {
      track_.pop_front();
    }
    const Place first = track_.front();
    if (now - first.time < after_) {
      return 0.0;
    }
    double asked = 0.0, farthest = 0.0;
    for (const Place & each : track_) {
      asked += each.asked;
      farthest = std::max(farthest, std::hypot(each.x - first.x, each.y - first.y));
    }
    const double wanted = asked / static_cast<double>(track_.size()) * (now - first.time);
    return farthest < 0.1 * wanted ? 1.0 : 0.0;
  }

private:
  struct Place
  {
    double time, x, y, asked;
  };

  double after_;
  std::deque<Place> track_;
};

}  // namespace understudy

#endif  // DERIVED_READINGS_HPP_
