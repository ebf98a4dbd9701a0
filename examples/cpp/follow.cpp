// The program: drives where BAUDBOT_CONNECT, BAUDBOT_WORLD and BAUDBOT_ROBOT say, which `baudbot run --brain exec:…` sets.
#include "follow.hpp"

int main() try {
  const auto tick = baudbot::drive<Follow>("follow.cpp");
  std::cout << "the run is over at tick " << tick << std::endl;
} catch (const std::exception& error) {
  std::cerr << "follow: " << error.what() << std::endl;
  return 1;
}
