# frozen_string_literal: true

require "follow"
require "test_server"

RSpec.describe Follow do
  def step(values)
    described_class.step(->(sensor, unread) { values.fetch(sensor, unread) })
  end

  it "turns on the spot before any reading" do
    expect(step({})).to eq(left_signal: -0.2, right_signal: 0.2)
  end

  it "drives straight at the wanted nearness" do
    signals = step("ir_front" => 0.0, "ir_front_left" => 0.0, "ir_right" => 0.3)
    expect(signals).to eq(left_signal: 0.4, right_signal: 0.4)
  end

  it "turns away from a wall that is too near" do
    signals = step("ir_front" => 0.0, "ir_front_left" => 0.0, "ir_right" => 0.1, "ir_front_right" => 0.9)
    expect(signals[:left_signal]).to be < signals[:right_signal]
  end

  it "commands again after a tenth of a second, and after a reset" do
    brain = described_class.new
    commanded = [[500, false], [510, false], [520, true], [620, false], [10, false]].map do |at_ms, has_message|
      turn = Baudbot::V1::RobotTurn.new(at_ns: at_ms * 1_000_000, has_message: has_message)
      brain.answer(Link::Turn.new(turn, nil)).key?(:command)
    end
    expect(commanded).to eq([true, false, true, true, true])
  end

  it "drives until the run is over" do
    commands = []
    recording = Class.new(described_class) do
      define_method(:answer) { |turn| super(turn).tap { |answer| commands << answer[:command] } }
    end
    TestServer.start("--pace", "lockstep", "--set", "end.after_s=10.0") do |address|
      stub_const("ENV", ENV.to_h.merge("BAUDBOT_CONNECT" => address))
      expect(Link.drive("follow.rb") { recording.new }).to eq(1000)
    end
    expect(commands.compact).to include(a_hash_including(left_signal: a_value > 0, right_signal: a_value > 0))
  end
end
