// A real server for tests, run by the program that BAUDBOT names (default: baudbot).
#pragma once

#include <fcntl.h>
#include <sys/wait.h>
#include <unistd.h>

#include <chrono>
#include <csignal>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <sstream>
#include <stdexcept>
#include <string>
#include <thread>

class TestServer {
 public:
  /// Serves wander until the robot has driven for ten seconds.
  TestServer() : process_(fork()) {
    if (process_ == 0) run();
    for (int i = 0; !(std::ifstream(folder_ / "port") >> address_); ++i) {
      if (i == 3000 || waitpid(process_, nullptr, WNOHANG) != 0) {
        std::stringstream log;
        log << std::ifstream(folder_ / "log").rdbuf();
        stop();
        throw std::runtime_error("the server has ended, or is not ready after 30 s; it says:\n" + log.str());
      }
      std::this_thread::sleep_for(std::chrono::milliseconds(10));
    }
  }

  ~TestServer() { stop(); }

  const std::string& address() const { return address_; }

 private:
  [[noreturn]] void run() const {
    const int log = open((folder_ / "log").c_str(), O_WRONLY | O_CREAT, 0600);
    dup2(log, STDOUT_FILENO);
    dup2(log, STDERR_FILENO);
    const char* given = std::getenv("BAUDBOT");
    const char* program = given ? given : "baudbot";
    execlp(program, program, "serve", "wander", "--listen", "127.0.0.1:0", "--port-file", (folder_ / "port").c_str(),
           "--viewer", "off", "--pace", "lockstep", "--set", "end.after_s=10.0", nullptr);
    perror(program);
    _exit(127);
  }

  void stop() const {
    kill(process_, SIGTERM);
    waitpid(process_, nullptr, 0);
    std::filesystem::remove_all(folder_);
  }

  std::filesystem::path folder_ = mkdtemp((std::filesystem::temp_directory_path() / "baudbot-XXXXXX").string().data());
  pid_t process_;
  std::string address_;
};
