// The node's own client, in the node's order of calls, without ROS: PORT SECONDS. Built and run by node_starts.py. Ends with 1 where a call
// failed, or where the board's clock stood still between two readings.
#include <unistd.h>

#include <cmath>
#include <cstdio>
#include <string>

#include "turtlebot3_node/control_table.hpp"
#include "turtlebot3_node/dynamixel_sdk_wrapper.hpp"

using namespace robotis::turtlebot3;
using Clock = std::chrono::steady_clock;

int main(int, char ** arguments)
{
  const std::string port = arguments[1];
  const double seconds = std::stod(arguments[2]);
  char target[8];
  while (readlink(port.c_str(), target, sizeof target) < 0) {usleep(200);}
  const auto & table = extern_control_table;
  const auto & last = table.profile_acceleration_right;
  DynamixelSDKWrapper client({port, 200, 1000000, 2.0f});
  client.init_read_memory(table.millis.addr, last.addr - table.millis.addr + last.length);
  int failed = 0, calls = 0;
  double worst_ms = 0;
  const auto timed = [&](const auto & call) {
      const auto begun = Clock::now();
      failed += !call();
      ++calls;
      worst_ms = std::max(worst_ms, std::chrono::duration<double, std::milli>(Clock::now() - begun).count());
    };
  // The node asks once, and ends where nobody answers.
  timed([&] {return client.is_connected_to_device();});
  if (failed) {
    std::puts("no answer to the first question");
    return 1;
  }
  const double first_ms = worst_ms;
  std::string message;
  const auto write = [&](const auto & item, uint8_t value) {
      timed([&] {return client.set_data_to_device(item.addr, item.length, &value, &message);});
    };
  write(table.imu_re_calibration, 1);
  const auto end = Clock::now() + std::chrono::duration<double>(seconds);
  uint32_t before = 0;
  for (uint8_t turn = 0; Clock::now() < end; ++turn) {
    // It says of a failure only in its log: its clock would be the one before.
    timed([&] {
        client.read_data_set();
        const auto now = client.get_data_from_device<uint32_t>(table.millis.addr, table.millis.length);
        return std::exchange(before, now) != now;
      });
    if (turn % 2 == 0) {write(table.heartbeat, turn / 2);}
    std::this_thread::sleep_for(std::chrono::milliseconds(50));
  }
  double force = 0;
  for (int axis = 0; axis < 3; ++axis) {
    const auto value = client.get_data_from_device<float>(table.imu_linear_acceleration_x.addr + 4 * axis, 4);
    force += value * value;
  }
  force = std::sqrt(force);
  std::printf(
    "first answer after %.1f ms, %d calls, %d failed, worst %.1f ms, gravity %.2f m/s2\n",
    first_ms, calls, failed, worst_ms, force);
  return failed || std::abs(force - 9.81) > 0.3;
}
