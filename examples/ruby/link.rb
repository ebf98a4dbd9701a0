# frozen_string_literal: true

$LOAD_PATH.unshift(File.join(__dir__, "build"))

require "baudbot/v1/brain_link_services_pb"
require "forwardable"
require_relative "settings"

# The connection to the server. It knows nothing of the brain.
module Link
  # What ends the program, in words for people.
  class Error < StandardError; end

  # What a robot's brain learns in a step, and the robot's data sheet.
  Turn = Struct.new(:message, :body) do
    extend Forwardable
    def_delegators :message, :robot, :at_ns, :readings

    # The last reading of a sensor, the first one of several values, or `unread` if none has arrived yet.
    def value(sensor, unread)
      readings.find { |reading| body.sensors[reading.sensor].sensor == sensor }&.values&.first || unread
    end

    # Whether anything has arrived since the last turn: the server asks in ticks without news, too.
    def news?
      message.has_message || readings.any?(&:readable)
    end
  end

  # No proxy between a robot and its brain, another try at least twice a second, and pings, which notice a server that is gone
  # without a word.
  CHANNEL = {
    "grpc.enable_http_proxy" => 0, "grpc.initial_reconnect_backoff_ms" => 300, "grpc.max_reconnect_backoff_ms" => 300,
    "grpc.keepalive_time_ms" => 20_000, "grpc.keepalive_timeout_ms" => 20_000, "grpc.http2.max_pings_without_data" => 0
  }.freeze

  module_function

  # Drives the robots that the environment names until the run is over, and gives its last tick. The block makes a brain for
  # each connection, since the world may have changed. The server shows the program's name.
  def drive(program)
    address = Settings.address
    reconnect_s = Settings.reconnect_s
    server = Baudbot::V1::BrainLinkService::Stub.new(address, :this_channel_is_insecure, channel_args: CHANNEL)
    was_attached = false
    lost_at = nil
    begin
      metadata = Settings.metadata(address)
      attach(server, Settings.hello(program), metadata, yield) do
        was_attached = true
        lost_at = nil
      end
    rescue GRPC::BadStatus => e
      raise Error, e.details unless reconnect_s.positive? && lost?(e, was_attached, Settings.metadata(address) != metadata)

      now = Process.clock_gettime(Process::CLOCK_MONOTONIC)
      warn "#{File.basename(program, '.*')}: connection lost (#{e.details}); trying again for #{reconnect_s} s" unless lost_at
      lost_at ||= now
      raise Error, e.details if now - lost_at >= reconnect_s

      sleep 0.5
      retry
    end
  end

  # Whether another try may succeed.
  def lost?(error, was_attached, token_changed)
    case error
    when GRPC::AlreadyExists then was_attached # perhaps by this program's last connection, which the server takes to be alive
    when GRPC::Unauthenticated then token_changed # a server may write its token just after it has begun to listen
    else error.is_a?(GRPC::Unavailable) || error.metadata["baudbot-reason"] == "restart"
    end
  end

  # Drives in one stream, and gives the last tick. It yields once it is attached.
  def attach(server, hello, metadata, brain)
    requests = Queue.new
    requests << { hello: hello }
    sent = Enumerator.produce { Baudbot::V1::AttachRequest.new(requests.pop || raise(StopIteration)) }
    call = server.attach(sent, metadata: metadata, return_op: true)
    # When the server has closed the stream, gRPC waits until there are no more requests.
    Thread.new do
      sleep 0.1 until call.status || requests.closed?
      requests.close
    end
    bodies = nil
    call.execute.each do |response|
      if response.welcome
        bodies = response.welcome.robots
        yield
      elsif response.turn
        robots = response.turn.robots.map { |turn| brain.answer(Turn.new(turn, bodies[turn.robot])) }
        requests << { step: { turn: response.turn.turn, robots: robots } }
      elsif response.ended
        return response.ended.tick
      end
    end
    raise GRPC::Unavailable, "the server closed the connection before the run was over"
  ensure
    requests.close
  end
end
