// The link between brains and their server. It knows nothing of any brain: keep this file, and replace follow.*.
#pragma once

#include <grpcpp/grpcpp.h>

#include <chrono>
#include <iostream>
#include <optional>
#include <thread>

#include "baudbot/v1/brain_link.grpc.pb.h"
#include "settings.hpp"

namespace baudbot {

/// Whether a message has come from the robot since its last turn.
inline bool is_news(const v1::RobotTurn& turn) {
  bool is_news = turn.has_message();
  for (const auto& reading : turn.readings()) is_news |= reading.readable();
  return is_news;
}

/// A sensor's last reading, or `unread` if none has arrived yet.
inline double value(const v1::RobotDescription& body, const v1::RobotTurn& turn, std::string_view sensor, double unread) {
  for (const auto& reading : turn.readings())
    if (body.sensors(reading.sensor()).sensor() == sensor) return reading.values(0);
  return unread;
}

inline std::shared_ptr<grpc::Channel> connect(const std::string& address) {
  grpc::ChannelArguments arguments;
  arguments.SetInt(GRPC_ARG_ENABLE_HTTP_PROXY, 0);          // it has no business between a robot and its brain
  arguments.SetInt(GRPC_ARG_USE_LOCAL_SUBCHANNEL_POOL, 1);  // else gRPC waits longer before each attempt
  arguments.SetInt(GRPC_ARG_KEEPALIVE_TIME_MS, 20'000);     // notices a server that has gone without a word
  arguments.SetInt(GRPC_ARG_HTTP2_MAX_PINGS_WITHOUT_DATA, 0);
  if (address.starts_with("unix:")) arguments.SetString(GRPC_ARG_DEFAULT_AUTHORITY, "localhost");
  return grpc::CreateCustomChannel(address, grpc::InsecureChannelCredentials(), arguments);
}

/// Drives robots with a `Brain` for each until the stream ends. Returns the last tick if the run is over.
template <class Brain>
std::optional<std::uint64_t> attend(grpc::ClientReaderWriter<v1::AttachRequest, v1::AttachResponse>& stream,
                                    bool& is_attached) {
  std::vector<Brain> brains;
  for (v1::AttachResponse response; stream.Read(&response);) {
    if (response.has_welcome()) {
      is_attached = true;
      for (const auto& body : response.welcome().robots()) brains.emplace_back(body);
    } else if (response.has_turn()) {
      v1::AttachRequest request;
      request.mutable_step()->set_turn(response.turn().turn());
      for (const auto& turn : response.turn().robots()) {
        auto& answer = *request.mutable_step()->add_robots();
        answer = brains.at(turn.robot()).answer(turn);
        answer.set_robot(turn.robot());
      }
      stream.Write(request);
    } else if (response.has_ended()) {
      return response.ended().tick();
    }
  }
  return std::nullopt;
}

/// Drives until the run is over, whose last tick it returns. After a lost connection it tries again, with new brains.
template <class Brain>
std::uint64_t drive(const std::string& name) {
  using Clock = std::chrono::steady_clock;
  const auto program = name.substr(0, name.find('.')), server = address();
  const auto patience = reconnect();
  std::optional<Clock::time_point> lost_at;
  for (bool was_attached = false;; std::this_thread::sleep_for(std::chrono::milliseconds(500))) {
    grpc::ClientContext context;
    if (const auto shown = token(server); !shown.empty()) context.AddMetadata("authorization", "Bearer " + shown);
    const auto service = v1::BrainLinkService::NewStub(connect(server));
    const auto stream = service->Attach(&context);
    stream->Write(hello(name));
    bool is_attached = false;
    const auto tick = attend<Brain>(*stream, is_attached);
    if (tick) context.TryCancel();  // releases the robots
    const auto status = stream->Finish();
    if (tick) return *tick;

    if (is_attached) lost_at.reset();
    was_attached |= is_attached;
    const auto code = status.error_code();
    const auto& trailers = context.GetServerTrailingMetadata();
    const bool may_pass = code == grpc::OK || code == grpc::UNAVAILABLE ||
                          (code == grpc::ALREADY_EXISTS && was_attached) ||
                          (code == grpc::ABORTED && trailers.count("baudbot-reason"));  // an operator asks for a restart
    const auto reason = status.ok() ? "the server closed the connection before the run was over" : status.error_message();
    const auto now = Clock::now();
    if (!may_pass || now - lost_at.value_or(now) >= patience) throw std::runtime_error(reason);
    if (!lost_at)
      std::cerr << program << ": connection lost (" << reason << "); trying again for " << patience.count() << " s\n";
    lost_at = lost_at.value_or(now);
  }
}

}  // namespace baudbot
