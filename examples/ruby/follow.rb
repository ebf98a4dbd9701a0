#!/usr/bin/env ruby
# frozen_string_literal: true

# A brain that follows the wall on its right. For one of your own change `step`, and keep link.rb.

require_relative "link"

# The brain of all robots of a connection.
class Follow
  SPEED = 0.4
  GAIN = 1.0
  WANTED = 0.3 # nearness of the wall that it keeps: 0 is out of range, 1 is very near
  REPEAT_NS = 100_000_000

  # What the brain does in a step. `value` gives a sensor's last reading, or its second argument if none has arrived yet.
  def self.step(value)
    ahead = [value["ir_front", 1.0], value["ir_front_left", 1.0]].max
    return { left_signal: -0.5 * SPEED, right_signal: 0.5 * SPEED } if ahead > WANTED # a corner: to the left, on the spot

    right = [value["ir_right", 0.0], value["ir_front_right", 0.0]].max
    turning = GAIN * SPEED * (right - WANTED) # too near: to the left
    { left_signal: SPEED - turning, right_signal: SPEED + turning }
  end

  def initialize
    @commanded_at_ns = {}
  end

  # One command for each message, and another after 0.1 s without any: the cable may have lost the last one.
  def answer(turn)
    answer = { robot: turn.robot }
    if turn.news? || due?(turn)
      @commanded_at_ns[turn.robot] = turn.at_ns
      answer[:command] = self.class.step(turn.method(:value))
    end
    answer.merge(until_message: { at_latest_ns: @commanded_at_ns[turn.robot] + REPEAT_NS })
  end

  private

  def due?(turn)
    last = @commanded_at_ns[turn.robot]
    was_reset = last && turn.at_ns < last
    last.nil? || was_reset || turn.at_ns >= last + REPEAT_NS
  end
end

if $PROGRAM_NAME == __FILE__
  trap("INT", "DEFAULT") # no backtrace at Ctrl-C
  begin
    puts "the run is over at tick #{Link.drive('follow.rb') { Follow.new }}"
  rescue Link::Error => e
    abort "follow: #{e.message}"
  end
end
