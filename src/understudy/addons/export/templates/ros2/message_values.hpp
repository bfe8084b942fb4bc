// Numbers from messages, read as Understudy reads them: NaN is absent.
#ifndef MESSAGE_VALUES_HPP_
#define MESSAGE_VALUES_HPP_

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>
#include <numeric>
#include <vector>

namespace understudy
{

constexpr double ABSENT = std::numeric_limits<double>::quiet_NaN();
constexpr double TAU = 6.283185307179586;
constexpr double LARGEST = 1e30;  // larger numbers are no measurements
constexpr double SAME = 1e-4;     // rad; angles of scans are sums of 32-bit floats
constexpr double SAME_M = 1e-6;   // relative; distances in scans are 32-bit floats

inline bool is_absent(double value) {return std::isnan(value);}

inline double finite(double value) {return std::fabs(value) <= LARGEST ? value : ABSENT;}

// The remainder that is not negative, as of Python's % with a positive period.
inline double wrap(double value, double period)
{
  double rest = std::fmod(value, period);
  if (rest < 0.0) {
    rest += period;
  }
  return rest;
}

// An angle in [0, TAU), rad.
inline double wrap_angle(double angle)
{
  return std::isfinite(angle) ? wrap(wrap(angle, TAU), TAU) : ABSENT;
}

// The cosine of an angle, rad, at most some thousand turns: as Understudy's, equal to the last bit on all machines.
inline double compute_cosine(double angle)
{
  const double quarters = std::floor(angle * (2.0 / 3.141592653589793) + 0.5);
  const double rest = (angle - quarters * 1.5707963267341256) - quarters * 6.077100506506192e-11;
  const double u = rest * rest, v = u * u;
  const long long quarter = static_cast<long long>(quarters) & 3;
  double value;
  if (quarter & 1) {
    const double odd = (-0.16666666666666666 + 0.008333333333330946 * u) +
      (-0.0001984126983675497 + 2.755731610068303e-06 * u) * v +
      (-2.5051131455427946e-08 + 1.591810123027412e-10 * u) * (v * v);
    value = rest + rest * u * odd;
  } else {
    const double even = (0.041666666666666664 + -0.0013888888888887395 * u) +
      (2.4801587298763433e-05 + -2.7557317270560326e-07 * u) * v +
      (2.0876146024689747e-09 + -1.1382614868556325e-11 * u) * (v * v);
    value = 1.0 - (0.5 * u - v * even);
  }
  return quarter == 1 || quarter == 2 ? -value : value;
}

// The heading of an orientation (REP 103), in [0, TAU) rad; absent if its norm is far from 1.
template<class Quaternion>
double compute_heading(const Quaternion & q)
{
  const double norm = q.x * q.x + q.y * q.y + q.z * q.z + q.w * q.w;
  if (!(norm > 0.5 && norm < 2.0)) {
    return ABSENT;
  }
  return wrap_angle(
    std::atan2(2 * (q.w * q.z + q.x * q.y) / norm, 1 - 2 * (q.y * q.y + q.z * q.z) / norm));
}

// A distance from the rim, m, of a Range message, read as REP 117 defines it.
inline double clear_range(double value, double low, double high, double offset)
{
  if (std::isinf(value) && value < 0 && low == high) {
    return std::isfinite(high) ? 0.0 : ABSENT;
  }
  if (std::isinf(value)) {
    value = value > 0 ? high : low;
  }
  return low <= value && value <= high ? finite(std::max(value - offset, 0.0)) : ABSENT;
}

// A sector of a LaserScan, counter-clockwise from one angle to another, rad, both included.
class ScanSector
{
public:
  ScanSector(double start, double end)
  : start_(start), full_(end - start >= TAU - SAME), width_(full_ ? TAU : wrap(end - start, TAU)),
    beam_(!full_ && (width_ < SAME || width_ > TAU - SAME))
  {
  }

  // The nearest distance from the rim, m; absent if no beam in the sector is valid.
  template<class Scan>
  double find_nearest(const Scan & scan, double offset) const
  {
    double nearest = ABSENT;
    for (const Beam & beam : select(scan)) {
      if (!is_absent(beam.range) && !(nearest <= beam.range)) {
        nearest = beam.range;
      }
    }
    return is_absent(nearest) ? ABSENT : finite(std::max(nearest - offset, 0.0));
  }

  // The direction of the nearest return, rad in [0, TAU); absent if nothing is in range.
  template<class Scan>
  double find_bearing(const Scan & scan) const
  {
    const std::vector<Beam> beams = select(scan);
    const Beam * nearest = nullptr;
    for (const Beam & beam : beams) {
      if (!is_absent(beam.range) && (nearest == nullptr || beam.range < nearest->range)) {
        nearest = &beam;
      }
    }
    if (nearest == nullptr || nearest->range >= static_cast<double>(scan.range_max)) {
      return ABSENT;
    }
    return wrap_angle(start_ + nearest->after);
  }

