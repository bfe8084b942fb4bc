// The messages of ROS 2 that the peer speaks, field by field as their definitions list them. Each says how it goes
// through Fast CDR, which does the rest: what its bytes are is Fast CDR's word, not ours.
#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <vector>

struct Header {
    int32_t seconds = 12;
    uint32_t nanoseconds = 34;
    std::string frame;

    template <class Cdr>
    void through(Cdr& cdr) {
        cdr(seconds), cdr(nanoseconds), cdr(frame);
    }
};

struct Range {
    static constexpr const char* type = "sensor_msgs::msg::dds_::Range_";
    Header header{12, 34, "sonar"};
    uint8_t radiation = 0;
    float field_of_view = 0.25F, nearest = 0.125F, farthest = 3.0F, range = 2.0F, variance = 0.5F;
    bool has_variance = true;  // since ROS 2 Iron; Humble's ends before it

    template <class Cdr>
    void through(Cdr& cdr) {
        header.through(cdr);
        cdr(radiation), cdr(field_of_view), cdr(nearest), cdr(farthest), cdr(range);
        if (has_variance) cdr(variance);
    }
};

struct Odometry {
    static constexpr const char* type = "nav_msgs::msg::dds_::Odometry_";
    Header header{12, 34, "odom"};
    std::string child = "base_link";
    std::array<double, 7> pose{1.0, -2.0, 0.0, 0.0, 0.0, 0.6, 0.8};  // x, y, z; then the orientation
    std::array<double, 36> pose_covariance{0.125};
    std::array<double, 6> twist{0.5, 0.0, 0.0, 0.0, 0.0, -0.25};  // linear, angular
    std::array<double, 36> twist_covariance{0.0, 0.25};

    template <class Cdr>
    void through(Cdr& cdr) {
        header.through(cdr);
        cdr(child), cdr(pose), cdr(pose_covariance), cdr(twist), cdr(twist_covariance);
    }
};

struct Image {
    static constexpr const char* type = "sensor_msgs::msg::dds_::Image_";
    Header header{12, 34, "camera"};
    uint32_t height = 0, width = 0;
    std::string encoding = "rgb8";
    uint8_t bigendian = 0;
    uint32_t step = 0;
    std::vector<uint8_t> data;

    // Byte i is i modulo 251: no row, column or fragment is like another.
    void fill(uint32_t w, uint32_t h) {
        width = w, height = h, step = 3 * w, data.resize(step * h);
        for (size_t i = 0; i < data.size(); ++i) data[i] = static_cast<uint8_t>(i % 251);
    }

    template <class Cdr>
    void through(Cdr& cdr) {
        header.through(cdr);
        cdr(height), cdr(width), cdr(encoding), cdr(bigendian), cdr(step), cdr(data);
    }
};

struct Twist {
    static constexpr const char* type = "geometry_msgs::msg::dds_::Twist_";
    std::array<double, 6> speeds{};  // linear x, y, z; angular x, y, z

    template <class Cdr>
    void through(Cdr& cdr) {
        cdr(speeds);
    }
};
