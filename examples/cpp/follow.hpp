// A brain that follows the wall on its right.
#pragma once

#include <algorithm>
#include <functional>
#include <string_view>

#include "link.hpp"

constexpr double speed = 0.4, gain = 1.0;
constexpr double wanted = 0.3;  // nearness of the wall that it keeps: 0 is out of range, 1 is very near

struct Signals {
  double left, right;
};

/// What the brain does in a step. `value` gives a sensor's last reading, or `unread` if none has arrived yet.
inline Signals step(const std::function<double(std::string_view sensor, double unread)>& value) {
  const double ahead = std::max(value("ir_front", 1.0), value("ir_front_left", 1.0));
  if (ahead > wanted) return {-0.5 * speed, 0.5 * speed};  // a corner: to the left, on the spot
  const double right = std::max(value("ir_right", 0.0), value("ir_front_right", 0.0));
  const double turning = gain * speed * (right - wanted);  // too near: to the left
  return {speed - turning, speed + turning};
}

/// The brain of one robot, for as long as a connection lasts.
class Follow {
 public:
  explicit Follow(const baudbot::v1::RobotDescription& body) : body_(body) {}

  /// One command for each message, and another after 0.1 s without any: the cable may have lost the last one.
  baudbot::v1::RobotStep answer(const baudbot::v1::RobotTurn& turn) {
    baudbot::v1::RobotStep answer;
    const bool went_back = turn.at_ns() + 100'000'000 < repeat_ns_;  // the world has been reset
    if (baudbot::is_news(turn) || went_back || turn.at_ns() >= repeat_ns_) {
      const auto [left, right] =
          step([&](auto sensor, double unread) { return baudbot::value(body_, turn, sensor, unread); });
      answer.mutable_command()->set_left_signal(left);
      answer.mutable_command()->set_right_signal(right);
      repeat_ns_ = turn.at_ns() + 100'000'000;
    }
    answer.mutable_until_message()->set_at_latest_ns(repeat_ns_);
    return answer;
  }

 private:
  baudbot::v1::RobotDescription body_;
  std::uint64_t repeat_ns_ = 0;
};