  // The width, m, of the widest opening in which all beams reach `clear` from the rim.
  template<class Scan>
  double measure_opening(const Scan & scan, double offset, double clear) const
  {
    const double spacing = std::fabs(static_cast<double>(scan.angle_increment));
    std::vector<Beam> beams;
    bool any = false;
    for (const Beam & beam : select(scan)) {
      if (static_cast<double>(beam.number) * spacing < TAU - SAME) {  // the first turn counts
        beams.push_back(beam);
        any = any || !is_absent(beam.range);
      }
    }
    if (!any) {
      return ABSENT;
    }
    if (full_) {
      std::sort(
        beams.begin(), beams.end(),
        [](const Beam & a, const Beam & b) {return a.number < b.number;});
    }
    std::vector<double> far;
    for (std::size_t i = 0; i < beams.size(); ++i) {
      if (!full_ && i > 0 && beams[i].after - beams[i - 1].after > 1.5 * spacing) {
        far.push_back(ABSENT);  // a gap between the ends of the scan
      }
      double distance = beams[i].range;
      if (!is_absent(distance)) {
        distance = std::max(distance - offset, 0.0);
      }
      far.push_back(std::fabs(distance - clear) < SAME_M * (clear + offset) ? clear : distance);
    }
    return measure_widest(far, spacing, offset, clear);
  }

private:
  struct Beam
  {
    std::size_t number;
    double after;  // rad after the start of the sector
    double range;  // m; absent if it is invalid
  };

  // The beams in the sector, by angle.
  template<class Scan>
  std::vector<Beam> select(const Scan & scan) const
  {
    const double low = scan.range_min, high = scan.range_max;
    const double begin = scan.angle_min, step = scan.angle_increment;
    std::vector<Beam> found;
    if (!(std::isfinite(begin) && std::isfinite(step) && std::isfinite(low) && std::isfinite(high))) {
      return found;
    }
    for (std::size_t i = 0; i < scan.ranges.size(); ++i) {
      const double after = wrap(begin + step * static_cast<double>(i) - start_, TAU);
      double range = scan.ranges[i];
      if (std::isinf(range)) {
        range = range > 0 ? high : low;
      }
      found.push_back({i, after, range >= low && range <= high ? range : ABSENT});
    }
    if (found.empty()) {
      return found;
    }
    if (beam_) {
      const auto away = [](const Beam & beam) {return std::min(beam.after, TAU - beam.after);};
      const Beam nearest = *std::min_element(
        found.begin(), found.end(),
        [&away](const Beam & a, const Beam & b) {return away(a) < away(b);});
      found.clear();
      if (away(nearest) <= std::fabs(step) / 2 + SAME) {
        found.push_back(nearest);
      }
      return found;
    }
    for (Beam & beam : found) {
      if (beam.after >= TAU - SAME) {
        beam.after -= TAU;
      }
    }
    std::stable_sort(
      found.begin(), found.end(), [](const Beam & a, const Beam & b) {return a.after < b.after;});
    found.erase(
      std::remove_if(
        found.begin(), found.end(),
        [this](const Beam & beam) {return !(beam.after <= width_ + SAME);}),
      found.end());
    return found;
  }

  static double measure_widest(
    const std::vector<double> & far, double spacing, double rim, double clear)
  {
    const std::size_t count = far.size();
    const bool ring =
      std::fabs(spacing * static_cast<double>(count) - TAU) < spacing / 2.0;
    std::size_t start = 0;
    while (ring && start < count && far[start] >= clear) {
      ++start;
    }
    if (ring && start == count) {
      return 2.0 * (rim + clear);
    }
    double widest = 0.0;
    bool open = false;
    std::size_t opened = 0;
    for (std::size_t k = start; k < start + count + 1; ++k) {
      const bool there = ring || k < start + count;
      const double distance = there ? far[k % count] : ABSENT;
      if (k < start + count && distance >= clear) {
        opened = open ? opened : k;
        open = true;
      } else if (open) {
        std::size_t steps = k - opened + 1;
        double before = ring || opened > start ? far[(opened + count - 1) % count] : ABSENT;
        double after = distance;
        if (is_absent(before)) {
          before = clear;
          --steps;
        }
        if (is_absent(after)) {
          after = clear;
          --steps;
        }
        const double a = before + rim, b = after + rim;
        const double across = compute_cosine(std::min(static_cast<double>(steps) * spacing, TAU / 2));
        widest = std::max(widest, std::sqrt(std::max(0.0, a * a + b * b - 2.0 * a * b * across)));
        open = false;
      }
    }
    return widest;
  }

  double start_;
  bool full_;
  double width_;
  bool beam_;
};

struct Polar
{
  double range = ABSENT;    // m
  double bearing = ABSENT;  // rad, in [0, TAU)
};

// Where a place is from a pose: both absent if either is unknown.
inline Polar locate(double x, double y, double own_x, double own_y, double heading)
{
  const double ahead = x - own_x, left = y - own_y, distance = std::hypot(ahead, left);
  if (!std::isfinite(distance) || is_absent(heading)) {
    return {};
  }
  return {distance, wrap_angle(std::atan2(left, ahead) - heading)};
}

}  // namespace understudy

#endif  // MESSAGE_VALUES_HPP_
