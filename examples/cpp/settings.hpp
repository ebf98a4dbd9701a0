// What the environment says about the server. Keep this file, and replace follow.*.
#pragma once

#include <unistd.h>

#include <chrono>
#include <cstdlib>
#include <fstream>
#include <sstream>
#include <stdexcept>

#include "baudbot/v1/brain_link.pb.h"

namespace baudbot {

/// A variable of the environment; an empty one counts as unset.
inline std::string variable(const char* name, const std::string& otherwise) {
  const char* value = std::getenv(name);
  return value && *value ? value : otherwise;
}

/// BAUDBOT_TOKEN, else the one in BAUDBOT_TOKEN_FILE, else that of the user's own server (docs/reference/trust.md).
inline std::string token(std::string address) {
  std::string token;
  if (std::istringstream(variable("BAUDBOT_TOKEN", "")) >> token) return token;
  if (const auto file = variable("BAUDBOT_TOKEN_FILE", ""); !file.empty()) {
    if (std::ifstream(file) >> token) return token;
    throw std::runtime_error("BAUDBOT_TOKEN_FILE=" + file + ": must be a file with a token");
  }
  if (address.starts_with("localhost:")) address.replace(0, 9, "127.0.0.1");
  const auto user = std::to_string(getuid()), runtime = variable("XDG_RUNTIME_DIR", "/run/user/" + user);
  for (const auto& folder : {runtime + "/baudbot", "/tmp/baudbot-" + user, variable("HOME", "") + "/.baudbot"})
    if (std::ifstream(folder + "/" + address + ".token") >> token) return token;
  return "";
}

/// The address in BAUDBOT_CONNECT, as gRPC has it.
inline std::string address() {
  auto address = variable("BAUDBOT_CONNECT", "127.0.0.1:7400");
  if (address.starts_with("https://"))
    throw std::runtime_error("BAUDBOT_CONNECT=" + address +
                             ": this example has no TLS; give HOST:PORT or unix:/PATH of a server without TLS");
  if (address.starts_with("http://")) address.erase(0, 7);
  if (address.ends_with('/')) address.pop_back();
  return address;
}

/// For how long to try again after a lost connection.
inline std::chrono::duration<double> reconnect() {
  const auto text = variable("BAUDBOT_RECONNECT_S", "600");
  double seconds = 0.0;
  if (std::istringstream(text) >> seconds) return std::chrono::duration<double>(seconds);
  throw std::runtime_error("BAUDBOT_RECONNECT_S must be a number of seconds, is " + text);
}

/// What the server is told first: who drives what.
inline v1::AttachRequest hello(const std::string& name) {
  v1::AttachRequest request;
  v1::Hello& hello = *request.mutable_hello();
  hello.set_world(variable("BAUDBOT_WORLD", "wander"));
  std::istringstream robots(variable("BAUDBOT_ROBOT", "robot"));
  for (std::string robot; std::getline(robots, robot, ',');) hello.add_robots(robot);
  hello.set_mode(v1::PORT_MODE_MESSAGES);
  hello.set_brain(name);
  hello.set_thinks_as_scenario(true);
  return request;
}

}  // namespace baudbot
